//! The 95 % regions of a result hold the truth in 95 % of the trials, when the noise is what they assume.
#![allow(clippy::unwrap_used)]

mod support;

use cylfuse::fitter::{FitResult, Flags, Method, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::{AxisCone, Cylinder, CylinderLimits};
use cylfuse::noise::NoiseModel;
use nalgebra::Vector3;
use support::{Noise, camera, can, fitter_with, intrinsics, limb_segments, visible_points};

const TRIALS: usize = 10_000;

/// χ² of five degrees of freedom that is exceeded once in 20 times; the normal deviation, and χ² of three.
const REGION: f64 = 11.070;
const INTERVAL: f64 = 1.960;

struct Case {
    options: Options,
    points: usize,
    noise: PointNoise,
    /// Standard deviation of each coordinate of an endpoint in pixels; `None` without segments.
    endpoint: Option<f64>,
}

/// Independent noise of the points, standard deviation in metres.
enum PointNoise {
    /// Of every coordinate.
    Coordinates(f64),
    /// Of the distance from the camera: across the surface it is small beside the limbs.
    Range(f64),
}

fn trial(truth: &Cylinder, case: &Case, seed: u64) -> FitResult {
    let mut noise = Noise::new(seed);
    let mut points = visible_points(truth, &Vector3::zeros(), case.points);
    for point in &mut points {
        match case.noise {
            PointNoise::Coordinates(deviation) => {
                point.iter_mut().for_each(|x| *x += deviation * noise.normal());
            }
            PointNoise::Range(deviation) => {
                let change = deviation / Vector3::from(*point).norm() * noise.normal();
                point.iter_mut().for_each(|x| *x *= 1.0 + change);
            }
        }
    }
    let mut fitter = fitter_with(&points);
    if let Some(deviation) = case.endpoint {
        let mut segments = limb_segments(truth, &camera());
        for q in segments.iter_mut().flat_map(|segment| &mut segment.endpoints) {
            q.iter_mut().for_each(|x| *x += deviation * noise.normal());
        }
        fitter.set_intrinsics(intrinsics()).unwrap();
        fitter.push_edges(&segments).unwrap();
    }
    // Only the noise is on trial, not the search for a start, nor errors that all points share.
    fitter.set_start(Some(*truth));
    let noise = NoiseModel { depth_shared: 0.0, ..case.options.noise };
    fitter.set_options(Options { start: StartKind::Model, threads: 1, noise, ..case.options }).unwrap();
    fitter.fit().unwrap()
}

/// How often the 95 % region of all five degrees of freedom and the 95 % interval of the radius hold the truth, and that
/// of the difference between the radii by points and limbs holds 0, where there are both. Every trial has its own noise,
/// whichever thread runs it.
fn coverage(case: &Case) -> [f64; 3] {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let truth = can();
    let count = |first: usize| {
        let mut counts = [0; 3];
        for seed in (first..TRIALS).step_by(threads) {
            let result = trial(&truth, case, seed as u64);
            let uncertainty = result.uncertainty.unwrap();
            let error = result.cylinder.radius - truth.radius;
            // What is known takes degrees of freedom away.
            let limits = &case.options.cylinder_limits;
            let region = match (limits.fix_axis(), limits.fix_radius()) {
                (true, true) => 5.991,
                (true, false) => 7.815,
                (false, true) => 9.488,
                (false, false) => REGION,
            };
            counts[0] += usize::from(uncertainty.squared_distance(&truth) <= region);
            counts[1] += usize::from(error.abs() <= INTERVAL * uncertainty.radius());
            counts[2] += usize::from(result.radii.is_some_and(|radii| radii.z_score().abs() <= INTERVAL));
        }
        counts
    };
    let counts: Vec<[usize; 3]> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || count(first))).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).collect()
    });
    [0, 1, 2].map(|k| counts.iter().map(|counts| counts[k]).sum::<usize>() as f64 / TRIALS as f64)
}

fn assert_covers(name: &str, case: &Case) {
    let [region, radius, difference] = coverage(case);
    println!("{name}: region {region:.4}, radius {radius:.4}, difference of the radii {difference:.4}");
    let parts = [region, radius, difference];
    for part in &parts[..if case.endpoint.is_some() { 3 } else { 2 }] {
        assert!((0.94..=0.96).contains(part), "{name}: {part}");
    }
}

const COORDINATES: PointNoise = PointNoise::Coordinates(3e-4);

fn fused(objective: ObjectiveKind) -> Options {
    Options { objective, ..Options::default() }
}

