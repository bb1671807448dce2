//! Limits of a measured quantity, and whether a measurement keeps them.

use cylfuse::fitter::{self, Conformity, Flags};
use serde::Serialize;
use std::str::FromStr;

/// What can be limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    Radius,
    Length,
}

impl Quantity {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Radius => "radius",
            Quantity::Length => "length",
        }
    }
}

/// `radius=LOW..HIGH` or `length=LOW..HIGH`, in the unit of the data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    quantity: Quantity,
    low: f64,
    high: f64,
}

impl FromStr for Tolerance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "write radius=LOW..HIGH or length=LOW..HIGH";
        let (name, range) = text.split_once('=').ok_or(form)?;
        let quantity = match name {
            "radius" => Quantity::Radius,
            "length" => Quantity::Length,
            _ => return Err(format!("{name:?} has no tolerance; {form}")),
        };
        let (low, high) = range.split_once("..").ok_or(form)?;
        let number =
            |text: &str| text.parse::<f64>().map_err(|_| format!("{text:?} is not a number; {form}"));
        let (low, high) = (number(low)?, number(high)?);
        match low < high && low >= 0.0 && high.is_finite() {
            true => Ok(Self { quantity, low, high }),
            false => Err(format!(
                "{low} to {high} is no tolerance; the limits must be finite, the low one below the high one and at least 0"
            )),
        }
    }
}

impl Tolerance {
    /// Whether it limits a quantity.
    pub fn limits(&self, quantity: Quantity) -> bool {
        self.quantity == quantity
    }
}

/// What a measurement says about limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// All quantities are within their limits.
    Pass,
    /// The uncertainty does not tell, a quantity was not measured, or a warning puts the measurement in doubt.
    Undecided,
    /// A quantity is outside its limits.
    Fail,
}

/// A verdict and what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// The worst of all quantities.
    pub verdict: Verdict,
    /// What is said of each quantity, and the warnings that put the measurement in doubt; those that led to the verdict
    /// first.
    pub reasons: Vec<String>,
}

/// A value as it was measured.
#[derive(Debug, Clone, Copy, Default)]
pub struct Measured {
    /// The value, if there is one.
    pub value: Option<f64>,
    /// Its standard deviation, if it is known.
    pub deviation: Option<f64>,
    /// Whether the true value may be greater by any amount: the length of what is seen of a cylinder that goes on.
    pub at_least: bool,
}

/// The unit in which reasons are written: its size in that of the data, and its name.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    /// Units in the unit of the data.
    pub factor: f64,
    /// With a space before it, or nothing.
    pub name: &'static str,
}

/// The verdict on radius and length; none without limits.
///
/// Within or outside is what is so by [`fitter::Tolerance::decide`]: between lies what the measurement does not decide. Nor
/// does it decide anything where there are `warnings`.
pub fn judge(
    tolerances: &[Tolerance],
    radius: Measured,
    length: Measured,
    warnings: &[String],
    unit: Unit,
) -> Option<Judgement> {
    let of = |tolerance: &Tolerance| match tolerance.quantity {
        Quantity::Radius => tolerance.judge(radius, unit),
        Quantity::Length => tolerance.judge(length, unit),
    };
    let mut parts: Vec<(Verdict, String)> = tolerances.iter().map(of).collect();
    // The worst first; those alike stay in the order of the limits.
    parts.sort_by_key(|(verdict, _)| std::cmp::Reverse(*verdict));
    let worst = parts.first()?.0;
    let verdict = if warnings.is_empty() { worst } else { Verdict::Undecided };
    let warnings = warnings.iter().map(|warning| format!("in doubt: {warning}"));
    Some(Judgement { verdict, reasons: warnings.chain(parts.into_iter().map(|part| part.1)).collect() })
}

impl Tolerance {
    fn judge(&self, measured: Measured, unit: Unit) -> (Verdict, String) {
        let name = self.quantity.name();
        let undecided = |why: &str| (Verdict::Undecided, format!("{name} {why}"));
        let Measured { value: Some(value), deviation, at_least } = measured else {
            return undecided("not measured");
        };
        // A deviation of 0 is that of what was not measured but given.
        let Some(deviation) = deviation.filter(|deviation| *deviation > 0.0) else {
            return undecided("without a known uncertainty");
        };
        let reach = fitter::Tolerance::COVERAGE * deviation;
        let text = |size: f64| shown(size, reach, unit);
        // How far beyond the nearer limit, or inside of it.
        let beyond = (value - self.high).max(self.low - value);
        let (limit, side) =
            if value - self.high >= self.low - value { (self.high, "above") } else { (self.low, "below") };
        let limit = format!("{}{}", rounded(limit * unit.factor), unit.name);
        let margin = match beyond > 0.0 {
            true => format!("{} {side} the limit of {limit}", text(beyond)),
            false => format!("{} within the limit of {limit}", text(-beyond)),
        };
        let surely_too_long = value - reach > self.high;
        if at_least && !surely_too_long {
            return undecided("of the visible part only: an end is cut off, hidden or not seen");
        }
        let decided = fitter::Tolerance::new(self.low, self.high)
            .and_then(|limits| limits.decide(value, Some(deviation), Flags::empty()));
        match decided {
            Ok(Conformity::Conforming) => (Verdict::Pass, format!("{name} {margin}")),
            Ok(Conformity::NotConforming) => (Verdict::Fail, format!("{name} {margin}")),
            _ => {
                let coverage = fitter::Tolerance::COVERAGE;
                undecided(&format!("{margin}, its uncertainty is {} ({coverage} deviations)", text(reach)))
            }
        }
    }
}

