//! Frames as another grid of pixels would hold them: the image by bicubic interpolation, or by means where it gets
//! smaller; mask and depth by the nearest pixel; camera and edges to match.

use crate::frame::Frame;
use crate::frames::Inputs;

/// Numbers of pixels that stand for others along either side.
#[derive(Clone, Copy, PartialEq)]
pub struct Scale {
    pub of_new: usize,
    pub of_old: usize,
}

/// The grid as it is.
pub const SAME: Scale = Scale { of_new: 1, of_old: 1 };

impl Scale {
    /// The place of the middle of a new pixel on the old grid.
    fn to_old(self, place: usize) -> f64 {
        (place as f64 + 0.5) * self.of_old as f64 / self.of_new as f64 - 0.5
    }

    /// The place on the new grid of a place on the old one.
    fn to_new(self, place: f64) -> f64 {
        (place + 0.5) * self.of_new as f64 / self.of_old as f64 - 0.5
    }

    fn count(self, pixels: usize) -> usize {
        pixels * self.of_new / self.of_old
    }

    /// The frame on the new grid.
    pub fn applied(self, frame: &Frame) -> Frame {
        let Inputs { intrinsics, size, depth, depth_scale, mask, image, edges } = &frame.inputs;
        let ratio = self.of_new as f64 / self.of_old as f64;
        let new_size = (self.count(size.0), self.count(size.1));
        let mut intrinsics = *intrinsics;
        (intrinsics.width, intrinsics.height) = (new_size.0 as u32, new_size.1 as u32);
        (intrinsics.fx, intrinsics.fy) = (intrinsics.fx * ratio, intrinsics.fy * ratio);
        (intrinsics.cx, intrinsics.cy) = (self.to_new(intrinsics.cx), self.to_new(intrinsics.cy));
        let mut edges = edges.clone();
        for q in edges.iter_mut().flat_map(|segment| &mut segment.endpoints) {
            q.iter_mut().for_each(|x| *x = self.to_new(*x));
        }
        Frame {
            name: frame.name.clone(),
            inputs: Inputs {
                intrinsics,
                size: new_size,
                depth: self.nearest(depth, *size),
                depth_scale: *depth_scale,
                mask: self.nearest(mask, *size),
                image: self.image(image, *size),
                edges,
            },
            color: None,
            truth: frame.truth,
            radius_known: frame.radius_known,
            length: frame.length,
            ends_seen: frame.ends_seen,
        }
    }

    fn nearest<T: Copy>(self, values: &[T], (width, height): (usize, usize)) -> Vec<T> {
        let old = |place: usize| place * self.of_old / self.of_new;
        let columns = self.count(width);
        let pixel = |k: usize| values[old(k / columns) * width + old(k % columns)];
        (0..columns * self.count(height)).map(pixel).collect()
    }

    fn image(self, image: &[u8], (width, height): (usize, usize)) -> Vec<u8> {
        let rows: Vec<f64> = self.rows(&image.iter().map(|&v| f64::from(v)).collect::<Vec<_>>(), width);
        let columns = self.rows(&transposed(&rows, self.count(width)), height);
        let image = transposed(&columns, self.count(height));
        image.into_iter().map(|value| value.round().clamp(0.0, 255.0) as u8).collect()
    }

    /// Every row on the new grid.
    fn rows(self, values: &[f64], width: usize) -> Vec<f64> {
        let taps: Vec<Vec<(usize, f64)>> =
            (0..self.count(width)).map(|place| self.taps(place, width)).collect();
        let row = |row: &[f64]| -> Vec<f64> {
            taps.iter().map(|taps| taps.iter().map(|&(k, weight)| weight * row[k]).sum()).collect()
        };
        values.chunks_exact(width).flat_map(row).collect()
    }

    /// The old pixels and their weights at the middle of a new one.
    fn taps(self, place: usize, width: usize) -> Vec<(usize, f64)> {
        let inside = |k: i64| k.clamp(0, width as i64 - 1) as usize;
        if self.of_new < self.of_old {
            let first = place * self.of_old / self.of_new;
            let count = self.of_old / self.of_new;
            return (first..first + count).map(|k| (k, 1.0 / count as f64)).collect();
        }
        let at = self.to_old(place);
        let first = at.floor() as i64 - 1;
        (first..first + 4).map(|k| (inside(k), bicubic(at - k as f64))).collect()
    }
}

/// The cubic convolution of Keys with a = −1/2, that of Catmull and Rom.
fn bicubic(x: f64) -> f64 {
    let x = x.abs();
    match x {
        _ if x < 1.0 => (1.5 * x - 2.5) * x * x + 1.0,
        _ if x < 2.0 => ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0,
        _ => 0.0,
    }
}

fn transposed(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    (0..values.len()).map(|k| values[k % height * width + k / height]).collect()
}
