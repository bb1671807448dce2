//! Rendered cylinders with known limbs.

use super::*;
use crate::camera::{Distortion, Intrinsics};
use crate::noise::NoiseModel;
use crate::observations::{DepthImage, DepthView, EdgeSegment, GreyImage, ImageView, Mask, MaskView};
use nalgebra::Vector3;

fn noise() -> ImageNoise {
    NoiseModel::default().in_image((640, 480))
}

const SIZE: (usize, usize) = (240, 180);
const BLUR: f64 = 0.9;

/// Pixels over which a shadow fades.
const SHADOW: f64 = 10.0;

/// Rays per pixel and direction.
const SAMPLES: usize = 3;

struct Scene {
    camera: Camera,
    cylinder: Cylinder,
    range: [f64; 2],
    albedo: f64,
    background: f64,
    /// The part of the light that a shadow on the background takes away at the limb; it fades over some pixels.
    shadow: f64,
    /// Pixels beside the limbs that a hard shadow covers, which takes a quarter of the light.
    hard_shadow: f64,
    /// Whether a label of dark patches is on the surface.
    label: bool,
    /// Image rows hidden by something dark.
    occluded: std::ops::Range<usize>,
}

impl Scene {
    fn new() -> Self {
        let cylinder =
            Cylinder::new(Vector3::new(0.02, -0.01, 0.6), Vector3::new(0.25, 0.95, 0.2), 0.04).unwrap();
        Self {
            camera: camera(Distortion::None),
            cylinder,
            range: [-0.07, 0.07],
            albedo: 150.0,
            background: 40.0,
            shadow: 0.0,
            hard_shadow: 0.0,
            label: false,
            occluded: 0..0,
        }
    }

    fn brightness(&self, pixel: &Vector2<f64>) -> f64 {
        let row = (pixel.y + 0.5) as usize;
        if self.occluded.contains(&row) {
            return 15.0;
        }
        let axis = &self.cylinder.axis;
        let hit = self.camera.unproject(pixel).and_then(|ray| self.cylinder.first_hit(&ray));
        let Some(p) = hit else {
            let apart = self.camera.unproject(pixel).map_or(f64::INFINITY, |ray| {
                let normal = ray.cross(&axis.direction);
                normal.dot(&axis.point).abs() / normal.norm() - self.cylinder.radius
            });
            let pixels = apart * self.camera.intrinsics().fx / axis.point.z;
            let hard = if pixels < self.hard_shadow { 0.75 } else { 1.0 };
            return self.background * hard * (1.0 - self.shadow * (1.0 - pixels / SHADOW).max(0.0));
        };
        let position = axis.position_of(&p);
        if !(self.range[0]..=self.range[1]).contains(&position) {
            return self.background;
        }
        let normal = (p - axis.nearest_to(&p)).normalize();
        let light = Vector3::new(-0.4, -0.3, -1.0).normalize();
        let angle = normal.dot(&axis.direction.cross(&Vector3::z())).atan2(-normal.z);
        let patch = ((position / 0.012).floor() + (angle / 0.35).floor()).rem_euclid(3.0) < 1.0;
        let paint = if self.label && patch { 0.4 } else { 1.0 };
        self.albedo * paint * (0.35 + 0.65 * normal.dot(&light).max(0.0))
    }

