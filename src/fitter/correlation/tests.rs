use super::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5).collect()
}

fn grid(columns: usize, rows: usize) -> Vec<[usize; 2]> {
    (0..columns * rows).map(|k| [k % columns, k / columns]).collect()
}

fn lattice(cells: &[[usize; 2]]) -> Lattice {
    Lattice::new([0, 1].map(|axis| cells.iter().map(|cell| cell[axis] as u32).collect())).unwrap()
}

/// Means over windows of pixels by pixels.
fn smooth(columns: usize, rows: usize, window: [usize; 2]) -> Vec<f64> {
    let (wide, high) = (columns + window[0], rows + window[1]);
    let raw = noise(wide * high, 1);
    let mean = |cell: &[usize; 2]| -> f64 {
        let inside = (0..window[1]).flat_map(|y| (0..window[0]).map(move |x| [x, y]));
        inside.map(|[x, y]| raw[(cell[1] + y) * wide + cell[0] + x]).sum()
    };
    grid(columns, rows).iter().map(mean).collect()
}

#[test]
fn products_are_summed_as_one_by_one() {
    for size in [1.0, 1e15, 1e-15, 0.0] {
        for count in [0, 1, 31, 32, 33, 4096, 4097, 5000] {
            let number = |k: usize| (size * (k as f64 * 0.37).sin()) as f32;
            let (a, b): (Vec<f32>, Vec<f32>) = (0..count).map(|k| (number(k), number(3 * k + 1))).unzip();
            let products = || a.iter().zip(&b).map(|(a, b)| f64::from(*a) * f64::from(*b));
            let scale: f64 = products().map(f64::abs).sum();
            assert!((dot(&a, &b) - products().sum::<f64>()).abs() <= 1e-6 * scale);
        }
    }
}

#[test]
fn independent_noise_has_as_many_independent_points_as_points() {
    for (columns, rows) in [(10, 5), (25, 20), (80, 60)] {
        let lattice = lattice(&grid(columns, rows));
        let count = columns * rows;
        let part = |seed: u64| lattice.independent_points(&noise(count, seed), 1.0) / count as f64;
        let mean = (0..200).map(part).sum::<f64>() / 200.0;
        assert!((0.98..=1.0).contains(&mean), "{count}: {mean}");
    }
}

#[test]
fn the_ranges_are_those_of_a_moving_average() {
    // The mean of 5 neighbours has the correlation 1 − k / 5, so that 1 + 2 Σ ρ is 5.
    let residuals = smooth(200, 150, [5, 3]);
    let found = lattice(&grid(200, 150)).independent_points(&residuals, 100.0);
    assert!((found * 15.0 / 30_000.0 - 1.0).abs() < 0.05, "{found}");
}

#[test]
fn points_along_a_line_make_no_large_grid() {
    let count = 10_000;
    for (slope, scatter) in [(1.0, 0.0), (0.0, 1e-6), (0.0, 1e-12), (1e-3, 1e-9)] {
        let along = noise(count, 4).into_iter().zip(noise(count, 5));
        let positions: (Vec<f64>, Vec<f64>) =
            along.map(|(t, jitter)| (slope * t + scatter * jitter, t)).unzip();
        let cells = Lattice::of_positions([&positions.0[..], &positions.1[..]].map(List::from))
            .map_or(0, |lattice| lattice.shares.len());
        assert!(cells < 100 * count, "{slope} {scatter}: {cells} cells");
    }
}

#[test]
fn frames_of_a_still_camera_count_by_what_is_new_in_them() {
    let positions = |frames: usize| {
        let position = |axis: usize| move |cell: [usize; 2]| cell[axis] as f64 / 570.0;
        [0, 1].map(|axis| (0..frames).flat_map(|_| grid(60, 50).into_iter().map(position(axis))).collect())
    };
    let of = |frames: usize, residuals: &[f64]| {
        Lattice::of_positions(positions(frames)).unwrap().independent_points(residuals, 100.0)
    };
    let frame = smooth(60, 50, [3, 3]);
    let one = of(1, &frame);
    let more = noise(12 * 3_000, 7);
    for frames in [2, 3, 4, 5, 8, 12] {
        let alike = of(frames, &frame.repeat(frames));
        assert!((alike / one - 1.0).abs() < 0.25, "{frames} times one frame: {alike} of {one}");
        let other = of(frames, &more[..frames * 3_000]);
        assert!((other / (frames as f64 * 3_000.0) - 1.0).abs() < 0.1, "{frames} frames: {other}");
    }
}

