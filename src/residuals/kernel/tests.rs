use super::super::NormalEquations;
use super::super::loss::{Influence, Truncated, Tukey, Wall};
use super::super::points::{PointRows, unpack};
use super::*;
use crate::geometry::Cylinder;
use pulp::Scalar;

/// Points about an axis, of some size.
fn axes(count: usize, size: f64) -> [Vec<f64>; 3] {
    let t = |k: usize| k as f64;
    [
        (0..count).map(|k| size * (0.1 + 0.09 * (t(k) * 0.37).sin())).collect(),
        (0..count).map(|k| size * (-0.2 + 0.1 * (t(k) * 0.11).cos())).collect(),
        (0..count).map(|k| size * (0.85 + 0.03 * (t(k) * 1.7).sin())).collect(),
    ]
}

fn frame(size: f64) -> LocalFrame {
    let point = Vector3::new(0.1, -0.2, 0.9) * size;
    let cylinder = Cylinder::new(point, Vector3::new(0.4, 0.8, 0.3), 0.07 * size).unwrap();
    LocalFrame::new(&cylinder, &point, 0.05 * size)
}

/// The sums of every width of the instructions are the same to the last bit, and to 1e-6 those of single points.
fn compare(axes: [&[f64]; 3], frame: &LocalFrame, loss: impl Loss) {
    let (count, origin) = (axes[0].len(), Vector3::zeros());
    let weights: Vec<f32> = (0..count).map(|k| (k % 3) as f32).collect();
    let kernel = &Kernel::new(&origin, frame);
    let chunk = || Chunk { kernel, axes, weights: Some(&weights), range: 0..count, terms: Whole(loss) };
    let wide = kernel.chunk(axes, Some(&weights), 0..count, Whole(loss));
    let mut widths = vec![chunk().with_simd(Scalar::new())];
    #[cfg(target_arch = "x86_64")]
    {
        widths.extend(pulp::x86::V3::try_new().map(|simd| Simd::vectorize(simd, chunk())));
        widths.extend(pulp::x86::V4::try_new().map(|simd| Simd::vectorize(simd, chunk())));
    }
    for sums in widths {
        assert_eq!(wide.map(f64::to_bits), sums.map(f64::to_bits));
    }
    let mut expected = NormalEquations::zero();
    let rows = PointRows::new(frame);
    for (k, weight) in weights.iter().enumerate() {
        let (e, jacobian, facing) = rows.row(&Vector3::new(axes[0][k], axes[1][k], axes[2][k]));
        let Influence { loss: value, weight: factor, .. } = loss.influence(e, facing);
        let weight = f64::from(*weight);
        expected.add_residual(weight * factor, e, &jacobian);
        expected.cost += weight * (value - factor * e * e);
    }
    let sums = unpack(&wide);
    let near = |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-6 * size;
    assert!(near(sums.cost, expected.cost, expected.cost), "{} {}", sums.cost, expected.cost);
    let size = (expected.hessian.trace() * expected.cost).sqrt();
    assert!(near((sums.gradient - expected.gradient).norm(), 0.0, size));
    assert!(near((sums.hessian - expected.hessian).norm(), 0.0, expected.hessian.norm()));
}

#[test]
fn sums_agree_with_those_of_single_points_for_ordinary_huge_and_tiny_coordinates() {
    for size in [1.0, 1e60, 1e-60] {
        for count in [1, 7, 8, 9, 127, 128, 129, 1000] {
            for wall in [Wall::Either, Wall::Facing, Wall::Averted] {
                let (axes, frame) = (axes(count, size), frame(size));
                compare(axes.each_ref().map(|axis| &axis[..]), &frame, super::super::loss::Squared);
                compare(axes.each_ref().map(|axis| &axis[..]), &frame, Tukey { cutoff: 0.8, wall });
                compare(axes.each_ref().map(|axis| &axis[..]), &frame, Truncated { threshold: 0.5, wall });
            }
        }
    }
}

#[test]
fn sums_are_finite_where_all_points_are_on_the_axis_or_on_the_surface() {
    let frame = frame(1.0);
    let cylinder = frame.cylinder;
    for point in [cylinder.axis.point, cylinder.axis.point + frame.u * cylinder.radius] {
        let axes = [0, 1, 2].map(|k| vec![point[k]; 20]);
        compare(axes.each_ref().map(|axis| &axis[..]), &frame, Tukey { cutoff: 1.0, wall: Wall::Facing });
        let tiny = Tukey { cutoff: f64::MIN_POSITIVE, wall: Wall::Either };
        let sums = Kernel::new(&Vector3::zeros(), &frame).chunk(
            axes.each_ref().map(|axis| &axis[..]),
            None,
            0..20,
            Whole(tiny),
        );
        assert!(sums.iter().all(|sum| sum.is_finite()));
    }
}
