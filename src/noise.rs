//! What is known of the errors of the data before any of them is seen: one model for all stages of a fit.
//!
//! Thresholds of the stages are multiples of these standard deviations, so that who knows the data better changes a
//! number here and no threshold.

use crate::error::{Error, Result, not_negative, positive};

/// Pixels of the image for which the standard deviations of edges and masks hold as they are: 640 × 480, on which they
/// were measured.
const DRAWN_PIXELS: f64 = 640.0 * 480.0;

/// The part of the distance over which what shifts all points changes by its own size: a lens has the errors of its
/// field of view, twenty degrees and more.
pub(crate) const SHARED_RANGE: f64 = 1.0 / 3.0;

/// The same in standard deviations of where the points are: what filters and scattered light do to depth differs from one
/// end of a body to the other, as what is beside them does.
pub(crate) const SHARED_SPREADS: f64 = 2.0;

/// A shift of all points across the line of sight in parts of an offset along it: a quarter of a pixel of a depth camera.
pub(crate) const SHARED_ACROSS: f64 = 0.4;

/// Depth cameras scatter less than this part of the distance, within the range they are made for. About 745 cylinders in the
/// right place, of recorded frames, structured light and time of flight, points scatter by up to 0.0053 of it.
pub(crate) const LARGEST_DEPTH_NOISE: f64 = 0.01;

constants! {
    /// The default of [`NoiseModel::edge_endpoint`].
    EDGE_ENDPOINT = 0.5, "drawn px";

    /// The default of [`NoiseModel::mask_side`].
    MASK_SIDE = 1.6, "drawn px";

    /// The default of [`NoiseModel::mask_unevenness`].
    MASK_UNEVENNESS = 1.0, "drawn px";

    /// The default of [`NoiseModel::mask_growth`].
    MASK_GROWTH = 3.0, "drawn px";

    /// Standard deviation of what all sides of a mask are off outwards besides, as a part of that of one side: how masks are
    /// drawn, large or small all round. See docs/measurements-masks.md.
    pub(crate) MASK_COMMON = 0.2, "side";

    /// The same as the stated uncertainty knows it: 1.3 pixels for the default of `mask_side`, as drawn masks are.
    pub(crate) MASK_COMMON_STATED = 0.8, "side";

    /// The default of [`NoiseModel::mask_boundary`].
    MASK_BOUNDARY = 0.8, "drawn px";

    /// The default of [`NoiseModel::mask_correlation`].
    MASK_CORRELATION = 10.0, "drawn px";

    /// The default of [`NoiseModel::limb_of_points`].
    LIMB_OF_POINTS = 2.0, "drawn px";

    /// The default of [`NoiseModel::depth_shared`].
    DEPTH_SHARED = 0.002, "distance";
}

#[cfg(feature = "sensitivity")]
/// The defaults of the standard deviations.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    CONSTANTS.to_vec()
}

/// A blur of so many pixels, a standard deviation, leaves less than a tenth of the contrast at the finest pattern that
/// pixels can hold, exp(−π² σ² / 2): more pixels show nothing more.
const RESOLVED_BLUR: f64 = 0.7;

/// A part of the longer side of an image, but no less than some pixels, beyond which no hint is taken to be off: limbs are looked for as
/// far, pixel by pixel, and what is said to be worse tells next to nothing.
const FARTHEST: f64 = 1.0 / 16.0;
const FARTHEST_IN_SMALL: f64 = 8.0;

/// The smallest pixel of a drawing, in pixels of the image: no screen shows a pixel of an image larger.
const FINEST_PIXEL: f64 = 1.0 / 64.0;

/// The blur that boxes of `factor` pixels add to that of a pixel, in pixels: both are apertures, of variance w² / 12.
#[must_use]
pub fn box_blur(factor: usize) -> f64 {
    ((factor as f64).powi(2) - 1.0).sqrt() / 12.0_f64.sqrt()
}

