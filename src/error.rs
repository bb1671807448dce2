//! What can go wrong, each with the value, the limit and the remedy in its text.
//!
//! An error means that no usable result was written; whatever was pushed before stays in place. Doubtful
//! results (no convergence, a weakly determined radius, ignored edges) are not errors but fields of the
//! result. Texts are lower-case ASCII without a trailing period and fit a 512-byte buffer.

/// The result of a call that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// A failed call.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument has a value outside its documented range.
    #[error("{name} is {value}; it must {requirement}")]
    InvalidArgument {
        /// The argument or field.
        name: String,
        /// The value that was given.
        value: String,
        /// The condition that the value must meet, worded to follow "it must".
        requirement: String,
    },
    /// A camera parameter has a value with which no camera model works.
    #[error("intrinsics: {name} is {value}; it must {requirement}")]
    InvalidIntrinsics {
        /// The parameter.
        name: String,
        /// The value that was given.
        value: String,
        /// The condition that the value must meet, worded to follow "it must".
        requirement: String,
    },
    /// Two images that share one pixel grid have different sizes.
    #[error(
        "{name} is {width} x {height} but {other} is {other_width} x {other_height}; both must have the same size: {remedy}"
    )]
    SizeMismatch {
        /// The image that was given.
        name: &'static str,
        /// Its width in pixels.
        width: usize,
        /// Its height in pixels.
        height: usize,
        /// What it must match.
        other: &'static str,
        /// The width to match.
        other_width: usize,
        /// The height to match.
        other_height: usize,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A call came before something that it needs.
    #[error("{call} needs {missing}; {remedy}")]
    BadState {
        /// The call.
        call: &'static str,
        /// What is missing.
        missing: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A combination of settings or data that the chosen method does not define.
    #[error("{what}; {remedy}")]
    Unsupported {
        /// What was asked for.
        what: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// Memory for the data could not be allocated.
    #[error(
        "out of memory: {bytes} bytes for {what} could not be allocated; pass less data at once, or free memory"
    )]
    OutOfMemory {
        /// What the memory was for.
        what: &'static str,
        /// How much was asked for.
        bytes: usize,
    },
    /// Too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8 points with
    /// independent noise.
    #[error(
        "{usable} of {given} points are usable{left_out} but a cylinder needs at least {needed}; {remedy}"
    )]
    TooFewPoints {
        /// Points that can be used.
        usable: usize,
        /// Points that were given.
        given: usize,
        /// Why the others were left out, in parentheses; empty where none was.
        left_out: String,
        /// The least number.
        needed: usize,
        /// What to check.
        remedy: &'static str,
    },
    /// The points are as flat as a plane: the radius runs away.
    #[error("{}", planar(*radius, *spread, *limit, *axis_limited))]
    PlanarPoints {
        /// The radius at which the fit was given up.
        radius: f64,
        /// The spread of the points across the axis.
        spread: f64,
        /// The largest ratio of the two that counts as a cylinder.
        limit: f64,
        /// Whether the axis was limited to a cone, which may be why.
        axis_limited: bool,
    },
    /// The points lie on one straight line, such as a single generator of the cylinder.
    #[error(
        "the points lie on one line: they spread {} across a line of length {}; give points that cover more of the circumference",
        short(*across),
        short(*along)
    )]
    CollinearPoints {
        /// Root mean square spread along the line.
        along: f64,
        /// Root mean square spread across it.
        across: f64,
    },
    /// No pixel of the mask is set.
    #[error("{}", empty_mask(*width, *height))]
    EmptyMask {
        /// Width of the mask in pixels.
        width: usize,
        /// Height of the mask in pixels.
        height: usize,
    },
    /// No pixel in the region has a usable depth.
    #[error("{}", no_depth(*pixels, *missing, *out_of_range, *range))]
    NoDepth {
        /// Pixels in the region.
        pixels: usize,
        /// Pixels with a depth of zero, below zero or not finite, or of the largest integer.
        missing: usize,
        /// Pixels outside the range of depths.
        out_of_range: usize,
        /// The range, from the nearest to the farthest depth that counts.
        range: (f64, f64),
    },
    /// No start could be found for the iteration.
    #[error("no start was found: {reason}; give a start model")]
    NoStart {
        /// Why the starts that were tried failed.
        reason: String,
    },
    /// The camera sees no limb lines where they are needed, or nothing that was given meets the cylinder.
    #[error("{reason}; {remedy}")]
    EdgeGeometry {
        /// Why.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The arithmetic left the range of numbers.
    #[error("numerical failure: {what}; scale the data to ordinary numbers")]
    Numerical {
        /// Where.
        what: &'static str,
    },
    /// The caller asked to stop.
    #[error("{}", cancelled(*iterations))]
    Cancelled {
        /// Iterations done by then.
        iterations: usize,
    },
}

