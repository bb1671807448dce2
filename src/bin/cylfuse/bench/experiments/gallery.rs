//! Figures 10 to 12: fitted cylinders over the image, and what completion makes of the depth.

use crate::bench::Bench;
use crate::bench::methods::{Method, Outcome, fit_by_any};
use crate::bench::page::{Section, paragraph, pictures, shown};
use crate::bench::picture::{Outline, over_image};
use crate::bench::plot::cross_section;
use crate::bench::sample::{Sample, Truth};
use crate::failure::Failure;
use nalgebra::Vector3;

const TRUE_COLOR: [u8; 3] = [255, 255, 255];
const MEASURED: [u8; 3] = [150, 150, 150];

/// Points in a cross-section: more are no clearer.
const SHOWN: usize = 350;

fn configurations(bench: &Bench) -> Vec<(u32, u32)> {
    bench.scale.of(vec![(20, 30), (30, 0), (60, 0)], vec![(20, 30)], vec![(30, 0)])
}

pub fn count(bench: &Bench) -> usize {
    configurations(bench).len()
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let methods = bench.compared();
    let samples = bench.map(&configurations(bench), |configuration| bench.capture(*configuration, 0))?;
    let mut body = paragraph(
        "Fig. 10 and 11 of the paper: what each method found, over the image; the truth in dashed white. Fig. 12: the same \
         along the axis: depth points in grey, the points of the mask completed on the fitted cylinder in colour, the true \
         circle dashed.",
    );
    for sample in &samples {
        let (mut over, mut across) = (Vec::new(), Vec::new());
        for method in &methods {
            let Some(outcome) = fit_by_any(sample, *method, bench.pcl.as_ref())? else { continue };
            let errors = outcome.errors.map(shown);
            let name = method.name();
            let caption = format!(
                "{name}: E_o {}°, E_p {} mm, E_r {} %, E_l {} %",
                errors[0], errors[1], errors[2], errors[3]
            );
            let fitted = outcome.extent.as_ref().map(|extent| Outline {
                cylinder: outcome.cylinder,
                ends: [extent.start, extent.end],
                color: method.color(),
                dashed: false,
            });
            let outlines: Vec<Outline> = fitted.into_iter().chain(true_outline(&sample.truth)).collect();
            over.push(over_image(&sample.views[0], &outlines, &caption)?);
            across.push(completion(sample, *method, &outcome)?);
        }
        body.push_str(&format!("<h3>{}</h3>\n", crate::bench::page::escaped(&sample.name)));
        body.push_str(&pictures(&over));
        body.push_str(&pictures(&across));
    }
    Ok(Section {
        name: "pictures",
        title: "Pictures (Fig. 10 to 12)".into(),
        body,
        numbers: Vec::new(),
        said: None,
    })
}

pub fn true_outline(truth: &Truth) -> Option<Outline> {
    let (center, length) = (truth.center?, truth.length?);
    let half = truth.cylinder.axis.direction * (0.5 * length);
    Some(Outline {
        cylinder: truth.cylinder,
        ends: [center - half, center + half],
        color: TRUE_COLOR,
        dashed: true,
    })
}

fn completion(sample: &Sample, method: Method, outcome: &Outcome) -> Result<String, Failure> {
    let fitter = sample.fitter(None)?;
    let truth = &sample.truth.cylinder;
    let frame = truth.axis;
    let toward = frame.nearest_to_origin().normalize();
    let side = frame.direction.cross(&toward);
    let across = |point: Vector3<f64>| {
        let from = point - frame.point;
        [1e3 * from.dot(&side), 1e3 * from.dot(&toward)]
    };
    let mut completed = Vec::new();
    fitter.complete(Some(&outcome.cylinder), None, &mut |_, _, point| completed.extend(point.map(across)))?;
    let measured: Vec<_> = fitter.cloud().points().map(across).collect();
    let thinned = |points: Vec<[f64; 2]>| {
        let step = (points.len() / SHOWN).max(1);
        points.into_iter().step_by(step).collect::<Vec<_>>()
    };
    let layers = [(MEASURED, thinned(measured)), (method.color(), thinned(completed))];
    let radius = 1e3 * truth.radius;
    cross_section(method.name(), 1.6 * radius, radius, &layers)
}
