//! Edge segments in the image.

use crate::error::{Error, Result};
use nalgebra::Vector2;

/// The largest weight of a segment: beyond it the points lose the digits that they need beside it.
const LARGEST_WEIGHT: f64 = 1e9;

/// A piece of a limb line, in pixels of the (distorted) image: pixel centres at integer coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeSegment {
    /// The two endpoints, in any order.
    pub endpoints: [Vector2<f64>; 2],
    /// How much it counts, from 0 to 1e9; 1 for an ordinary segment.
    pub weight: f64,
}

/// Checks the coordinates and weights of segments.
///
/// # Errors
/// `InvalidArgument` when a number is not finite or a weight is out of range; names the segment.
pub fn check_segments(segments: &[EdgeSegment]) -> Result<()> {
    for (index, segment) in segments.iter().enumerate() {
        if let Some(value) = segment.endpoints.iter().flatten().find(|value| !value.is_finite()) {
            return Err(Error::argument(format!("a coordinate of edge segment {index}"), value, "be finite"));
        }
        if !(0.0..=LARGEST_WEIGHT).contains(&segment.weight) {
            let name = format!("the weight of edge segment {index}");
            return Err(Error::argument(name, segment.weight, "lie in [0, 1e9]"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bad_number_is_named() {
        let good = EdgeSegment { endpoints: [Vector2::new(1.0, 2.0), Vector2::new(3.0, 4.0)], weight: 1.0 };
        assert!(check_segments(&[good]).is_ok());
        let infinite =
            EdgeSegment { endpoints: [Vector2::new(1.0, f64::INFINITY), Vector2::zeros()], ..good };
        let error = check_segments(&[good, infinite]).unwrap_err();
        assert_eq!(error.to_string(), "a coordinate of edge segment 1 is inf; it must be finite");
        let error = check_segments(&[EdgeSegment { weight: -1.0, ..good }]).unwrap_err();
        assert_eq!(error.to_string(), "the weight of edge segment 0 is -1; it must lie in [0, 1e9]");
    }
}
