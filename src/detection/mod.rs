//! All cylinders of a scene: from a depth image or from a bare cloud.

mod candidate;
mod caps;
mod cloud;
mod cone;
mod distances;
mod edges;
mod effort;
mod evidence;
mod grid;
mod labels;
mod limb_pairs;
mod moments;
mod noise;
mod normal_equations;
mod outline;
mod parts;
mod patch;
mod planes;
mod rays;
mod region;
mod row;
mod score;
mod search;
mod settle;
mod shift;
mod surface;

pub(crate) use candidate::SETTLED;
pub(crate) use cloud::{Looks, detect_points_until, grown, is_round};
pub(crate) use cone::slope_by_points;
pub use evidence::Evidence;

#[cfg(feature = "sensitivity")]
/// The constants of detection.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    let files = [
        CONSTANTS,
        candidate::CONSTANTS,
        caps::CONSTANTS,
        edges::CONSTANTS,
        evidence::CONSTANTS,
        grid::CONSTANTS,
        labels::CONSTANTS,
        limb_pairs::CONSTANTS,
        noise::CONSTANTS,
        outline::CONSTANTS,
        parts::CONSTANTS,
        patch::CONSTANTS,
        planes::CONSTANTS,
        region::CONSTANTS,
        score::CONSTANTS,
        search::CONSTANTS,
        settle::CONSTANTS,
        shift::CONSTANTS,
        surface::CONSTANTS,
    ];
    [files.concat(), cloud::constants()].concat()
}

pub(crate) use rays::{Band, meets};
pub(crate) use region::{detect_in_mask, widened};
pub(crate) use score::{ONE_LIMB, least_before_fit, with_odds_divided};

use crate::camera::Camera;
use crate::error::{Error, Result, cancelled_if};
use crate::geometry::{Cylinder, CylinderLimits};
use crate::memory::List;
use crate::observations::{DepthImage, GreyImage, SCALE_IMAGE, check_same_size};
use effort::Effort;
use grid::{Grid, side_of_cells};
use limb_pairs::{ImageEdges, ON_LIMB};
use nalgebra::{Vector2, Vector3};
use search::{Limbs, Searched, search};
use std::ops::Range;

constants! {
    /// By how much the located limbs of a cylinder turn against each other, as a slope of its radius, beyond their stated deviations.
    /// On 321 cylinders of rendered scenes the slope is 0.001 in the median, less than 0.012 on 98 %, and 0.033 at most; on 11 bodies
    /// that taper and passed for cylinders it was 0.065 and more.
    LIMBS_TURN = 0.01, "";
}

/// The settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectionOptions {
    /// Limits of the radius and the direction of the axis.
    pub limits: CylinderLimits,
    /// Most cylinders.
    pub max_count: usize,
    /// Fewest pixels of a cylinder.
    pub min_pixels: usize,
    /// The least score.
    pub min_score: f64,
}

impl Default for DetectionOptions {
    fn default() -> Self {
        Self { limits: CylinderLimits::default(), max_count: usize::MAX, min_pixels: 100, min_score: 0.5 }
    }
}

impl DetectionOptions {
    /// Checks the values.
    ///
    /// # Errors
    /// `InvalidArgument`.
    pub fn check(&self) -> Result<()> {
        self.limits.check().map_err(|error| error.in_struct("options"))?;
        if !(0.0..=1.0).contains(&self.min_score) {
            return Err(Error::argument("options.min_score", self.min_score, "lie in [0, 1]"));
        }
        Ok(())
    }
}

/// One cylinder that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// The cylinder.
    pub cylinder: Cylinder,
    /// The probability that there is a cylinder, before a fit to its region.
    pub score: f64,
    /// Pixels of its region.
    pub pixels: usize,
    /// Where its region begins and ends along the axis, from the point of the axis.
    pub along: [f64; 2],
    /// What speaks for it.
    pub evidence: Evidence,
}

/// What was found in a scene.
#[derive(Debug, Clone, Default)]
pub struct Detections {
    /// The cylinders by falling score.
    pub cylinders: Vec<Detection>,
    /// For each pixel, row by row, the number of its cylinder in the order of `cylinders` from 1 on, or 0.
    pub labels: Vec<u16>,
    /// The pixels along columns and rows by which the depth would have to be moved to lie where the image shows the same bodies: where
    /// a sensor's registration is a little off. `None` where it lies there, and where nothing tells.
    pub shift: Option<[i32; 2]>,
    /// Whether there was more to look at than a search may: cylinders may be missing.
    pub cut_short: bool,
    /// What the search took: see `effort`.
    pub(crate) visits: u64,
    /// The position where everything was seen from, if any.
    pub(crate) seen_from: Option<Vector3<f64>>,
    /// Whether a region has all of its body that there is, as far as that can be told.
    pub(crate) whole: bool,
    /// Whether each point of a cloud has an error of its own.
    pub(crate) independent: bool,
    /// What scores after a fit need of the image.
    image: Option<ImageEdges>,
}

