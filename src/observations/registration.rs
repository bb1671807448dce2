//! What the colour camera sees of the depth that another camera measured.
//!
//! Each measured pixel covers its footprint: the quadrangle of its four corners, which is carried to the colour image.
//! A corner has the mean depth of the pixels around it that are on one surface with the pixel, so that the footprints of a
//! surface meet without gaps, however finer the colour grid is. Of several footprints on a colour pixel the nearest one
//! counts (a z-buffer).
//!
//! **One surface.** Two depths belong to one surface, and neither hides the other, when they differ by at most
//!
//! τ(z) = √2 tan 75° · s · z + 3 √2 σ(z).
//!
//! The first part is the slope: s is the size of a pixel of the coarser of the two grids on the plane z = 1. What meets
//! on a colour pixel lies at most half a pixel of either grid from its centre along rows and along columns, and
//! neighbours lie one pixel apart: √2 s z across, on which a surface that leans 75° from the image plane rises by
//! √2 tan 75° s z. Depth cameras hardly measure surfaces that lean more. The second part is the noise: the difference of
//! two depths has the standard deviation √2 σ. σ(z) = c z², as triangulation has it, where c comes from the image: the
//! second difference of three neighbours in a row on a smooth surface has the deviation √6 σ.

use super::depth::DepthImage;
use super::frame::DepthCamera;
use super::mask::Mask;
use crate::camera::Camera;
use crate::error::{Result, with_room};
use crate::statistics::{DEVIATION_OF_MEDIAN, median};
use nalgebra::{Vector2, Vector3};

/// tan 75°.
const STEEPEST: f64 = 3.732_050_807_568_877;

/// Pixels between rays that are computed; those between them are interpolated, for z-buffer and mask only. Between them
/// a lens bends by at most f″ / 8 · 8²: about 0.01 pixels for k1 = 0.3 at the border of an image of 60° field.
const RAY_SPACING: usize = 8;

/// How many times the pixels of an ordinary footprint one may cover along rows or columns. One that covers more lies
/// eight times nearer to the colour camera than to the depth camera, and is no surface but a wrong number. Also bounds the work.
const LARGEST_FOOTPRINT: f64 = 8.0;

/// Second differences that the noise is taken from.
const NOISE_SAMPLES: usize = 2048;

/// Whether a mask on the colour image selects a measured pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sight {
    /// The colour camera sees it where the mask is set.
    Seen,
    /// It lies behind something nearer where the mask is set.
    Hidden,
    /// The mask is not set there.
    Outside,
}

/// Where the measured pixels lie on the colour image.
#[derive(Debug, Clone)]
pub(super) struct Registration {
    /// The depth on the grid of the colour image.
    image: DepthImage,
    /// For each measured pixel the colour pixel that sees it, counted row by row, with [`HIDDEN`], or [`OUTSIDE`].
    pixels: Vec<u32>,
}

/// Set where something nearer is in the way. Images have at most 2²⁸ pixels.
const HIDDEN: u32 = 1 << 31;

/// No pixel of the colour image.
const OUTSIDE: u32 = u32::MAX;

impl Registration {
    /// The depth image of a depth camera on the grid of a colour camera.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn new(depth: &DepthImage, own: &DepthCamera, camera: &Camera) -> Result<Self> {
        let rays = Rays::new(own)?;
        let surface = Surface::new(depth, own, camera);
        let (width, height) = depth.size();
        let mut splat = Splat::new(depth.size(), camera, own.camera.pixel_size() / camera.pixel_size())?;
        let mut pixels = reserved(width * height, OUTSIDE)?;
        // Corners that all pixels around share, above and below the row.
        let mut above: Vec<Option<Vector2<f64>>> = reserved(width + 1, None)?;
        let mut below: Vec<Option<Vector2<f64>>> = reserved(width + 1, None)?;
        let translation = own.to_color.translation();
        let point_at = |depth: f64, ray: Vector3<f64>| ray * depth + translation;
        let corner = |column: usize, row: usize, from: Option<f64>| {
            let depth = surface.corner(depth, column, row, from)?;
            camera.project(&point_at(depth, rays.at(column as f64, row as f64)?))
        };
        for row in 0..height {
            if row == 0 {
                (0..=width).for_each(|column| above[column] = corner(column, 0, None));
            } else {
                std::mem::swap(&mut above, &mut below);
            }
            (0..=width).for_each(|column| below[column] = corner(column, row + 1, None));
            for column in 0..width {
                let index = row * width + column;
                let Some(z) = depth.depth_at(index) else { continue };
                let Some(ray) = rays.at(column as f64 + 0.5, row as f64 + 0.5) else { continue };
                let point = point_at(z, ray);
                if let Some(pixel) = camera.project(&point).filter(|pixel| camera.contains(pixel)) {
                    pixels[index] = splat.index(&pixel);
                }
                let own = |shared: Option<Vector2<f64>>, right: usize, down: usize| {
                    shared.or_else(|| corner(column + right, row + down, Some(z)))
                };
                // Around the pixel.
                let corners = (
                    own(above[column], 0, 0),
                    own(above[column + 1], 1, 0),
                    own(below[column + 1], 1, 1),
                    own(below[column], 0, 1),
                );
                if let (Some(a), Some(b), Some(c), Some(d)) = corners {
                    splat.cover(&[a, b, c, d], point.z as f32);
                }
            }
        }
        let image = splat.image;
        for row in 0..height {
            for column in 0..width {
                let index = row * width + column;
                if pixels[index] == OUTSIDE {
                    continue;
                }
                let ray = rays.at(column as f64 + 0.5, row as f64 + 0.5);
                let point = depth.depth_at(index).zip(ray).map(|(z, ray)| point_at(z, ray));
                let nearest = image.depth_at(pixels[index] as usize);
                if let (Some(point), Some(nearest)) = (point, nearest)
                    && point.z - nearest > surface.tolerance(nearest)
                {
                    pixels[index] |= HIDDEN;
                }
            }
        }
        Ok(Self { image, pixels })
    }

    /// The depth on the grid of the colour image.
    pub fn image(&self) -> &DepthImage {
        &self.image
    }

    /// Whether a mask on the colour image selects a measured pixel, counted row by row.
    #[inline]
    pub fn sight(&self, index: usize, mask: &Mask) -> Sight {
        let pixel = self.pixels[index];
        if pixel == OUTSIDE || !mask.contains_index((pixel & !HIDDEN) as usize) {
            Sight::Outside
        } else if pixel & HIDDEN == 0 {
            Sight::Seen
        } else {
            Sight::Hidden
        }
    }
}