/// A length with the digits that its uncertainty leaves.
fn shown(size: f64, reach: f64, unit: Unit) -> String {
    let (size, reach) = (size * unit.factor, reach * unit.factor);
    let digits = if reach > 0.0 { (1.0 - reach.log10().floor()).clamp(0.0, 12.0) as usize } else { 6 };
    format!("{size:.digits$}{}", unit.name)
}

/// A limit as it was given, without the errors of its change of unit.
fn rounded(limit: f64) -> f64 {
    format!("{limit:.9e}").parse().unwrap_or(limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLIMETRES: Unit = Unit { factor: 1000.0, name: " mm" };

    fn known(value: f64, deviation: f64) -> Measured {
        Measured { value: Some(value), deviation: Some(deviation), at_least: false }
    }

    fn limits(texts: &[&str]) -> Vec<Tolerance> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn the_uncertainty_decides_and_the_reason_says_by_how_much() {
        let tolerances = limits(&["radius=0.019..0.021", "length=0.1..0.2"]);
        let judged = |radius: f64, deviation: f64| {
            let length = known(0.16, 0.001);
            judge(&tolerances, known(radius, deviation), length, &[], MILLIMETRES).unwrap()
        };
        for (radius, deviation, verdict, reason) in [
            (0.0202, 0.00039, Verdict::Pass, "radius 0.80 mm within the limit of 21 mm"),
            (
                0.0202,
                0.0006,
                Verdict::Undecided,
                "radius 0.8 mm within the limit of 21 mm, its uncertainty is 1.2 mm (2 deviations)",
            ),
            (
                0.0209,
                0.0004,
                Verdict::Undecided,
                "radius 0.10 mm within the limit of 21 mm, its uncertainty is 0.80 mm (2 deviations)",
            ),
            (
                0.0215,
                0.0004,
                Verdict::Undecided,
                "radius 0.50 mm above the limit of 21 mm, its uncertainty is 0.80 mm (2 deviations)",
            ),
            (0.022, 0.0004, Verdict::Fail, "radius 1.00 mm above the limit of 21 mm"),
            (0.018, 0.0004, Verdict::Fail, "radius 1.00 mm below the limit of 19 mm"),
        ] {
            let judgement = judged(radius, deviation);
            assert_eq!(judgement.verdict, verdict, "{radius} {deviation}");
            assert_eq!(judgement.reasons[0], reason);
            assert_eq!(judgement.reasons[1], "length 40.0 mm within the limit of 200 mm");
        }
    }

    #[test]
    fn what_led_to_the_verdict_comes_first() {
        let tolerances = limits(&["radius=0.019..0.021", "length=0.1..0.2"]);
        let judgement = judge(&tolerances, known(0.02, 1e-4), known(0.25, 0.001), &[], MILLIMETRES).unwrap();
        assert_eq!(judgement.verdict, Verdict::Fail);
        assert_eq!(judgement.reasons[0], "length 50.0 mm above the limit of 200 mm");
    }

    #[test]
    fn what_is_not_known_decides_nothing() {
        let tolerances = limits(&["radius=0.019..0.021", "length=0.1..0.2"]);
        let radius = known(0.02, 0.0001);
        let judged = |length: Measured| judge(&tolerances, radius, length, &[], MILLIMETRES).unwrap();
        let missing = judged(Measured::default());
        assert_eq!((missing.verdict, &missing.reasons[0][..]), (Verdict::Undecided, "length not measured"));
        let vague = judged(Measured { deviation: None, ..known(0.15, 0.0) });
        assert_eq!(vague.verdict, Verdict::Undecided);
        assert_eq!(vague.reasons[0], "length without a known uncertainty");
        // A length that was given.
        assert_eq!(judged(known(0.15, 0.0)), vague);
        assert_eq!(judge(&[], radius, radius, &[], MILLIMETRES), None);
    }

    #[test]
    fn a_part_of_a_cylinder_can_only_be_too_long() {
        let tolerances = limits(&["length=0.1..0.2"]);
        let judged = |value: f64| {
            let part = Measured { at_least: true, ..known(value, 0.001) };
            judge(&tolerances, Measured::default(), part, &[], MILLIMETRES).unwrap().verdict
        };
        assert_eq!([0.05, 0.15, 0.201, 0.25].map(judged), {
            use Verdict::{Fail, Undecided};
            [Undecided, Undecided, Undecided, Fail]
        });
    }

    #[test]
    fn a_doubt_leaves_nothing_decided() {
        let doubt = ["not converged".to_string()];
        for limits in [["radius=0.01..0.03"], ["radius=0.03..0.04"]].map(|texts| limits(&texts)) {
            let sure = judge(&limits, known(0.02, 1e-4), Measured::default(), &[], MILLIMETRES).unwrap();
            let judgement =
                judge(&limits, known(0.02, 1e-4), Measured::default(), &doubt, MILLIMETRES).unwrap();
            assert_ne!(sure.verdict, Verdict::Undecided);
            assert_eq!(judgement.verdict, Verdict::Undecided);
            // What the numbers alone would say stays.
            assert_eq!(judgement.reasons, ["in doubt: not converged", &sure.reasons[0]]);
        }
    }

    #[test]
    fn mistakes_are_named() {
        for (text, expected) in [
            ("radius", "write radius=LOW..HIGH"),
            ("width=1..2", "\"width\" has no tolerance"),
            ("radius=1", "write radius=LOW..HIGH"),
            ("radius=a..2", "\"a\" is not a number"),
            ("radius=2..1", "2 to 1 is no tolerance"),
            ("radius=NaN..1", "NaN to 1 is no tolerance"),
        ] {
            let error = text.parse::<Tolerance>().unwrap_err();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }
}
