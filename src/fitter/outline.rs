//! Masks of the pixels that have depth. Depth is missing beside the limbs of a curved surface, so the sides of such a mask
//! lie within the limbs; they are drawn again about the cylinder that was fitted.

use super::view::View;
use crate::detection::{Band, meets};
use crate::geometry::Cylinder;
use crate::limb_location::axial_range;
use nalgebra::{Vector2, Vector3};

/// The part of the pixels of a mask that may lack depth where the mask is one of the pixels that have depth,
const MOST_WITHIN: f64 = 0.001;

/// and the part of the pixels around it that lack depth then at least. Of 282 masks of whole lateral surfaces or objects,
/// drawn by hand or rendered, none has both.
const LEAST_AROUND: f64 = 0.2;

/// The drawn sides lie so far outside those of the cylinder, in pixels.
const MARGIN: f64 = 1.5;

/// The radii about which the sides are drawn, one fit after the other, as parts of that of the fit before. The first fit
/// took the sides of the mask for limbs.
pub(super) const RADII: [f64; 2] = [1.05, 1.0];

/// The part of the outline of a mask that may be beyond an end: single pixels.
const TRIM: f64 = 0.005;

impl View {
    /// Whether the mask holds the pixels that have depth and no others: it ends where the depth does.
    pub fn mask_ends_with_depth(&self) -> bool {
        if self.mask_of_points {
            return true;
        }
        let (Some(mask), Some(depth)) = (&self.mask, self.depth()) else { return false };
        let lacks_depth = |&(column, row): &(usize, usize)| depth.depth(column, row).is_none();
        let allowed = (MOST_WITHIN * mask.count() as f64) as usize;
        if mask.set_pixels().filter(lacks_depth).nth(allowed).is_some() {
            return false;
        }
        let (around, lacking) = mask.surroundings().fold((0_usize, 0_usize), |(around, lacking), pixel| {
            (around + 1, lacking + usize::from(lacks_depth(&pixel)))
        });
        lacking > 0 && lacking as f64 >= LEAST_AROUND * around as f64
    }

    /// The view with a mask that goes on, over pixels without depth, to the sides of a cylinder in the coordinates of the
    /// view, whose radius is `factor` times as large. `None` where nobody can tell.
    pub fn with_sides_of(&self, cylinder: &Cylinder, factor: f64) -> Option<View> {
        let (camera, mask, depth) = (self.camera()?, self.mask.as_ref()?, self.depth()?);
        let ray = |(column, row): (usize, usize)| camera.ray_of_pixel(column, row);
        let outline = mask.outline().iter().map(|&(column, row)| Vector2::new(column as f64, row as f64));
        let [low, high] = axial_range(camera, cylinder, outline, TRIM)?;
        let pixel = cylinder.axis.nearest_to_origin().norm() / (camera.intrinsics().fx * cylinder.radius);
        let band = Band::new(cylinder, factor + MARGIN * pixel);
        let between = |ray: &Vector3<f64>| band.contains(ray) && (low..=high).contains(&meets(cylinder, ray));
        let belongs = |pixel: (usize, usize)| {
            depth.depth(pixel.0, pixel.1).is_none() && ray(pixel).is_some_and(|ray| between(&ray))
        };
        // The mask shows a part of the cylinder, beyond which the rest is at most as wide as all of it.
        let reach = (2.0 * (factor / pixel + MARGIN)).ceil() as usize;
        Some(self.with_drawn_sides(mask.extended(reach, belongs)))
    }
}
