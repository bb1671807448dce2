//! Parts of the axis along which a view shows the surface, from the point of the axis.

use super::data::ViewData;
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::limb_location::axial_range;
use crate::memory::List;
use crate::statistics::at_both_ends;
use pulp::Arch;

/// The part of the points at either end that does not tell how long the surface is.
const POINTS_TRIM: f64 = 0.02;

impl ViewData<'_> {
    /// The part of the axis along which segments were given.
    pub fn range_of_given(&self, camera: &Camera, cylinder: &Cylinder) -> Option<[f64; 2]> {
        let endpoints = self.view.segments.iter().flat_map(|segment| segment.endpoints);
        axial_range(camera, &self.seen(cylinder), endpoints, 0.0)
    }

    /// The part of the axis along which there are points.
    pub fn range_of_points(&self, cylinder: &Cylinder) -> [f64; 2] {
        self.range_of_points_on(&self.seen(cylinder))
    }

    /// The same of a cylinder in the coordinates of the view.
    pub fn range_of_points_on(&self, cylinder: &Cylinder) -> [f64; 2] {
        let axis = cylinder.axis;
        let Some(last) = self.view.cloud.len().checked_sub(1) else { return [0.0, 0.0] };
        let positions = self.view.cloud.points().map(|p| axis.position_of(&p));
        let mut along = List::with_capacity(last + 1);
        Arch::new().dispatch(|| along.extend(positions));
        at_both_ends(&along, (POINTS_TRIM * last as f64) as usize)
    }
}

/// A range along the axis of one cylinder on that of another.
pub(super) fn moved(range: &[f64; 2], from: &Cylinder, to: &Cylinder) -> [f64; 2] {
    let [a, b] = range.map(|position| to.axis.position_of(&from.axis.at(position)));
    [a.min(b), a.max(b)]
}
