//! Limits of radius and axis hold in every returned cylinder, and the minimum within them is the right one.
#![allow(clippy::unwrap_used)]

mod support;

use cylfuse::fitter::{
    ChartChoice, FitResult, Fitter, Flags, Inputs, Method, ObjectiveKind, Options, StartKind,
};
use cylfuse::geometry::{AxisCone, Cylinder, CylinderLimits, any_orthogonal, rotate_direction};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;
use support::{Noise, camera, can, fitter_with, intrinsics, limb_segments, visible_points};

/// Points of the can with noise of 0.3 mm.
fn points() -> Vec<[f64; 3]> {
    let mut noise = Noise::new(3);
    let exact = visible_points(&can(), &Vector3::zeros(), 800);
    exact.into_iter().map(|p| (Vector3::from(p) + noise.vector() * 3e-4).into()).collect()
}

fn fitter(options: Options) -> Fitter {
    let mut fitter = fitter_with(&points());
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter.push_edges(&limb_segments(&can(), &camera())).unwrap();
    let mut start = can();
    start.axis.direction = aside(0.1);
    start.radius = 0.033;
    fitter.set_start(Some(start));
    fitter.set_options(options).unwrap();
    fitter
}

/// The direction of the can turned by an angle.
fn aside(angle: f64) -> Vector3<f64> {
    let d = can().axis.direction;
    let (u, v) = any_orthogonal(&d);
    rotate_direction(&d, &((u * 0.6 + v * 0.8) * angle))
}

fn radius(radius_min: f64, radius_max: f64) -> CylinderLimits {
    CylinderLimits { radius_min, radius_max, axis: None }
}

fn cone(direction: Vector3<f64>, max_angle: f64) -> CylinderLimits {
    CylinderLimits { axis: Some(AxisCone { direction, max_angle }), ..CylinderLimits::default() }
}

fn both(radius: CylinderLimits, cone: CylinderLimits) -> CylinderLimits {
    CylinderLimits { axis: cone.axis, ..radius }
}

fn methods() -> Vec<Options> {
    let fused = |objective, edge_weight| Options { objective, edge_weight, ..Options::default() };
    let method = |method| Options { method, ..Options::default() };
    vec![
        fused(ObjectiveKind::Robust, 0.6),
        fused(ObjectiveKind::Paper, 0.0),
        fused(ObjectiveKind::Paper, 0.6),
        fused(ObjectiveKind::Paper, 1.0),
        method(Method::Points),
        method(Method::Ransac),
        method(Method::Eberly),
    ]
}

#[test]
fn limits_hold_whatever_the_method_and_the_start() {
    let radii =
        [radius(0.0, 0.028), radius(0.032, f64::INFINITY), radius(0.029, 0.029), radius(0.0299, 0.0301)];
    let cones = [
        cone(aside(0.2) * -3.0, 0.1),
        cone(aside(0.02), 0.0),
        cone(aside(1.3), 0.9),
        cone(aside(1e-3), 1e-9),
        cone(aside(0.0), 0.5),
    ];
    let mut all: Vec<CylinderLimits> = radii.iter().chain(&cones).copied().collect();
    all.extend(radii.iter().flat_map(|r| cones.iter().map(|c| both(*r, *c))));
    let starts = [StartKind::Auto, StartKind::Limbs, StartKind::Moments, StartKind::Ransac, StartKind::Model];
    for options in methods() {
        for (index, &limits) in all.iter().enumerate() {
            // Of the pairs each takes one start in turn; limits alone take all.
            let some = if index < 9 { &starts[..] } else { &starts[index % 5..=index % 5] };
            // Only the fused method has edges.
            let edges = options.method == Method::Fused;
            for &start in some.iter().filter(|start| edges || **start != StartKind::Limbs) {
                let result = fitter(Options { start, cylinder_limits: limits, ..options }).fit().unwrap();
                assert_kept(&limits, &result, &format!("{options:?} {start:?}"));
            }
        }
    }
}

