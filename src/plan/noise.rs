//! Laws of the noise of depth and image, by distance and size alone.

use crate::camera::Camera;
use crate::error::{Error, Result, not_negative};

/// The noise of depth along the optical axis: σ(z) = `constant` + `linear` z + `quadratic` z², alike in squares of pixels of
/// the side `correlation`.
///
/// It is what changes from capture to capture. What all points of a frame share is that of
/// [`NoiseModel`](crate::noise::NoiseModel).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthNoise {
    /// In metres.
    pub constant: f64,
    /// Metres a metre.
    pub linear: f64,
    /// Metres a square metre: σ_d / (f b) of triangulation with a noise of σ_d pixels of the disparity, a focal length of f
    /// pixels and a baseline of b metres.
    pub quadratic: f64,
    /// The side of the squares that share their noise, in pixels of the image, at least 1: a matching window, or the reach of
    /// a filter.
    pub correlation: f64,
}

impl DepthNoise {
    /// That of the structured light of the twin: f = 575 pixels, b = 75 mm, windows of 9 × 9 pixels. Their disparity has a
    /// noise of 0.039 pixels by the scatter of the positions of 8 scenes.
    #[must_use]
    pub fn structured_light(camera: &Camera) -> Self {
        let correlation = on_image(9.0, 575.0, camera);
        Self { constant: 0.0, linear: 0.0, quadratic: 0.039 / (575.0 * 0.075), correlation }
    }

    /// That of the active stereo of the twin: f = 600 pixels, b = 55 mm, windows of 9 × 9 pixels, a noise of 0.03 pixels.
    #[must_use]
    pub fn active_stereo(camera: &Camera) -> Self {
        let correlation = on_image(9.0, 600.0, camera);
        Self { constant: 0.0, linear: 0.0, quadratic: 0.030 / (600.0 * 0.055), correlation }
    }

    /// That of the time of flight of the twin: the noise of the phase, by its electrons, and its filter.
    #[must_use]
    pub fn time_of_flight(camera: &Camera) -> Self {
        let correlation = on_image(2.6, 540.0, camera);
        Self { constant: 0.0, linear: 3.1e-4, quadratic: 1.5e-4, correlation }
    }

    /// Standard deviation at a depth, both in metres.
    #[must_use]
    pub fn at(&self, depth: f64) -> f64 {
        self.constant + depth * (self.linear + depth * self.quadratic)
    }

    pub(super) fn check(&self) -> Result<()> {
        let coefficients = [
            ("constant noise of depth", self.constant),
            ("linear noise of depth", self.linear),
            ("quadratic noise of depth", self.quadratic),
        ];
        for (name, value) in coefficients {
            not_negative(name, value)?;
        }
        if !(self.at(1.0) > 0.0) {
            return Err(Error::argument("noise of depth", self.at(1.0), "be greater than 0"));
        }
        match self.correlation >= 1.0 && self.correlation.is_finite() {
            true => Ok(()),
            false => {
                Err(Error::argument("correlation of depth", self.correlation, "be finite and at least 1"))
            }
        }
    }
}

/// Pixels of a depth camera of some focal length in pixels of the image.
fn on_image(pixels: f64, focal_length: f64, camera: &Camera) -> f64 {
    (pixels * camera.intrinsics().fx / focal_length).max(1.0)
}

/// How well the image shows limbs and ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepNoise {
    /// At each limb, the standard deviation of a pixel as a part of the step of brightness: of the steps along the limb their
    /// root mean square. The default is 0.014: a step of half the full scale, and pixels of some 10,000 electrons.
    pub limbs: [f64; 2],
    /// At each end, the standard deviation of a pixel as a part of the step of brightness. Where the tilt is positive the first end is the nearer one.
    pub ends: [f64; 2],
    /// Blur of lens and focus, the standard deviation of a Gaussian in pixels. The default is 0.7.
    pub blur: f64,
}

impl Default for StepNoise {
    fn default() -> Self {
        Self::alike(0.014, 0.7)
    }
}

impl StepNoise {
    /// Noise that is alike at all limbs and ends, with the blur of the image.
    #[must_use]
    pub const fn alike(noise: f64, blur: f64) -> Self {
        Self { limbs: [noise; 2], ends: [noise; 2], blur }
    }

    /// The noise at limbs and ends where all have the same.
    #[must_use]
    pub fn common(&self) -> Option<f64> {
        let noise = self.limbs[0];
        (*self == Self::alike(noise, self.blur)).then_some(noise)
    }

    /// Standard deviation of the position of a straight step along some pixels, if all but that position were known: with the
    /// slope of a step of the blur b the information is Σ (∂I/∂u)² / σ² = n / (2 √π b σ²) (the Cramér–Rao bound).
    pub(super) fn position_deviation(&self, noise: f64, pixels: f64) -> f64 {
        // The aperture of a pixel blurs, too.
        let blur = self.blur.hypot(1.0 / 12.0_f64.sqrt());
        noise * (2.0 * std::f64::consts::PI.sqrt() * blur / pixels).sqrt()
    }

    pub(super) fn check(&self) -> Result<()> {
        for noise in self.limbs.into_iter().chain(self.ends) {
            if !(noise > 0.0 && noise <= 1.0) {
                return Err(Error::argument("noise of a step", noise, "be greater than 0 and at most 1"));
            }
        }
        if !(self.blur >= 0.0 && self.blur <= 10.0) {
            return Err(Error::argument("blur of the image", self.blur, "be from 0 to 10 pixels"));
        }
        Ok(())
    }
}
