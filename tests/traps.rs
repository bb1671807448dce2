//! Odd and broken input: what must fit, what fits with a flag, and what is an error of its own.
#![allow(clippy::unwrap_used)]

#[path = "support/frames.rs"]
mod frames;
mod support;

use cylfuse::error::Error;
use cylfuse::fitter::{Fitter, Flags, Method, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, MaskView, PointsView};
use frames::Inputs;
use nalgebra::Vector3;
use std::ops::ControlFlow;
use std::path::Path;
use support::{Noise, SIZE, camera, can, fitter_with, intrinsics, limb_segments, segment, visible_points};

fn paper() -> Options {
    Options { objective: ObjectiveKind::Paper, ..Options::default() }
}

/// A fitter with the points of the can and these segments.
fn can_with(segments: &[cylfuse::observations::EdgeSegment], options: Options) -> Fitter {
    let mut fitter = fitter_with(&visible_points(&can(), &Vector3::zeros(), 1000));
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter.push_edges(segments).unwrap();
    fitter.set_options(options).unwrap();
    fitter
}

fn assert_can(fitter: &mut Fitter) -> Flags {
    let result = fitter.fit().unwrap();
    let difference = can().compare(&result.cylinder);
    assert!(difference.radius_relative.abs() < 1e-8 && difference.angle < 1e-8, "{result:?}");
    result.flags
}

#[test]
fn one_edge_three_edges_and_none_are_ordinary() {
    let both = limb_segments(&can(), &camera());
    let halves: Vec<_> = both
        .iter()
        .flat_map(|whole| {
            let [a, b] = whole.endpoints;
            let middle = (a + b) * 0.5;
            [[a, middle], [middle, b]]
                .map(|endpoints| cylfuse::observations::EdgeSegment { endpoints, weight: 1.0 })
        })
        .collect();
    for segments in [&both[..0], &both[..1], &both[1..], &halves[..3], &halves[..]] {
        let mut fitter = can_with(segments, Options::default());
        assert_eq!(assert_can(&mut fitter), Flags::empty());
        assert_eq!(fitter.result().unwrap().segments_used, segments.len());
    }
}

#[test]
fn the_paper_takes_two_segments_or_no_weight() {
    let both = limb_segments(&can(), &camera());
    for count in [0, 1] {
        let mut fitter = can_with(&both[..count], paper());
        let error = fitter.fit().unwrap_err();
        assert_eq!(error.name(), "UNSUPPORTED");
        assert!(error.to_string().contains(&format!("exactly 2 edge segments, not {count}")), "{error}");
        // The handle stays usable and keeps its data.
        fitter.set_options(Options { edge_weight: 0.0, ..paper() }).unwrap();
        assert_can(&mut fitter);
    }
}

#[test]
fn a_radius_whose_interval_reaches_half_of_it_is_weak() {
    let can = can();
    let mut noise = Noise::new(1);
    let faces = |p: &Vector3<f64>| (p - can.axis.nearest_to(p)).normalize().dot(&-p.normalize()) > 0.85;
    let points: Vec<[f64; 3]> = visible_points(&can, &Vector3::zeros(), 20_000)
        .into_iter()
        .map(Vector3::from)
        .filter(faces)
        .map(|p| (p * (1.0 + 0.002 * noise.normal())).into())
        .collect();
    let mut fitter = fitter_with(&points);
    // Independent points tell the radius; where few in all are, it may be anything.
    for (independent_points, weak) in [(points.len() as f64, false), (30.0, true), (10.0, true)] {
        fitter.set_options(Options { independent_points, ..Options::default() }).unwrap();
        let fit = fitter.fit().unwrap();
        let deviation = fit.uncertainty.unwrap().radius() / fit.cylinder.radius;
        assert_eq!(deviation > 0.25, weak, "{deviation}");
        assert_eq!(fit.flags.contains(Flags::WEAK_RADIUS), weak, "{deviation}");
    }
}