/// What a caller does with a failure is its own business, unless the fit was cancelled, which is the outer error.
pub(crate) fn unless_cancelled<T>(result: Result<T>) -> Result<Result<T>> {
    match result {
        Err(error @ Error::Cancelled { .. }) => Err(error),
        other => Ok(other),
    }
}

/// Refuses to go on with what was stopped before its first iteration.
pub(crate) fn cancelled_if(stopped: bool) -> Result<()> {
    if stopped { Err(Error::Cancelled { iterations: 0 }) } else { Ok(()) }
}

/// Refuses a number that is negative or not finite.
pub(crate) fn not_negative(name: &str, value: f64) -> Result<()> {
    match value >= 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(Error::argument(name, value, "be finite and at least 0")),
    }
}

/// Refuses a number that is not positive or not finite.
pub(crate) fn positive(name: &str, value: f64) -> Result<()> {
    match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(Error::argument(name, value, "be finite and greater than 0")),
    }
}

/// Makes room for so many more elements.
pub(crate) fn reserve<T>(list: &mut Vec<T>, more: usize, what: &'static str) -> Result<()> {
    let bytes = more.saturating_mul(size_of::<T>());
    list.try_reserve(more).map_err(|_| Error::OutOfMemory { what, bytes })
}

/// An empty list with room for so many elements.
pub(crate) fn with_room<T>(count: usize, what: &'static str) -> Result<Vec<T>> {
    let mut list = Vec::new();
    reserve(&mut list, count, what)?;
    Ok(list)
}

impl Error {
    /// An [`Error::InvalidArgument`].
    pub(crate) fn argument(
        name: impl Into<String>,
        value: impl std::fmt::Display,
        requirement: impl Into<String>,
    ) -> Self {
        Error::InvalidArgument {
            name: name.into(),
            value: readable(&value.to_string()),
            requirement: readable(&requirement.into()),
        }
    }

    /// The same failure where its argument is the field of a struct.
    pub(crate) fn in_struct(mut self, of: &str) -> Self {
        if let Error::InvalidArgument { name, .. } = &mut self {
            *name = format!("{of}.{name}");
        }
        self
    }

    /// The number of this failure in the C interface. Numbers are never reused.
    #[must_use]
    pub const fn code(&self) -> i32 {
        match self {
            Error::InvalidArgument { .. } => -1,
            Error::BadState { .. } => -5,
            Error::OutOfMemory { .. } => -8,
            Error::Unsupported { .. } => -9,
            Error::SizeMismatch { .. } => -10,
            Error::InvalidIntrinsics { .. } => -11,
            Error::TooFewPoints { .. } => -20,
            Error::PlanarPoints { .. } => -21,
            Error::CollinearPoints { .. } => -22,
            Error::EmptyMask { .. } => -23,
            Error::NoDepth { .. } => -24,
            Error::NoStart { .. } => -25,
            Error::EdgeGeometry { .. } => -26,
            Error::Numerical { .. } => -27,
            Error::Cancelled { .. } => -40,
        }
    }

    /// The name of this failure: the C constant without its prefix.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Error::InvalidArgument { .. } => "INVALID_ARGUMENT",
            Error::BadState { .. } => "BAD_STATE",
            Error::OutOfMemory { .. } => "OUT_OF_MEMORY",
            Error::Unsupported { .. } => "UNSUPPORTED",
            Error::SizeMismatch { .. } => "SIZE_MISMATCH",
            Error::InvalidIntrinsics { .. } => "INVALID_INTRINSICS",
            Error::TooFewPoints { .. } => "TOO_FEW_POINTS",
            Error::PlanarPoints { .. } => "PLANAR_POINTS",
            Error::CollinearPoints { .. } => "COLLINEAR_POINTS",
            Error::EmptyMask { .. } => "EMPTY_MASK",
            Error::NoDepth { .. } => "NO_DEPTH",
            Error::NoStart { .. } => "NO_START",
            Error::EdgeGeometry { .. } => "EDGE_GEOMETRY",
            Error::Numerical { .. } => "NUMERICAL",
            Error::Cancelled { .. } => "CANCELLED",
        }
    }
}

fn planar(radius: f64, spread: f64, limit: f64, axis_limited: bool) -> String {
    let grew = format!(
        "the radius reached {}, more than {limit} times their spread of {} across the axis",
        short(radius),
        short(spread)
    );
    match axis_limited {
        true => format!(
            "no cylinder with its axis within the limit fits the points: {grew}; check axis and axis_max_angle, and the mask"
        ),
        false => format!(
            "the points lie on a plane: {grew}; check the mask or the choice of points, or give points that cover more of the circumference"
        ),
    }
}