fn assert_kept(limits: &CylinderLimits, result: &FitResult, what: &str) {
    let Cylinder { axis, radius } = result.cylinder;
    assert!(limits.radius_min <= radius && radius <= limits.radius_max, "{what} {limits:?} {radius}");
    if let Some(AxisCone { direction, max_angle }) = limits.axis {
        let middle = direction.normalize();
        let angle = middle.cross(&axis.direction).norm().atan2(middle.dot(&axis.direction).abs());
        assert!(angle <= max_angle, "{what} {limits:?} {angle}");
        if max_angle == 0.0 {
            assert!(axis.direction == middle || axis.direction == -middle);
        }
    }
    if limits.fix_radius() {
        assert_eq!(radius.to_bits(), limits.radius_min.to_bits());
        assert!(!result.flags.contains(Flags::WEAK_RADIUS), "{what} {:?}", result.flags);
    } else {
        let at_end = radius == limits.radius_min || radius == limits.radius_max;
        assert_eq!(result.flags.contains(Flags::RADIUS_AT_LIMIT), at_end);
    }
    assert!(!result.flags.contains(Flags::NOT_CONVERGED), "{what} {limits:?} {result:?}");
}

#[test]
fn a_known_radius_or_direction_that_the_data_contradict_is_flagged() {
    let flags = |cylinder_limits: CylinderLimits, edges: bool| {
        let mut fitter = fitter(Options { cylinder_limits, ..Options::default() });
        if !edges {
            fitter.clear_inputs(Inputs::EDGES);
        }
        fitter.fit().unwrap().flags & (Flags::RADIUS_AT_LIMIT | Flags::AXIS_AT_LIMIT)
    };
    let direction = can().axis.direction;
    for edges in [true, false] {
        for (known, right) in [(0.03, true), (0.0285, false), (0.0315, false), (0.02, false), (0.06, false)] {
            let expected = if right { Flags::empty() } else { Flags::RADIUS_AT_LIMIT };
            assert_eq!(flags(radius(known, known), edges), expected, "{known} {edges}");
            // What is right beside it is not in doubt.
            let both = flags(both(radius(known, known), cone(direction, 0.0)), edges);
            assert_eq!(both.contains(Flags::RADIUS_AT_LIMIT), !right, "{known} {edges}");
        }
        assert_eq!(flags(cone(direction, 0.0), edges), Flags::empty());
        assert_eq!(flags(cone(aside(0.04), 0.0), edges), Flags::AXIS_AT_LIMIT);
    }
}

#[test]
fn limits_that_the_data_keep_change_nothing() {
    let wide = both(radius(0.01, 0.1), cone(aside(0.05), 0.4));
    for options in methods() {
        let free = fitter(options).fit().unwrap().cylinder;
        let result = fitter(Options { cylinder_limits: wide, ..options }).fit().unwrap();
        let difference = free.compare(&result.cylinder);
        // Eberly's fit minimises over the same directions; random samples are drawn in another way.
        let tolerance = if options.method == Method::Ransac { 0.02 } else { 1e-5 };
        assert!(
            difference.radius_relative.abs() < tolerance && difference.angle < tolerance,
            "{difference:?}"
        );
        assert!(!result.flags.intersects(Flags::RADIUS_AT_LIMIT | Flags::AXIS_AT_LIMIT));
    }
}