#[test]
fn robust_fits_are_covered() {
    let options = fused(ObjectiveKind::Robust);
    let case = Case { options, points: 400, noise: COORDINATES, endpoint: Some(0.5) };
    assert_covers("robust", &case);
    assert_covers("robust, noise of the range", &Case { noise: PointNoise::Range(3e-4), ..case });
}

#[test]
fn robust_fits_without_segments_are_covered() {
    let options = fused(ObjectiveKind::Robust);
    assert_covers("robust, no segments", &Case { options, points: 400, noise: COORDINATES, endpoint: None });
}

#[test]
fn fits_by_least_squares_are_covered() {
    let options = fused(ObjectiveKind::Paper);
    let paper = Case { options, points: 400, noise: COORDINATES, endpoint: Some(0.5) };
    assert_covers("paper", &paper);
    let options = Options { method: Method::Points, ..options };
    assert_covers("points", &Case { options, endpoint: None, ..paper });
}

#[test]
fn a_known_radius_and_a_known_direction_have_no_uncertainty() {
    let truth = can();
    let axis = Some(AxisCone { direction: truth.axis.direction, max_angle: 0.0 });
    let known = CylinderLimits { radius_min: truth.radius, radius_max: truth.radius, axis: None };
    for limits in
        [known, CylinderLimits { axis, ..CylinderLimits::default() }, CylinderLimits { axis, ..known }]
    {
        let options = Options { cylinder_limits: limits, ..fused(ObjectiveKind::Robust) };
        let case = Case { options, points: 200, noise: COORDINATES, endpoint: Some(0.5) };
        let uncertainty = trial(&truth, &case, 1).uncertainty.unwrap();
        assert_eq!(uncertainty.radius() == 0.0, limits.fix_radius());
        assert_eq!(uncertainty.direction() == 0.0, limits.fix_axis());
        assert!(uncertainty.position() > 0.0 && uncertainty.covariance().iter().all(|x| x.is_finite()));
        let mut other = truth;
        other.radius *= 1.01;
        assert_eq!(uncertainty.squared_distance(&other) == f64::INFINITY, limits.fix_radius());
        let [region, ..] = coverage(&case);
        println!("known radius {}, known direction {}: {region:.4}", limits.fix_radius(), limits.fix_axis());
        assert!((0.94..=0.96).contains(&region), "{region}");
    }
}

/// A fit of a dense cloud with noise, moved by an offset of the depth, and the segments of the true limbs.
fn fit_with_offset(offset: f64) -> FitResult {
    let truth = can();
    let mut noise = Noise::new(1);
    let mut points = visible_points(&truth, &Vector3::zeros(), 5000);
    for [x, y, z] in &mut points {
        // What a camera measures is z; x and y follow with it.
        let scale = 1.0 + (offset + 3e-4 * noise.normal()) / *z;
        [*x, *y, *z] = [*x * scale, *y * scale, *z * scale];
    }
    let mut fitter = fitter_with(&points);
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter.push_edges(&limb_segments(&truth, &camera())).unwrap();
    let noise = NoiseModel { depth_shared: 0.0, ..NoiseModel::default() };
    fitter.set_options(Options { noise, ..Options::default() }).unwrap();
    fitter.fit().unwrap()
}

#[test]
fn points_and_limbs_disagree_when_the_depth_has_an_offset() {
    let right = fit_with_offset(0.0);
    assert!(!right.flags.contains(Flags::POINTS_AND_LIMBS_DISAGREE), "{:?}", right.radii);
    let radii = right.radii.unwrap();
    for (radius, deviation) in
        [(radii.from_points, radii.from_points_deviation), (radii.from_limbs, radii.from_limbs_deviation)]
    {
        assert!((radius - can().radius).abs() < 3.0 * deviation && deviation < 0.02 * radius, "{radii:?}");
    }
    // Farther away the same width of the image is a larger radius, of which the depth differences show nothing.
    let z_scores = [0.02, 0.05, 0.1].map(|offset| {
        let result = fit_with_offset(offset);
        let z_score = result.radii.unwrap().z_score();
        println!("offset {offset} m: z {z_score:.1}");
        assert_eq!(result.flags.contains(Flags::POINTS_AND_LIMBS_DISAGREE), z_score > 4.0);
        z_score
    });
    assert!(radii.z_score() < z_scores[0] && z_scores.is_sorted() && z_scores[2] > 4.0, "{z_scores:?}");
}
