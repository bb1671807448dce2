//! The points of a fit: structure of arrays, relative to an origin near the data.

mod part;
mod sums;

use super::batch::{Batch, Coordinate};
use super::dropped::Dropped;
use super::mask::Mask;
use super::strided::Scalar;
use super::views::PointsView;
use crate::error::{Error, Result, reserve};
use crate::memory::List;
use nalgebra::{Matrix3, Vector3};
pub(crate) use part::{ENOUGH_POINTS_TO_FIT, are_many, spread};
use pulp::Arch;
use sums::{Along, Moments};

/// Weights are kept as f32.
const LARGEST_WEIGHT: f64 = f32::MAX as f64;

/// What a weight must do that is larger.
const WEIGHT_REQUIREMENT: &str = "be at most 3.4e38; only the ratios of the weights count, so scale them all";

fn bad_weight(index: usize, weight: f64) -> Error {
    let requirement = if weight < 0.0 { "be at least 0" } else { WEIGHT_REQUIREMENT };
    Error::argument(format!("the weight of point {index}"), format!("{weight:?}"), requirement)
}

/// Checks the weights of a cloud as [`PointCloud::push_points`] does, where only parts of it are pushed.
///
/// # Errors
/// `InvalidArgument` for a weight that is negative or larger than an f32 can hold.
pub(crate) fn check_weights(view: &PointsView<'_>) -> Result<()> {
    if view.weights.is_none() || view.width() == 0 {
        return Ok(());
    }
    for row in 0..view.height() {
        for column in 0..view.width() {
            let weight = view.weight(column, row);
            if weight.is_finite() && !(0.0..=LARGEST_WEIGHT).contains(&weight) {
                return Err(bad_weight(row * view.width() + column, weight));
            }
        }
    }
    Ok(())
}

