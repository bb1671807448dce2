//! What the lens models share: the end of the valid field and the inverse of an increasing function.

/// The greatest angle from the optical axis in any valid field, 89°: the point on the plane z = 1 runs away
/// towards 90°.
const MAX_ANGLE: f64 = 89.0 * std::f64::consts::PI / 180.0;

/// Steps of the search for the end of the valid field, 0.2 mrad each. [`MIN_STRETCH`] keeps the result right
/// between them: only coefficients beyond all lenses could make the stretch fall from there to zero and come
/// back within one step.
const STEPS: u32 = 8192;

/// The least factor, against that at the centre, by which the lens stretches any direction in the valid
/// field.
///
/// At zero the image folds over. Rounding grows by the inverse of the factor from the pixel to the ray, so
/// staying a little away from zero keeps the ray exact, at the cost of some hundredths of a pixel at the fold.
pub(super) const MIN_STRETCH: f64 = 0.01;

/// The greatest such factor. It is infinite where a denominator vanishes; rounding grows by it from the ray to
/// the pixel.
pub(super) const MAX_STRETCH: f64 = 100.0;

/// The relative length of a step of Newton's method after which only rounding is left, as each step squares the
/// error.
pub(super) const LAST_STEP: f64 = 1e-9;

/// The greatest angle in radians up to which `holds` is true of all angles from the optical axis, at most
/// 89°; zero when it is true of none.
pub(super) fn end_of_field(holds: impl Fn(f64) -> bool) -> f64 {
    let angle = |step: u32| MAX_ANGLE * f64::from(step) / f64::from(STEPS);
    let Some(step) = (1..=STEPS).find(|&step| !holds(angle(step))) else { return MAX_ANGLE };
    let (mut inside, mut outside) = (angle(step - 1), angle(step));
    for _ in 0..60 {
        let middle = 0.5 * (inside + outside);
        *(if holds(middle) { &mut inside } else { &mut outside }) = middle;
    }
    inside
}

/// The x in [0, end] at which an increasing function that vanishes at zero takes the value `target` ≥ 0; `end`
/// when it stays below. `function` gives the value and the derivative, which must be in
/// [[`MIN_STRETCH`], [`MAX_STRETCH`]].
///
/// Newton's method; wherever it does not at least halve the error the bracket is halved instead.
pub(super) fn solve_increasing(function: impl Fn(f64) -> (f64, f64), target: f64, end: f64) -> f64 {
    if function(end).0 <= target {
        return end;
    }
    let (mut low, mut high) = (0.0, end);
    let mut last_error = f64::INFINITY;
    let mut x = target.min(end);
    // Halving the bracket takes about 60 steps to the last digit, Newton's method about 5.
    for _ in 0..200 {
        let (value, slope) = function(x);
        let error = value - target;
        *(if error > 0.0 { &mut high } else { &mut low }) = x;
        let newton = x - error / slope;
        if (newton - x).abs() <= LAST_STEP * x {
            return newton.clamp(0.0, end);
        }
        let halved = error.abs() <= 0.5 * last_error;
        last_error = error.abs();
        x = if halved && low < newton && newton < high { newton } else { 0.5 * (low + high) };
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_ends_where_the_condition_first_fails() {
        assert_eq!(end_of_field(|_| true), MAX_ANGLE);
        assert_eq!(end_of_field(|_| false) as f32, 0.0);
        assert!((end_of_field(|angle| angle < 0.3) - 0.3).abs() < 1e-15);
        assert!((end_of_field(|angle| !(0.4..0.5).contains(&angle)) - 0.4).abs() < 1e-15);
        assert!((end_of_field(|angle| angle < 1e-6) - 1e-6).abs() < 1e-15);
    }

    #[test]
    fn increasing_functions_are_inverted_to_rounding() {
        let cubic = |x: f64| (x + 100.0 * x.powi(3), 1.0 + 300.0 * x * x);
        let flat = |x: f64| (x - 0.33 * x.powi(3), 1.0 - 0.99 * x * x);
        let wavy = |x: f64| (x + 0.99 * x.sin(), 1.0 + 0.99 * x.cos());
        for k in 0..=1000 {
            let x = f64::from(k) / 1000.0;
            assert!((solve_increasing(cubic, cubic(x).0, 1.0) - x).abs() < 1e-14);
            assert!((solve_increasing(flat, flat(x).0, 1.0) - x).abs() < 1e-13);
            let x = 20.0 * x;
            // The slope falls to 0.01 and its own slope to zero there: rounding grows a hundredfold.
            assert!((solve_increasing(wavy, wavy(x).0, 20.0) - x).abs() < 1e-12);
        }
        assert!((solve_increasing(cubic, 1e-200, 1.0) / 1e-200 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn beyond_the_end_the_end_is_returned() {
        assert_eq!(solve_increasing(|x| (x, 1.0), 3.0, 1.0), 1.0);
        assert_eq!(solve_increasing(|x| (x, 1.0), 3.0, 0.0), 0.0);
    }
}
