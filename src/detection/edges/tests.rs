use super::*;
use crate::camera::{Distortion, Intrinsics};
use crate::observations::ImageView;

const SIZE: (usize, usize) = (160, 120);

fn camera() -> Camera {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    Camera::new(Intrinsics {
        width,
        height,
        fx: 150.0,
        fy: 150.0,
        cx: 79.5,
        cy: 59.5,
        distortion: Distortion::None,
    })
    .unwrap()
}

/// The ends in pixels of the edges in an image of the given brightness, with errors between −2 and 2 that are always the
/// same.
fn found(brightness: impl Fn(f64) -> f64) -> Vec<[Vector2<f64>; 2]> {
    let mut state = 5_u32;
    let pixels: Vec<u8> = (0..SIZE.0 * SIZE.1)
        .map(|k| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let error = f64::from(state >> 16) / 65_536.0 * 4.0 - 2.0;
            (brightness((k % SIZE.0) as f64) + error).round() as u8
        })
        .collect();
    let image = GreyImage::copy(&ImageView::from_u8(&pixels, SIZE).unwrap()).unwrap();
    let camera = camera();
    let pixel = |p: &Vector2<f64>| Vector2::new(p.x * 150.0 + 79.5, p.y * 150.0 + 59.5);
    edges(&image, &camera).iter().map(|edge| edge.ends.map(|p| pixel(&p))).collect()
}

/// How many rows the edges next to a column cover.
fn covered(edges: &[[Vector2<f64>; 2]], column: f64) -> f64 {
    let beside = |ends: &&[Vector2<f64>; 2]| ends.iter().all(|p| (p.x - column).abs() < 1.0);
    edges.iter().filter(beside).map(|ends| (ends[1].y - ends[0].y).abs()).sum()
}

#[test]
fn a_step_is_an_edge_along_its_whole_length() {
    let edges = found(|x| if x < 60.0 { 60.0 } else { 120.0 });
    assert!(covered(&edges, 59.5) > 110.0, "{edges:?}");
}

#[test]
fn shading_beside_a_limb_does_not_hide_it() {
    // A limb with a step of 30, beside which the body gets brighter by 4 a pixel.
    let edges = found(|x| 60.0 + if x < 60.0 { 0.0 } else { (30.0 + 4.0 * (x - 60.0)).min(150.0) });
    assert!(covered(&edges, 59.5) > 100.0, "{edges:?}");
}

#[test]
fn the_lower_quartile_is_that_of_the_ordered_list() {
    let mut state = 7_u32;
    for count in [1, 2, 5, 1000] {
        let numbers: Vec<f32> = (0..count)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // Many share the upper half of their bits, some all of them.
                1.0 + (state >> 20) as f32 * 1e-6
            })
            .collect();
        let mut ordered = numbers.clone();
        ordered.sort_by(f32::total_cmp);
        assert_eq!(lower_quartile(&numbers), Some(ordered[count / 4]));
    }
    assert_eq!(lower_quartile(&[]), None);
}

#[test]
fn pixels_come_by_their_magnitude() {
    let magnitudes: Vec<f32> = (0..500_u16).map(|k| f32::from(k * 131 % 97) * 1.7e-3).collect();
    let order: Vec<u32> = (0..500).filter(|k| k % 3 != 0).collect();
    let mut sorted = order.clone();
    sorted.sort_by(|&a, &b| magnitudes[b as usize].total_cmp(&magnitudes[a as usize]));
    assert_eq!(strongest_first(order, &magnitudes), sorted);
}
