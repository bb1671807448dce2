use super::*;
use crate::geometry::{AxisCone, Cylinder};
use crate::start::clouds::{Arc, normal, oblique, uniform};
use ControlFlow::{Break, Continue};

fn search(
    points: &[Vector3<f64>],
    normals: Option<&[Vector3<f64>]>,
    observer_at_origin: bool,
    options: &RansacOptions,
) -> Result<Cylinder> {
    ransac(points, normals, observer_at_origin, options, &mut || Continue(()))
}

fn fixed(threshold: f64) -> RansacOptions {
    RansacOptions { threshold, ..RansacOptions::default() }
}

fn radius(radius_min: f64, radius_max: f64) -> CylinderLimits {
    CylinderLimits { radius_min, radius_max, axis: None }
}

/// Asserts that two cylinders agree: radius and axis position relative to the radius, angle in radians.
fn assert_near(expected: &Cylinder, found: &Cylinder, tolerance: f64) {
    let difference = expected.compare(found);
    let shift = expected.axis.distance(&found.axis.point) / expected.radius;
    assert!(difference.radius_relative.abs() < tolerance, "{difference:?}");
    assert!(difference.angle < tolerance && shift < tolerance, "{difference:?} {shift}");
}

#[test]
fn points_without_noise_give_the_cylinder() {
    let (points, normals) = Arc::default().sample(1);
    for normals in [None, Some(normals.as_slice())] {
        for observer in [false, true] {
            let fit = search(&points, normals, observer, &RansacOptions::default()).unwrap();
            assert_near(&oblique(), &fit, 1e-9);
        }
    }
}

#[test]
fn noise_and_outliers_leave_the_cylinder() {
    for (noise, outliers, tolerance) in [(1e-3, 0.0, 0.02), (2e-4, 0.4, 0.01), (1e-3, 0.4, 0.05)] {
        for seed in 0..5 {
            let (points, normals) = Arc { noise, outliers, ..Arc::default() }.sample(seed);
            for normals in [None, Some(normals.as_slice())] {
                let options = RansacOptions { seed, ..RansacOptions::default() };
                let fit = search(&points, normals, true, &options).unwrap();
                assert_near(&oblique(), &fit, tolerance);
                let threshold =
                    searching(&points, normals, true, &options, &mut || Continue(()), |mut search| {
                        search.by_samples(&mut ChaCha8Rng::seed_from_u64(seed))?;
                        Ok(search.scorer.threshold)
                    });
                // 2.5 standard deviations of the noise; outliers inside the band widen it a little.
                assert!((2.0..3.5).contains(&(threshold.unwrap() / noise)), "{fit:?}");
            }
        }
    }
}

fn next_to(guess: &Cylinder, points: &[Vector3<f64>]) -> Option<Cylinder> {
    explained(points, true, &RansacOptions::default(), guess, &mut || ControlFlow::Continue(())).unwrap()
}

#[test]
fn a_guess_next_to_a_cylinder_without_outliers_leads_to_it() {
    let (points, _) = Arc { noise: 2e-4, ..Arc::default() }.sample(4);
    let near = Cylinder { radius: 1.1 * oblique().radius, ..oblique() };
    assert_near(&oblique(), &next_to(&near, &points).unwrap(), 0.02);
    // From another direction, if at all.
    let across = Vector3::new(0.0, oblique().axis.direction.z, -oblique().axis.direction.y);
    let wrong = Cylinder::new(oblique().axis.point, across, oblique().radius).unwrap();
    if let Some(found) = next_to(&wrong, &points) {
        assert_near(&oblique(), &found, 0.02);
    }
}

#[test]
fn a_guess_among_outliers_or_in_much_noise_explains_nothing() {
    // Three in ten points lie elsewhere.
    let (points, _) = Arc { noise: 1e-3, outliers: 0.3, ..Arc::default() }.sample(4);
    assert_eq!(next_to(&oblique(), &points), None);
    // The noise is a fifth of the radius.
    let (points, _) = Arc { noise: 0.2 * oblique().radius, ..Arc::default() }.sample(4);
    assert_eq!(next_to(&oblique(), &points), None);
}

#[test]
fn a_given_threshold_withstands_more_outliers_than_half() {
    let (points, _) = Arc { noise: 2e-4, outliers: 0.6, ..Arc::default() }.sample(3);
    let fit = search(&points, None, true, &fixed(6e-4)).unwrap();
    assert_near(&oblique(), &fit, 0.02);
}

