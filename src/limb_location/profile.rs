//! What an image looks like across a limb: brightness outside and inside, blurred.
//!
//! Outside, the background is a constant. Inside, the brightness of a convex body is a smooth
//! function of the direction of its normal, and so of the angle θ between the sight line and the tangent
//! plane: 1 − cos θ = u / ρ at the distance u inside the limb of a cylinder of radius ρ pixels. Near the limb
//! sin θ grows as √u, which is why the strongest gradient is not at the limb. For a matt surface and any lights
//! that none of it turns away from, brightness is a + b sin θ + c (1 − cos θ). What is expected of it comes from the
//! inner part of the surface; the two functions correct it. Both sides are blurred by the same Gaussian.

use super::block::{INSIDE, OUTSIDE};
use super::refine::MOST_BLUR;
use super::shading::LimbShading;

/// Spacing of the tables in pixels.
const STEP: f64 = 0.1;

/// How far the Gaussian is followed, in units of its standard deviation.
const TAIL: f64 = 4.0;

/// Functions per profile: 1 outside; the expected brightness, sin θ and 1 − cos θ inside.
pub(super) const FUNCTIONS: usize = 4;

/// The functions of the profile for one blur and one radius, tabulated over u.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    first: f64,
    values: Vec<[f64; FUNCTIONS]>,
    slopes: Vec<[f64; FUNCTIONS]>,
    blur_slopes: Vec<[f64; FUNCTIONS]>,
}

/// The functions, their derivatives in u and in the blur, at one u.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProfileRow {
    pub values: [f64; FUNCTIONS],
    pub slopes: [f64; FUNCTIONS],
    pub blur_slopes: [f64; FUNCTIONS],
}

/// The functions of one limb without blur.
#[derive(Debug, Clone)]
pub(super) struct SharpProfile {
    /// Index of the first cell; cell k is about u = k · `STEP`.
    first: i32,
    cells: Vec<[f64; FUNCTIONS]>,
}

impl SharpProfile {
    /// For a radius of the cylinder in the image and what the limb is expected to look like; the window may be
    /// widened by `margin` pixels on both sides later.
    pub fn new(radius: f64, shading: &LimbShading, margin: f64) -> Self {
        let taps = (TAIL * MOST_BLUR / STEP).ceil() as i32;
        let (first, last) = window(margin);
        let cells = (first - taps..=last + taps).map(|k| sharp(k, radius, shading)).collect();
        Self { first: first - taps, cells }
    }

    /// Tables over the window widened by `margin` on both sides, for a blur (standard deviation in pixels).
    pub fn blurred(&self, blur: f64, margin: f64) -> Profile {
        let taps = (TAIL * blur / STEP).ceil() as i32;
        let (first_index, last_index) = window(margin);
        let sharp = &self.cells[(first_index - taps - self.first).max(0) as usize..];
        // g, g′ and ∂g/∂σ, each normalised by the sum of g so that constants stay constants.
        let kernel: Vec<[f64; 3]> = (-taps..=taps)
            .map(|k| {
                let x = f64::from(k) * STEP / blur;
                let g = (-x * x / 2.0).exp();
                [g, -x / blur * g, (x * x - 1.0) / blur * g]
            })
            .collect();
        let sum: f64 = kernel.iter().map(|k| k[0]).sum();
        let drift: f64 = kernel.iter().map(|k| k[2]).sum::<f64>() / sum;
        let kernel: Vec<[f64; 3]> =
            kernel.iter().map(|k| [k[0] / sum, k[1] / sum, (k[2] - drift * k[0]) / sum]).collect();
        let count = (last_index - first_index + 1) as usize;
        let mut tables = [(); 3].map(|()| vec![[0.0; FUNCTIONS]; count]);
        for index in 0..count {
            for (weights, values) in kernel.iter().rev().zip(&sharp[index..]) {
                for (table, weight) in tables.iter_mut().zip(weights) {
                    for (out, value) in table[index].iter_mut().zip(values) {
                        *out += weight * value;
                    }
                }
            }
        }
        let [values, slopes, blur_slopes] = tables;
        Profile { first: f64::from(first_index) * STEP, values, slopes, blur_slopes }
    }
}

/// First and last cell of the window.
fn window(margin: f64) -> (i32, i32) {
    (-((OUTSIDE + margin) / STEP).ceil() as i32 - 1, ((INSIDE + margin) / STEP).ceil() as i32 + 1)
}

impl Profile {
    /// The functions at u; `None` outside the tables.
    pub fn at(&self, u: f64) -> Option<ProfileRow> {
        let x = (u - self.first) / STEP;
        if !(x >= 0.0 && x < (self.values.len() - 1) as f64) {
            return None;
        }
        let k = x as usize;
        let part = x - k as f64;
        let mix = |table: &[[f64; FUNCTIONS]]| {
            let mut out = table[k];
            for (a, b) in out.iter_mut().zip(&table[k + 1]) {
                *a += part * (b - *a);
            }
            out
        };
        Some(ProfileRow {
            values: mix(&self.values),
            slopes: mix(&self.slopes),
            blur_slopes: mix(&self.blur_slopes),
        })
    }
}

/// The functions without blur, averaged over the cell of index k: θ has an infinite slope at the limb.
fn sharp(k: i32, radius: f64, shading: &LimbShading) -> [f64; FUNCTIONS] {
    let u = f64::from(k) * STEP;
    // The part of the cell on the inner side.
    let (low, high) = ((u - STEP / 2.0).max(0.0), (u + STEP / 2.0).max(0.0));
    let inner = (high - low) / STEP;
    let outer = 1.0 - inner;
    // sin θ = √(1 − (1 − w)²) with w = u / ρ has the integral ρ/2 (θ − sin θ cos θ).
    let integral = |u: f64| {
        let cos = 1.0 - (u / radius).min(1.0);
        let theta = cos.acos();
        radius / 2.0 * (theta - theta.sin() * cos)
    };
    let sine = (integral(high) - integral(low)) / STEP;
    let lean = f64::midpoint(low, high) / radius * inner;
    // Less their means over the window, so that the level inside is the mean brightness there.
    let mean_sine = integral(INSIDE) / INSIDE;
    let mean_lean = INSIDE / (2.0 * radius);
    // The expected brightness has an infinite slope there, too.
    let places = 8;
    let place = |j: usize| low + (high - low) * (j as f64 + 0.5) / places as f64;
    let expected = if inner > 0.0 {
        inner * (0..places).map(|j| shading.at(place(j) / radius)).sum::<f64>() / places as f64
    } else {
        0.0
    };
    [outer, expected, sine - mean_sine * inner, lean - mean_lean * inner]
}