/// Elements of one value.
fn reserved<T: Clone>(count: usize, value: T) -> Result<Vec<T>> {
    let mut elements = with_room(count, "the registration of the depth image")?;
    elements.resize(count, value);
    Ok(elements)
}

/// Which depths belong to one surface.
struct Surface {
    /// What slope allows, relative to the depth.
    slope: f64,
    /// What noise allows, relative to the square of the depth.
    noise: f64,
}

impl Surface {
    fn new(depth: &DepthImage, own: &DepthCamera, camera: &Camera) -> Self {
        let size = |camera: &Camera| 1.0 / camera.intrinsics().fx.min(camera.intrinsics().fy);
        let slope = 2_f64.sqrt() * STEEPEST * size(camera).max(size(&own.camera));
        let mut surface = Self { slope, noise: 0.0 };
        surface.noise = 3.0 * 2_f64.sqrt() * surface.deviation(depth);
        surface
    }

    /// σ / z²: where the slope alone tells three neighbours apart they are not on one surface.
    fn deviation(&self, depth: &DepthImage) -> f64 {
        let count = depth.width() * depth.height();
        let mut samples = [0.0; NOISE_SAMPLES];
        let mut taken = 0;
        // A step that shares no factor with usual widths, so that the samples are spread over all columns.
        let step = (count / NOISE_SAMPLES).max(1) | 1;
        for index in (1..count.saturating_sub(1)).step_by(step) {
            let neighbours = [index - 1, index, index + 1].map(|index| depth.depth_at(index));
            if let [Some(left), Some(z), Some(right)] = neighbours
                && taken < NOISE_SAMPLES
                && (z - left).abs().max((z - right).abs()) <= self.tolerance(z)
            {
                samples[taken] = (left - 2.0 * z + right).abs() / (z * z);
                taken += 1;
            }
        }
        DEVIATION_OF_MEDIAN * median(&mut samples[..taken]) / 6_f64.sqrt()
    }

    /// How much two depths of one surface may differ.
    #[inline]
    fn tolerance(&self, depth: f64) -> f64 {
        (self.slope + self.noise * depth) * depth
    }

    /// The depth at the upper left corner of a pixel: the mean of the pixels around it that are on one surface with
    /// `from`. Without `from` all that are measured must be on one surface.
    #[inline]
    fn corner(&self, depth: &DepthImage, column: usize, row: usize, from: Option<f64>) -> Option<f64> {
        if from.is_none()
            && let Some([a, b, c, d]) = depth.block(column, row)
        {
            let (least, most) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
            if most == 0.0 {
                return None;
            }
            if least > 0.0 {
                let [least, most] = [least, most].map(|value| f64::from(value) * depth.scale());
                let mean = || [a, b, c, d].map(f64::from).iter().sum::<f64>() * (0.25 * depth.scale());
                return (most - least <= self.tolerance(least)).then(mean);
            }
        }
        let around = [
            depth.depth(column.wrapping_sub(1), row.wrapping_sub(1)),
            depth.depth(column, row.wrapping_sub(1)),
            depth.depth(column.wrapping_sub(1), row),
            depth.depth(column, row),
        ];
        let (mut sum, mut count) = (0.0, 0.0);
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for z in around.into_iter().flatten() {
            if from.is_none_or(|from| (z - from).abs() <= self.tolerance(z.min(from))) {
                sum += z;
                count += 1.0;
            }
            (least, most) = (least.min(z), most.max(z));
        }
        (count > 0.0 && (from.is_some() || most - least <= self.tolerance(least))).then(|| sum / count)
    }
}

