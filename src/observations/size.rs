//! Images that share one pixel grid have one size.

use crate::error::{Error, Result};

/// Checks that an image has the size of another one, both as (columns, rows).
///
/// # Errors
/// `SizeMismatch`, with the names and sizes of both.
pub fn check_same_size(
    name: &'static str,
    (width, height): (usize, usize),
    other: &'static str,
    (other_width, other_height): (usize, usize),
) -> Result<()> {
    if (width, height) == (other_width, other_height) {
        return Ok(());
    }
    Err(Error::SizeMismatch { name, width, height, other, other_width, other_height })
}