#[test]
fn edges_that_cannot_be_two_limbs_are_ignored_with_a_flag() {
    let both = limb_segments(&can(), &camera());
    let ([a, b], [c, d]) = (both[0].endpoints, both[1].endpoints);
    let crossing = [segment(a.into(), d.into()), segment(c.into(), b.into())];
    let same = [both[0], segment((a + (b - a) * 0.2).into(), (b + (b - a) * 0.3).into())];
    let points = [segment(a.into(), a.into()), segment(c.into(), c.into())];
    for options in [Options::default(), paper()] {
        for (segments, reason) in [
            (crossing, Flags::EDGES_CROSS),
            (same, Flags::EDGES_COINCIDE),
            (points, Flags::SEGMENTS_UNUSABLE),
        ] {
            let mut fitter = can_with(&segments, options);
            assert_eq!(assert_can(&mut fitter), Flags::EDGES_IGNORED | reason);
            assert_eq!(fitter.result().unwrap().segments_used, 0);
        }
    }
}

#[test]
fn rays_that_miss_the_plane_of_the_limbs_are_flagged() {
    // The axis nearly along the line of sight: the plane of the limbs meets a sideways ray behind the camera.
    let start = Cylinder::new(Vector3::new(0.3, 0.0, 0.9), Vector3::new(0.0, 0.0, 1.0), 0.03).unwrap();
    let segments = [segment([10.0, 100.0], [30.0, 300.0]), segment([60.0, 100.0], [80.0, 300.0])];
    let points = visible_points(&start, &Vector3::zeros(), 1000);
    let mut fitter = fitter_with(&points);
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter.push_edges(&segments).unwrap();
    fitter.set_start(Some(start));
    fitter.set_options(Options { start: StartKind::Model, ..paper() }).unwrap();
    let result = fitter.fit().unwrap();
    assert!(result.flags.contains(Flags::EDGES_IGNORED | Flags::EDGES_BEHIND), "{:?}", result.flags);
    assert!((result.cylinder.radius / 0.03 - 1.0).abs() < 1e-8);
}

#[test]
fn edges_alone_keep_the_scale_of_the_start_and_say_so() {
    let truth = can();
    let start =
        Cylinder::new(truth.axis.point * 1.2, Vector3::new(0.22, 0.88, 0.33), truth.radius * 1.25).unwrap();
    let distance = start.distance_of_axis_from_origin();
    for with_points in [true, false] {
        let mut fitter = Fitter::new();
        if with_points {
            let points = visible_points(&truth, &Vector3::zeros(), 1000);
            fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
        }
        fitter.set_intrinsics(intrinsics()).unwrap();
        fitter.push_edges(&limb_segments(&truth, &camera())).unwrap();
        fitter.set_start(Some(start));
        fitter.set_options(Options { edge_weight: 1.0, start: StartKind::Model, ..paper() }).unwrap();
        let result = fitter.fit().unwrap();
        assert!(result.flags.contains(Flags::SCALE_HELD | Flags::WEAK_RADIUS), "{:?}", result.flags);
        assert!((result.cylinder.distance_of_axis_from_origin() / distance - 1.0).abs() < 1e-9);
        assert!(result.energy_edges.unwrap().sqrt() < 1e-7, "{result:?}");
        assert!(result.edge_rms_pixels.unwrap() < 1e-3);
    }
}

#[test]
fn points_that_are_not_finite_are_dropped_and_counted() {
    let mut points = visible_points(&can(), &Vector3::zeros(), 1000);
    for k in 0..100 {
        points[k * 7][k % 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][k % 3];
    }
    let mut fitter = fitter_with(&points);
    let result = fitter.fit().unwrap();
    assert_eq!((result.points_used, result.points_given, result.dropped.not_finite), (900, 1000, 100));
    assert_eq!(result.flags, Flags::POINTS_NOT_FINITE);
}

