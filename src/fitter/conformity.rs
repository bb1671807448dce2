//! Whether a measured length conforms to its tolerance: the decision rule of ISO 14253-1.

use super::result::{FitResult, Flags};
use crate::error::{Error, Result, positive};

impl Flags {
    /// The warnings of which a stated deviation says nothing: with one of them no measurement decides about a tolerance
    /// (`docs/warnings.md`).
    pub const UNDECIDED: Self = Self::POOR_FIT
        .union(Self::POINTS_AND_LIMBS_DISAGREE)
        .union(Self::BODY_TAPERS)
        .union(Self::MASK_DISAGREES)
        .union(Self::DEPTH_SHIFTED)
        .union(Self::HIDDEN_WALL)
        .union(Self::MASK_ENDS_WITH_DEPTH)
        .union(Self::NOT_CONVERGED)
        .union(Self::RADIUS_AT_LIMIT)
        .union(Self::AXIS_AT_LIMIT)
        .union(Self::SCALE_HELD)
        .union(Self::RESOLUTION_LOST)
        .union(Self::UNCERTAINTY_UNKNOWN);
}

/// What a measurement says about a tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conformity {
    /// The measurement does not tell: its uncertainty reaches over a limit or is not known, or a warning puts it in doubt.
    Undecided,
    /// The value is within the limits with all of its uncertainty.
    Conforming,
    /// The value is outside the limits with all of its uncertainty.
    NotConforming,
}

/// The limits of a radius, a diameter or another length, and how sure a decision about them must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    lower: f64,
    upper: f64,
    coverage: f64,
}

impl Tolerance {
    /// The coverage factor k where none is asked for: standard deviations on either side of a value.
    pub const COVERAGE: f64 = 2.0;

    /// The limits in the unit of length of the data, which belong to what conforms; an infinite one is none.
    ///
    /// # Errors
    /// `InvalidArgument` unless the lower limit is below the upper one and one of them is finite.
    pub fn new(lower: f64, upper: f64) -> Result<Self> {
        // Of NaN neither is so.
        if lower < upper && (lower.is_finite() || upper.is_finite()) {
            return Ok(Self { lower, upper, coverage: Self::COVERAGE });
        }
        let requirement = "have a lower limit below the upper one, and at least one that is finite";
        Err(Error::argument("the tolerance", format!("{lower} to {upper}"), requirement))
    }

    /// These limits with another coverage factor.
    ///
    /// # Errors
    /// `InvalidArgument` unless it is finite and greater than 0.
    pub fn with_coverage(self, coverage: f64) -> Result<Self> {
        positive("the coverage factor", coverage)?;
        Ok(Self { coverage, ..self })
    }

    /// What a value says with its standard deviation and the warnings of its result. Without a deviation it says nothing, nor
    /// with one of 0: what the limits of a fit fix was not measured.
    ///
    /// A deviation covers the noise of the data and what the noise model says that all points share; not a wrong scale of the
    /// depth, nor wrong intrinsics. A decision is as good as that.
    ///
    /// # Errors
    /// `InvalidArgument` for a value that is not finite, and for a deviation that is negative or infinite; NaN is none.
    pub fn decide(&self, value: f64, deviation: Option<f64>, flags: Flags) -> Result<Conformity> {
        if !value.is_finite() {
            return Err(Error::argument("the measured value", value, "be finite"));
        }
        let deviation = deviation.filter(|deviation| !deviation.is_nan()).unwrap_or(0.0);
        if !(deviation >= 0.0 && deviation.is_finite()) {
            return Err(Error::argument(
                "the deviation",
                deviation,
                "be finite and at least 0, or NaN for none",
            ));
        }
        if deviation == 0.0 || flags.intersects(Flags::UNDECIDED) {
            return Ok(Conformity::Undecided);
        }
        let reach = self.coverage * deviation;
        let (low, high) = (value - reach, value + reach);
        Ok(if low >= self.lower && high <= self.upper {
            Conformity::Conforming
        } else if high < self.lower || low > self.upper {
            Conformity::NotConforming
        } else {
            Conformity::Undecided
        })
    }
}

impl FitResult {
    /// Whether the radius conforms to a tolerance.
    ///
    /// # Errors
    /// See [`Tolerance::decide`].
    pub fn radius_conforms(&self, tolerance: &Tolerance) -> Result<Conformity> {
        let deviation = self.uncertainty.as_ref().map(super::Uncertainty::radius);
        tolerance.decide(self.cylinder.radius, deviation, self.flags)
    }

