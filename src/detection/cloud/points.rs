//! Points as the looks at a cloud read them.

use super::{BETWEEN_QUESTIONS, CancelCheck};
use crate::error::{Error, Result};
use crate::observations::{PointsView, spread};
use nalgebra::{Matrix3, Vector3};

/// Points that tell the extent and the main directions of more of them.
const SAMPLE: usize = 8192;

/// Points in single precision relative to a position among them, axis by axis: so they are told far finer than any noise that a search
/// assumes, and take half the memory. The coordinates of points of no use are no numbers.
#[derive(Debug, Default)]
pub(super) struct Points {
    pub origin: Vector3<f64>,
    pub axes: [Vec<f32>; 3],
    /// How many are of use.
    pub usable: usize,
}

impl Points {
    /// None, with room for so many.
    pub fn with_room(origin: Vector3<f64>, count: usize) -> Result<Self> {
        let mut points = Self { origin, ..Self::default() };
        for axis in &mut points.axes {
            let bytes = count * size_of::<Vector3<f32>>();
            axis.try_reserve_exact(count).map_err(|_| Error::OutOfMemory { what: "the points", bytes })?;
        }
        Ok(points)
    }

    /// All of a cloud as they come, relative to a position.
    pub fn read(view: &PointsView<'_>, origin: Vector3<f64>, check_cancel: &CancelCheck<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        let mut points = Self::with_room(origin, width * height)?;
        for row in 0..height {
            for column in 0..width {
                if points.len().is_multiple_of(BETWEEN_QUESTIONS) {
                    check_cancel()?;
                }
                points.push_given(view, column, row);
            }
        }
        Ok(points)
    }

    pub fn len(&self) -> usize {
        self.axes[0].len()
    }

    /// A point relative to the origin.
    #[inline]
    pub fn at(&self, k: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| f64::from(self.axes[axis][k]))
    }

    /// Where a point lies.
    pub fn point(&self, k: usize) -> Vector3<f64> {
        self.origin + self.at(k)
    }

    #[inline]
    pub fn is_usable(&self, k: usize) -> bool {
        !self.axes[0][k].is_nan()
    }

    /// Those of use, relative to the origin.
    pub fn all_usable(&self) -> impl Iterator<Item = Vector3<f64>> {
        (0..self.len()).filter(|&k| self.is_usable(k)).map(|k| self.at(k))
    }

    /// Adds a point of the caller's.
    pub fn push_given(&mut self, view: &PointsView<'_>, column: usize, row: usize) {
        let point = (view.points.at(column, row) - self.origin).cast::<f32>();
        let is_usable = point.iter().all(|x| x.is_finite()) && view.weight(column, row) > 0.0;
        self.usable += usize::from(is_usable);
        let point = if is_usable { point } else { Vector3::repeat(f32::NAN) };
        self.axes.iter_mut().zip(&point).for_each(|(axis, x)| axis.push(*x));
    }

    /// Forgets all points, for others relative to some position.
    pub fn start_from(&mut self, origin: Vector3<f64>) {
        (self.origin, self.usable) = (origin, 0);
        self.axes.iter_mut().for_each(Vec::clear);
    }

    /// Adds those of use of a range of others, and their numbers to a list.
    pub fn push_usable(&mut self, others: &Self, range: std::ops::Range<usize>, numbers: &mut Vec<u32>) {
        let [x, y, z] = others.axes.each_ref().map(|axis| &axis[range.clone()]);
        for (k, ((x, y), z)) in (range.start as u32..).zip(x.iter().zip(y).zip(z)) {
            if !x.is_nan() {
                self.axes[0].push(*x);
                self.axes[1].push(*y);
                self.axes[2].push(*z);
                numbers.push(k);
            }
        }
        self.usable = self.len();
    }

    /// What is of no use from now on.
    pub fn remove(&mut self, k: usize) {
        self.usable -= usize::from(self.is_usable(k));
        self.axes.iter_mut().for_each(|axis| axis[k] = f32::NAN);
    }

    /// Some that stand for all, where these are many.
    pub fn sample(&self) -> Option<Self> {
        if self.len() <= SAMPLE {
            return None;
        }
        let chosen = spread(self.len(), SAMPLE);
        let chosen = || chosen.iter().copied().filter(|&k| self.is_usable(k));
        let axes = self.axes.each_ref().map(|axis| chosen().map(|k| axis[k]).collect::<Vec<f32>>());
        Some(Self { origin: self.origin, usable: axes[0].len(), axes })
    }
}

/// A camera at points: x_camera = R x + t, x relative to their origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub rotation: Matrix3<f64>,
    pub offset: Vector3<f64>,
}

impl Pose {
    #[inline]
    pub fn turn(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.offset
    }

    /// The rows of R, t, in single precision.
    pub fn single(&self) -> [[f32; 4]; 3] {
        let row =
            |k: usize| [self.rotation[(k, 0)], self.rotation[(k, 1)], self.rotation[(k, 2)], self.offset[k]];
        [0, 1, 2].map(|k| row(k).map(|x| x as f32))
    }
}
