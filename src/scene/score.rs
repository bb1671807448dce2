//! What the image adds to the probability that there is a cylinder.

/// What no, one and two located limbs add to the logarithm of the odds: where the image shows both limbs where depth sees a
/// cylinder there hardly is anything else; boxes and scraps show none. A logistic on half of the test scenes gave these.
const LIMBS: [f64; 3] = [-0.6, 2.2, 4.0];

/// The score of a detection with so many located limbs.
pub(super) fn with_limbs(score: f64, located: usize) -> f64 {
    logistic(logit(score) + LIMBS[located.min(2)])
}

/// The least score of a detection that the image can raise to a given one.
pub(super) fn least_before_limbs(score: f64) -> f64 {
    logistic(logit(score) - LIMBS[2])
}

fn logit(probability: f64) -> f64 {
    let probability = probability.clamp(1e-12, 1.0 - 1e-12);
    (probability / (1.0 - probability)).ln()
}

fn logistic(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}