/// The can, so far from the origin, and a fitter with its points in single precision.
fn of_f32_far_away(offset: Vector3<f64>) -> (Cylinder, Fitter) {
    let mut truth = can();
    truth.axis.point += offset;
    let observer = truth.axis.point - Vector3::new(0.0, 0.0, 0.7);
    let points: Vec<[f32; 3]> =
        visible_points(&truth, &observer, 3000).iter().map(|p| p.map(|x| x as f32)).collect();
    let mut fitter = Fitter::new();
    fitter.push_points(&PointsView::from_f32(&points), None).unwrap();
    (truth, fitter)
}

#[test]
fn an_f32_cloud_10_km_away_has_lost_its_resolution() {
    let (truth, mut fitter) = of_f32_far_away(Vector3::new(10_000.0, 0.0, 0.0));
    let result = fitter.fit().unwrap();
    assert!(result.flags.contains(Flags::RESOLUTION_LOST));
    assert!((result.cylinder.radius / truth.radius - 1.0).abs() < 0.02);
}

/// What is left of the points about the cylinder is rounding.
#[test]
fn an_f32_cloud_whose_steps_are_coarser_than_its_noise_states_no_deviation() {
    let (_, mut fitter) = of_f32_far_away(Vector3::new(30_000.0, 30_000.0, 0.0));
    let result = fitter.fit().unwrap();
    assert!(result.flags.contains(Flags::RESOLUTION_LOST | Flags::UNCERTAINTY_UNKNOWN), "{result:?}");
    assert_eq!(result.uncertainty, None);
}

/// Invalid points at the origin of a sensor lie there in its own coordinates alone.
#[test]
fn a_single_point_however_far_away_changes_nothing() {
    let mut can = can();
    can.axis.point.x += 1e6;
    let observer = can.axis.point - Vector3::new(0.0, 0.0, 0.7);
    let points = visible_points(&can, &observer, 3000);
    for far in [[0.0; 3], [1e12, 0.0, 0.0]] {
        for at in [0, 3000] {
            let mut points = points.clone();
            points.insert(at, far);
            let mut fitter = fitter_with(&points);
            let result = fitter.fit().unwrap();
            assert_eq!((result.points_used, result.points_given), (3000, 3001));
            assert!((result.cylinder.radius / can.radius - 1.0).abs() < 1e-6, "{far:?}: {result:?}");
        }
    }
}

/// Most points on a spot of the body do not make the rest of it far away.
#[test]
fn a_dense_spot_is_not_the_whole_body() {
    let mut noise = Noise::new(5);
    let mut points = visible_points(&can(), &Vector3::zeros(), 1500);
    let spot = Vector3::from(points[700]);
    points.extend((0..2000).map(|_| <[f64; 3]>::from(spot + 1e-6 * noise.vector())));
    let result = fitter_with(&points).fit().unwrap();
    assert_eq!(result.points_used, 3500);
    assert!((result.cylinder.radius / can().radius - 1.0).abs() < 1e-3, "{result:?}");
}

/// A cylinder through both the body and what is behind it explains them, but a plane explains the body as well.
#[test]
fn a_few_points_of_what_is_far_behind_the_body_change_nothing() {
    let mut noise = Noise::new(3);
    let mut points: Vec<[f64; 3]> = visible_points(&can(), &Vector3::zeros(), 3000)
        .into_iter()
        .map(|p| (Vector3::from(p) + 0.0005 * noise.vector()).into())
        .collect();
    for far in [2.0, 6.0] {
        for count in [30, 90] {
            let behind = |_| (Vector3::new(0.0, 0.0, 1.0) + 0.02 * noise.vector()).normalize() * far;
            points.truncate(3000);
            points.extend((0..count).map(behind).map(<[f64; 3]>::from));
            let result = fitter_with(&points).fit().unwrap();
            assert!((result.cylinder.radius / can().radius - 1.0).abs() < 0.02, "{far} {count}: {result:?}");
        }
    }
}