impl Detections {
    /// What speaks for a detection after a fit to its region; the fitted cylinder is in the coordinates of the camera.
    /// `radius_deviation` is the standard deviation of its radius as a part of it, infinite where the data do not tell; `slope`
    /// is by how much the radius grows along the axis, and the standard deviation of that, where both limbs were located.
    #[must_use]
    pub fn evidence_of_fit(
        &self,
        detection: &Detection,
        fitted: &Cylinder,
        radius_deviation: f64,
        slope: Option<[f64; 2]>,
    ) -> Evidence {
        // Edges on the limbs of either speak for a cylinder.
        let limbs = self.image.as_ref().map(|_| {
            let [seen, fitted] =
                [&detection.cylinder, fitted].map(|cylinder| self.covered(detection, cylinder));
            if seen.iter().sum::<f64>() > fitted.iter().sum() { seen } else { fitted }
        });
        // Two sharp lines tell it far better than depth, which is drawn out beside them.
        let slope = slope.map(|[slope, deviation]| [slope, deviation.hypot(LIMBS_TURN.get())]);
        let slope = slope.or(detection.evidence.slope);
        Evidence { limbs, slope, radius_deviation: Some(radius_deviation), ..detection.evidence }
    }

    /// How much of their limbs the image shows, by how certain the cylinders are.
    pub(crate) fn seen_in_image(&self) -> f64 {
        let limbs = |detection: &Detection| detection.evidence.limbs.map_or(0.0, |limbs| limbs.iter().sum());
        self.cylinders.iter().map(|detection| detection.score * limbs(detection)).sum()
    }

    /// The part of each limb of a cylinder along a detection that straight edges of the image cover; 0 without an
    /// image.
    #[must_use]
    pub fn covered(&self, detection: &Detection, cylinder: &Cylinder) -> [f64; 2] {
        let axis = &detection.cylinder.axis;
        let mut range = detection.along.map(|along| cylinder.axis.position_of(&axis.at(along)));
        range.sort_by(f64::total_cmp);
        let support = self.image.as_ref().and_then(|image| image.support(cylinder, range, ON_LIMB.get()));
        support.unwrap_or_default().covered
    }
}

/// Finds all cylinders in a depth image, and in the image that belongs to it where there is one. A fit to its region tells
/// more of each: see [`Detections::evidence_of_fit`].
///
/// # Errors
/// `InvalidArgument`; `SizeMismatch` where depth or image do not have the size of the camera.
pub fn detect(
    camera: &Camera,
    depth: &DepthImage,
    image: Option<&GreyImage>,
    options: &DetectionOptions,
) -> Result<Detections> {
    check_same_size("depth image", (depth.width(), depth.height()), "camera", camera.size(), SCALE_IMAGE)?;
    if let Some(image) = image {
        check_same_size("image", (image.width(), image.height()), "camera", camera.size(), SCALE_IMAGE)?;
    }
    detect_until(camera, depth, image, options, &|| false)
}

/// The same for images of the size of the camera, until `stopped` says so.
///
/// # Errors
/// `InvalidArgument`, `Cancelled`.
pub(crate) fn detect_until(
    camera: &Camera,
    depth: &DepthImage,
    image: Option<&GreyImage>,
    options: &DetectionOptions,
    stopped: &dyn Fn() -> bool,
) -> Result<Detections> {
    options.check()?;
    let (width, height) = camera.size();
    let pixel = camera.pixel_size();
    let rays = camera.rays_by_column_and_row();
    let read_rays = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 2]| match &rays {
        Some((x, y)) => {
            list[1].clear();
            list[1].resize(columns.len(), y[row]);
            list[0].clear();
            list[0].extend_from_slice(&x[columns]);
        }
        None => row::write(columns, list, |column| {
            camera.ray_of_pixel(column, row).map_or([f64::NAN; 2], |ray| [ray.x, ray.y])
        }),
    };
    let read_points = |row: usize, columns: Range<usize>, points: &mut [List<f64>; 3]| match &rays {
        Some((x, y)) => {
            let depths = &depth.values_of_row(row)[columns.clone()];
            row::write_points(depths, depth.scale(), &x[columns], y[row], points);
        }
        None => row::write(columns, points, |column| {
            let ray = depth.depth(column, row).and_then(|z| Some(camera.ray_of_pixel(column, row)? * z));
            ray.unwrap_or_default().cast::<f32>().cast::<f64>().into()
        }),
    };
    let cancelled = || cancelled_if(stopped());
    cancelled()?;
    let mut grid = Grid::new((width, height), pixel, side_of_cells((width, height), pixel), &read_points);
    cancelled()?;
    let edges = image.map(|image| ImageEdges::new(edges::edges(image, camera), pixel));
    cancelled()?;
    let pixel_of = |p: &Vector2<f64>| {
        let pixel = camera.project(&Vector3::new(p.x, p.y, 1.0))?.map(f64::round);
        (pixel.min() >= 0.0).then_some((pixel.x as usize, pixel.y as usize))
    };
    let limbs = edges.as_ref().map_or(Limbs::Outline, |edges| Limbs::Edges(edges, &pixel_of));
    let effort = Effort::new(stopped);
    let Searched { cylinders, shift, .. } = search(&mut grid, pixel, &limbs, options, &effort)?;
    let found = labels::label(&grid, &cylinders, (width, height), pixel, &read_points, &read_rays, &effort);
    Ok(Detections { image: edges, shift, ..found })
}

#[cfg(test)]
mod tests;
