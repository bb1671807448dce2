//! Limits of a measured quantity, and whether a measurement keeps them.

use serde::Serialize;
use std::str::FromStr;

/// Standard deviations within which the truth lies in 95 % of the measurements.
const COVERAGE: f64 = 1.96;

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
    /// The uncertainty does not tell, or a quantity was not measured.
    Undecided,
    /// A quantity is outside its limits.
    Fail,
}

/// The verdict on radius and length, each a value and its standard deviation; none without limits.
///
/// Within or outside is what is so with an interval of 95 % on either side (ISO 14253-1): between lies what the
/// measurement does not decide.
pub fn verdict(
    tolerances: &[Tolerance],
    radius: (Option<f64>, Option<f64>),
    length: (Option<f64>, Option<f64>),
) -> Option<Verdict> {
    let of = |tolerance: &Tolerance| {
        let (Some(value), Some(deviation)) = (match tolerance.quantity {
            Quantity::Radius => radius,
            Quantity::Length => length,
        }) else {
            return Verdict::Undecided;
        };
        let reach = COVERAGE * deviation;
        match (value - reach, value + reach) {
            (low, high) if low >= tolerance.low && high <= tolerance.high => Verdict::Pass,
            (low, high) if low > tolerance.high || high < tolerance.low => Verdict::Fail,
            _ => Verdict::Undecided,
        }
    };
    tolerances.iter().map(of).max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uncertainty_decides() {
        let tolerances = ["radius=0.019..0.021", "length=0.1..0.2"].map(|text| text.parse().unwrap());
        let judge = |radius: f64, deviation: f64| {
            verdict(&tolerances, (Some(radius), Some(deviation)), (Some(0.15), Some(0.001)))
        };
        assert_eq!(judge(0.02, 0.0004), Some(Verdict::Pass));
        assert_eq!(judge(0.02, 0.0006), Some(Verdict::Undecided));
        assert_eq!(judge(0.0209, 0.0004), Some(Verdict::Undecided));
        assert_eq!(judge(0.0215, 0.0004), Some(Verdict::Undecided));
        assert_eq!(judge(0.022, 0.0004), Some(Verdict::Fail));
        assert_eq!(judge(0.018, 0.0004), Some(Verdict::Fail));
        // What is not known decides nothing.
        let known = (Some(0.02), Some(0.0001));
        assert_eq!(verdict(&tolerances, known, (None, None)), Some(Verdict::Undecided));
        assert_eq!(verdict(&tolerances[..1], (Some(0.02), None), (None, None)), Some(Verdict::Undecided));
        assert_eq!(verdict(&[], known, known), None);
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
