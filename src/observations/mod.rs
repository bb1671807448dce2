//! What was measured: points, depth images, masks and edge segments, checked and copied in.
//!
//! Views borrow the caller's memory as it lies, with byte strides, so that a PCL cloud, an OpenCV matrix or a
//! plain array pass without conversion. Pushing copies what is usable and counts the rest by reason.

mod batch;
mod depth;
mod dropped;
mod frame;
mod image;
mod mask;
mod pieces;
mod points;
mod reduced;
mod registration;
mod segments;
mod size;
mod sparse;
mod strided;
mod views;

pub(crate) use depth::moved;
pub use depth::{DepthImage, DepthRange};
pub use dropped::Dropped;
pub use frame::{DepthCamera, Frame};
pub use image::GreyImage;
pub use mask::Mask;
use nalgebra::Vector2;
pub(crate) use points::check_weights;
pub(crate) use points::{ENOUGH_POINTS_TO_FIT, are_many, spread};
pub use points::{Offsets, PointCloud};
pub(crate) use reduced::Squares;
pub use reduced::{ReducedImage, from_reduced};
pub use segments::{EdgeSegment, check_segments};
pub(crate) use size::SCALE_IMAGE;
pub use size::check_same_size;
pub use strided::{Scalar, Strided};
pub(crate) use views::LARGEST_STORED_DEPTH;
pub use views::{DepthView, ImageFormat, ImageView, MaskView, Pixels, PointsView, VectorsView};

/// The column and the row of the pixel at a position; `None` left of the image or above it.
#[inline]
pub(crate) fn pixel_at(position: &Vector2<f64>) -> Option<(usize, usize)> {
    let (x, y) = (position.x + 0.5, position.y + 0.5);
    // The conversion rounds down; `f64::round` is a call.
    (x > 0.0 && y > 0.0).then_some((x as usize, y as usize))
}

#[cfg(test)]
mod tests;
