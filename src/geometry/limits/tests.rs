use super::*;

fn cylinder() -> Cylinder {
    Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.4, 0.8, 0.3), 0.07).unwrap()
}

/// A cone of the given angle whose middle is `off` away from the axis of the cylinder.
fn cone(off: f64, max_angle: f64) -> AxisCone {
    let d = cylinder().axis.direction;
    AxisCone { direction: rotate_direction(&d, &(any_orthogonal(&d).1 * off)) * -3.0, max_angle }
}

fn limits(radius_min: f64, radius_max: f64, axis: Option<AxisCone>) -> CylinderLimits {
    CylinderLimits { radius_min, radius_max, axis }
}

/// Numbers in [-1, 1], the same at every run.
fn numbers(seed: u32) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 23) - 1.0
    }
}

#[test]
fn what_lies_outside_moves_to_the_border() {
    let center = cylinder().axis.point - Vector3::z() * 0.07;
    for (off, max_angle) in [(0.4, 0.1), (1.2, 0.0), (0.3, 1e-9), (1e-5, 1e-6), (1.5, 1.2), (0.2, 1e-300)] {
        let cone = cone(off, max_angle);
        let limits = limits(0.0, 0.05, Some(cone));
        let moved = limits.nearest(&cylinder(), &center);
        assert!(limits.contain(&moved), "{off} {max_angle}");
        assert_eq!(moved.radius, 0.05);
        assert!(limits.hold_radius(&moved) && limits.hold_axis(&moved) == (max_angle > 0.0));
        assert!(moved.axis.direction.dot(&cylinder().axis.direction) > 0.0);
        let turned = moved.axis.angle(&cylinder().axis);
        assert!((turned - (off - max_angle)).abs() < 1e-12, "{turned}");
        assert_eq!(limits.nearest(&moved, &center), moved);
        if max_angle == 0.0 {
            assert_eq!(moved.axis.direction, -cone.middle());
        }
    }
    // The surface stays where it faces the data.
    let wider = limits(0.09, 0.09, None).nearest(&cylinder(), &center);
    assert!((wider.distance(&center) - cylinder().distance(&center)).abs() < 1e-15);
    assert_eq!(
        limits(0.0, f64::INFINITY, Some(cone(1.0, FRAC_PI_2))).nearest(&cylinder(), &center),
        cylinder()
    );
}

/// Compares the step with many others that keep the limits, on random models.
#[test]
fn no_other_step_within_the_limits_is_lower() {
    let mut active = [0; 4];
    for seed in 0..400 {
        let mut number = numbers(seed);
        let random = TangentMap::from_fn(|_, _| number());
        let hessian = random * random.transpose() + TangentMap::identity() * 0.05;
        // Small ones leave the minimum inside now and then.
        let size = [0.6, 0.2, 0.04, 0.01][seed as usize % 4];
        let gradient = Tangent::from_fn(|_, _| size * number());
        let frame = LocalFrame::new(&cylinder(), &Vector3::new(0.3, 0.1, 0.8), 0.05);
        let max_angle = 0.1 + 0.05 * number();
        let limits = limits(0.06, 0.08, Some(cone(0.07, max_angle)));
        let frame = LocalFrame { cylinder: limits.nearest(&frame.cylinder, &Vector3::zeros()), ..frame };
        let frame = LocalFrame::new(&frame.cylinder, &frame.cylinder.axis.point, frame.unit);
        let (_, best) = limits.step(&frame, &hessian, &gradient).unwrap();
        assert!(limits.contain(&best));
        active[usize::from(limits.hold_radius(&best)) + 2 * usize::from(limits.hold_axis(&best))] += 1;

        // The model, in the coordinates that it is a model in.
        let cone = limits.cone().unwrap();
        let chart = ConeChart::new(cone, &frame.cylinder.axis.direction);
        let map = chart.tangent_map(&frame);
        let model = |cylinder: &Cylinder| {
            let shift = (cylinder.axis.point - frame.cylinder.axis.point) / frame.unit;
            let w = ConeChart::new(cone, &cylinder.axis.direction).position - chart.position;
            let radius = (cylinder.radius - frame.cylinder.radius) / frame.unit;
            let delta = map * Tangent::new(shift.dot(&frame.u), shift.dot(&frame.v), w.x, w.y, radius);
            gradient.dot(&delta) + 0.5 * (delta.transpose() * hessian * delta)[0]
        };
        let least = model(&best);
        for k in 0..2000 {
            let size = 0.5_f64.powi(k % 20);
            let mut other = best;
            other.axis.point += (frame.u * number() + frame.v * number()) * (size * frame.unit);
            other.axis.direction =
                rotate_direction(&best.axis.direction, &((frame.u * number() + frame.v * number()) * size));
            other.radius += number() * size * frame.unit;
            other.axis.direction = cone.nearest(&other.axis.direction);
            other.radius = other.radius.clamp(limits.radius_min, limits.radius_max);
            assert!(model(&other) >= least - 1e-12, "seed {seed}: {} < {least}", model(&other));
        }
    }
    assert!(active.iter().all(|&count| count > 3), "{active:?}");
}