/// Standard deviations of the data. Where 0 says so, it stands for an estimate from the data.
///
/// Edges and masks are drawn by people on a screen, or by networks on a grid of some hundred columns, whatever the
/// size of the image. So their deviations count in pixels of a drawing, see [`Self::drawn_pixel`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseModel {
    /// Size of a pixel of the drawing, in which edges and masks were made, in pixels of the image; 0 = by the size of
    /// the image: 1 up to 640 × 480 pixels, beyond that the square root of how many times as many pixels there are.
    pub drawn_pixel: f64,
    /// A hand-set endpoint of an edge across its limb, in pixels of the drawing. 0.5: the edges of 48 twin frames lie
    /// 0.33 pixels off the limbs in the median, which is that of a deviation of 0.5.
    pub edge_endpoint: f64,
    /// A side of a mask as a whole across its limb, in pixels of the drawing. 1.6: masks are drawn to one or two
    /// pixels, mostly all round alike.
    pub mask_side: f64,
    /// The part of it that differs from one end of a side to the other, in pixels of the drawing. 1: what is left of
    /// `mask_side` when a growth all round of 1.25 pixels is taken away.
    pub mask_unevenness: f64,
    /// The largest growth of a mask all round, in pixels of the drawing; a bound, no deviation. 3: two of the
    /// deviations of a growth of 1.25 pixels, and the half pixel of the raster.
    pub mask_growth: f64,
    /// The boundary of a mask at one position, in pixels of the drawing. 0.8: a person or a network draws a boundary to
    /// about a pixel, smoothly.
    pub mask_boundary: f64,
    /// The length along a boundary over which it wanders, in pixels of the drawing. 10: by eye on the masks of recorded
    /// frames.
    pub mask_correlation: f64,
    /// A limb as a fit to the points alone predicts it, in pixels of the drawing. 2: depth cameras smear depth at the
    /// limbs by some pixels of their own, of which matching windows have 5 to 11.
    pub limb_of_points: f64,
    /// A measured point across the surface, in the unit of length; 0 = from the residuals.
    pub depth: f64,
    /// Errors that all points of a view share, as a part of their distance; 0 = none. By so much all of them may be too
    /// near or too far, and so much may the radius of the cylinder they lie on be wrong, as apertures, filters and
    /// matching windows bend a profile. 0.002, about a pixel across the line of sight of a depth camera of 640 columns:
    /// a fifth to a tenth of what data sheets grant; with 0.001 the intervals of random cylinders of the twin are too narrow.
    /// A cloud without a camera has none, unless the options say that it was seen from the origin.
    pub depth_shared: f64,
    /// The values of the grey image, in the unit of the image linear in light; 0 = from differences of neighbours.
    pub image: f64,
    /// The blur of the grey image, the standard deviation of a Gaussian in pixels of the image; 0 = from its edges.
    pub blur: f64,
}

impl Default for NoiseModel {
    fn default() -> Self {
        Self {
            drawn_pixel: 0.0,
            edge_endpoint: EDGE_ENDPOINT.get(),
            mask_side: MASK_SIDE.get(),
            mask_unevenness: MASK_UNEVENNESS.get(),
            mask_growth: MASK_GROWTH.get(),
            mask_boundary: MASK_BOUNDARY.get(),
            mask_correlation: MASK_CORRELATION.get(),
            limb_of_points: LIMB_OF_POINTS.get(),
            depth: 0.0,
            depth_shared: DEPTH_SHARED.get(),
            image: 0.0,
            blur: 0.0,
        }
    }
}