#[test]
fn planes_lines_and_handfuls_of_points_are_errors_of_their_own() {
    let mut noise = support::Noise::new(1);
    let grid: Vec<(f64, f64)> =
        (0..900).map(|k| (f64::from(k % 30) * 0.003, f64::from(k / 30) * 0.003)).collect();
    let plane: Vec<[f64; 3]> = grid.iter().map(|(x, y)| [*x, *y, 0.7 + 0.3 * x - 0.1 * y]).collect();
    let rough: Vec<[f64; 3]> =
        grid.iter().map(|(x, y)| [*x, *y, 0.7 + 0.3 * x + 0.0005 * noise.normal()]).collect();
    let line: Vec<[f64; 3]> = grid.iter().map(|(x, _)| [*x, 2.0 * x, 0.7 - x]).collect();
    let one_point = vec![[0.1, 0.2, 0.7]; 50];
    let few = visible_points(&can(), &Vector3::zeros(), 4);
    for (points, name) in [
        (plane, "PLANAR_POINTS"),
        (rough, "PLANAR_POINTS"),
        (line, "COLLINEAR_POINTS"),
        (one_point, "COLLINEAR_POINTS"),
        (few, "TOO_FEW_POINTS"),
        (vec![], "TOO_FEW_POINTS"),
    ] {
        let mut fitter = fitter_with(&points);
        for camera in [false, true] {
            if camera {
                fitter.set_intrinsics(intrinsics()).unwrap();
            }
            for method in [Method::Fused, Method::Points] {
                fitter.set_options(Options { method, ..Options::default() }).unwrap();
                let error = fitter.fit().unwrap_err();
                assert_eq!(error.name(), name, "{method:?}: {error}");
            }
        }
        // What was pushed is still there.
        assert_eq!(fitter.cloud().len(), points.len());
    }
}

fn depth_fitter() -> Fitter {
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter
}

#[test]
fn empty_masks_empty_depth_and_wrong_sizes_are_errors_of_their_own() {
    let (width, height) = SIZE;
    let zeros = vec![0_u16; width * height];
    let depth = vec![7000_u16; width * height];
    let mask = vec![1_u8; width * height];
    let whole = DepthView::from_u16(&depth, SIZE, 1e-4).unwrap();
    let empty = DepthView::from_u16(&zeros, SIZE, 1e-4).unwrap();
    let range = DepthRange::default();
    let mut fitter = depth_fitter();

    let no_mask = MaskView::from_u8(&[0; 640 * 480], SIZE).unwrap();
    let error = fitter.push_depth(&whole, Some(&no_mask), &range).unwrap_err();
    assert_eq!(error.name(), "EMPTY_MASK");
    let error = fitter.push_depth(&empty, None, &range).unwrap_err();
    let (pixels, all) = (width * height, (0.0, f64::INFINITY));
    assert_eq!(error, Error::NoDepth { pixels, missing: pixels, out_of_range: 0, range: all });
    let far = DepthRange { min: 1.0, max: 2.0 };
    let error = fitter.push_depth(&whole, None, &far).unwrap_err();
    assert_eq!(error, Error::NoDepth { pixels, missing: 0, out_of_range: pixels, range: (1.0, 2.0) });
    assert!(error.to_string().contains("outside min_depth 1.0 to max_depth 2.0"), "{error}");

    let small_mask = MaskView::from_u8(&mask[..320 * 240], (320, 240)).unwrap();
    let error = fitter.push_depth(&whole, Some(&small_mask), &range).unwrap_err();
    assert_eq!(
        error.to_string(),
        "mask is 320 x 240 but depth image is 640 x 480; both must have the same size: scale the mask"
    );
    let small = DepthView::from_u16(&depth[..320 * 240], (320, 240), 1e-4).unwrap();
    let error = fitter.push_depth(&small, None, &range).unwrap_err();
    assert_eq!(error.name(), "SIZE_MISMATCH");
    let error = Fitter::new().push_depth(&whole, None, &range).unwrap_err();
    assert_eq!(error.name(), "BAD_STATE");
    assert_eq!(fitter.cloud().given(), 0);
}