    /// Whether the diameter conforms to a tolerance, whose limits are those of the diameter.
    ///
    /// # Errors
    /// See [`Tolerance::decide`].
    pub fn diameter_conforms(&self, tolerance: &Tolerance) -> Result<Conformity> {
        let deviation = self.uncertainty.as_ref().map(|uncertainty| 2.0 * uncertainty.radius());
        tolerance.decide(2.0 * self.cylinder.radius, deviation, self.flags)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Fitter;
    use super::*;
    use crate::observations::PointsView;
    use Conformity::{Conforming, NotConforming, Undecided};

    #[test]
    fn the_whole_interval_decides() {
        // Limits that are not alike about the nominal 20.
        let tolerance = Tolerance::new(19.5, 20.25).unwrap();
        for (value, deviation, expected) in [
            (20.0, 0.125, Conforming), // Up to the limit, which belongs to it.
            (20.0, 0.126, Undecided),
            (19.75, 0.125, Conforming),
            (19.74, 0.125, Undecided),
            (20.3, 0.025, Undecided),
            (20.3, 0.024, NotConforming),
            (19.25, 0.125, Undecided),
            (19.25, 0.12, NotConforming),
            (20.0, 5.0, Undecided), // Over both.
        ] {
            let decided = tolerance.decide(value, Some(deviation), Flags::empty()).unwrap();
            assert_eq!(decided, expected, "{value} {deviation}");
        }
        let sure = tolerance.with_coverage(3.0).unwrap();
        assert_eq!(sure.decide(20.0, Some(0.125), Flags::empty()), Ok(Undecided));
        assert_eq!(sure.decide(20.0, Some(0.08), Flags::empty()), Ok(Conforming));
    }

    #[test]
    fn a_limit_on_one_side_is_enough() {
        let least = Tolerance::new(19.5, f64::INFINITY).unwrap();
        let most = Tolerance::new(f64::NEG_INFINITY, 20.25).unwrap();
        for (value, by_least, by_most) in [
            (19.0, NotConforming, Conforming),
            (20.0, Conforming, Conforming),
            (21.0, Conforming, NotConforming),
        ] {
            assert_eq!(least.decide(value, Some(0.1), Flags::empty()), Ok(by_least), "{value}");
            assert_eq!(most.decide(value, Some(0.1), Flags::empty()), Ok(by_most), "{value}");
        }
    }

    #[test]
    fn what_is_not_known_decides_nothing() {
        let tolerance = Tolerance::new(19.5, 20.25).unwrap();
        for deviation in [None, Some(f64::NAN), Some(0.0)] {
            for value in [20.0, 25.0] {
                assert_eq!(tolerance.decide(value, deviation, Flags::empty()), Ok(Undecided));
            }
        }
        for flag in Flags::all().iter() {
            let doubtful = Flags::UNDECIDED.contains(flag);
            let decided = tolerance.decide(25.0, Some(0.1), flag).unwrap();
            assert_eq!(decided, if doubtful { Undecided } else { NotConforming }, "{flag:?}");
        }
    }

    #[test]
    fn a_fit_decides_by_its_own_deviation() {
        let point = |k: u32| {
            let (angle, noise) = (0.008 * f64::from(k), 1e-3 * (f64::from(k) * 2.4).sin());
            let [sin, cos] = [angle.sin(), angle.cos()].map(|part| (0.5 + noise) * part);
            [cos, 0.1 * f64::from(k % 7), 2.0 - sin]
        };
        let points: Vec<[f64; 3]> = (0..200).map(point).collect();
        let mut fitter = Fitter::new();
        fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
        let result = fitter.fit().unwrap();
        let (radius, deviation) = (result.cylinder.radius, result.uncertainty.unwrap().radius());
        for (below, above, expected) in
            [(2.1, 2.1, Conforming), (1.9, 2.1, Undecided), (2.1, 1.9, Undecided), (9.0, -2.1, NotConforming)]
        {
            let tolerance = Tolerance::new(radius - below * deviation, radius + above * deviation).unwrap();
            assert_eq!(result.radius_conforms(&tolerance), Ok(expected), "{below} {above}");
            let doubled =
                Tolerance::new(2.0 * (radius - below * deviation), 2.0 * (radius + above * deviation))
                    .unwrap();
            assert_eq!(result.diameter_conforms(&doubled), Ok(expected), "{below} {above}");
        }
        // One of its warnings suffices.
        let doubtful = FitResult { flags: Flags::UNDECIDED, ..result };
        let tolerance = Tolerance::new(0.9 * radius, 1.1 * radius).unwrap();
        assert_eq!(doubtful.radius_conforms(&tolerance), Ok(Undecided));
        let doubled = Tolerance::new(1.8 * radius, 2.2 * radius).unwrap();
        assert_eq!(doubtful.diameter_conforms(&doubled), Ok(Undecided));
    }

    #[test]
    fn mistakes_are_named() {
        let text = |error: Error| error.to_string();
        for (lower, upper) in [(2.0, 1.0), (1.0, 1.0), (f64::NAN, 1.0), (f64::NEG_INFINITY, f64::INFINITY)] {
            let error = text(Tolerance::new(lower, upper).unwrap_err());
            assert!(error.starts_with(&format!("the tolerance is {lower} to {upper}; it must")), "{error}");
        }
        let tolerance = Tolerance::new(1.0, 2.0).unwrap();
        for coverage in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(
                text(tolerance.with_coverage(coverage).unwrap_err()).starts_with("the coverage factor is")
            );
        }
        let error = text(tolerance.decide(f64::NAN, Some(0.1), Flags::empty()).unwrap_err());
        assert_eq!(error, "the measured value is NaN; it must be finite");
        for deviation in [-0.1, f64::INFINITY] {
            let error = text(tolerance.decide(1.5, Some(deviation), Flags::empty()).unwrap_err());
            assert!(error.starts_with(&format!("the deviation is {deviation}; it must")), "{error}");
        }
    }
}