impl NoiseModel {
    /// Checks every value.
    ///
    /// # Errors
    /// `InvalidArgument` that names the deviation, its value and its limit.
    pub fn check(&self) -> Result<()> {
        let estimated = [
            ("drawn_pixel", self.drawn_pixel),
            ("depth", self.depth),
            ("image", self.image),
            ("blur", self.blur),
        ];
        for (name, value) in estimated {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::argument(name, value, "be finite and at least 0; 0 = estimated"));
            }
        }
        let given = [
            ("edge_endpoint", self.edge_endpoint),
            ("mask_side", self.mask_side),
            ("mask_unevenness", self.mask_unevenness),
            ("mask_boundary", self.mask_boundary),
            ("mask_correlation", self.mask_correlation),
            ("limb_of_points", self.limb_of_points),
        ];
        for (name, value) in given {
            positive(name, value)?;
        }
        not_negative("mask_growth", self.mask_growth)?;
        not_negative("depth_shared", self.depth_shared)
    }

    /// The deviations in an image of some columns and rows. Nothing is farther off than the image is long, edges and sides
    /// of a mask than a part of that, nor drawn on a grid finer than a 64th of a pixel: what is looked at pixel by pixel ends.
    #[must_use]
    pub fn in_image(&self, (width, height): (usize, usize)) -> ImageNoise {
        let longest = width.max(height).max(1) as f64;
        let pixel = if self.drawn_pixel > 0.0 {
            self.drawn_pixel.clamp(FINEST_PIXEL, longest)
        } else {
            (width as f64 * height as f64 / DRAWN_PIXELS).sqrt().max(1.0)
        };
        let in_pixels = |drawn: f64| (pixel * drawn).min(longest);
        let farthest = (FARTHEST * longest).max(FARTHEST_IN_SMALL);
        ImageNoise {
            pixel,
            endpoint: in_pixels(self.edge_endpoint).min(farthest),
            side: in_pixels(self.mask_side).min(farthest),
            unevenness: in_pixels(self.mask_unevenness),
            growth: in_pixels(self.mask_growth),
            boundary: in_pixels(self.mask_boundary),
            correlation: in_pixels(self.mask_correlation),
            limb_of_points: in_pixels(self.limb_of_points),
            value: self.image,
            blur: self.blur,
        }
    }
}

/// The [`NoiseModel`] in one image: lengths in its pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageNoise {
    /// Size of a pixel of the drawing.
    pub pixel: f64,
    /// A hand-set endpoint across its limb.
    pub endpoint: f64,
    /// A side of a mask as a whole.
    pub side: f64,
    /// The part of it that differs from one end of a side to the other.
    pub unevenness: f64,
    /// The largest growth of a mask all round.
    pub growth: f64,
    /// The boundary of a mask at one position.
    pub boundary: f64,
    /// The length along a boundary over which it wanders.
    pub correlation: f64,
    /// A limb as a fit to the points alone predicts it.
    pub limb_of_points: f64,
    /// The values of the grey image; 0 = estimated.
    pub value: f64,
    /// Blur of the grey image; 0 = estimated.
    pub blur: f64,
}

/// Masks may end this many standard deviations of their unevenness beyond their largest growth.
const UNEVEN: f64 = 2.0;

impl ImageNoise {
    /// The farthest that the boundary of a mask may be off.
    pub(crate) fn largest_margin(&self) -> f64 {
        self.growth + UNEVEN * self.unevenness
    }

    /// This noise in an image whose pixels are the means of boxes of `factor` columns and rows.
    #[must_use]
    pub fn reduced(&self, factor: usize) -> Self {
        let ratio = factor as f64;
        Self {
            pixel: self.pixel / ratio,
            endpoint: self.endpoint / ratio,
            side: self.side / ratio,
            unevenness: self.unevenness / ratio,
            growth: self.growth / ratio,
            boundary: self.boundary / ratio,
            correlation: self.correlation / ratio,
            limb_of_points: self.limb_of_points / ratio,
            value: self.value / ratio,
            blur: if self.blur > 0.0 { self.blur.hypot(box_blur(factor)) / ratio } else { 0.0 },
        }
    }

