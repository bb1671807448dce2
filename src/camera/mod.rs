//! The camera: from a point in the camera frame to a pixel and back.
//!
//! Frame: x to the right, y down, z forward along the optical axis, origin at the centre of projection, any
//! unit of length. Pixels: x to the right, y down, the centre of the first pixel at (0, 0), as in OpenCV.
//!
//! A point p goes to the pixel of the image in three steps, and a pixel comes back in reverse order:
//!
//! 1. to the plane z = 1: (x, y) = (p.x, p.y) / p.z,
//! 2. through the lens ([`Distortion`]): (x′, y′) = F(x, y), the identity for a pinhole,
//! 3. to pixels: (fx x′ + cx, fy y′ + cy).
//!
//! **Valid field.** The formulas of F describe a lens only near the axis: further out they fold over, so that
//! two rays share a pixel. The valid field is the largest cone of rays about the optical axis in which F
//! stretches every direction by 1/100 to 100 times what it does at the centre (on the plane z = 1 for
//! Brown–Conrady, per angle for Kannala–Brandt) and no denominator vanishes. It ends at 89° from the axis at
//! the latest; the field of a pinhole is everything in front of the camera. Within the field F is one to one
//! and [`Camera::project`] and [`Camera::unproject`] are inverse to each other; outside they answer `None`.
//! With the coefficients of real lenses both ways around close to 1e-9 pixels (an angle between rays counts as
//! pixels through the focal length).
//!
//! An *ideal pixel* is what a pinhole with the same fx, fy, cx, cy would see: straight lines in space are
//! straight lines in ideal pixels, which is what the equations of the limbs need.

mod brown_conrady;
mod intrinsics;
mod kannala_brandt;
mod radial;
mod rays;

use crate::error::{Error, Result};
use crate::geometry::{Cylinder, LimbFrame};
use crate::memory::List;
use brown_conrady::BrownConrady;
pub use intrinsics::{Distortion, Intrinsics};
use kannala_brandt::KannalaBrandt;
use nalgebra::{Matrix3, Vector2, Vector3};
use rays::Rays;
use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

/// How far the pixel of a ray may be from the pixel that the ray was computed from.
const REPROJECTION_TOLERANCE: f64 = 1e-10;

/// The lens with what its valid field needs, on the plane z = 1.
#[derive(Clone, Debug)]
enum Lens {
    Pinhole,
    BrownConrady(BrownConrady),
    KannalaBrandt(KannalaBrandt),
}

/// A camera: checked [`Intrinsics`] and the valid field of the lens.
///
/// One with distortion remembers the rays of whole pixels of the image that it was asked for, together with its clones. That
/// takes 16 bytes a pixel when all were asked for.
#[derive(Clone)]
pub struct Camera {
    intrinsics: Intrinsics,
    lens: Lens,
    /// None for a pinhole, whose rays are found as fast as they are looked up.
    rays: Option<Arc<Rays>>,
}

impl Debug for Camera {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        // Rays follow from the rest.
        let Self { intrinsics, lens, rays: _ } = self;
        f.debug_struct("Camera").field("intrinsics", intrinsics).field("lens", lens).finish()
    }
}

impl Camera {
    /// Checks the parameters and finds the valid field.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidIntrinsics`] with the name, the value and the limit when fx or fy is not
    /// between 0.001 and 100,000 longer sides of the image, cx or cy is not finite or beyond 10,000 of them, a coefficient
    /// is not finite, or the image has no pixels or more than 2²⁸.
    pub fn new(intrinsics: Intrinsics) -> Result<Self> {
        intrinsics.check()?;
        let lens = match intrinsics.distortion {
            Distortion::None => Lens::Pinhole,
            // Calibrations without distortion often come as zeros: exact and fast as a pinhole.
            Distortion::BrownConrady(k) if k == [0.0; 8] => Lens::Pinhole,
            Distortion::BrownConrady(k) => Lens::BrownConrady(BrownConrady::new(&k)),
            Distortion::KannalaBrandt(k) => Lens::KannalaBrandt(KannalaBrandt::new(&k)),
        };
        Ok(Self::with_lens(intrinsics, lens))
    }