/// Coordinates relative to the origin of a [`PointCloud`], axis by axis.
#[derive(Debug, Clone, Copy)]
pub enum Offsets<'a> {
    /// From depth images and f32 clouds: half the memory traffic, and the offsets of a small object keep
    /// more digits than the input had.
    F32([&'a [f32]; 3]),
    /// From f64 clouds.
    F64([&'a [f64]; 3]),
}

/// The same as a cloud keeps them.
#[derive(Debug, Clone)]
enum Axes {
    F32([List<f32>; 3]),
    F64([List<f64>; 3]),
}

impl Axes {
    fn len(&self) -> usize {
        match self {
            Axes::F32(axes) => axes[0].len(),
            Axes::F64(axes) => axes[0].len(),
        }
    }
}

/// Points in structure-of-arrays form. Coordinates are `origin` + offset.
#[derive(Debug, Clone)]
pub struct PointCloud {
    origin: Vector3<f64>,
    offsets: Axes,
    /// Empty while every weight is 1.
    weights: List<f32>,
    /// Empty unless every point came with one.
    normals: List<Vector3<f32>>,
    /// Empty unless all points came from one grid.
    pixels: List<[u32; 2]>,
    dropped: Dropped,
    given: usize,
    /// The largest distance between neighbouring representable numbers of the input, over all coordinates.
    resolution: f64,
}

impl Default for PointCloud {
    fn default() -> Self {
        // Most never get weights or normals, and points are given room for as many as there are.
        Self {
            origin: Vector3::zeros(),
            offsets: Axes::F32([(); 3].map(|()| List::apart())),
            weights: List::apart(),
            normals: List::apart(),
            pixels: List::apart(),
            dropped: Dropped::default(),
            given: 0,
            resolution: 0.0,
        }
    }
}

impl PointCloud {
    /// Forgets all points and counts but keeps the memory.
    pub fn clear(&mut self) {
        match &mut self.offsets {
            Axes::F32(axes) => axes.iter_mut().for_each(|axis| axis.clear()),
            Axes::F64(axes) => axes.iter_mut().for_each(|axis| axis.clear()),
        }
        self.weights.clear();
        self.normals.clear();
        self.pixels.clear();
        self.dropped = Dropped::default();
        self.given = 0;
        self.resolution = 0.0;
    }

    /// Makes room for the coordinates of that many points.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn reserve(&mut self, additional: usize) -> Result<()> {
        let size = if matches!(self.offsets, Axes::F32(_)) { 4 } else { 8 };
        let outcome = match &mut self.offsets {
            Axes::F32(axes) => axes.iter_mut().try_for_each(|axis| axis.try_reserve(additional)),
            Axes::F64(axes) => axes.iter_mut().try_for_each(|axis| axis.try_reserve(additional)),
        };
        let bytes = additional.saturating_mul(3 * size);
        outcome.map_err(|_| Error::OutOfMemory { what: "the points", bytes })
    }

    /// Usable points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Whether there is no usable point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Points that were pushed, usable or not.
    #[must_use]
    pub fn given(&self) -> usize {
        self.given
    }

    /// Points that were left out.
    #[must_use]
    pub fn dropped(&self) -> &Dropped {
        &self.dropped
    }

    /// The point that the offsets count from.
    #[must_use]
    pub fn origin(&self) -> &Vector3<f64> {
        &self.origin
    }

    /// The coordinates relative to the origin.
    #[must_use]
    pub fn offsets(&self) -> Offsets<'_> {
        match &self.offsets {
            Axes::F32(axes) => Offsets::F32(axes.each_ref().map(|axis| &axis[..])),
            Axes::F64(axes) => Offsets::F64(axes.each_ref().map(|axis| &axis[..])),
        }
    }

    /// One weight a point, or `None` while all are 1.
    #[must_use]
    pub fn weights(&self) -> Option<&[f32]> {
        (!self.weights.is_empty()).then_some(&self.weights)
    }

    /// One direction across the surface a point, of any length and sign, zero where it is unknown; `None`
    /// unless all points were pushed with normals.
    #[must_use]
    pub fn normals(&self) -> Option<&[Vector3<f32>]> {
        (!self.normals.is_empty()).then_some(&self.normals)
    }

    /// The pixel of each point, column and row, in the grid of the sensor that measured it: that of the depth camera,
    /// or of an organised cloud. `None` unless all points came from one such grid: points of several pushes, or of a
    /// cloud of one row, have no common neighbourhood.
    #[must_use]
    pub fn pixels(&self) -> Option<&[[u32; 2]]> {
        (!self.pixels.is_empty()).then_some(&self.pixels)
    }

    /// The distance between neighbouring numbers of the input at its largest coordinate: what the input could
    /// resolve. An f32 cloud 10 km from the origin has 1 mm.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// One point.
    #[inline]
    #[must_use]
    pub fn point(&self, index: usize) -> Vector3<f64> {
        let offset = match &self.offsets {
            Axes::F32([x, y, z]) => Vector3::new(x[index], y[index], z[index]).cast(),
            Axes::F64([x, y, z]) => Vector3::new(x[index], y[index], z[index]),
        };
        self.origin + offset
    }

    /// The weight of one point.
    #[must_use]
    pub fn weight(&self, index: usize) -> f64 {
        self.weights().map_or(1.0, |weights| f64::from(weights[index]))
    }

    /// All points.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> + Clone + '_ {
        (0..self.len()).map(|index| self.point(index))
    }

    /// The mean of the points and their covariance about it; `None` for none.
    #[must_use]
    pub fn mean_and_covariance(&self) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let (mean, covariance) = match self.offsets() {
            Offsets::F32(axes) => Arch::new().dispatch(Moments(axes)),
            Offsets::F64(axes) => Arch::new().dispatch(Moments(axes)),
        };
        (!self.is_empty()).then(|| (self.origin + mean, covariance))
    }

    /// At most `count` points, evenly spread over the order in which they were pushed.
    pub(crate) fn sampled(&self, count: usize) -> impl ExactSizeIterator<Item = Vector3<f64>> + '_ {
        let count = count.min(self.len());
        (0..count).map(move |k| self.point(k * self.len() / count))
    }

    /// Copies the usable points of a cloud. A mask selects pixels of an organised one.
    ///
    /// # Errors
    /// `SizeMismatch` when the mask has another size than the cloud; `InvalidArgument` for a weight that is negative or
    /// larger than an f32 can hold, and for a point so far from the others that the type of the cloud cannot hold the
    /// distance; `OutOfMemory`. Nothing is added then.
    pub fn push_points(&mut self, view: &PointsView<'_>, mask: Option<&Mask>) -> Result<()> {
        if let Some(mask) = mask {
            mask.check_size("organised cloud", (view.width(), view.height()))?;
        }
        self.push_some(view, mask.map(|mask| (mask.count(), mask.set_pixels())))
    }

    /// The same for points with these numbers, row by row from 0 on and in that order, in place of a mask with nothing but them.
    ///
    /// # Errors
    /// `EmptyMask` for none, else as [`PointCloud::push_points`].
    pub(crate) fn push_numbered(
        &mut self,
        view: &PointsView<'_>,
        numbers: impl ExactSizeIterator<Item = usize>,
    ) -> Result<()> {
        let (width, height) = (view.width(), view.height());
        if numbers.len() == 0 {
            return Err(Error::EmptyMask { width, height });
        }
        let count = numbers.len();
        // Most clouds are a single row, and a division takes longer than all else that is done with a point.
        let pixel = |number| if height == 1 { (number, 0) } else { (number % width, number / width) };
        self.push_some(view, Some((count, numbers.map(pixel))))
    }

    /// Copies the usable points of so many pixels, or of all.
    fn push_some(
        &mut self,
        view: &PointsView<'_>,
        pixels: Option<(usize, impl Iterator<Item = (usize, usize)>)>,
    ) -> Result<()> {
        // On their way the coordinates take as much memory as in the hands of the caller.
        match view.scalar() {
            Scalar::F32 => self.push_as(view, pixels, |point| point.cast::<f32>().into()),
            Scalar::F64 => self.push_as(view, pixels, Vector3::into),
        }
    }

    fn push_as<T: Coordinate>(
        &mut self,
        view: &PointsView<'_>,
        pixels: Option<(usize, impl Iterator<Item = (usize, usize)>)>,
        point_of: impl Fn(Vector3<f64>) -> [T; 3],
    ) -> Result<()> {
        let (width, height) = (view.width(), view.height());
        let mut batch = Batch::grid(width, height);
        let take = |batch: &mut Batch<T>, column: usize, row: usize| -> Result<()> {
            let (point, weight) = (view.points.at(column, row), view.weight(column, row));
            if !(point.iter().all(|x| x.is_finite()) && weight.is_finite()) {
                batch.dropped.not_finite += 1;
            } else if !(0.0..=LARGEST_WEIGHT).contains(&weight) {
                return Err(bad_weight(row * width + column, weight));
            } else if weight as f32 == 0.0 {
                batch.dropped.zero_weight += 1;
            } else {
                batch.push(point_of(point), column, row);
                if view.weights.is_some() {
                    batch.push_weight(weight)?;
                }
                if let Some(normals) = &view.normals {
                    batch.push_normal(&normals.at(column, row))?;
                }
            }
            Ok(())
        };
        if let Some((count, pixels)) = pixels {
            batch.dropped.outside_mask = batch.given - count;
            batch.reserve(count)?;
            for (column, row) in pixels {
                take(&mut batch, column, row)?;
            }
        } else {
            // Rows of no points are as many as the caller likes.
            let height = if width == 0 { 0 } else { height };
            batch.reserve(width * height)?;
            for row in 0..height {
                for column in 0..width {
                    take(&mut batch, column, row)?;
                }
            }
        }
        self.append(batch, view.scalar())
    }

    /// The points that are chosen by their index, with what belongs to each of them.
    #[must_use]
    pub fn chosen(&self, choose: impl Fn(usize) -> bool) -> Self {
        self.listed(&(0..self.len()).filter(|&index| choose(index)).collect::<List<_>>())
    }

    /// The points whose positions along a direction, from the origin of the cloud, lie between two bounds.
    pub(crate) fn between(&self, direction: &Vector3<f64>, [low, high]: [f64; 2]) -> Self {
        let (mut indices, mut first) = (List::new(), 0);
        let block = |positions: &[f64]| {
            let inside =
                positions.iter().enumerate().filter(|(_, position)| (low..=high).contains(*position));
            indices.extend(inside.map(|(k, _)| first + k));
            first += positions.len();
        };
        let direction = (*direction).into();
        match self.offsets() {
            Offsets::F32(axes) => Arch::new().dispatch(Along { axes, direction, block }),
            Offsets::F64(axes) => Arch::new().dispatch(Along { axes, direction, block }),
        }
        self.listed(&indices)
    }

    /// At most `count` points as in [`PointCloud::sample`], with what belongs to each of them.
    pub(crate) fn thinned(&self, count: usize) -> Self {
        let count = count.min(self.len());
        self.listed(&(0..count).map(|k| k * self.len() / count).collect::<List<_>>())
    }

    /// The points with these numbers, with what belongs to each of them.
    pub(crate) fn listed(&self, indices: &[usize]) -> Self {
        fn of<T>(all: &[T], indices: &[usize]) -> List<T>
        where
            T: Copy + Send + 'static,
        {
            if all.is_empty() { List::apart() } else { indices.iter().map(|&index| all[index]).collect() }
        }
        let offsets = match &self.offsets {
            Axes::F32(axes) => Axes::F32([0, 1, 2].map(|k| of(&axes[k], indices))),
            Axes::F64(axes) => Axes::F64([0, 1, 2].map(|k| of(&axes[k], indices))),
        };
        Self {
            offsets,
            weights: of(&self.weights, indices),
            normals: of(&self.normals, indices),
            pixels: of(&self.pixels, indices),
            ..*self
        }
    }

    /// Adds the points of a batch whose input had the given type.
    pub(super) fn append<T: Coordinate>(&mut self, mut batch: Batch<T>, scalar: Scalar) -> Result<()> {
        let first = self.is_empty();
        let origin = if first { batch.middle() } else { self.origin };
        // One f64 cloud makes the whole f64: mixing costs nothing but memory.
        let wide = scalar == Scalar::F64 || !first && matches!(self.offsets, Axes::F64(_));
        batch.check_distances(&origin, wide)?;
        let ordered = first && batch.height > 1;
        if !ordered {
            batch.pixels = List::new();
        }
        match &self.offsets {
            Axes::F64(_) if !wide => self.offsets = Axes::F32(Default::default()),
            Axes::F32(axes) if wide => self.offsets = widened(axes)?,
            _ => {}
        }
        let added = batch.len();
        self.reserve(added)?;
        let weighted = !self.weights.is_empty() || batch.weights.iter().any(|&weight| weight != 1.0);
        let oriented = (first || !self.normals.is_empty()) && batch.normals.len() == added;
        let total = self.len() + added;
        // All memory is there before anything is added.
        if weighted {
            let more = total - self.weights.len();
            reserve(&mut self.weights, more, "the weights")?;
        }
        if oriented {
            reserve(&mut self.normals, added, "the normals")?;
        }
        if ordered {
            reserve(&mut self.pixels, added, "the pixels of the points")?;
        }
        if weighted {
            self.weights.resize(total - added, 1.0);
            self.weights.extend(batch.weights.iter().map(|&weight| weight as f32));
            self.weights.resize(total, 1.0);
        }
        if oriented {
            self.normals.extend_from_slice(&batch.normals);
        } else if added > 0 {
            self.normals.clear();
        }
        if ordered {
            self.pixels.append(&mut batch.pixels);
            batch.pixels = List::new();
        } else if added > 0 {
            self.pixels.clear();
        }
        self.origin = origin;
        for k in 0..3 {
            let (coordinates, from) = (&batch.axes[k], origin[k]);
            let offsets = coordinates.iter().map(|x| (*x).into() - from);
            Arch::new().dispatch(|| match &mut self.offsets {
                Axes::F32(axes) => axes[k].extend(offsets.map(|offset| offset as f32)),
                Axes::F64(axes) => axes[k].extend(offsets),
            });
        }
        self.given += batch.given;
        self.dropped.add(&batch.dropped);
        let epsilon = match scalar {
            Scalar::F32 => f64::from(f32::EPSILON),
            Scalar::F64 => f64::EPSILON,
        };
        self.resolution = self.resolution.max(batch.largest() * epsilon);
        Ok(())
    }
}

/// Offsets of twice the width.
fn widened(axes: &[List<f32>; 3]) -> Result<Axes> {
    let bytes = axes[0].len() * 3 * size_of::<f64>();
    let mut wide: [List<f64>; 3] = Default::default();
    for (wide, axis) in wide.iter_mut().zip(axes) {
        wide.try_reserve(axis.len()).map_err(|_| Error::OutOfMemory { what: "the points", bytes })?;
        wide.extend(axis.iter().map(|&x| f64::from(x)));
    }
    Ok(Axes::F64(wide))
}

#[cfg(test)]
mod tests;