    /// Columns and rows of the boxes that lose nothing of an image of some blur: the told blur, else a measured one,
    /// else that of an image which shows no more than the drawing. They are no larger than a pixel of the drawing: on the
    /// grid on which edges and masks are known to a pixel there is time enough, and where a limb is hardly to be seen the
    /// measured blur may be anything. Or they are no larger than `most`, where it is known that all is blurred.
    #[must_use]
    pub fn factor(&self, measured: Option<f64>, most: usize) -> usize {
        let blur = if self.blur > 0.0 { Some(self.blur) } else { measured };
        let factor = blur.map_or(self.pixel, |blur| blur / RESOLVED_BLUR);
        (factor as usize).clamp(1, (self.pixel.ceil() as usize).max(most).max(1))
    }

    /// How far beyond the boundary of a mask, and within it, its surroundings are looked at: past the reach of a boundary
    /// that is off by five deviations, as the growth of masks and matching windows of depth may make it, yet beside it.
    #[must_use]
    pub fn beyond(&self) -> [f64; 4] {
        [5.0, 7.5, 10.0, 12.5].map(|deviations| deviations * self.boundary)
    }

    /// The limbs of a fit to hand-set segments: two deviations of an endpoint, as depth draws such a fit, too.
    #[must_use]
    pub fn limb_of_segments(&self) -> f64 {
        2.0 * self.endpoint
    }

    /// How far from the sides of a mask segments agree with them, growth apart: four deviations of an endpoint, or two
    /// of the unevenness of a side.
    #[must_use]
    pub fn agreement(&self) -> f64 {
        (4.0 * self.endpoint).max(2.0 * self.unevenness)
    }

    /// How far from its limb a hand-set endpoint is grossly wrong: ten deviations.
    #[must_use]
    pub fn gross(&self) -> f64 {
        10.0 * self.endpoint
    }

    /// Lines nearer to each other than this are one limb: two deviations of an endpoint.
    #[must_use]
    pub fn same_limb(&self) -> f64 {
        2.0 * self.endpoint
    }

    /// The least distance of two limbs that can be told apart: four deviations of an endpoint.
    #[must_use]
    pub fn apart(&self) -> f64 {
        4.0 * self.endpoint
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_grow_with_the_image_and_never_shrink() {
        let model = NoiseModel::default();
        assert_eq!(model.in_image((640, 480)).endpoint, 0.5);
        assert_eq!(model.in_image((320, 240)).endpoint, 0.5);
        let large = model.in_image((2560, 1920));
        assert_eq!((large.endpoint, large.side, large.growth), (2.0, 6.4, 12.0));
        let told = NoiseModel { drawn_pixel: 1.0, ..model };
        assert_eq!(told.in_image((2560, 1920)).endpoint, 0.5);
    }

    #[test]
    fn a_bad_deviation_is_named() {
        assert_eq!(NoiseModel::default().check(), Ok(()));
        let error = |model: NoiseModel| model.check().unwrap_err().to_string();
        let model = NoiseModel { edge_endpoint: 0.0, ..NoiseModel::default() };
        assert_eq!(error(model), "edge_endpoint is 0; it must be finite and greater than 0");
        let model = NoiseModel { blur: f64::NAN, ..NoiseModel::default() };
        assert_eq!(error(model), "blur is NaN; it must be finite and at least 0; 0 = estimated");
        let model = NoiseModel { mask_growth: -1.0, ..NoiseModel::default() };
        assert_eq!(error(model), "mask_growth is -1; it must be finite and at least 0");
    }

    #[test]
    fn nothing_is_farther_off_than_the_image_is_long() {
        let model = NoiseModel { drawn_pixel: 1e-300, mask_boundary: 1e9, ..NoiseModel::default() };
        assert_eq!(model.in_image((640, 480)).pixel, FINEST_PIXEL);
        assert_eq!(model.in_image((640, 480)).boundary, 640.0);
        let model = NoiseModel { drawn_pixel: 1e9, ..NoiseModel::default() };
        let noise = model.in_image((200, 480));
        assert_eq!((noise.pixel, noise.boundary, noise.endpoint), (480.0, 384.0, 30.0));
    }
}