    /// The image with blur, noise of 1.5 and 8 bits.
    fn render(&self) -> GreyImage {
        let (width, height) = (SIZE.0 * SAMPLES, SIZE.1 * SAMPLES);
        let pixel_of = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
        let mut fine: Vec<f64> = (0..width * height)
            .map(|k| self.brightness(&Vector2::new(pixel_of(k % width), pixel_of(k / width))))
            .collect();
        // The mean over the samples of a pixel is part of the blur.
        let own = (1.0 - 1.0 / (SAMPLES * SAMPLES) as f64) / 12.0;
        let sigma = (BLUR * BLUR - own).sqrt() * SAMPLES as f64;
        let taps: Vec<f64> = (-9..=9).map(|k| (-0.5 * (f64::from(k) / sigma).powi(2)).exp()).collect();
        let sum: f64 = taps.iter().sum();
        for (count, stride) in [(width, 1), (height, width)] {
            let source = fine.clone();
            for (k, out) in fine.iter_mut().enumerate() {
                let at = (k / stride % count) as i64;
                let value = |d: i64| {
                    let to = (at + d).clamp(0, count as i64 - 1);
                    source[(k as i64 + (to - at) * stride as i64) as usize]
                };
                *out = (-9_i64..=9).zip(&taps).map(|(d, tap)| tap * value(d)).sum::<f64>() / sum;
            }
        }
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let bytes: Vec<u8> = (0..SIZE.0 * SIZE.1)
            .map(|k| {
                let (x, y) = (k % SIZE.0 * SAMPLES, k / SIZE.0 * SAMPLES);
                let cells = (0..SAMPLES * SAMPLES).map(|c| (x + c % SAMPLES, y + c / SAMPLES));
                let mean = cells.map(|(x, y)| fine[y * width + x]).sum::<f64>() / (SAMPLES * SAMPLES) as f64;
                // Four uniform numbers are nearly Gaussian, with variance 1/3.
                let noise = ((0..4).map(|_| uniform()).sum::<f64>() - 2.0) * 3.0_f64.sqrt() * 1.5;
                (mean + noise).round().clamp(0.0, 255.0) as u8
            })
            .collect();
        GreyImage::copy(&ImageView::from_u8(&bytes, SIZE).unwrap()).unwrap()
    }

    /// The cylinder as a rough fit has it: limbs off by about a pixel, and 1.5 with the radius.
    fn rough(&self) -> Cylinder {
        let Cylinder { axis, radius } = self.cylinder;
        let point = axis.point + Vector3::new(0.001, 0.0005, 0.004);
        Cylinder::new(point, axis.direction + Vector3::new(0.008, 0.0, 0.03), radius * 1.05).unwrap()
    }

    fn search(&self) -> LimbSearch {
        LimbSearch {
            ranges: [self.range; 2],
            reach: [4.0; 2],
            deviation: [1.5; 2],
            covered: [false; 2],
            noise: noise(),
        }
    }

    fn locate(&self) -> [LimbObservation; 2] {
        locate_limbs(&self.render(), &self.camera, &self.rough(), &self.search()).limbs
    }

    /// The distance of the true limb from a located line at both ends of the range, and its standard deviation
    /// there.
    fn errors(&self, limb: usize, line: &LimbLine) -> [(f64, f64); 2] {
        let along = line.ends[1] - line.ends[0];
        let length = along.norm();
        let start = self.cylinder.axis.point.dot(&self.cylinder.axis.direction);
        let truth = LimbFrame::new(&self.cylinder).unwrap().limb_lines()[limb];
        let middle = (line.ends[0] + line.ends[1]) / 2.0;
        self.range.map(|position| {
            let q = self.camera.ideal_pixel(&truth.at(start + position)).unwrap();
            let s = (q - middle).dot(&along) / length;
            let covariance = line.covariance();
            let deviation = (covariance[(0, 0)] + covariance[(1, 1)] * s * s).sqrt();
            (along.perp(&(q - middle)) / length, deviation)
        })
    }

    /// Checks that both limbs are found within a bound, and consistently with their covariance.
    fn check(&self, bound: f64) -> [LimbObservation; 2] {
        let observations = self.locate();
        for (k, observation) in observations.iter().enumerate() {
            let line = observation.line.unwrap_or_else(|reason| panic!("limb {k}: {reason:?}"));
            for (error, deviation) in self.errors(k, &line) {
                assert!(error.abs() < bound, "limb {k}: {error} +- {deviation}, {observations:?}");
                assert!(error.abs() < 4.0 * deviation, "limb {k}: {error} +- {deviation}");
            }
        }
        observations
    }
}

fn camera(distortion: Distortion) -> Camera {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let intrinsics = Intrinsics { width, height, fx: 420.0, fy: 415.0, cx: 118.0, cy: 91.0, distortion };
    Camera::new(intrinsics).unwrap()
}

#[test]
fn limbs_are_located_to_a_tenth_of_a_pixel_at_either_polarity() {
    for background in [20.0, 220.0] {
        let observations = Scene { background, ..Scene::new() }.check(0.1);
        let blur = observations[0].blur.unwrap();
        assert!((blur - BLUR).abs() < 0.15, "{blur}");
        assert!(observations.iter().all(|o| o.samples.len() >= 8));
    }
}

