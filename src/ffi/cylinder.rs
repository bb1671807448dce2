//! Geometry and plans without a fitter: `cylfuse_fitter_last_error(NULL)` tells the thread what was wrong.

use super::handle::stateless;
use super::lists::{Room, numbers};
use super::sized::read;
use super::status::cylfuse_status;
use super::structs::{cylfuse_cylinder, cylfuse_intrinsics, cylfuse_points_view};
use super::views::{self, Slot, cylinder};
use crate::camera::Camera;
use crate::error::Error;
use crate::plan::{DepthNoise, Deviations, Plan, StepNoise};

/// Signed distances of points from the surface, negative inside.
///
/// @param model the cylinder
/// @param points the points; weights are ignored
/// @param out room for `capacity` doubles, row by row of the points; NaN for a point with a coordinate that is not
///   finite, or so far away that no number holds its distance. Of any alignment; must not overlap with the points. May be
///   NULL when `capacity` is 0.
/// @param capacity at least width * height of the points
/// @return INVALID_ARGUMENT, STRUCT_SIZE, BUFFER_TOO_SMALL; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_cylinder_distances(
    model: *const cylfuse_cylinder,
    points: *const cylfuse_points_view,
    out: *mut f64,
    capacity: usize,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let cylinder = unsafe { cylinder(model, "model") }?;
        // SAFETY: as the header asks, `points` is NULL or points that can be read.
        let view = unsafe { read(points, "points") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let points = unsafe { views::points_view(&view) }?;
        let (width, height) = (points.width(), points.height());
        let needed = width * height;
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` doubles.
        let out = unsafe { Room::new(out, needed, capacity, "out") }?;
        out.fill((0..needed).map(|index| {
            let point = points.points.at(index % width, index / width);
            let distance = cylinder.distance(&point);
            if distance.is_finite() { distance } else { f64::NAN }
        }));
        Ok(())
    })
}

/// The two limb lines of a cylinder in the image: a u + b v + c = 0 with a^2 + b^2 = 1, in ideal pixels, which
/// are those of a pinhole with the same fx, fy, cx and cy: without distortion the pixels of the image. The cylinder has no
/// ends here: whether its visible part lies before the camera is not asked.
///
/// @param model the cylinder in the camera frame
/// @param intrinsics the camera
/// @param out_lines room for 6 doubles: a, b, c of the first line, then of the second. Of any alignment.
/// @return EDGE_GEOMETRY when the camera is inside the cylinder or a line lies at infinity, INVALID_ARGUMENT,
///   INVALID_INTRINSICS, STRUCT_SIZE; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_cylinder_project(
    model: *const cylfuse_cylinder,
    intrinsics: *const cylfuse_intrinsics,
    out_lines: *mut f64,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `out_lines` is NULL or room for 6 doubles.
        let out = unsafe { Slot::new(out_lines.cast::<[f64; 6]>(), "out_lines") }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let cylinder = unsafe { cylinder(model, "model") }?;
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`.
        let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
        let camera = Camera::new(views::intrinsics(&intrinsics)?)?;
        let mut lines = [0.0; 6];
        for (line, found) in lines.chunks_exact_mut(3).zip(camera.limb_lines(&cylinder)?) {
            line.copy_from_slice(found.as_slice());
        }
        out.write(lines);
        Ok(())
    })
}

