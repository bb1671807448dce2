//! Noise-free data give the cylinder back, wherever it lies and in whatever unit.
#![allow(clippy::unwrap_used)]

mod support;

use cylfuse::fitter::{ChartChoice, FitResult, Flags, Method, NearWall, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::Cylinder;
use nalgebra::Vector3;
use support::{Noise, camera, can, fitter_with, intrinsics, limb_segments, visible_points};

fn assert_same(found: &Cylinder, truth: &Cylinder, relative: f64) {
    let difference = truth.compare(found);
    let at_data = found.axis.distance(&truth.axis.point) / truth.radius;
    assert!(difference.angle < relative, "angle {:e}", difference.angle);
    assert!(at_data < relative, "axis off by {at_data:e} radii");
    assert!(difference.radius_relative.abs() < relative, "radius {:e}", difference.radius_relative);
}

fn options(objective: ObjectiveKind) -> Options {
    Options { objective, ..Options::default() }
}

fn fit_can(options: Options, scale: f64) -> FitResult {
    let mut truth = can();
    truth.axis.point *= scale;
    truth.radius *= scale;
    let mut fitter = fitter_with(&visible_points(&truth, &Vector3::zeros(), 2000));
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter.push_edges(&limb_segments(&truth, &camera())).unwrap();
    fitter.set_options(options).unwrap();
    let result = fitter.fit().unwrap();
    assert_same(&result.cylinder, &truth, 1e-9);
    result
}

#[test]
fn points_and_edges_give_the_cylinder_to_1e_9_in_every_objective() {
    for objective in [ObjectiveKind::Paper, ObjectiveKind::Robust] {
        let result = fit_can(options(objective), 1.0);
        assert_eq!(result.flags, Flags::empty());
        assert_eq!(result.segments_used, 2);
        assert!(result.edge_rms_pixels.unwrap() < 1e-7);
    }
}

#[test]
fn millimetres_take_the_same_steps_as_metres() {
    for objective in [ObjectiveKind::Paper, ObjectiveKind::Robust] {
        let metres = fit_can(options(objective), 1.0);
        let millimetres = fit_can(options(objective), 1000.0);
        assert_eq!(metres.start_kind, millimetres.start_kind);
        assert!(metres.iterations.abs_diff(millimetres.iterations) <= 2);
    }
}

#[test]
fn every_method_and_start_recovers_points_without_edges() {
    let truth = can();
    let points = visible_points(&truth, &Vector3::zeros(), 2000);
    for method in [Method::Fused, Method::Points, Method::Ransac, Method::Eberly] {
        let mut fitter = fitter_with(&points);
        fitter.set_options(Options { method, ..Options::default() }).unwrap();
        assert_same(&fitter.fit().unwrap().cylinder, &truth, 1e-9);
    }
    for start in [StartKind::Moments, StartKind::Ransac] {
        let mut fitter = fitter_with(&points);
        fitter.set_options(Options { start, ..Options::default() }).unwrap();
        let result = fitter.fit().unwrap();
        assert_eq!(result.start_kind, start);
        assert_same(&result.cylinder, &truth, 1e-9);
    }
}

#[test]
fn a_cloud_10_km_away_gives_the_same_radius() {
    for objective in [ObjectiveKind::Robust, ObjectiveKind::Paper] {
        let mut truth = can();
        truth.axis.point += Vector3::new(10_000.0, -7_000.0, 3_000.0);
        let observer = truth.axis.point - Vector3::new(0.0, 0.1, 0.7);
        let mut fitter = fitter_with(&visible_points(&truth, &observer, 2000));
        fitter.set_options(Options { edge_weight: 0.0, ..options(objective) }).unwrap();
        let found = fitter.fit().unwrap();
        assert!((found.cylinder.radius / truth.radius - 1.0).abs() < 1e-9, "{:?}", found.cylinder);
        assert_eq!(found.flags, Flags::empty());
    }
}

#[test]
fn an_axis_through_or_near_the_origin_is_no_special_case() {
    for offset in [0.0, 1e-12, 1e-6] {
        let truth = Cylinder::new(Vector3::new(offset, 0.0, 0.0), Vector3::new(0.1, 0.3, 0.9), 0.25).unwrap();
        let points = visible_points(&truth, &Vector3::new(2.0, 0.5, 0.0), 2000);
        let mut fitter = fitter_with(&points);
        for objective in [ObjectiveKind::Robust, ObjectiveKind::Paper] {
            fitter.set_options(Options { edge_weight: 0.0, ..options(objective) }).unwrap();
            assert_same(&fitter.fit().unwrap().cylinder, &truth, 1e-9);
        }
    }
}

#[test]
fn a_camera_inside_the_pipe_sees_its_far_wall() {
    let truth = Cylinder::new(Vector3::new(0.05, -0.1, 0.8), Vector3::new(0.1, 0.05, 1.0), 0.4).unwrap();
    assert!(truth.contains_origin());
    // The wall below the axis, seen from inside.
    let points = visible_points(&truth, &Vector3::new(0.3, 5.0, 0.8), 2000);
    let mut fitter = fitter_with(&points);
    fitter.set_intrinsics(intrinsics()).unwrap();
    let result = fitter.fit().unwrap();
    assert_same(&result.cylinder, &truth, 1e-9);
    assert!(result.flags.contains(Flags::CAMERA_INSIDE) && !result.flags.contains(Flags::HIDDEN_WALL));
    assert_eq!(result.near_wall_fraction, Some(1.0));
}

#[test]
fn both_charts_reach_the_same_optimum_of_noisy_data() {
    let truth = can();
    let mut noise = support::Noise::new(7);
    let mut points = visible_points(&truth, &Vector3::zeros(), 3000);
    for point in &mut points {
        let ray = 1.0 + 0.002 * noise.normal();
        point.iter_mut().for_each(|x| *x *= ray);
    }
    let mut segments = limb_segments(&truth, &camera());
    segments[0].endpoints[0].x += 0.7;
    segments[1].endpoints[1].y -= 0.4;
    for objective in [ObjectiveKind::Paper, ObjectiveKind::Robust] {
        let fit = |chart| {
            let mut fitter = fitter_with(&points);
            fitter.set_intrinsics(intrinsics()).unwrap();
            fitter.push_edges(&segments).unwrap();
            let mut options = options(objective);
            options.chart = chart;
            options.limits.cost_tolerance = 1e-15;
            fitter.set_options(options).unwrap();
            fitter.fit().unwrap()
        };
        let (local, orthonormal) = (fit(ChartChoice::Local), fit(ChartChoice::Orthonormal));
        // The robust objective is settled when its scale is, to 1e-4.
        let tolerance = if objective == ObjectiveKind::Paper { 1e-8 } else { 1e-4 };
        assert!((local.cost / orthonormal.cost - 1.0).abs() < tolerance, "{objective:?}");
        assert_same(&orthonormal.cylinder, &local.cylinder, tolerance);
    }
}

#[test]
fn the_near_wall_rule_leaves_the_mirror_minimum() {
    let truth = can();
    let points = visible_points(&truth, &Vector3::zeros(), 2000);
    // A start between camera and surface, whose far wall holds the points.
    let c = truth.axis.nearest_to_origin().normalize();
    let mirrored = Cylinder::new(truth.axis.point - c * 0.058, truth.axis.direction, 0.03).unwrap();
    let fit = |near_wall, chart| {
        let mut fitter = fitter_with(&points);
        fitter.set_intrinsics(intrinsics()).unwrap();
        fitter.set_start(Some(mirrored));
        fitter
            .set_options(Options {
                near_wall,
                chart,
                start: StartKind::Model,
                method: Method::Points,
                ..Options::default()
            })
            .unwrap();
        fitter.fit()
    };
    for chart in [ChartChoice::Auto, ChartChoice::Local] {
        assert_same(&fit(NearWall::Auto, chart).unwrap().cylinder, &truth, 1e-9);
    }
    // Left alone the radius grows without end: the curvature has the wrong sign.
    assert_eq!(fit(NearWall::Off, ChartChoice::Local).unwrap_err().name(), "PLANAR_POINTS");
}

#[test]
fn the_same_data_give_the_same_bits_for_any_number_of_threads() {
    let truth = can();
    let mut noise = support::Noise::new(3);
    let mut points = visible_points(&truth, &Vector3::zeros(), 300_000);
    for point in &mut points {
        point.iter_mut().for_each(|x| *x += 0.001 * noise.normal());
    }
    let fit = |threads| {
        let mut fitter = fitter_with(&points);
        fitter.set_options(Options { threads, ..Options::default() }).unwrap();
        let mut result = fitter.fit().unwrap();
        result.seconds = Default::default();
        result
    };
    let one = fit(1);
    for threads in [2, 3, 0] {
        assert_eq!(fit(threads), one);
    }
}

#[test]
fn of_very_many_points_a_part_leads_to_what_a_few_less_tell() {
    let fit = |count: usize| {
        let mut noise = Noise::new(1);
        let mut segments = limb_segments(&can(), &camera());
        segments
            .iter_mut()
            .flat_map(|segment| &mut segment.endpoints)
            .for_each(|q| q.x += 0.5 * noise.normal());
        let mut cloud = visible_points(&can(), &Vector3::zeros(), count);
        for point in &mut cloud {
            let stretch = 1.0 + 0.0015 * noise.normal();
            point.iter_mut().for_each(|x| *x *= stretch);
        }
        let mut fitter = fitter_with(&cloud);
        fitter.set_intrinsics(intrinsics()).unwrap();
        fitter.push_edges(&segments).unwrap();
        let result = fitter.fit().unwrap();
        assert_eq!(result.points_used, count);
        result
    };
    let [all, part] = [40_000, 40_400].map(fit);
    let [of_all, of_part] = [&all, &part].map(|result| result.uncertainty.unwrap());
    assert!((of_part.radius() / of_all.radius() - 1.0).abs() < 0.02);
    assert!((of_part.direction() / of_all.direction() - 1.0).abs() < 0.02);
    // The edges, which are the same, tell the radius; the points their own noise.
    let change = all.cylinder.compare(&part.cylinder);
    assert!(change.radius_relative.abs() * can().radius < 0.2 * of_all.radius());
    assert!(change.angle < 2.0 * of_all.direction(), "{} {}", change.angle, of_all.direction());
}