#[test]
fn limbs_of_sixteen_rows_are_located() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let search = LimbSearch { ranges: [[-0.012, 0.012]; 2], ..scene.search() };
    let limbs = locate_limbs(&scene.render(), &scene.camera, &scene.rough(), &search).limbs;
    for (k, limb) in limbs.iter().enumerate() {
        let line = limb.line.unwrap_or_else(|reason| panic!("limb {k}: {reason:?}"));
        assert_eq!(limb.samples.len(), 3);
        // The ends of the whole surface are far from what was looked at.
        let [(first, _), (last, _)] = scene.errors(k, &line);
        assert!(f64::midpoint(first, last).abs() < 0.1, "limb {k}: {first} {last}");
    }
}

/// An image on a grid that is finer by some factor, interpolated bilinearly.
fn enlarged(image: &GreyImage, factor: usize) -> GreyImage {
    let size = (image.width() * factor, image.height() * factor);
    let beside = |place: usize, count: usize| {
        let at = ((place as f64 + 0.5) / factor as f64 - 0.5).clamp(0.0, (count - 1) as f64);
        let first = (at as usize).min(count - 2);
        (first, (at - first as f64) as f32)
    };
    let value = |k: usize| {
        let (column, right) = beside(k % size.0, image.width());
        let (row, down) = beside(k / size.0, image.height());
        let along = |row| image.value(column, row) * (1.0 - right) + image.value(column + 1, row) * right;
        along(row) * (1.0 - down) + along(row + 1) * down
    };
    let values: Vec<f32> = (0..size.0 * size.1).map(value).collect();
    GreyImage::copy(&ImageView::from_f32(&values, size).unwrap()).unwrap()
}

#[test]
fn what_is_blurred_is_located_as_on_a_coarser_grid() {
    const FACTOR: usize = 3;
    let ratio = FACTOR as f64;
    let scene = Scene { background: 220.0, ..Scene::new() };
    let image = enlarged(&scene.render(), FACTOR);
    let Intrinsics { fx, fy, cx, cy, distortion, .. } = *scene.camera.intrinsics();
    let place = |place: f64| ratio * (place + 0.5) - 0.5;
    let (width, height) = (image.width() as u32, image.height() as u32);
    let (fx, fy, cx, cy) = (fx * ratio, fy * ratio, place(cx), place(cy));
    let large = Scene {
        camera: Camera::new(Intrinsics { width, height, fx, fy, cx, cy, distortion }).unwrap(),
        ..Scene::new()
    };
    let noise = NoiseModel { drawn_pixel: ratio, ..NoiseModel::default() }.in_image(SIZE);
    let search = LimbSearch { reach: [4.0 * ratio; 2], deviation: [1.5 * ratio; 2], noise, ..scene.search() };
    let observations = locate_limbs(&image, &large.camera, &large.rough(), &search).limbs;
    for (k, observation) in observations.iter().enumerate() {
        for (error, deviation) in large.errors(k, &observation.line.unwrap()) {
            assert!(error.abs() < 0.1 * ratio && error.abs() < 4.0 * deviation, "limb {k}: {error}");
        }
        // The interpolation adds a sixth of a squared pixel.
        let blur = observation.blur.unwrap() / ratio;
        assert!((blur - BLUR.hypot(1.0 / 6.0_f64.sqrt())).abs() < 0.15, "{blur}");
    }
}

#[test]
fn what_is_sharp_is_located_on_its_own_grid() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let drawn = NoiseModel { drawn_pixel: 3.0, edge_endpoint: 0.5 / 3.0, ..NoiseModel::default() };
    let search = LimbSearch { noise: drawn.in_image(SIZE), ..scene.search() };
    let observations = locate_limbs(&scene.render(), &scene.camera, &scene.rough(), &search).limbs;
    assert_eq!(observations, scene.locate());
}

/// An image that moved evenly over some columns while it was taken.
fn moved(image: &GreyImage, columns: usize) -> GreyImage {
    let (width, height) = (image.width(), image.height());
    let value = |k: usize| {
        let beside = |d: usize| (k % width + d).saturating_sub(columns / 2).min(width - 1);
        (0..columns).map(|d| image.value(beside(d), k / width)).sum::<f32>() / columns as f32
    };
    let values: Vec<f32> = (0..width * height).map(value).collect();
    GreyImage::copy(&ImageView::from_f32(&values, (width, height)).unwrap()).unwrap()
}

