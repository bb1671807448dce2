//! Steps of points alone: where the surface along an axis goes on with another radius, as that of a stepped shaft does.

use super::collar::{ALONE_RATIO, DEPTH_FLOOR, is_near, least_step};
use super::profile::{LEAST_SIGHTS, Profile, Slices};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::median;
use nalgebra::Vector3;

/// The smaller part of what points show along the axis where a clear step divides it, from and to; infinite at an end. `None` without
/// a step.
pub(crate) fn other_radius(
    cylinder: &Cylinder,
    points: impl Iterator<Item = Vector3<f64>>,
) -> Option<[f64; 2]> {
    let Cylinder { axis, radius } = cylinder;
    let seen: List<[f64; 2]> = points
        .map(|point| [axis.position_of(&point), cylinder.distance(&point)])
        .filter(|[_, distance]| is_near(*distance, *radius))
        .collect();
    let slices = Slices::of_points(cylinder, &seen)?;
    let profile = Profile::new(&slices, &seen, (LEAST_SIGHTS, median), DEPTH_FLOOR.get() * radius)?;
    // What is raised at one end is lowered at the other.
    let [size, _] = least_step(*radius);
    let least = [size, ALONE_RATIO.get()];
    let profiles = [profile.clone(), profile.negated()];
    let raised = profiles.iter().filter_map(|profile| {
        let stretch = profile.raised_at_end(1..slices.count / 2 + 1, least)?;
        profile.step(&stretch).filter(|step| step.ratio() >= ALONE_RATIO.get())?;
        Some((profile.explained(&stretch), stretch))
    });
    let (_, stretch) = raised.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(slices.along(&stretch, 0))
}