/// How two cylinders differ.
///
/// @param a the first cylinder, such as the truth
/// @param b the second cylinder
/// @param out_angle angle between the axes in radians, in [0, pi / 2], whatever the signs of the directions
/// @param out_axis_distance shortest distance between the two axes, in the unit of length
/// @param out_radius_relative (radius of b - radius of a) / radius of a
/// @return INVALID_ARGUMENT for a bad cylinder, NUMERICAL where no number holds a difference; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_cylinder_compare(
    a: *const cylfuse_cylinder,
    b: *const cylfuse_cylinder,
    out_angle: *mut f64,
    out_axis_distance: *mut f64,
    out_radius_relative: *mut f64,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `out_angle` is NULL or writable.
        let angle = unsafe { Slot::new(out_angle, "out_angle") }?;
        // SAFETY: as the header asks, `out_axis_distance` is NULL or writable.
        let axis_distance = unsafe { Slot::new(out_axis_distance, "out_axis_distance") }?;
        // SAFETY: as the header asks, `out_radius_relative` is NULL or writable.
        let radius_relative = unsafe { Slot::new(out_radius_relative, "out_radius_relative") }?;
        // SAFETY: as the header asks, `a` is NULL or a cylinder.
        let a = unsafe { cylinder(a, "a") }?;
        // SAFETY: as the header asks, `b` is NULL or a cylinder.
        let b = unsafe { cylinder(b, "b") }?;
        let difference = a.compare(&b);
        let numbers = [difference.angle, difference.axis_distance, difference.radius_relative];
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(Error::Numerical { what: "the difference of the cylinders" }.into());
        }
        for (slot, number) in [angle, axis_distance, radius_relative].into_iter().zip(numbers) {
            slot.write(number);
        }
        Ok(())
    })
}

/// What to expect of measurements of a cylinder with a camera: standard deviations by the covariance at the exact view. The
/// middle of the axis lies on the optical axis. Unlike elsewhere in the interface lengths are in metres, as the noise of the
/// structured light is known in them; angles are in radians.
///
/// @param intrinsics the camera of the image, on whose pixels the depth is
/// @param cylinder 5 doubles: the distance from the camera to the middle of the axis; radius; length; the tilt of the axis
///   out of the plane of the image, from -1.4 to 1.4; its angle in the image from the vertical
/// @param noise 6 doubles, or NULL for those of the structured light of the twin and an ordinary image: a, b, c of the noise of
///   depth a + b z + c z^2 at the depth z; the side of the squares of pixels that share it, at least 1; the noise of a pixel
///   of the image as a part of the step of brightness at limbs and ends; the blur of the image in pixels
/// @param out_scatter room for 4 doubles: the standard deviations of captures of one scene about each other, of radius,
///   direction (radians), position of the axis and length; NaN for the length where an end lies outside the image
/// @param out_total room for 4 doubles: the same of a measurement about the truth, which is what a fit states
/// @return INVALID_ARGUMENT, INVALID_INTRINSICS, TOO_FEW_POINTS when the pixels that see the cylinder are worth fewer than 8
///   points with independent noise, NUMERICAL where the view does not determine it, STRUCT_SIZE; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_plan(
    intrinsics: *const cylfuse_intrinsics,
    cylinder: *const f64,
    noise: *const f64,
    out_scatter: *mut f64,
    out_total: *mut f64,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `out_scatter` is NULL or room for 4 doubles.
        let scatter = unsafe { Slot::new(out_scatter.cast::<[f64; 4]>(), "out_scatter") }?;
        // SAFETY: as the header asks, `out_total` is NULL or room for 4 doubles.
        let total = unsafe { Slot::new(out_total.cast::<[f64; 4]>(), "out_total") }?;
        // SAFETY: as the header asks, `cylinder` is NULL or 5 doubles.
        let [distance, radius, length, tilt, turn] = unsafe { numbers(cylinder, "cylinder") }?;
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`.
        let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
        let camera = Camera::new(views::intrinsics(&intrinsics)?)?;
        let depth = DepthNoise::structured_light(&camera);
        let mut plan = Plan { distance, radius, length, tilt, turn, ..Plan::new(camera, depth) };
        if !noise.is_null() {
            // SAFETY: as the header asks, `noise` is 6 doubles where it is not NULL.
            let [constant, linear, quadratic, correlation, noise, blur] = unsafe { numbers(noise, "noise") }?;
            plan.depth = DepthNoise { constant, linear, quadratic, correlation };
            plan.step = StepNoise::alike(noise, blur);
        }
        let expected = plan.expected()?;
        let in_order = |deviations: &Deviations| {
            let Deviations { radius, direction, position, length } = *deviations;
            [radius, direction, position, length.unwrap_or(f64::NAN)]
        };
        scatter.write(in_order(&expected.scatter));
        total.write(in_order(&expected.total));
        Ok(())
    })
}