#[test]
fn limbs_of_what_moved_are_located() {
    for background in [20.0, 220.0] {
        let scene = Scene { background, ..Scene::new() };
        let image = scene.render();
        for columns in [5, 7] {
            let image = moved(&image, columns);
            let search = LimbSearch { reach: [8.0; 2], deviation: [2.0; 2], ..scene.search() };
            let seen = locate_limbs(&image, &scene.camera, &scene.rough(), &search);
            for (k, limb) in seen.limbs.iter().enumerate() {
                let line =
                    limb.line.unwrap_or_else(|reason| panic!("limb {k}, {columns} columns: {reason:?}"));
                for (error, deviation) in scene.errors(k, &line) {
                    let is_right = error.abs() < 0.1 * columns as f64 && error.abs() < 4.0 * deviation;
                    assert!(is_right, "limb {k}, {columns} columns: {error} +- {deviation}");
                }
            }
        }
    }
}

#[test]
fn what_rests_is_not_looked_at_as_what_moved() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let image = scene.render();
    let last = locate_limbs(&moved(&image, 5), &scene.camera, &scene.rough(), &scene.search());
    let last = last.appearance.unwrap();
    let again = locate_limbs_again(&image, &scene.camera, &scene.cylinder, &scene.search(), &last, false);
    assert!(again.is_none());
}

#[test]
fn white_that_was_cut_off_does_not_move_the_limbs() {
    Scene { background: 600.0, ..Scene::new() }.check(0.1);
}

#[test]
fn a_shadow_that_fades_beside_the_limbs_does_not_move_them() {
    Scene { background: 220.0, shadow: 0.5, ..Scene::new() }.check(0.35);
}

#[test]
fn a_faint_shadow_does_not_move_the_limbs_either() {
    for background in [160.0, 220.0] {
        Scene { background, shadow: 0.15, ..Scene::new() }.check(0.05);
    }
}

#[test]
fn the_deviation_of_a_line_says_that_a_hard_shadow_ends_beside_it() {
    for width in [2.5, 3.0, 3.5] {
        let scene = Scene { hard_shadow: width, background: 220.0, ..Scene::new() };
        for (k, limb) in scene.locate().iter().enumerate() {
            for (error, deviation) in scene.errors(k, &limb.line.unwrap()) {
                assert!(error.abs() < 3.0 * deviation, "a shadow of {width} px: {error} +- {deviation}");
            }
        }
    }
}

#[test]
fn an_edge_softer_than_any_limb_is_none() {
    let scene = Scene { background: 150.0, albedo: 150.0, shadow: 0.7, ..Scene::new() };
    let image = scene.render();
    // Nothing but the shadow is in reach: its middle is five pixels from the limbs.
    let model = Cylinder { radius: 0.04 * 1.25, ..scene.cylinder };
    let search = LimbSearch { reach: [3.0; 2], ..scene.search() };
    for observation in locate_limbs(&image, &scene.camera, &model, &search).limbs {
        assert!(observation.line.is_err(), "{observation:?}");
    }
}

#[test]
fn a_lens_does_not_bend_the_lines() {
    let lens = Distortion::brown_conrady(&[-0.25, 0.08, 0.002, -0.001]).unwrap();
    Scene { camera: camera(lens), background: 220.0, ..Scene::new() }.check(0.1);
}

#[test]
fn flat_lines_are_located_as_steep_ones() {
    let cylinder = Cylinder::new(Vector3::new(0.0, 0.01, 0.6), Vector3::new(0.95, 0.2, -0.2), 0.03).unwrap();
    Scene { cylinder, background: 220.0, ..Scene::new() }.check(0.1);
}

#[test]
fn a_label_and_an_occluder_cost_little() {
    Scene { label: true, background: 200.0, ..Scene::new() }.check(0.3);
    let observations = Scene { occluded: 80..100, ..Scene::new() }.check(0.3);
    for observation in &observations {
        let refused = observation.samples.iter().filter(|sample| sample.weight < 0.5).count();
        let hidden = observation.samples.iter().filter(|s| (84.0..96.0).contains(&s.position.y));
        assert!(hidden.clone().count() > 0 && hidden.clone().all(|s| s.weight < 0.5 || s.sigma > 0.5));
        assert!(refused < observation.samples.len() / 2);
    }
}