    fn with_lens(intrinsics: Intrinsics, lens: Lens) -> Self {
        let size = (intrinsics.width as usize, intrinsics.height as usize);
        let rays = (!matches!(lens, Lens::Pinhole)).then(|| Arc::new(Rays::new(size)));
        Self { intrinsics, lens, rays }
    }

    /// The parameters.
    #[must_use]
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// How large a pixel is at the distance 1.
    pub(crate) fn pixel_size(&self) -> f64 {
        0.5 * (1.0 / self.intrinsics.fx + 1.0 / self.intrinsics.fy)
    }

    /// The mean of the focal lengths along rows and columns, in pixels.
    pub(crate) fn focal_length(&self) -> f64 {
        0.5 * (self.intrinsics.fx + self.intrinsics.fy)
    }

    /// The camera of an image whose pixels are boxes of `factor` columns and rows of this one's, those that the border
    /// cuts left out.
    #[must_use]
    pub fn reduced(&self, factor: usize) -> Self {
        let ratio = factor.max(1) as f64;
        let Intrinsics { width, height, fx, fy, cx, cy, distortion } = self.intrinsics;
        let count = |pixels: u32| (f64::from(pixels) / ratio) as u32;
        let reduced = |coordinate: f64| (coordinate + 0.5) / ratio - 0.5;
        let intrinsics = Intrinsics {
            width: count(width),
            height: count(height),
            fx: fx / ratio,
            fy: fy / ratio,
            cx: reduced(cx),
            cy: reduced(cy),
            distortion,
        };
        Self::with_lens(intrinsics, self.lens.clone())
    }