/// The rays of a depth camera in the directions of the colour frame, at corners and centres of pixels.
struct Rays<'a> {
    own: &'a DepthCamera,
    columns: usize,
    /// At every [`RAY_SPACING`]-th corner, a little beyond the image; not a number where there is no ray.
    nodes: Vec<Vector3<f64>>,
}

impl<'a> Rays<'a> {
    fn new(own: &'a DepthCamera) -> Result<Self> {
        let (width, height) = own.camera.size();
        let columns = width / RAY_SPACING + 2;
        let rows = height / RAY_SPACING + 2;
        let mut rays = Self { own, columns, nodes: reserved(columns * rows, Vector3::repeat(f64::NAN))? };
        for row in 0..rows {
            for column in 0..columns {
                let at = |node: usize| (node * RAY_SPACING) as f64;
                if let Some(ray) = rays.exact(at(column), at(row)) {
                    rays.nodes[row * columns + column] = ray;
                }
            }
        }
        Ok(rays)
    }

    /// The ray at a position that is counted from the upper left corner of the image.
    fn exact(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        let ray = self.own.camera.unproject(&Vector2::new(x - 0.5, y - 0.5))?;
        Some(self.own.to_color.rotation() * ray)
    }

    /// The same, between the nodes where there are some.
    #[inline]
    fn at(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        let (x_nodes, y_nodes) = (x / RAY_SPACING as f64, y / RAY_SPACING as f64);
        let (column, row) = (x_nodes as usize, y_nodes as usize);
        let (right, down) = (x_nodes - column as f64, y_nodes - row as f64);
        let first = row * self.columns + column;
        let (above, below) = (&self.nodes[first..first + 2], &self.nodes[first + self.columns..][..2]);
        let top = above[0] + (above[1] - above[0]) * right;
        let bottom = below[0] + (below[1] - below[0]) * right;
        let ray = top + (bottom - top) * down;
        if ray.x.is_nan() { self.exact(x, y) } else { Some(ray) }
    }
}

/// A z-buffer.
struct Splat {
    image: DepthImage,
    /// The most columns and rows of a footprint.
    reach: Vector2<f64>,
}

impl Splat {
    /// For depth of some columns and rows, whose pixels have a size in those of the image.
    fn new(from: (usize, usize), camera: &Camera, pixel: f64) -> Result<Self> {
        let (width, height) = camera.size();
        let reach = |to: usize, from: usize| LARGEST_FOOTPRINT * (to as f64 / from as f64).max(1.0);
        let reach = Vector2::new(reach(width, from.0), reach(height, from.1));
        Ok(Self { image: DepthImage::empty((width, height), 1.0, pixel)?, reach })
    }

    /// The pixel that a position of the image is in, counted row by row.
    fn index(&self, position: &Vector2<f64>) -> u32 {
        let (column, row) = ((position.x + 0.5) as usize, (position.y + 0.5) as usize);
        (row * self.image.width() + column) as u32
    }

    /// Puts a depth into all pixels with centres in a quadrangle, given around.
    fn cover(&mut self, corners: &[Vector2<f64>; 4], depth: f32) {
        let low = corners.iter().fold(corners[0], |low, corner| low.inf(corner));
        let high = corners.iter().fold(corners[0], |high, corner| high.sup(corner));
        let size = high - low;
        if !(depth.is_finite() && size.x <= self.reach.x && size.y <= self.reach.y) {
            return;
        }
        let (width, height) = self.image.size();
        // Casts round towards 0 and stop there; without them every footprint would call functions for rounding.
        let range = |low: f64, high: f64, size: usize| {
            let first = low.max(0.0) as usize;
            let first = first + usize::from((first as f64) < low);
            let end = if high < 0.0 { 0 } else { (high as usize).saturating_add(1) };
            first..end.min(size)
        };
        let columns = range(low.x, high.x, width);
        for row in range(low.y, high.y, height) {
            for column in columns.clone() {
                let [a, b, c, d] = corners.map(|corner| corner - Vector2::new(column as f64, row as f64));
                if around_origin(&a, &b, &c) || around_origin(&a, &c, &d) {
                    self.image.put_nearest(row * width + column, depth);
                }
            }
        }
    }
}

/// Whether a triangle of either orientation contains the origin, its border included.
fn around_origin(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> bool {
    let sides = [a.perp(b), b.perp(c), c.perp(a)];
    sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0)
}