#[test]
fn the_image_border_may_cut_the_cylinder() {
    let scene = Scene { range: [-0.5, 0.5], background: 220.0, ..Scene::new() };
    let observations = scene.locate();
    for (k, observation) in observations.iter().enumerate() {
        let line = observation.line.unwrap();
        let truth = Scene { range: [-0.1, 0.1], ..Scene::new() };
        for (error, _) in truth.errors(k, &line) {
            assert!(error.abs() < 0.1, "{error}");
        }
    }
}

#[test]
fn what_cannot_be_seen_is_not_found() {
    let scene = Scene { albedo: 0.0, background: 0.0, ..Scene::new() };
    for observation in scene.locate() {
        assert_eq!(observation.line, Err(NotVisible::NoEdge));
    }
    let image = scene.render();
    let reasons = |model: &Cylinder, search: &LimbSearch| {
        locate_limbs(&image, &scene.camera, model, search).limbs.map(|o| o.line.unwrap_err())
    };
    let around = Cylinder::new(Vector3::new(0.0, 0.1, 0.2), Vector3::x(), 1.0).unwrap();
    assert_eq!(reasons(&around, &scene.search()), [NotVisible::NoLimbs; 2]);
    let short = LimbSearch { ranges: [[0.0, 0.01]; 2], ..scene.search() };
    assert_eq!(reasons(&scene.rough(), &short), [NotVisible::TooShort; 2]);
    let outside = Cylinder::new(Vector3::new(0.9, 0.0, 0.6), Vector3::y(), 0.04).unwrap();
    assert_eq!(reasons(&outside, &scene.search()), [NotVisible::TooShort; 2]);
}

#[test]
fn one_limb_may_be_missing() {
    // The left half of the image shows nothing at all.
    let scene = Scene { background: 220.0, ..Scene::new() };
    let mut bytes: Vec<u8> = Vec::new();
    let image = scene.render();
    let axis = scene.camera.project(&scene.cylinder.axis.point).unwrap();
    for row in 0..SIZE.1 {
        bytes.extend((0..SIZE.0).map(|x| if (x as f64) < axis.x { 90 } else { image.value(x, row) as u8 }));
    }
    let image = GreyImage::copy(&ImageView::from_u8(&bytes, SIZE).unwrap()).unwrap();
    let observations = locate_limbs(&image, &scene.camera, &scene.rough(), &scene.search()).limbs;
    let found: Vec<usize> = (0..2).filter(|&k| observations[k].line.is_ok()).collect();
    assert_eq!(found.len(), 1, "{observations:?}");
    for (error, _) in scene.errors(found[0], &observations[found[0]].line.unwrap()) {
        assert!(error.abs() < 0.15, "{error}");
    }
}

#[test]
fn a_mask_and_segments_say_where_to_search() {
    let scene = Scene::new();
    let axis = &scene.cylinder.axis;
    let on_surface = |x: usize, y: usize| {
        let ray = scene.camera.unproject(&Vector2::new(x as f64, y as f64)).unwrap();
        let hit = scene.cylinder.first_hit(&ray);
        hit.is_some_and(|p| axis.position_of(&p).abs() <= scene.range[1])
    };
    let bytes: Vec<u8> = (0..SIZE.0 * SIZE.1).map(|k| u8::from(on_surface(k % SIZE.0, k / SIZE.0))).collect();
    let mask = Mask::copy(&MaskView::from_u8(&bytes, SIZE).unwrap()).unwrap();

    let sides = Outline::new(&mask, None, &scene.camera, &noise())
        .unwrap()
        .sides(&scene.camera, &scene.rough())
        .unwrap();
    let limbs = [0, 1].map(|k| {
        let line = LimbLine { ends: sides[k].ends, sigma: 1.0 };
        [0, 1].map(|limb| scene.errors(limb, &line).map(|(error, _)| error.abs()))
    });
    let near = |errors: &[f64; 2]| errors.iter().all(|&error| error < 1.5);
    let order = if near(&limbs[0][0]) { [0, 1] } else { [1, 0] };
    assert!(near(&limbs[0][order[0]]) && near(&limbs[1][order[1]]), "{limbs:?}");

    let pixels = mask.set_pixels().map(|(x, y)| Vector2::new(x as f64, y as f64));
    let range = axial_range(&scene.camera, &scene.cylinder, pixels, 0.0).unwrap();
    for (found, truth) in range.iter().zip(&scene.range) {
        assert!((found - truth).abs() < 0.004, "{range:?}");
    }
    let segment =
        EdgeSegment { endpoints: [Vector2::new(80.0, 30.0), Vector2::new(110.0, 150.0)], weight: 1.0 };
    let range = axial_range(&scene.camera, &scene.cylinder, segment.endpoints.into_iter(), 0.0).unwrap();
    assert!(range[0] < -0.05 && range[1] > 0.05, "{range:?}");
    assert_eq!(axial_range(&scene.camera, &scene.cylinder, std::iter::empty(), 0.1), None);
}

