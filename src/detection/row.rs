//! Rows of a depth image: the points that its pixels see.

use crate::memory::List;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Reads the rays of some columns of a row, by their positions on the plane z = 1: not numbers where a pixel has none.
pub(super) type Rays<'a> = dyn Fn(usize, Range<usize>, &mut [List<f64>; 2]) + 'a;

/// Reads the points that some columns of a row see, with a depth of 0 where nothing was measured.
pub(super) type Points<'a> = dyn Fn(usize, Range<usize>, &mut [List<f64>; 3]) + 'a;

/// Writes numbers for some columns in place of what is in lists.
pub(super) fn write<const N: usize>(
    columns: Range<usize>,
    lists: &mut [List<f64>; N],
    numbers: impl Fn(usize) -> [f64; N],
) {
    lists.iter_mut().for_each(|list| list.resize(columns.len(), 0.0));
    for (k, column) in columns.enumerate() {
        for (list, number) in lists.iter_mut().zip(numbers(column)) {
            list[k] = number;
        }
    }
}

/// Writes the points of a row by their stored depths, the length of a unit of those, and the rays of a pinhole by column and row,
/// as precise as f32 is.
pub(super) fn write_points(depths: &[f32], unit: f64, x: &[f64], y: f64, points: &mut [List<f64>; 3]) {
    points.iter_mut().for_each(|list| list.resize(depths.len(), 0.0));
    Arch::new().dispatch(Row { depths, unit, x, y, points });
}

/// One pass over the depths of a row.
struct Row<'a> {
    depths: &'a [f32],
    unit: f64,
    x: &'a [f64],
    y: f64,
    points: &'a mut [List<f64>; 3],
}

impl WithSimd for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { depths, unit, x, y, points } = self;
        let [px, py, pz] = points;
        let coordinates = px.iter_mut().zip(py.iter_mut()).zip(pz.iter_mut());
        for (((px, py), pz), (depth, x)) in coordinates.zip(depths.iter().zip(x)) {
            let z = f64::from(if *depth > 0.0 { *depth } else { 0.0 }) * unit;
            *px = f64::from((x * z) as f32);
            *py = f64::from((y * z) as f32);
            *pz = f64::from(z as f32);
        }
    }
}
