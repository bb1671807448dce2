//! What `plan` expects of captures of one scene against how much those of ../shared/frames/repeat scatter, as a table:
//! `cargo run --release --features twin --example plan_scatter`.
//!
//! The noise of depth and image is taken from the captures themselves, where limbs and ends are from the truth.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/frames.rs"]
mod frames;

use cylfuse::camera::Camera;
use cylfuse::geometry::{Cylinder, any_orthogonal};
use cylfuse::plan::{DepthNoise, Deviations, Plan, Scatter, StepNoise, Trial};
use frames::Inputs;
use nalgebra::{Vector2, Vector3};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// How far brightness is read from a limb or an end, beyond the blur, in pixels.
const BESIDE: f64 = 2.5;

/// Places along a limb or an arc.
const PLACES: usize = 100;

/// Beyond so many pixels the noise of depth has nothing in common.
const FARTHEST: usize = 10;

/// A pixel whose depth scatters by so many times the median is one beside the cylinder in some captures.
const OUTLIER: f64 = 3.0;

/// The captures of one scene.
struct Scene {
    inputs: Vec<Inputs>,
    camera: Camera,
    cylinder: Cylinder,
    length: f64,
}

impl Scene {
    fn read(folders: &[PathBuf]) -> Self {
        let inputs: Vec<Inputs> = folders.iter().map(|folder| Inputs::read(folder)).collect();
        let truth = frames::json(&folders[0].join("truth.json"));
        Self {
            camera: Camera::new(inputs[0].intrinsics).unwrap(),
            inputs,
            cylinder: frames::cylinder(&truth, "center", "axis"),
            length: truth["length"].as_f64().unwrap(),
        }
    }

    /// Mean and variance of a pixel over the captures.
    fn of_pixel(&self, value: impl Fn(&Inputs) -> f64) -> (f64, f64) {
        let values: Vec<f64> = self.inputs.iter().map(value).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (mean, square / (values.len() - 1) as f64)
    }

    /// Mean and variance of the brightness at a place, of the nearest pixel.
    fn brightness(&self, at: &Vector2<f64>) -> (f64, f64) {
        let index = at.y.round() as usize * self.inputs[0].size.0 + at.x.round() as usize;
        self.of_pixel(|input| f64::from(input.image[index]))
    }

    /// The noise over the root mean square of the steps between what lies on either side of some places.
    fn step_noise(&self, places: &[(Vector2<f64>, Vector2<f64>)]) -> f64 {
        let (mut steps, mut variances) = (0.0, 0.0);
        for (place, across) in places {
            let (inside, outside) = (place + across * BESIDE, place - across * BESIDE);
            let [(a, a_variance), (b, b_variance)] = [inside, outside].map(|at| self.brightness(&at));
            steps += (a - b).powi(2);
            variances += 0.5 * (a_variance + b_variance);
        }
        (variances / steps).sqrt()
    }

    /// Where a curve on the cylinder is in the image, with the direction across it towards the inside.
    fn places(
        &self,
        curve: impl Fn(f64) -> Vector3<f64>,
        inside: impl Fn(f64) -> Vector3<f64>,
    ) -> Vec<(Vector2<f64>, Vector2<f64>)> {
        let part = |k: usize| (k as f64 + 0.5) / PLACES as f64;
        let pixel = |point: Vector3<f64>| self.camera.project(&point).unwrap();
        (0..PLACES)
            .map(|k| (pixel(curve(part(k))), pixel(inside(part(k)))))
            .map(|(at, inside)| (at, (inside - at).normalize()))
            .collect()
    }

    /// What the captures say of the noise at limbs and ends.
    fn step(&self) -> StepNoise {
        let axis = self.cylinder.axis.direction;
        let (center, radius) = (self.cylinder.axis.point, self.cylinder.radius);
        // Seen from the camera the limbs are where the normal is across the line of sight.
        let away = center - axis * center.dot(&axis);
        let distance = away.norm();
        let (away, sideways) = (away / distance, axis.cross(&(away / distance)));
        let (sine, cosine) = (radius / distance, (1.0 - (radius / distance).powi(2)).sqrt());
        let limbs = [-1.0, 1.0].map(|side| {
            let normal = sideways * (side * cosine) - away * sine;
            let at = |part: f64| center + axis * (0.84 * (part - 0.5) * self.length);
            self.step_noise(&self.places(|part| at(part) + normal * radius, at))
        });
        let ends = [-1.0, 1.0].map(|side| {
            // The near wall, without what is within a tenth of the limbs.
            let normal = |part: f64| {
                let sine = 0.9 * (2.0 * part - 1.0) * cosine;
                sideways * sine - away * (1.0 - sine * sine).sqrt()
            };
            let at = |part: f64, along: f64| center + axis * (side * along) + normal(part) * radius;
            let half = 0.5 * self.length;
            self.step_noise(&self.places(|part| at(part, half), |part| at(part, half - 0.002)))
        });
        StepNoise { limbs, ends, ..StepNoise::default() }
    }

