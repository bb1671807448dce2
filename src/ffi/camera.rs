//! What a camera sees where, without a fitter.

use super::handle::stateless;
use super::lists::{Room, list};
use super::sized::read;
use super::status::cylfuse_status;
use super::structs::{cylfuse_intrinsics, cylfuse_points_view};
use super::views;
use crate::camera::Camera;
use nalgebra::Vector2;

/// The pixels of the (distorted) image at which a camera sees points.
///
/// @param intrinsics the camera
/// @param points in the camera frame; weights and normals are ignored
/// @param out_pixels room for `capacity` pixels of 2 doubles, x and y, row by row of the points. Pixels may lie beyond
///   the border of the image; NaN for a point that is not finite, not in front of the camera or outside the field of
///   its model. Of any alignment; must not overlap with the points. May be NULL when `capacity` is 0.
/// @param capacity at least width * height of the points
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE, BUFFER_TOO_SMALL; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_intrinsics_project(
    intrinsics: *const cylfuse_intrinsics,
    points: *const cylfuse_points_view,
    out_pixels: *mut f64,
    capacity: usize,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`.
        let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
        let camera = Camera::new(views::intrinsics(&intrinsics)?)?;
        // SAFETY: as the header asks, `points` is NULL or points that can be read.
        let view = unsafe { read(points, "points") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let points = unsafe { views::points_view(&view) }?;
        let (width, height) = (points.width(), points.height());
        let needed = width * height;
        // SAFETY: as the header asks, `out_pixels` is NULL or room for `capacity` pixels.
        let out = unsafe { Room::new(out_pixels.cast::<[f64; 2]>(), needed, capacity, "out_pixels") }?;
        out.fill((0..needed).map(|index| {
            let pixel = camera.project(&points.points.at(index % width, index / width));
            pixel.map_or([f64::NAN; 2], Into::into)
        }));
        Ok(())
    })
}

/// The rays along which a camera sees pixels of the (distorted) image: the points at z = 1 of its frame.
///
/// The ray of an ideal pixel, as those of limb lines are, is that of the same intrinsics without distortion.
///
/// @param intrinsics the camera
/// @param pixels `count` pixels of 2 doubles, x and y, in the image or beyond its border; of any alignment. May be NULL
///   when `count` is 0.
/// @param count how many pixels
/// @param out_rays room for `count` rays of 3 doubles, x, y and z = 1; NaN for a pixel that is not finite or for which
///   the model has no ray. Of any alignment; must not overlap with the pixels. May be NULL when `count` is 0.
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_intrinsics_unproject(
    intrinsics: *const cylfuse_intrinsics,
    pixels: *const f64,
    count: usize,
    out_rays: *mut f64,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`.
        let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
        let camera = Camera::new(views::intrinsics(&intrinsics)?)?;
        // SAFETY: as the header asks, `pixels` is NULL or 2 doubles for each of `count` pixels.
        let pixels = unsafe { list(pixels.cast::<[f64; 2]>(), count, "pixels") }?;
        // SAFETY: as the header asks, `out_rays` is NULL or room for `count` rays.
        let out = unsafe { Room::new(out_rays.cast::<[f64; 3]>(), count, count, "out_rays") }?;
        out.fill(pixels.map(|pixel| {
            let ray = camera.unproject(&Vector2::from(pixel));
            ray.map_or([f64::NAN; 3], Into::into)
        }));
        Ok(())
    })
}
