//! Images that share one pixel grid have one size.

use crate::error::{Error, Result};

/// What to do about an image that does not have the size of its camera.
pub(crate) const SCALE_IMAGE: &str = "scale the image, or set the intrinsics for its size";

/// Checks that an image has the size of another one, both as (columns, rows), or says what to do about it.
///
/// # Errors
/// `SizeMismatch`, with the names and sizes of both.
pub fn check_same_size(
    name: &'static str,
    (width, height): (usize, usize),
    other: &'static str,
    (other_width, other_height): (usize, usize),
    remedy: &'static str,
) -> Result<()> {
    if (width, height) == (other_width, other_height) {
        return Ok(());
    }
    Err(Error::SizeMismatch { name, width, height, other, other_width, other_height, remedy })
}