/// The sides of the scene behind something, given which pixels that covers; also told is whether the surface is at a pixel.
fn sides_behind(covers: impl Fn(usize, usize, &dyn Fn(usize, usize) -> bool) -> bool) -> [Side; 2] {
    let scene = Scene::new();
    let axis = &scene.cylinder.axis;
    let hit = |x: usize, y: usize| {
        let ray = scene.camera.unproject(&Vector2::new(x as f64, y as f64)).unwrap();
        let hit = scene.cylinder.first_hit(&ray);
        hit.filter(|p| axis.position_of(p).abs() <= scene.range[1])
    };
    let in_front = |x: usize, y: usize| covers(x, y, &|x, y| hit(x, y).is_some());
    let pixels = (0..SIZE.0 * SIZE.1).map(|k| (k % SIZE.0, k / SIZE.0));
    let bytes: Vec<u8> =
        pixels.clone().map(|(x, y)| u8::from(!in_front(x, y) && hit(x, y).is_some())).collect();
    let depth = |(x, y)| if in_front(x, y) { 0.4 } else { hit(x, y).map_or(2.0, |p| p.z as f32) };
    let depths: Vec<f32> = pixels.map(depth).collect();
    let mask = Mask::copy(&MaskView::from_u8(&bytes, SIZE).unwrap()).unwrap();
    let depth = DepthImage::copy(&DepthView::from_f32(&depths, SIZE, 1.0).unwrap()).unwrap();
    let outline = Outline::new(&mask, Some(&depth), &scene.camera, &noise()).unwrap();
    outline.sides(&scene.camera, &scene.cylinder).unwrap()
}

#[test]
fn the_edge_of_something_in_front_is_no_side() {
    let scene = Scene::new();
    let axis = scene.camera.project(&scene.cylinder.axis.point).unwrap();
    let (column, row) = (axis.x as usize, axis.y as usize);
    let right = |sides: &[Side; 2]| usize::from(sides[1].ends[0].x > sides[0].ends[0].x);
    // The lower half is covered: the side follows the upper one.
    let sides = sides_behind(|x, y, _| x >= column && y >= row);
    assert!(!sides[0].cut && !sides[1].cut, "{sides:?}");
    let line = LimbLine { ends: sides[right(&sides)].ends, sigma: 1.0 };
    let near = |limb: usize| scene.errors(limb, &line).iter().all(|(error, _)| error.abs() < 1.5);
    assert!(near(0) || near(1), "{sides:?}");
    // There the limb is seen.
    let (part, hidden) = sides[right(&sides)].seen.unwrap();
    let covered = usize::from(part[1].y > part[0].y);
    assert!((part[covered].y - row as f64).abs() < 3.0, "{sides:?} {row}");
    assert!(hidden[covered] && !hidden[1 - covered], "{sides:?}");
    assert_eq!(sides[1 - right(&sides)].seen, None);
    // All of it is covered.
    let sides = sides_behind(|x, _, _| x >= column);
    let right = right(&sides);
    assert!(sides[right].cut && !sides[1 - right].cut, "{sides:?}");
    assert_eq!(sides[right].seen, None);
}

#[test]
fn what_is_nearer_beside_a_limb_hides_nothing_of_it() {
    let scene = Scene::new();
    let axis = scene.camera.project(&scene.cylinder.axis.point).unwrap();
    let (column, row) = (axis.x as usize, axis.y as usize);
    let sides = sides_behind(|x, y, on_surface| {
        x >= column && y >= row && (0..4).all(|beside| !on_surface(x - beside, y))
    });
    assert!(sides.iter().all(|side| side.seen.is_none() && !side.cut), "{sides:?}");
}
