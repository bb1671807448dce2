//! The parameters of a camera as a calibration gives them.

use crate::error::{Error, Result};
use std::fmt::Display;

/// The largest image in pixels; more is taken for a mistake in the numbers.
const MAX_PIXELS: u64 = 1 << 28;

/// The least and the greatest focal length in longer sides of the image. Fisheye lenses have 1/3, a telescope of 10 m
/// before 4000 pixels of 3 µm has 800; pieces cut out of an image have more than the whole. Numbers beyond are in another
/// unit, and what walks along a line pixel by pixel would not come to an end.
const FOCAL_LENGTHS: [f64; 2] = [1e-3, 1e5];

/// How far the principal point may be from the first pixel in longer sides of the image: pieces cut out of an image
/// have it far outside.
const PRINCIPAL_POINT: f64 = 1e4;

/// The distortion of the lens, F on the plane z = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// A pinhole: F is the identity.
    None,
    /// Brown–Conrady with the rational radial term, coefficients k1 k2 p1 p2 k3 k4 k5 k6 in the order of
    /// OpenCV, without unit:
    ///
    /// x′ = x (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²),
    /// y′ = y (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶) + p1 (r² + 2 y²) + 2 p2 x y,
    ///
    /// r² = x² + y².
    BrownConrady([f64; 8]),
    /// Kannala–Brandt (the fisheye model of OpenCV), coefficients k1 k2 k3 k4, without unit:
    ///
    /// (x′, y′) = (θ′ / r) (x, y) with θ′ = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), θ = atan r, r² = x² + y².
    ///
    /// Only rays less than 89° from the axis are in the valid field, because a ray is given by its point on
    /// the plane z = 1.
    KannalaBrandt([f64; 4]),
}

impl Distortion {
    /// Brown–Conrady from 0, 4, 5 or 8 coefficients in the order k1 k2 p1 p2 k3 k4 k5 k6; the missing ones
    /// are zero.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidIntrinsics`] for any other number of coefficients. Their values are checked by
    /// [`Camera::new`](super::Camera::new).
    pub fn brown_conrady(coefficients: &[f64]) -> Result<Self> {
        if !matches!(coefficients.len(), 0 | 4 | 5 | 8) {
            let name = "the number of Brown-Conrady coefficients";
            return Err(invalid(name, coefficients.len(), "be 0, 4, 5 or 8"));
        }
        let mut all = [0.0; 8];
        all[..coefficients.len()].copy_from_slice(coefficients);
        Ok(Self::BrownConrady(all))
    }

    /// Kannala–Brandt from the 4 coefficients k1 k2 k3 k4, or from none for the equidistant fisheye θ′ = θ.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidIntrinsics`] for any other number of coefficients. Their values are checked by
    /// [`Camera::new`](super::Camera::new).
    pub fn kannala_brandt(coefficients: &[f64]) -> Result<Self> {
        if !matches!(coefficients.len(), 0 | 4) {
            let name = "the number of Kannala-Brandt coefficients";
            return Err(invalid(name, coefficients.len(), "be 0 or 4"));
        }
        let mut all = [0.0; 4];
        all[..coefficients.len()].copy_from_slice(coefficients);
        Ok(Self::KannalaBrandt(all))
    }
}

/// The parameters of a camera as a calibration gives them. [`Camera::new`](super::Camera::new) checks them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Focal length in pixel widths.
    pub fx: f64,
    /// Focal length in pixel heights.
    pub fy: f64,
    /// Principal point in pixels from the centre of the first pixel, to the right.
    pub cx: f64,
    /// Principal point in pixels from the centre of the first pixel, down.
    pub cy: f64,
    /// Distortion of the lens.
    pub distortion: Distortion,
}

impl Intrinsics {
    /// Checks each number by itself.
    pub(super) fn check(&self) -> Result<()> {
        for (name, value) in [("width", self.width), ("height", self.height)] {
            if value == 0 {
                return Err(invalid(name, value, "be at least 1 pixel"));
            }
        }
        if u64::from(self.width) * u64::from(self.height) > MAX_PIXELS {
            let size = format!("{} x {}", self.width, self.height);
            return Err(invalid("width x height", size, format!("be at most {MAX_PIXELS} pixels")));
        }
        let side = f64::from(self.width.max(self.height));
        for (name, value) in [("fx", self.fx), ("fy", self.fy)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(invalid_number(name, value, "be finite and above 0"));
            }
            let [least, most] = FOCAL_LENGTHS.map(|factor| factor * side);
            if !(least..=most).contains(&value) {
                let requirement = format!(
                    "lie in [{least:?}, {most:?}], 0.001 to 100000 times the longer side of the image; give it in \
                     pixels of this image"
                );
                return Err(invalid_number(name, value, &requirement));
            }
        }
        for (name, value) in [("cx", self.cx), ("cy", self.cy)] {
            if !value.is_finite() {
                return Err(invalid_number(name, value, "be finite"));
            }
            let most = PRINCIPAL_POINT * side;
            if !(value.abs() <= most) {
                let requirement = format!(
                    "lie in [-{most:?}, {most:?}], 10000 times the longer side of the image; give it in pixels of \
                     this image"
                );
                return Err(invalid_number(name, value, &requirement));
            }
        }
        let (names, values): (&[&str], &[f64]) = match &self.distortion {
            Distortion::None => (&[], &[]),
            Distortion::BrownConrady(k) => (&["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"], k),
            Distortion::KannalaBrandt(k) => (&["k1", "k2", "k3", "k4"], k),
        };
        for (name, &value) in names.iter().zip(values) {
            if !value.is_finite() {
                return Err(invalid_number(name, value, "be finite"));
            }
        }
        Ok(())
    }
}

fn invalid(name: &str, value: impl Display, requirement: impl Into<String>) -> Error {
    Error::InvalidIntrinsics { name: name.into(), value: format!("{value}"), requirement: requirement.into() }
}

fn invalid_number(name: &str, value: f64, requirement: &str) -> Error {
    // This notation keeps 1e300 short.
    invalid(name, format!("{value:?}"), requirement)
}
