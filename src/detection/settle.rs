//! The last fit of a cylinder by depth alone: what an image would tell of its width, the outline of its depth has to.

use super::candidate::{Candidate, Marks, Scene};
use super::distances;
use super::outline::{Beyond, Side, outline};
use super::surface::{OUTLINE_PIXELS, OUTLINE_SHIFT_PIXELS, Optics, REACH, Surface, Tangent, fit, middle};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::min_max;

constants! {
    /// Where nothing is measured beside a limb depth ends inside of it, as the surface turns away: by this many pixels times the root of
    /// the radius in pixels. By the sensors that were looked at it is 0.27 to 0.75: docs/measurements-detection-depth.md.
    MISSING = 0.35, "√px";

    /// The radius in pixels up to which the outline tells it as well as the points do.
    WIDEST = 30.0, "px";
}

/// Most steps of the fit.
const STEPS: usize = 6;

/// Most cells that it is made to, evenly chosen from more: they count as few anyway.
const FITTED: usize = 500;

impl Scene<'_> {
    /// The surface of a candidate by its cells and its outline, neither of which outvotes the other; `None` where that is no
    /// cylinder.
    ///
    /// What depth does next to a limb, and noise that matching windows share, it does alike all along a body. In the search each
    /// cell counts for itself, so that those of a long pipe leave the outline no say. Here all lines across the axis are one.
    pub fn settled(&self, candidate: &Candidate, marks: &mut Marks) -> Option<Surface> {
        let Candidate { surface, cells, .. } = candidate;
        let Surface::Cylinder(cylinder, _) = surface else { return None };
        // Where no window has matched the depth, the points alone tell the radius.
        if !self.noise.is_shared() {
            return None;
        }
        let depth = middle(&self.grid.cells, cells).z;
        if cylinder.radius > WIDEST.get() * self.optics.pixel * depth || self.effort.is_spent() {
            return None;
        }
        let tangents = self.both_sides(cylinder, cells, depth, marks);
        let stride = cells.len().div_ceil(FITTED);
        let fitted: List<usize> = cells.iter().step_by(stride).copied().collect();
        self.effort.spend(STEPS * fitted.len());
        let line = 2.0 * cylinder.radius / (self.grid.spacing * depth);
        let cells_per_sample = self.optics.cells_per_sample.max(cells.len() as f64 / line) / stride as f64;
        let optics = Optics { cells_per_sample, ..self.optics };
        fit(surface, (&self.numbers, &fitted), &tangents, optics, REACH.get(), STEPS)
    }

    /// The outline of cells, each of its sides one measurement.
    fn both_sides(
        &self,
        cylinder: &Cylinder,
        cells: &[usize],
        depth: f64,
        marks: &mut Marks,
    ) -> List<Tangent> {
        let (mut across, mut along) = (List::new(), List::new());
        distances::across_and_along(cylinder, &self.numbers, cells, &mut across, &mut along);
        let sides = outline(self, cylinder, cells, (&across, &along, min_max(&along)), marks);
        let radius = cylinder.radius / (self.optics.pixel * depth);
        let mut tangents = List::new();
        for sign in [-1.0, 1.0] {
            let ends = || sides.iter().filter(|side| side.sign == sign && side.limb().is_some());
            let weight = 1.0 / ends().count() as f64;
            let tangent = |side: &Side| {
                let inset = match side.beyond {
                    Beyond::Missing => MISSING.get() * radius.sqrt(),
                    _ => OUTLINE_SHIFT_PIXELS.get(),
                };
                Tangent { ray: side.ray, inset, deviation: OUTLINE_PIXELS.get(), weight }
            };
            tangents.extend(ends().map(tangent));
        }
        tangents
    }
}