fn empty_mask(width: usize, height: usize) -> String {
    match width * height {
        0 => {
            format!("the mask has the size {width} x {height}; set its width and height, those of the image")
        }
        _ => format!(
            "all {width} x {height} pixels of the mask are zero; set the pixels of the cylinder to a non-zero value"
        ),
    }
}

fn no_depth(pixels: usize, missing: usize, out_of_range: usize, range: (f64, f64)) -> String {
    let mut reasons = format!("{missing} without a measurement");
    if out_of_range > 0 {
        let limits = match range {
            (min, max) if max == f64::INFINITY => format!("nearer than min_depth {min:?}"),
            (min, max) if min <= 0.0 => format!("farther than max_depth {max:?}"),
            (min, max) => format!("outside min_depth {min:?} to max_depth {max:?}"),
        };
        reasons += &readable(&format!(", {out_of_range} {limits}"));
    }
    let hidden = pixels.saturating_sub(missing + out_of_range);
    if hidden > 0 {
        reasons += &format!(", {hidden} hidden by something nearer or outside the field of the camera");
    }
    format!(
        "none of the {pixels} pixels in the region has a usable depth: {reasons}; check the depth scale and the mask"
    )
}

fn cancelled(iterations: usize) -> String {
    match iterations {
        0 => "cancelled by the caller".into(),
        _ => format!("cancelled by the caller after {iterations} iterations"),
    }
}

/// A length with four digits: 0.1154, 24.53, 0; what is very small or large in scientific notation.
pub(crate) fn short(length: f64) -> String {
    let exponent = length.abs().log10().floor();
    match length {
        0.0 => "0".into(),
        _ if length.is_infinite() => "infinity".into(),
        _ if (-4.0..4.0).contains(&exponent) => format!("{length:.*}", (3.0 - exponent) as usize),
        _ => format!("{length:.3e}"),
    }
}

/// The longest number that is written digit by digit: any `u64`.
const MOST_DIGITS: usize = 20;

/// A text with its long numbers in scientific notation: 1e300 has 301 digits otherwise, and pushes the remedy out of
/// the buffer.
fn readable(text: &str) -> String {
    let mut readable = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, from) = rest.split_at(start);
        let end = from.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(from.len());
        let (number, after) = from.split_at(end);
        readable += before;
        match number.parse::<f64>() {
            Ok(value) if number.len() > MOST_DIGITS => readable += &format!("{value:e}"),
            _ => readable += number,
        }
        rest = after;
    }
    readable + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_leave_out_what_does_not_apply() {
        assert_eq!(Error::Cancelled { iterations: 0 }.to_string(), "cancelled by the caller");
        assert_eq!(
            Error::Cancelled { iterations: 3 }.to_string(),
            "cancelled by the caller after 3 iterations"
        );
        let lengths = [0.0, 1.154e-1, 2.4534e1, 9999.4, 12_345.6, 2e-5, f64::INFINITY].map(short);
        assert_eq!(lengths, ["0", "0.1154", "24.53", "9999", "1.235e4", "2.000e-5", "infinity"]);
        let error = Error::EmptyMask { width: 0, height: 0 };
        assert_eq!(
            error.to_string(),
            "the mask has the size 0 x 0; set its width and height, those of the image"
        );
        let range = (0.0, f64::INFINITY);
        let error = Error::NoDepth { pixels: 5, missing: 5, out_of_range: 0, range };
        assert_eq!(
            error.to_string(),
            "none of the 5 pixels in the region has a usable depth: 5 without a measurement; check the depth scale and the mask"
        );
        let inf = f64::INFINITY;
        for (range, limits) in [
            ((1.5, inf), "nearer than min_depth 1.5"),
            ((0.0, 0.25), "farther than max_depth 0.25"),
            ((1.5, 2.0), "outside min_depth 1.5 to max_depth 2.0"),
        ] {
            let error = Error::NoDepth { pixels: 9, missing: 2, out_of_range: 4, range };
            assert_eq!(
                error.to_string(),
                format!(
                    "none of the 9 pixels in the region has a usable depth: 2 without a measurement, 4 {limits}, 3 hidden by \
                     something nearer or outside the field of the camera; check the depth scale and the mask"
                )
            );
        }
    }

    #[test]
    fn long_numbers_leave_room_for_limit_and_remedy() {
        let error = Error::argument("max lambda", 1e299, format!("be at least {} and {}", 1e300, 2.5e-300));
        assert_eq!(error.to_string(), "max lambda is 1e299; it must be at least 1e300 and 2.5e-300");
        assert_eq!(readable("-1.25, 18446744073709551615 of v2."), "-1.25, 18446744073709551615 of v2.");
        assert_eq!(readable(&(-1e30).to_string()), "-1e30");
    }
}