#[test]
fn bad_settings_name_the_value_the_limit_and_the_remedy() {
    let mut fitter = Fitter::new();
    for weight in [-0.1, 1.4, f64::NAN] {
        let error = fitter.set_options(Options { edge_weight: weight, ..paper() }).unwrap_err();
        assert_eq!(error.to_string(), format!("options.edge_weight is {weight}; it must lie in [0, 1]"));
    }
    for (fx, text) in [(0.0, "fx is 0"), (f64::NAN, "fx is NaN"), (-5.0, "fx is -5")] {
        let mut bad = intrinsics();
        bad.fx = fx;
        let error = fitter.set_intrinsics(bad).unwrap_err();
        assert_eq!(error.name(), "INVALID_INTRINSICS");
        assert!(error.to_string().contains(text), "{error}");
    }
    assert_eq!(fitter.options(), &Options::default());
    assert!(fitter.camera().is_none());
}

#[test]
fn segments_without_intrinsics_ask_for_them() {
    let mut fitter = fitter_with(&visible_points(&can(), &Vector3::zeros(), 1000));
    fitter.push_edges(&limb_segments(&can(), &camera())).unwrap();
    let error = fitter.fit().unwrap_err();
    assert_eq!(
        error.to_string(),
        "fit needs intrinsics to use the edge segments; set the intrinsics or clear the segments"
    );
    fitter.set_intrinsics(intrinsics()).unwrap();
    assert_can(&mut fitter);
}

#[test]
fn a_cancelled_fit_keeps_the_last_result() {
    let mut fitter = can_with(&limb_segments(&can(), &camera()), Options::default());
    fitter.fit().unwrap();
    let before = *fitter.result().unwrap();
    for last in [1, 2] {
        let mut calls = 0;
        let error = fitter
            .fit_with(&mut |_| {
                calls += 1;
                if calls == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
            .unwrap_err();
        assert_eq!(error.name(), "CANCELLED");
        assert_eq!(fitter.result(), Some(&before));
    }
    assert_can(&mut fitter);
}

/// Whether a cylinder is flagged about which the points of a can scatter by a part of something.
fn is_poor(fitter: &Fitter, scale: f64) -> bool {
    // All points are this far from the surface, and the scale is that of normal errors with such a median.
    let radius = can().radius + scale / 1.4826;
    fitter.evaluate(&Cylinder { radius, ..can() }).unwrap().flags.contains(Flags::POOR_FIT)
}

#[test]
fn points_that_do_not_lie_on_the_cylinder_are_flagged() {
    let points = visible_points(&can(), &Vector3::zeros(), 1000);
    let mut fitter = fitter_with(&points);
    let radius = can().radius;
    assert!(!is_poor(&fitter, 0.24 * radius) && is_poor(&fitter, 0.5 * radius));
    fitter.set_intrinsics(intrinsics()).unwrap();
    let sum: Vector3<f64> = points.iter().map(|point| Vector3::from(*point)).sum();
    let distance = (sum / points.len() as f64).norm();
    assert!(!is_poor(&fitter, 0.0099 * distance) && is_poor(&fitter, 0.0101 * distance));
    let mut options = *fitter.options();
    options.noise.depth = 0.01 * distance;
    fitter.set_options(options).unwrap();
    assert!(!is_poor(&fitter, 0.0299 * distance) && is_poor(&fitter, 0.0301 * distance));
}

#[test]
fn a_scene_that_is_fitted_as_one_cylinder_is_flagged() {
    for name in ["r40_a20_f0", "w004", "w022"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames").join(name);
        let mut inputs = Inputs::read(&folder);
        assert!(!inputs.fitter().fit().unwrap().flags.contains(Flags::POOR_FIT), "{name}");
        inputs.mask.fill(255);
        let result = inputs.fitter().fit().unwrap();
        assert!(result.flags.contains(Flags::POOR_FIT), "{name}: {result:?}");
    }
}