#[test]
fn frames_with_pixels_that_drop_out_count_what_is_left() {
    let keys = noise(12 * 3_000, 11);
    let residuals = noise(12 * 3_000, 12);
    for (frames, part) in [(4, 0.1), (10, 0.0)] {
        // Of uniform numbers 60 and 50 % are above the limit.
        let kept: Vec<usize> = (0..frames * 3_000).filter(|&k| keys[k] > -part).collect();
        let cells = grid(60, 50);
        let positions =
            [0, 1].map(|axis| kept.iter().map(|k| cells[k % 3_000][axis] as f64 / 570.0).collect());
        let values: Vec<f64> = kept.iter().map(|&k| residuals[k]).collect();
        let found = Lattice::of_positions(positions).unwrap().independent_points(&values, 100.0);
        assert!((found / kept.len() as f64 - 1.0).abs() < 0.1, "{found} of {}", kept.len());
    }
}

#[test]
fn narrow_strips_that_lie_aslant_share_no_positions() {
    for (width, slope) in [(4.0, 1.0_f64), (8.0, 1.0), (8.0, 0.6), (12.0, 0.2)] {
        let length = slope.hypot(1.0);
        let inside = |cell: &[usize; 2]| {
            let across = (cell[1] as f64 - slope * cell[0] as f64) / length;
            (0.0..width).contains(&across)
        };
        let cells: Vec<[usize; 2]> = grid(280, 280).into_iter().filter(inside).collect();
        let values = noise(cells.len(), 5);
        let positions = [0, 1].map(|axis| cells.iter().map(|cell| cell[axis] as f64 / 570.0).collect());
        let found = Lattice::of_positions(positions).unwrap().independent_points(&values, 100.0);
        assert!(found > 0.8 * cells.len() as f64, "{width} {slope}: {found} of {}", cells.len());
    }
}

#[test]
fn the_order_of_the_points_and_the_shape_of_the_region_do_not_matter() {
    let inside = |cell: &[usize; 2]| (cell[0] as f64 - 60.0).hypot(cell[1] as f64 - 50.0) < 45.0;
    let residuals = smooth(120, 100, [4, 4]);
    let points: Vec<([usize; 2], f64)> =
        grid(120, 100).into_iter().zip(residuals).filter(|(cell, _)| inside(cell)).collect();
    let count = |points: &[([usize; 2], f64)]| {
        let cells: Vec<[usize; 2]> = points.iter().map(|point| point.0).collect();
        let residuals: Vec<f64> = points.iter().map(|point| point.1).collect();
        let by_pixels = lattice(&cells).independent_points(&residuals, 100.0);
        let positions = [0, 1].map(|axis| cells.iter().map(|cell| cell[axis] as f64 / 570.0).collect());
        (by_pixels, Lattice::of_positions(positions).unwrap().independent_points(&residuals, 100.0))
    };
    let (by_pixels, by_positions) = count(&points);
    assert!((by_pixels * 16.0 / points.len() as f64 - 1.0).abs() < 0.15, "{by_pixels}");
    assert!((by_positions / by_pixels - 1.0).abs() < 0.2, "{by_positions} {by_pixels}");
    let mut shuffled = points.clone();
    let mut keys = noise(points.len(), 3).into_iter();
    shuffled.sort_by_cached_key(|_| keys.next().map(|key| (key * 1e9) as i64));
    let (a, b) = count(&shuffled);
    assert!((a / by_pixels - 1.0).abs() < 1e-9 && (b / by_positions - 1.0).abs() < 1e-9);
}

#[test]
fn turns_are_those_of_the_arc_tangent() {
    let worst = (0..10_000)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 0.000_7 - 3.5).sin_cos();
            (turn(2.0 * cos, 2.0 * sin) - sin.atan2(cos)).abs()
        })
        .fold(0.0, f64::max);
    assert!(worst < 4e-4, "{worst}");
    assert_eq!([turn(0.0, 0.0), turn(1.0, 0.0), turn(0.0, 1.0)], [0.0, 0.0, FRAC_PI_2]);
}