#[test]
fn equal_seeds_give_equal_bits() {
    let (points, normals) = Arc { noise: 1e-3, outliers: 0.3, ..Arc::default() }.sample(4);
    for normals in [None, Some(normals.as_slice())] {
        let runs = [7, 7, 8].map(|seed| {
            let options = RansacOptions { seed, ..RansacOptions::default() };
            search(&points, normals, true, &options).unwrap()
        });
        assert_eq!(runs[0], runs[1]);
        assert_ne!(runs[0], runs[2]);
    }
}

#[test]
fn the_unit_of_length_and_the_position_do_not_matter() {
    let (points, _) = Arc { noise: 5e-4, outliers: 0.2, ..Arc::default() }.sample(5);
    let reference = search(&points, None, false, &RansacOptions::default()).unwrap();
    for (scale, offset) in
        [(1024.0, Vector3::zeros()), (1000.0, Vector3::zeros()), (1.0, Vector3::new(6e3, -7e3, 4e3))]
    {
        let moved: Vec<_> = points.iter().map(|p| p * scale + offset).collect();
        let fit = search(&moved, None, false, &RansacOptions::default()).unwrap();
        let mut expected = reference;
        expected.axis.point = expected.axis.point * scale + offset;
        expected.radius *= scale;
        assert_near(&expected, &fit, 1e-3);
        if scale == 1024.0 {
            // A power of two scales without rounding.
            assert_eq!(fit, expected);
        }
    }
}

#[test]
fn an_observer_sees_one_wall_only() {
    // Most points on an arc that is open towards the observer, as none sees a cylinder from outside, and the
    // others on one that is closed.
    let hollow = oblique();
    let c = hollow.axis.nearest_to_origin();
    let open = Arc { noise: 2e-4, points: 1200, ..Arc::default() }.sample(6).0;
    let mut cylinder = hollow;
    cylinder.axis.point += Vector3::new(0.08, 0.02, 0.0);
    let closed = Arc { cylinder, noise: 2e-4, points: 800, ..Arc::default() }.sample(7).0;
    let points: Vec<_> = open.iter().map(|p| c * 2.0 - p).chain(closed).collect();

    let fit = search(&points, None, false, &fixed(6e-4)).unwrap();
    assert_near(&hollow, &fit, 0.02);
    let fit = search(&points, None, true, &fixed(6e-4)).unwrap();
    assert_near(&cylinder, &fit, 0.02);
}

#[test]
fn an_observer_inside_sees_the_far_wall() {
    let pipe = Cylinder::new(Vector3::new(0.1, 0.05, 0.0), Vector3::new(0.1, 0.2, 1.0), 0.4).unwrap();
    let mut arc = Arc { cylinder: pipe, half_angle: 3.0, length: 2.0, noise: 5e-3, ..Arc::default() };
    arc.outliers = 0.2;
    let fit = search(&arc.sample(7).0, None, true, &RansacOptions::default()).unwrap();
    assert_near(&pipe, &fit, 0.02);
}

#[test]
fn limits_of_the_radius_hold() {
    let (points, normals) = Arc { noise: 2e-4, outliers: 0.1, ..Arc::default() }.sample(8);
    for (radius_min, radius_max) in [(0.0, 0.018), (0.023, 1.0), (0.0201, 0.0201), (0.019, 0.021)] {
        for normals in [None, Some(normals.as_slice())] {
            let options =
                RansacOptions { limits: radius(radius_min, radius_max), ..RansacOptions::default() };
            let fit = search(&points, normals, true, &options).unwrap();
            assert!((radius_min..=radius_max).contains(&fit.radius), "{fit:?}");
            assert!(oblique().compare(&fit).angle < 0.05, "{fit:?}");
        }
    }
    // A plane behind with more points than the cylinder, which a limit keeps from being one.
    let plane = (0..3000)
        .map(|i| Vector3::new(f64::from(i % 50) * 0.006 - 0.1, f64::from(i / 50) * 0.005 - 0.2, 0.73));
    let scene: Vec<_> = points.iter().copied().chain(plane).collect();
    let options = RansacOptions { limits: radius(0.0, 0.1), ..fixed(6e-4) };
    let fit = search(&scene, None, true, &options).unwrap();
    assert_near(&oblique(), &fit, 0.02);
}

