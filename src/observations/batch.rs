//! Usable points on their way into a cloud.

use super::dropped::Dropped;
use crate::error::{Error, Result};
use crate::statistics::median;
use nalgebra::{Scalar, Vector3};

/// The type of the coordinates of points on their way.
pub(super) trait Coordinate: Scalar + Copy + Default + Into<f64> {}

impl Coordinate for f32 {}
impl Coordinate for f64 {}

/// Usable points on their way into a cloud.
#[derive(Default)]
pub(super) struct Batch<T> {
    /// Columns and rows of the grid that they come from; one row stands for no order.
    pub width: usize,
    pub height: usize,
    pub points: Vec<Vector3<T>>,
    /// Empty where every weight is 1.
    pub weights: Vec<f64>,
    pub normals: Vec<Vector3<f32>>,
    /// Where they are in the grid, counted row by row.
    pub indices: Vec<usize>,
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
        let bytes = self
            .points
            .len()
            .saturating_add(additional)
            .saturating_mul(size_of::<Vector3<T>>() + size_of::<usize>());
        let out_of_memory = |_| Error::OutOfMemory { what: "the points", bytes };
        self.points.try_reserve(additional).map_err(out_of_memory)?;
        self.indices.try_reserve(additional).map_err(out_of_memory)
    }

    /// Adds a point, for which there is room.
    #[inline]
    pub fn push(&mut self, point: Vector3<T>, index: usize) {
        self.points.push(point);
        self.indices.push(index);
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
        let far = |point: &Vector3<T>| !((point.map(Into::into) - origin).amax() <= largest);
        let Some(far) = self.points.iter().position(far) else { return Ok(()) };
        let name = format!("point {}", self.indices[far]);
        let value = format!("{:?}", self.points[far].map(Into::<f64>::into).as_slice());
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

    /// A point in the middle of most of them: the median of a few in each coordinate, which single far
    /// points do not carry away.
    pub fn middle(&self) -> Vector3<f64> {
        const SAMPLES: usize = 255;
        let count = self.points.len().min(SAMPLES);
        if count == 0 {
            return Vector3::zeros();
        }
        Vector3::from_fn(|axis, _| {
            let mut values = [0.0; SAMPLES];
            for (k, value) in values[..count].iter_mut().enumerate() {
                *value = self.points[k * self.points.len() / count][axis].into();
            }
            median(&mut values[..count])
        })
    }
}
