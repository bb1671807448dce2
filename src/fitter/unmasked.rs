//! A view without a mask. The pixels on which its points lie stand in for one: like any mask of the pixels that have depth, they tell
//! beside which of the lines in the image the surface ends.

use super::view::View;
use crate::camera::Camera;
use crate::memory::List;
use crate::observations::{DepthRange, DepthView, Mask, MaskView, pixel_at};
use nalgebra::Vector3;

/// The least part of the pixels with points beside which the next one has points as well. What is less dense than the image has no
/// outline.
const DENSE: f64 = 0.7;

/// What marks a pixel with points that was counted.
const COUNTED: u8 = 2;

/// The part of the points that must lie within the image.
const WITHIN: f64 = 0.5;

impl View {
    /// The view with the pixels of its points as its mask, and with their depth where no depth image was pushed. `None` where there is a
    /// mask, edges, which say where the limbs are, or no image, and where the points are not dense.
    pub fn with_mask_of_points(&self) -> Option<Self> {
        self.image().and_then(|_| self.with_pixels_of_points())
    }

    /// The same with an image or without.
    pub fn with_pixels_of_points(&self) -> Option<Self> {
        if self.mask.is_some() || !self.segments.is_empty() {
            return None;
        }
        let camera = self.camera()?;
        let size = camera.size();
        let pixels = self.pixels_of_points(camera);
        let mut set = List::filled(0_u8, size.0 * size.1);
        pixels.iter().flatten().for_each(|&pixel| set[pixel] = 1);
        let within = pixels.iter().flatten().count();
        let (mut count, mut beside) = (0_usize, 0_usize);
        for &pixel in pixels.iter().flatten() {
            // Each pixel is counted once.
            if std::mem::replace(&mut set[pixel], COUNTED) != COUNTED {
                count += 1;
                beside += usize::from(set.get(pixel + 1).is_some_and(|&set| set != 0));
            }
        }
        if (within as f64) < WITHIN * self.cloud.len() as f64 || (beside as f64) < DENSE * count as f64 {
            return None;
        }
        let mask = Mask::copy(&MaskView::from_u8(&set, size).ok()?).ok()?;
        let mut frame = self.frame.clone();
        if frame.depth_on_image().is_none() {
            frame.set_depth_camera(None).ok()?;
            let nearest = self.nearest_points(&pixels, set.len());
            let depth = DepthView::from_f32(&nearest, size, 1.0).ok()?;
            frame.set_depth(&depth, &DepthRange::default()).ok()?;
        }
        Some(self.with_points_as_mask(frame, mask))
    }

    /// The pixel of each point, row by row, where it lies within the image.
    pub fn pixels_of_points(&self, camera: &Camera) -> List<Option<usize>> {
        let (width, height) = camera.size();
        let pixel = |point: Vector3<f64>| {
            let (column, row) = pixel_at(&camera.project(&point)?)?;
            (column < width && row < height).then_some(row * width + column)
        };
        self.cloud.points().map(pixel).collect()
    }

    /// The depth of the nearest point in each of so many pixels, 0 for none.
    fn nearest_points(&self, pixels: &[Option<usize>], count: usize) -> List<f32> {
        let mut nearest = List::filled(0.0_f32, count);
        for (point, pixel) in self.cloud.points().zip(pixels) {
            let Some(pixel) = *pixel else { continue };
            let (nearest, depth) = (&mut nearest[pixel], point.z as f32);
            *nearest = if *nearest > 0.0 { nearest.min(depth) } else { depth };
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::observations::{EdgeSegment, ImageView, PointsView};
    use nalgebra::Vector2;

    const SIZE: (usize, usize) = (32, 24);

    /// A view with an image and a point in the middle of each of these pixels, 2 away along the axis of the camera.
    fn view(pixels: impl Iterator<Item = (usize, usize)>) -> View {
        let distortion = Distortion::None;
        let intrinsics =
            Intrinsics { width: 32, height: 24, fx: 30.0, fy: 30.0, cx: 15.5, cy: 11.5, distortion };
        let camera = Camera::new(intrinsics).unwrap();
        let ray = |(x, y)| camera.unproject(&Vector2::new(x as f64, y as f64)).unwrap();
        let points: Vec<[f64; 3]> = pixels.map(|pixel| (ray(pixel) * 2.0).into()).collect();
        let mut view = View::default();
        view.frame.set_camera(camera.clone()).unwrap();
        view.frame.set_image(&ImageView::from_u8(&[9; 32 * 24], SIZE).unwrap()).unwrap();
        view.cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
        view
    }

    fn block(step: usize) -> impl Iterator<Item = (usize, usize)> {
        (4..14).flat_map(move |y| (5..25).step_by(step).map(move |x| (x, y)))
    }

    #[test]
    fn the_pixels_of_dense_points_are_the_mask() {
        let masked = view(block(1)).with_mask_of_points().unwrap();
        assert!(masked.mask.as_ref().unwrap().set_pixels().eq(block(1)));
        assert_eq!(masked.depth().unwrap().depth(5, 4), Some(2.0));
        assert_eq!(masked.depth().unwrap().depth(4, 4), None);
        assert!(masked.mask_ends_with_depth());
        assert!(!masked.mask_is_drawn());
        // With a mask there is none to be made.
        assert!(masked.with_mask_of_points().is_none());
    }

    #[test]
    fn no_mask_is_made_of_thin_points_nor_where_edges_or_no_image_are_given() {
        assert!(view(block(2)).with_mask_of_points().is_none());
        let mut with_edges = view(block(1));
        let endpoints = [Vector2::new(1.0, 2.0), Vector2::new(3.0, 4.0)];
        with_edges.segments.push(EdgeSegment { endpoints, weight: 1.0 });
        assert!(with_edges.with_mask_of_points().is_none());
        let mut without_image = view(block(1));
        without_image.frame.clear_image();
        assert!(without_image.with_mask_of_points().is_none());
        assert!(view(std::iter::empty()).with_mask_of_points().is_none());
    }
}