#[test]
fn the_axis_stays_in_its_cone() {
    let (points, normals) = Arc { noise: 2e-4, outliers: 0.3, ..Arc::default() }.sample(14);
    let truth = oblique().axis.direction;
    let aside = crate::geometry::any_orthogonal(&truth).0;
    for (off, max_angle) in [(0.0, 0.0), (0.0, 1e-3), (0.03, 0.02), (0.1, 0.3), (0.5, 0.2), (1.5, 1.0)] {
        let direction = (truth * f64::cos(off) + aside * f64::sin(off)) * -7.0;
        let cone = AxisCone { direction, max_angle };
        let limits = CylinderLimits { axis: Some(cone), ..CylinderLimits::default() };
        for normals in [None, Some(normals.as_slice())] {
            let fit = search(&points, normals, true, &RansacOptions { limits, ..fixed(1e-3) }).unwrap();
            assert!(cone.contains(&fit.axis.direction), "{fit:?}");
            if off <= max_angle {
                assert_near(&oblique(), &fit, 0.03);
            }
        }
    }
}

#[test]
fn degenerate_clouds_are_refused() {
    let (a, b) = (Vector3::new(0.3, 0.1, -0.7), Vector3::new(-0.2, 0.9, 0.4));
    let line: Vec<_> = (0..50).map(|i| a * f64::from(i)).collect();
    let plane: Vec<_> = (0..50).map(|i| a * f64::from(i % 7) + b * f64::from(i / 7)).collect();
    let normals = vec![a.cross(&b); 50];
    let huge: Vec<_> = plane.iter().map(|p| p * 1e300).collect();
    for points in [line, plane, vec![a; 50], huge] {
        for normals in [None, Some(normals.as_slice())] {
            let error = search(&points, normals, true, &RansacOptions::default()).unwrap_err();
            assert!(matches!(error, Error::NoStart { .. }), "{error}");
        }
    }
    let (mut few, _) = Arc { points: 6, ..Arc::default() }.sample(9);
    few[1].x = f64::NAN;
    few[4].z = f64::INFINITY;
    let error = search(&few, None, true, &RansacOptions::default()).unwrap_err();
    assert!(matches!(error, Error::TooFewPoints { usable: 4, given: 6, needed: 5, .. }), "{error}");
    assert!(search(&[], None, true, &RansacOptions::default()).is_err());
}

#[test]
fn a_threshold_below_the_noise_finds_nothing() {
    let (points, _) = Arc { noise: 1e-3, points: 200, ..Arc::default() }.sample(10);
    let options = RansacOptions { max_iterations: 50, ..fixed(1e-9) };
    let error = search(&points, None, true, &options).unwrap_err();
    assert!(error.to_string().contains("none of 50 samples"), "{error}");
}

#[test]
fn the_least_numbers_of_points_work() {
    for count in 5..=8 {
        let (points, normals) = Arc { points: count, ..Arc::default() }.sample(11);
        let fit = search(&points, None, false, &RansacOptions::default()).unwrap();
        assert!(points.iter().all(|p| fit.distance(p).abs() < 1e-8), "{fit:?}");
        let fit = search(&points, Some(&normals), true, &RansacOptions::default()).unwrap();
        assert_near(&oblique(), &fit, 1e-8);
    }
}

#[test]
fn points_and_normals_that_are_not_finite_are_left_out() {
    let (mut points, mut normals) = Arc { noise: 2e-4, points: 5000, ..Arc::default() }.sample(12);
    for i in (0..5000).step_by(3) {
        points[i].y = f64::NAN;
        normals[i + 1] = Vector3::zeros();
    }
    for normals in [None, Some(normals.as_slice())] {
        let fit = search(&points, normals, true, &RansacOptions::default()).unwrap();
        assert_near(&oblique(), &fit, 0.02);
    }
}

#[test]
fn chosen_points_are_evenly_spaced_and_finite() {
    let points: Vec<_> =
        (0..10_001).map(|i| Vector3::repeat(if i % 5 == 2 { f64::NAN } else { f64::from(i) })).collect();
    let chosen = choose(&points, &mut || Continue(())).unwrap();
    assert_eq!(chosen.len(), SCORED_POINTS);
    assert!(chosen.iter().all(|i| i % 5 != 2));
    assert!(chosen.windows(2).all(|pair| (4..=7).contains(&(pair[1] - pair[0]))));
    assert_eq!(choose(&points[..100], &mut || Continue(())).unwrap().len(), 80);
}