    /// Columns and rows of the image.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.intrinsics.width as usize, self.intrinsics.height as usize)
    }

    /// The pixel of the (distorted) image that sees the point `p` of the camera frame, in the image or beyond
    /// its border ([`Camera::contains`]). `None` when z ≤ 0, outside the valid field, or not finite.
    #[must_use]
    pub fn project(&self, p: &Vector3<f64>) -> Option<Vector2<f64>> {
        let ideal = on_unit_plane(p)?;
        let distorted = match &self.lens {
            Lens::Pinhole => ideal,
            Lens::BrownConrady(lens) => lens.distort(&ideal)?,
            Lens::KannalaBrandt(lens) => lens.distort(&ideal)?,
        };
        finite(self.to_pixel(&distorted))
    }

    /// The pixels of points `start` + `direction` t + `offset` for some t, as [`Camera::project`] has them, by their numbers x and
    /// y, which are not finite where it has none. Without a lens a plain loop, for those that run with vector instructions.
    #[inline(always)]
    pub(crate) fn project_line(
        &self,
        [start, direction, offset]: [&Vector3<f64>; 3],
        parameters: &[f64],
        x: &mut [f64],
        y: &mut [f64],
    ) {
        let points = parameters.iter().map(|t| start + direction * *t + offset);
        let pixels = points.zip(x.iter_mut().zip(y));
        if !matches!(self.lens, Lens::Pinhole) {
            for (point, (x, y)) in pixels {
                let pixel = self.project(&point);
                (*x, *y) = pixel.map_or((f64::NAN, f64::NAN), |pixel| (pixel.x, pixel.y));
            }
            return;
        }
        let Intrinsics { fx, fy, cx, cy, .. } = self.intrinsics;
        for (point, (x, y)) in pixels {
            let seen = point.z > 0.0;
            let pixel = (fx * (point.x / point.z) + cx, fy * (point.y / point.z) + cy);
            *x = if seen { pixel.0 } else { f64::NAN };
            *y = if seen { pixel.1 } else { f64::NAN };
        }
    }

    /// The ray with z = 1 that the pixel of the (distorted) image sees, for pixels in the image and beyond its
    /// border. `None` when no ray of the valid field goes there, or not finite. That of a whole pixel of the image is found
    /// once; between pixels a lens with distortion takes some hundred times as long.
    #[inline]
    #[must_use]
    pub fn unproject(&self, pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        match &self.rays {
            None => Some(ray_through(&finite(self.on_image_plane(pixel))?)),
            Some(rays) => self.unproject_through_lens(rays, pixel),
        }
    }

    /// Not inlined: without a lens a ray takes less than this call.
    #[inline(never)]
    fn unproject_through_lens(&self, rays: &Rays, pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        rays.ray(pixel, || self.find_ray(pixel))
    }

    /// [`Camera::unproject`] of a whole pixel, faster where the ray is known.
    #[inline]
    pub(crate) fn ray_of_pixel(&self, column: usize, row: usize) -> Option<Vector3<f64>> {
        // An image has fewer rows and columns than that, and what has 32 bits is quicker to convert.
        let pixel = Vector2::new(f64::from(column as u32), f64::from(row as u32));
        match &self.rays {
            None => self.unproject(&pixel),
            Some(rays) => rays.of_pixel(column, row, || self.find_ray(&pixel)),
        }
    }

    /// Takes x and y of the rays with z = 1 of whole pixels of a row, by their offsets from one at a column and a row on. Says whether
    /// all of them have one that is known already; else what was taken is of no use.
    #[inline]
    pub(crate) fn take_known_rays(
        &self,
        pixel: (usize, usize),
        offsets: &[usize],
        x: &mut [f64],
        y: &mut [f64],
    ) -> bool {
        self.rays.as_ref().is_some_and(|rays| rays.take_known(pixel, offsets, x, y))
    }

    /// The rays with z = 1 of whole pixels, each given by column and row, by their numbers x and y, which are not numbers for a
    /// pixel without a ray. Without a lens a plain loop, for those that run with vector instructions.
    #[inline(always)]
    pub(crate) fn rays_of_pixels(&self, pixels: &[[u32; 2]], x: &mut [f64], y: &mut [f64]) {
        let rays = pixels.iter().zip(x.iter_mut().zip(y));
        if !matches!(self.lens, Lens::Pinhole) {
            for ([column, row], (x, y)) in rays {
                let ray = self.ray_of_pixel(*column as usize, *row as usize);
                (*x, *y) = ray.map_or((f64::NAN, f64::NAN), |ray| (ray.x, ray.y));
            }
            return;
        }
        let Intrinsics { fx, fy, cx, cy, .. } = self.intrinsics;
        for ([column, row], (x, y)) in rays {
            let ray = ((f64::from(*column) - cx) / fx, (f64::from(*row) - cy) / fy);
            let finite = ray.0.is_finite() & ray.1.is_finite();
            *x = if finite { ray.0 } else { f64::NAN };
            *y = if finite { ray.1 } else { f64::NAN };
        }
    }

    /// The rays with z = 1 of whole pixels, where x depends on the column alone and y on the row: the x of all columns and the y
    /// of all rows. `None` with distortion.
    pub(crate) fn rays_by_column_and_row(&self) -> Option<(List<f64>, List<f64>)> {
        let (width, height) = self.size();
        let ray = |column: usize, row: usize| self.unproject(&Vector2::new(column as f64, row as f64));
        if !matches!(self.lens, Lens::Pinhole) {
            return None;
        }
        let (mut of_columns, mut of_rows) = (List::with_capacity(width), List::with_capacity(height));
        for column in 0..width {
            of_columns.push(ray(column, 0)?.x);
        }
        for row in 0..height {
            of_rows.push(ray(0, row)?.y);
        }
        Some((of_columns, of_rows))
    }

    /// [`Camera::unproject`], which remembers what this finds.
    #[inline(never)]
    fn find_ray(&self, pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let distorted = finite(self.on_image_plane(pixel))?;
        let ideal = match &self.lens {
            Lens::Pinhole => distorted,
            Lens::BrownConrady(lens) => lens.undistort(&distorted)?,
            Lens::KannalaBrandt(lens) => lens.undistort(&distorted),
        };
        // The lens gives the best ray of its valid field, which for a pixel outside is not the ray of that
        // pixel: only this comparison tells the two apart.
        let ray = ray_through(&ideal);
        let distance = (self.project(&ray)? - pixel).amax();
        // Rounding grows with the coordinates; it counts only far outside any image.
        let tolerance = REPROJECTION_TOLERANCE * (1e-3 * pixel.amax()).max(1.0);
        (distance <= tolerance).then_some(ray)
    }

    /// The ideal pixel K ray / z, without distortion. `None` when z ≤ 0 or not finite.
    #[must_use]
    pub fn ideal_pixel(&self, ray: &Vector3<f64>) -> Option<Vector2<f64>> {
        finite(self.to_pixel(&on_unit_plane(ray)?))
    }

    /// The ray K⁻¹ (u, v, 1) of an ideal pixel; its z is 1.
    #[must_use]
    pub fn ideal_ray(&self, ideal: &Vector2<f64>) -> Vector3<f64> {
        ray_through(&self.on_image_plane(ideal))
    }

    /// The matrix of (9) and (10): a line in space with the moment m is the line `l = K_L m` in ideal pixels,
    /// l · (u, v, 1) = 0.
    ///
    /// `K_L = det(K) K⁻ᵀ = [[fy, 0, 0], [0, fx, 0], [−fy cx, −fx cy, fx fy]]`.
    #[must_use]
    pub fn line_projection(&self) -> Matrix3<f64> {
        let Intrinsics { fx, fy, cx, cy, .. } = self.intrinsics;
        Matrix3::new(fy, 0.0, 0.0, 0.0, fx, 0.0, -fy * cx, -fx * cy, fx * fy)
    }

    /// The two limb lines of a cylinder in ideal pixels, in the order of [`LimbFrame::limb_lines`]: each (a, b, c) with
    /// a u + b v + c = 0 and a² + b² = 1.
    ///
    /// # Errors
    /// `EdgeGeometry` when the camera is inside the cylinder or a limb line lies at infinity.
    pub fn limb_lines(&self, cylinder: &Cylinder) -> Result<[Vector3<f64>; 2]> {
        let lines = LimbFrame::new(cylinder).map(|limbs| {
            limbs.limb_plane_normals().map(|normal| {
                let line = self.line_projection() * normal;
                line / line.x.hypot(line.y)
            })
        });
        lines.filter(|lines| lines.iter().flatten().all(|x| x.is_finite())).ok_or_else(|| {
            Error::EdgeGeometry {
                reason: "the camera is inside the cylinder or a limb line lies at infinity".into(),
                remedy: "give a cylinder in front of the camera",
            }
        })
    }

    /// The signed distances of both ends of a segment in ideal pixels from each limb line of a cylinder, in pixels, in the order of
    /// [`LimbFrame::limb_lines`]; `None` where that has no limb lines.
    pub(crate) fn distances_from_limbs(
        &self,
        cylinder: &Cylinder,
        segment: &[Vector2<f64>; 2],
    ) -> Option<[Vector2<f64>; 2]> {
        let lines = self.limb_lines(cylinder).ok()?;
        Some(lines.map(|line| Vector2::from(segment.map(|q| line.dot(&q.push(1.0))))))
    }

    /// Whether a pixel position lies in the image: −0.5 ≤ x < width − 0.5 and likewise y.
    #[must_use]
    pub fn contains(&self, pixel: &Vector2<f64>) -> bool {
        let inside = |x: f64, size: u32| -0.5 <= x && x < f64::from(size) - 0.5;
        inside(pixel.x, self.intrinsics.width) && inside(pixel.y, self.intrinsics.height)
    }

    fn to_pixel(&self, plane: &Vector2<f64>) -> Vector2<f64> {
        let Intrinsics { fx, fy, cx, cy, .. } = self.intrinsics;
        Vector2::new(fx * plane.x + cx, fy * plane.y + cy)
    }

    #[inline]
    fn on_image_plane(&self, pixel: &Vector2<f64>) -> Vector2<f64> {
        let Intrinsics { fx, fy, cx, cy, .. } = self.intrinsics;
        Vector2::new((pixel.x - cx) / fx, (pixel.y - cy) / fy)
    }
}

/// Where the ray to `p` meets the plane z = 1, if `p` is in front of the camera.
fn on_unit_plane(p: &Vector3<f64>) -> Option<Vector2<f64>> {
    (p.z > 0.0).then(|| Vector2::new(p.x / p.z, p.y / p.z))
}

/// The ray through a point of the plane z = 1.
#[inline]
fn ray_through(plane: &Vector2<f64>) -> Vector3<f64> {
    Vector3::new(plane.x, plane.y, 1.0)
}

#[inline]
fn finite(v: Vector2<f64>) -> Option<Vector2<f64>> {
    (v.x.is_finite() && v.y.is_finite()).then_some(v)
}

#[cfg(test)]
mod tests;