    /// The noise of depth by the square of the depth, and the side of the squares that share it, of the pixels of the mask.
    fn depth(&self) -> DepthNoise {
        let first = &self.inputs[0];
        let (width, height) = first.size;
        let seen =
            |index: usize| first.mask[index] > 0 && self.inputs.iter().all(|input| input.depth[index] > 0);
        let value = |input: &Inputs, index: usize| f64::from(input.depth[index]) * input.depth_scale;
        let noise = |(mean, variance): (f64, f64)| variance.sqrt() / mean.powi(2);
        let mut pixels: Vec<Option<(f64, f64)>> = (0..width * height)
            .map(|index| seen(index).then(|| self.of_pixel(|input| value(input, index))))
            .collect();
        let mut deviations: Vec<f64> = pixels.iter().flatten().copied().map(noise).collect();
        deviations.sort_by(f64::total_cmp);
        let most = OUTLIER * deviations[deviations.len() / 2];
        deviations.retain(|deviation| *deviation < most);
        for pixel in &mut pixels {
            *pixel = pixel.filter(|pixel| noise(*pixel) < most);
        }
        // The sum of the correlation over all distances along rows, and along columns.
        let side = |step: usize| {
            let correlation = |lag: usize| {
                let (mut sum, mut count) = (0.0, 0);
                for (index, pixel) in pixels.iter().enumerate() {
                    let other = index + lag * step;
                    if let (Some((a, _)), Some(Some((b, _)))) = (pixel, pixels.get(other)) {
                        let product = |input: &Inputs| (value(input, index) - a) * (value(input, other) - b);
                        sum += self.inputs.iter().map(product).sum::<f64>();
                        count += self.inputs.len();
                    }
                }
                sum / f64::from(count as u32)
            };
            1.0 + 2.0 * (1..=FARTHEST).map(correlation).sum::<f64>() / correlation(0)
        };
        DepthNoise {
            constant: 0.0,
            linear: 0.0,
            quadratic: (deviations.iter().map(|x| x * x).sum::<f64>() / deviations.len() as f64).sqrt(),
            correlation: (side(1) * side(width)).sqrt(),
        }
    }

    fn plan(&self) -> Plan {
        let axis = self.cylinder.axis.direction;
        Plan {
            distance: self.cylinder.axis.point.norm(),
            radius: self.cylinder.radius,
            length: self.length,
            tilt: axis.z.asin(),
            turn: axis.x.atan2(axis.y),
            step: self.step(),
            ..Plan::new(self.camera.clone(), self.depth())
        }
    }

    fn trial(&self, input: &Inputs) -> Trial {
        let mut fitter = input.fitter();
        input.push_image(&mut fitter);
        fitter.push_edges(&input.edges).unwrap();
        let found = fitter.fit().unwrap().cylinder;
        let truth = self.cylinder.axis;
        let (u, v) = any_orthogonal(&truth.direction);
        let cosine = found.axis.direction.dot(&truth.direction);
        let along = (truth.point - found.axis.point).dot(&truth.direction) / cosine;
        let position = found.axis.at(along) - truth.point;
        let both = |vector: Vector3<f64>| [vector.dot(&u), vector.dot(&v)];
        Trial {
            radius: found.radius - self.cylinder.radius,
            direction: both(found.axis.direction * cosine.signum()),
            position: both(position),
            length: fitter.extent(None, None).ok().map(|extent| extent.length - self.length),
        }
    }

    fn observed(&self) -> Deviations {
        let trials: Vec<Trial> = self.inputs.iter().map(|input| self.trial(input)).collect();
        Scatter::new(&trials).unwrap().deviation
    }
}

fn numbers(deviations: &Deviations) -> [f64; 4] {
    let Deviations { radius, direction, position, length } = *deviations;
    [radius, direction, position, length.unwrap()]
}

/// Ratios of predicted to observed.
fn ratios(predicted: [f64; 4], observed: [f64; 4]) -> String {
    let ratio = |k: usize| format!("{:.2} | ", predicted[k] / observed[k]);
    (0..4).map(ratio).collect()
}

fn main() {
    let mut scenes = BTreeMap::<String, Vec<PathBuf>>::new();
    for folder in frames::shared_frames("frames/repeat") {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let (scene, _) = name.split_once("_c").unwrap();
        scenes.entry(scene.into()).or_default().push(folder);
    }
    println!(
        "| scene | radius (mm) | depth noise | correlation (px) | limbs | ends | radius | axis | position | length |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let (mut all_predicted, mut all_observed) = ([0.0; 4], [0.0; 4]);
    for (name, folders) in scenes {
        let scene = Scene::read(&folders);
        let plan = scene.plan();
        let predicted = numbers(&plan.expected().unwrap().scatter);
        let observed = numbers(&scene.observed());
        let StepNoise { limbs, ends, .. } = plan.step;
        println!(
            "| {name} | {:.0} | {:.5} z² | {:.1} | {:.3}, {:.3} | {:.3}, {:.3} | {}",
            plan.radius * 1e3,
            plan.depth.quadratic,
            plan.depth.correlation,
            limbs[0],
            limbs[1],
            ends[0],
            ends[1],
            ratios(predicted, observed).trim_end(),
        );
        for k in 0..4 {
            all_predicted[k] += predicted[k].powi(2);
            all_observed[k] += observed[k].powi(2);
        }
    }
    let root = |sums: [f64; 4]| sums.map(f64::sqrt);
    println!("| all together | | | | | | {}", ratios(root(all_predicted), root(all_observed)).trim_end());
}