#[test]
fn options_out_of_range_are_refused_with_their_value() {
    let (points, normals) = Arc { points: 50, ..Arc::default() }.sample(13);
    let good = RansacOptions::default;
    let cases = [
        (RansacOptions { max_iterations: 0, ..good() }, "max_iterations is 0"),
        (RansacOptions { max_iterations: usize::MAX, ..good() }, "max_iterations is"),
        (RansacOptions { threshold: -1.0, ..good() }, "threshold is -1"),
        (RansacOptions { threshold: f64::NAN, ..good() }, "threshold is NaN"),
        (RansacOptions { limits: radius(-0.5, f64::INFINITY), ..good() }, "radius_min is -0.5"),
        (RansacOptions { limits: radius(f64::INFINITY, f64::INFINITY), ..good() }, "radius_min is inf"),
        (RansacOptions { limits: radius(0.0, 0.0), ..good() }, "radius_max is 0"),
        (RansacOptions { limits: radius(2.0, 1.0), ..good() }, "radius_max is 1"),
        (RansacOptions { limits: radius(0.0, f64::NAN), ..good() }, "radius_max is NaN"),
    ];
    for (options, text) in cases {
        let error = search(&points, None, true, &options).unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
    }
    let error = search(&points, Some(&normals[..49]), true, &good()).unwrap_err();
    assert!(error.to_string().contains("number of normals is 49"), "{error}");
}

/// A cylinder on a wide plane behind it that has more points, with noise.
fn beside_a_plane(noise: f64, on_plane: usize, seed: u64) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let (mut points, mut normals) = Arc { noise, ..Arc::default() }.sample(seed);
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 100);
    let across = Vector3::new(0.1, -0.3, -1.0).normalize();
    let (u, v) = crate::geometry::any_orthogonal(&across);
    let center = Vector3::new(0.0, 0.0, 0.75);
    for _ in 0..on_plane {
        let (a, b) = (uniform(&mut rng) - 0.5, uniform(&mut rng) - 0.5);
        points.push(center + u * a + v * b + across * (noise * normal(&mut rng)));
        normals.push((across + Vector3::from_fn(|_, _| 0.02 * normal(&mut rng))).normalize());
    }
    (points, normals)
}

#[test]
fn a_plane_is_no_cylinder_beside_one() {
    let mut wrong = Vec::new();
    for seed in 0..4 {
        for (noise, on_plane) in [(2e-4, 3000), (1e-3, 2500)] {
            let (points, normals) = beside_a_plane(noise, on_plane, seed);
            for normals in [None, Some(normals.as_slice())] {
                // A threshold from the data would need most points on the cylinder.
                let options = RansacOptions { seed, ..fixed(2.5 * noise) };
                let fit = search(&points, normals, true, &options).unwrap();
                if (fit.radius / oblique().radius - 1.0).abs() > 0.2 {
                    wrong.push((seed, noise, normals.is_some(), fit.radius));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_plane_alone_is_still_found() {
    let (points, normals) = beside_a_plane(1e-3, 3000, 1);
    let fit = search(&points[2000..], Some(&normals[2000..]), true, &fixed(3e-3)).unwrap();
    let near = points[2000..].iter().filter(|p| fit.distance(p).abs() < 3e-3).count();
    assert!(near > 2800 && fit.radius > 1.0, "{fit:?}");
}

#[test]
fn a_flat_arc_of_a_large_cylinder_is_one() {
    // 30° of a tank, whose sagitta of 3.4 cm is far above the noise.
    let cylinder = Cylinder::new(Vector3::new(0.1, 0.0, 3.0), Vector3::new(0.1, 1.0, 0.1), 1.0).unwrap();
    let half_angle = 15_f64.to_radians();
    let (points, _) = Arc { cylinder, half_angle, length: 0.6, noise: 2e-3, ..Arc::default() }.sample(3);
    let fit = search(&points, None, true, &RansacOptions::default()).unwrap();
    assert!((fit.radius - 1.0).abs() < 0.05, "{fit:?}");
}

#[test]
fn the_search_ends_where_the_check_breaks() {
    let (points, normals) = Arc { noise: 1e-3, outliers: 0.6, ..Arc::default() }.sample(4);
    for normals in [None, Some(normals.as_slice())] {
        let mut most = 0;
        let options = RansacOptions::default();
        ransac(&points, normals, true, &options, &mut || {
            most += 1;
            Continue(())
        })
        .unwrap();
        assert!(most > 200, "{most}");
        for allowed in [0, 1, 2, 60, 75, most - 1] {
            let mut calls = 0;
            let result = ransac(&points, normals, true, &options, &mut || {
                calls += 1;
                if calls > allowed { Break(()) } else { Continue(()) }
            });
            assert!(matches!(result, Err(Error::Cancelled { .. })), "{result:?}");
            // It is not asked again.
            assert_eq!(calls, allowed + 1);
        }
    }
}