/// The least mean squared distance of the points for a direction, by Gauss-Newton for a circle in the plane across
/// it: nothing of the library is used. The radius may be given.
fn circle_cost(points: &[[f64; 3]], direction: &Vector3<f64>, fixed: Option<f64>) -> f64 {
    let (u, v) = any_orthogonal(direction);
    let flat: Vec<(f64, f64)> =
        points.iter().map(|p| (Vector3::from(*p).dot(&u), Vector3::from(*p).dot(&v))).collect();
    let axis = can().axis.point;
    let (mut x, mut y, mut r) = (axis.dot(&u), axis.dot(&v), fixed.unwrap_or(0.03));
    let residuals = |x: f64, y: f64, r: f64| flat.iter().map(move |(a, b)| (a - x).hypot(b - y) - r);
    for _ in 0..60 {
        let (mut matrix, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
        for ((a, b), e) in flat.iter().zip(residuals(x, y, r)) {
            let rho = (a - x).hypot(b - y);
            let row = Vector3::new((x - a) / rho, (y - b) / rho, if fixed.is_some() { 0.0 } else { -1.0 });
            matrix += row * row.transpose();
            gradient += row * e;
        }
        if fixed.is_some() {
            matrix[(2, 2)] = 1.0;
        }
        let step = matrix.lu().solve(&gradient).unwrap();
        (x, y, r) = (x - step.x, y - step.y, r - step.z);
    }
    residuals(x, y, r).map(|e| e * e).sum::<f64>() / flat.len() as f64
}

fn points_options(limits: CylinderLimits) -> Options {
    Options { method: Method::Points, cylinder_limits: limits, ..Options::default() }
}

#[test]
fn the_minimum_on_the_border_of_a_cone_is_that_of_a_dense_search_along_it() {
    let points = points();
    for (off, max_angle, fixed) in
        [(0.2, 0.1, None), (0.5, 0.45, None), (0.02, 1e-4, None), (1.2, 0.8, None), (0.2, 0.1, Some(0.029))]
    {
        let direction = aside(off);
        let limits =
            both(fixed.map_or(radius(0.0, f64::INFINITY), |r| radius(r, r)), cone(direction, max_angle));
        let result = fitter(points_options(limits)).fit().unwrap();
        assert!(result.flags.contains(Flags::AXIS_AT_LIMIT));
        let (u, v) = any_orthogonal(&direction);
        let at = |angle: f64| {
            let tangent = (u * angle.cos() + v * angle.sin()) * max_angle;
            circle_cost(&points, &rotate_direction(&direction, &tangent), fixed)
        };
        // Coarse, then fine about the lowest.
        let lowest = |middle: f64, reach: f64| {
            let angles = (-360..=360).map(|k| middle + reach * f64::from(k) / 360.0);
            angles.min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap()
        };
        let angle = lowest(lowest(0.0, TAU / 2.0), 0.01);
        let least = at(angle);
        let ratio = result.cost / least - 1.0;
        // The search is as fine as 3e-5 radians about the cone.
        assert!((-1e-7..1e-9).contains(&ratio), "{off} {max_angle} {fixed:?}: {ratio:e}");
    }
}

#[test]
fn the_minimum_at_a_limit_of_the_radius_is_that_of_a_dense_search_over_directions() {
    let points = points();
    for limits in [radius(0.0, 0.0285), radius(0.0315, 1.0), radius(0.029, 0.029)] {
        let result = fitter(points_options(limits)).fit().unwrap();
        let r = result.cylinder.radius;
        assert!(r == limits.radius_min || r == limits.radius_max);
        // A search by compass over the directions from that of the can.
        let (mut best, mut least) = (can().axis.direction, f64::INFINITY);
        let mut reach = 0.02;
        while reach > 1e-7 {
            let (u, v) = any_orthogonal(&best);
            let around = (0..8).map(|k| f64::from(k) * TAU / 8.0);
            let found = around
                .map(|angle| rotate_direction(&best, &((u * angle.cos() + v * angle.sin()) * reach)))
                .map(|d| (circle_cost(&points, &d, Some(r)), d))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            if found.0 < least {
                (least, best) = found;
            } else {
                reach *= 0.5;
            }
        }
        assert!((result.cost / least - 1.0).abs() < 1e-9, "{limits:?}: {} {least}", result.cost);
        assert!(result.gradient_norm < 1e-6 * result.cost.sqrt(), "{result:?}");
    }
}

#[test]
fn the_edges_alone_take_the_scale_from_a_fixed_radius() {
    let paper = Options { objective: ObjectiveKind::Paper, edge_weight: 1.0, ..Options::default() };
    let free = fitter(Options { start: StartKind::Model, ..paper }).fit().unwrap();
    assert!(free.flags.contains(Flags::SCALE_HELD));
    let options = Options { start: StartKind::Model, cylinder_limits: radius(0.03, 0.03), ..paper };
    let result = fitter(options).fit().unwrap();
    assert_eq!(result.cylinder.radius, 0.03);
    assert!(!result.flags.intersects(Flags::SCALE_HELD | Flags::WEAK_RADIUS), "{:?}", result.flags);
    let ratio = |c: &Cylinder| c.radius / c.distance_of_axis_from_origin();
    assert!((ratio(&result.cylinder) / ratio(&free.cylinder) - 1.0).abs() < 1e-9);
}

#[test]
fn what_cannot_hold_is_refused() {
    let chart = ChartChoice::Orthonormal;
    let error = fitter(Options { chart, cylinder_limits: radius(0.0, 1.0), ..Options::default() }).fit();
    assert_eq!(
        error.unwrap_err().to_string(),
        "the orthonormal chart knows no limits of radius or axis; choose the chart auto or local, or take the \
         limits away"
    );
    let bad = Options { cylinder_limits: radius(2.0, 1.0), ..Options::default() };
    assert_eq!(Fitter::new().set_options(bad).unwrap_err().name(), "INVALID_ARGUMENT");
}

#[test]
fn a_plane_fits_the_largest_radius_that_is_allowed() {
    let mut noise = Noise::new(5);
    let plane: Vec<[f64; 3]> = (0..400)
        .map(|k| {
            let (x, y) = (f64::from(k % 20) * 0.002, f64::from(k / 20) * 0.004);
            [x, y, 0.7 + 1e-5 * noise.normal()]
        })
        .collect();
    for options in methods().into_iter().filter(|o| o.method == Method::Points || o.method == Method::Fused) {
        if options.edge_weight == 1.0 {
            continue;
        }
        let mut fitter = fitter_with(&plane);
        let limits = both(radius(0.0, 0.1), cone(Vector3::y(), 0.0));
        let objective = ObjectiveKind::Robust;
        fitter.set_options(Options { objective, cylinder_limits: limits, ..options }).unwrap();
        let result = fitter.fit().unwrap();
        assert_eq!(result.cylinder.radius, 0.1);
        assert!(result.flags.contains(Flags::RADIUS_AT_LIMIT));
    }
}

/// A clean half tube along another direction than the limit allows: the error names the limit.
#[test]
fn points_that_no_axis_within_the_limit_fits_are_not_called_flat() {
    let point = |k: u32| {
        let angle = std::f64::consts::PI * f64::from(k % 40) / 39.0;
        [0.05 * angle.cos(), 0.01 * f64::from(k / 40), 0.8 - 0.05 * angle.sin()]
    };
    let points: Vec<[f64; 3]> = (0..800).map(point).collect();
    let mut fitter = fitter_with(&points);
    let cylinder_limits = cone(Vector3::x(), 0.0);
    fitter.set_options(Options { cylinder_limits, ..Options::default() }).unwrap();
    let text = fitter.fit().unwrap_err().to_string();
    assert!(text.starts_with("no cylinder with its axis within the limit fits the points: "), "{text}");
    assert!(text.contains("check axis and axis_max_angle"), "{text}");
}

#[test]
fn an_axis_without_a_length_is_named_with_its_default() {
    let limits = cone(Vector3::repeat(f64::NAN), 0.1);
    let text = limits.check().unwrap_err().to_string();
    assert!(text.contains("leave it at its default for any direction"), "{text}");
}