#[test]
fn the_chart_of_the_cone_has_the_derivative_it_says() {
    for (off, side) in [(0.3, 1.0), (1.4, -1.0), (0.0, 1.0), (1e-7, -1.0)] {
        let mut cylinder = cylinder();
        cylinder.axis.direction *= side;
        let cone = cone(off, 1.5);
        let frame = LocalFrame::new(&cylinder, &Vector3::zeros(), 0.1);
        let chart = ConeChart::new(&cone, &cylinder.axis.direction);
        assert!((chart.direction(&cone, &chart.position) - cylinder.axis.direction).norm() < 1e-15);
        let map = chart.tangent_map(&frame);
        let h = 1e-6;
        for k in 0..2 {
            let step = Vector2::ith(k, h);
            let [ahead, behind] = [step, -step].map(|step| chart.direction(&cone, &(chart.position + step)));
            let difference = (ahead - behind) / (2.0 * h);
            let tilt = Vector2::new(difference.dot(&frame.u), difference.dot(&frame.v));
            assert!((tilt - map.fixed_view::<2, 1>(2, 2 + k)).norm() < 1e-9, "{off} {k}");
        }
    }
}

#[test]
fn a_minimum_on_the_border_has_no_gradient_left() {
    let frame = LocalFrame::new(&cylinder(), &Vector3::zeros(), 1.0);
    let out = Tangent::new(0.0, 0.0, 0.0, 0.0, -2.0);
    let rest = |limits: CylinderLimits, gradient: &Tangent| limits.free_gradient(&frame, gradient).norm();
    assert_eq!(rest(limits(0.0, 0.07, None), &out), 0.0);
    assert_eq!(rest(limits(0.07, 0.1, None), &out), 2.0);
    assert_eq!(rest(limits(0.07, 0.07, None), &-out), 0.0);
    assert_eq!(rest(CylinderLimits::default(), &out), 2.0);
    let known = limits(0.0, f64::INFINITY, Some(cone(0.0, 0.0)));
    assert_eq!(rest(known, &Tangent::new(0.0, 0.0, 3.0, 4.0, 0.0)), 0.0);
    // The cost falls along the great circle away from the middle of the cone, or back to it.
    let edge = limits(0.0, f64::INFINITY, Some(cone(0.1, 0.1)));
    let away = any_orthogonal(&cylinder().axis.direction).1;
    let gradient = |sign: f64| Tangent::new(0.0, 0.0, away.dot(&frame.u), away.dot(&frame.v), 0.0) * sign;
    assert!(rest(edge, &gradient(1.0)) < 1e-8 && (rest(edge, &gradient(-1.0)) - 1.0).abs() < 1e-8);
}

#[test]
fn limits_out_of_range_are_named() {
    let cases = [
        (limits(-1.0, 1.0, None), "radius_min is -1; it must be finite and at least 0"),
        (limits(2.0, 1.0, None), "radius_max is 1; it must be greater than 0 and at least radius_min, 2"),
        (limits(f64::NAN, 1.0, None), "radius_min is NaN"),
        (limits(0.0, f64::NAN, None), "radius_max is NaN"),
        (limits(1.7e308, 1.7e308, None), "radius_min is 1.7e308; it must be at most 1e100"),
        (limits(1.0, 1e200, None), "radius_max is 1e200; it must be at most 1e100"),
        (
            limits(0.0, 1.0, Some(AxisCone { direction: Vector3::zeros(), max_angle: 0.1 })),
            "axis is [0.0, 0.0, 0.0]; it must not be zero; leave it at its default for any direction",
        ),
        (
            limits(0.0, 1.0, Some(AxisCone { direction: Vector3::new(f64::NAN, 0.0, 1.0), max_angle: 0.1 })),
            "axis is [NaN, 0.0, 1.0]; it must have a finite length; leave it at its default for any direction",
        ),
        (limits(0.0, 1.0, Some(cone(0.0, 1.6))), "axis_max_angle is 1.6; it must lie in [0, pi/2]"),
        (limits(0.0, 1.0, Some(cone(0.0, -0.1))), "axis_max_angle is -0.1"),
        (limits(0.0, 1.0, Some(cone(0.0, f64::NAN))), "axis_max_angle is NaN"),
    ];
    for (limits, text) in cases {
        let error = limits.check().unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
    }
    assert!(limits(0.5, 0.5, Some(cone(0.0, 0.0))).check().is_ok());
}
