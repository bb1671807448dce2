//! Usable points on their way into a cloud.

use super::dropped::Dropped;
use crate::error::{Error, Result};
use crate::memory::List;
use crate::statistics::median;
use nalgebra::Vector3;
use pulp::Arch;

/// The type of the coordinates of points on their way.
pub(super) trait Coordinate: Copy + Default + Into<f64> + Send + 'static {}

impl Coordinate for f32 {}
impl Coordinate for f64 {}

/// Usable points on their way into a cloud.
#[derive(Default)]
pub(super) struct Batch<T: Coordinate> {
    /// Columns and rows of the grid that they come from; one row stands for no order.
    pub width: usize,
    pub height: usize,
    /// The coordinates, axis by axis.
    pub axes: [List<T>; 3],
    /// Empty where every weight is 1.
    pub weights: List<f64>,
    pub normals: List<Vector3<f32>>,
    /// Where they are in the grid, column and row.
    pub pixels: List<[u32; 2]>,
    pub dropped: Dropped,
    pub given: usize,
}

impl<T: Coordinate> Batch<T> {
    /// No points yet of a grid of that size.
    pub fn grid(width: usize, height: usize) -> Self {
        Self { width, height, given: width * height, ..Self::default() }
    }

    /// Makes room for so many points that are pushed next.
    pub fn reserve(&mut self, additional: usize) -> Result<()> {
        let size = size_of::<[T; 3]>() + size_of::<[u32; 2]>();
        let bytes = self.len().saturating_add(additional).saturating_mul(size);
        let out_of_memory = |_| Error::OutOfMemory { what: "the points", bytes };
        self.axes.iter_mut().try_for_each(|axis| axis.try_reserve(additional)).map_err(out_of_memory)?;
        self.pixels.try_reserve(additional).map_err(out_of_memory)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.axes[0].len()
    }

    /// Adds a point, for which there is room.
    #[inline]
    pub fn push(&mut self, point: [T; 3], column: usize, row: usize) {
        for (axis, coordinate) in self.axes.iter_mut().zip(point) {
            axis.push(coordinate);
        }
        self.pixels.push([column as u32, row as u32]);
    }

    fn point(&self, index: usize) -> Vector3<f64> {
        self.axes.each_ref().map(|axis| axis[index].into()).into()
    }

    pub fn push_weight(&mut self, weight: f64) -> Result<()> {
        let bytes = self.weights.len() * 16;
        self.weights.try_reserve(1).map_err(|_| Error::OutOfMemory { what: "the weights", bytes })?;
        self.weights.push(weight);
        Ok(())
    }

    /// Checks that the offsets from the origin have a place in the type that keeps them.
    pub fn check_distances(&self, origin: &Vector3<f64>, wide: bool) -> Result<()> {
        let largest = if wide { f64::MAX } else { f64::from(f32::MAX) };
        let far = |k: usize, x: T| !((x.into() - origin[k]).abs() <= largest);
        let any = |k: usize| {
            let axis = &self.axes[k];
            Arch::new().dispatch(|| axis.iter().fold(false, |any, x| any | far(k, *x)))
        };
        if !(0..3).any(any) {
            return Ok(());
        }
        let is_far = |index: &usize| (0..3).any(|k| far(k, self.axes[k][*index]));
        let Some(index) = (0..self.len()).find(is_far) else { return Ok(()) };
        let [column, row] = self.pixels[index].map(|x| x as usize);
        let name = format!("point {}", row * self.width + column);
        let value = format!("{:?}", self.point(index).as_slice());
        let requirement = format!(
            "lie within {largest:.1e} of the points around {:?} in each coordinate; leave it out or give f64 in \
             a smaller unit of length",
            origin.as_slice()
        );
        Err(Error::argument(name, value, requirement))
    }

    pub fn push_normal(&mut self, normal: &Vector3<f64>) -> Result<()> {
        let bytes = self.normals.len() * 24;
        self.normals.try_reserve(1).map_err(|_| Error::OutOfMemory { what: "the normals", bytes })?;
        let length = normal.norm();
        let known = length > 0.0 && length.is_finite();
        self.normals.push(if known { (normal / length).cast() } else { Vector3::zeros() });
        Ok(())
    }

    /// The largest size of a coordinate.
    pub fn largest(&self) -> f64 {
        let of_axis = |axis: &List<T>| Arch::new().dispatch(|| largest(axis));
        self.axes.iter().map(of_axis).fold(0.0, f64::max)
    }

    /// A point in the middle of most of them: the median of a few in each coordinate, which single far
    /// points do not carry away.
    pub fn middle(&self) -> Vector3<f64> {
        const SAMPLES: usize = 255;
        let count = self.len().min(SAMPLES);
        if count == 0 {
            return Vector3::zeros();
        }
        Vector3::from_fn(|axis, _| {
            let mut values = [0.0; SAMPLES];
            for (k, value) in values[..count].iter_mut().enumerate() {
                *value = self.axes[axis][k * self.len() / count].into();
            }
            median(&mut values[..count])
        })
    }
}

/// The largest size of some numbers, side by side.
#[inline(always)]
fn largest<T: Copy + Into<f64>>(numbers: &[T]) -> f64 {
    const LANES: usize = 8;
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    let mut lanes = [0.0_f64; LANES];
    for numbers in chunks {
        for (lane, number) in lanes.iter_mut().zip(numbers) {
            let size = (*number).into().abs();
            *lane = if size > *lane { size } else { *lane };
        }
    }
    lanes.into_iter().chain(rest.iter().map(|number| (*number).into().abs())).fold(0.0, f64::max)
}
