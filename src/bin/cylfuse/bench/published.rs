//! What the paper states in numbers (Zhang, Liu, Wang, Sensors 2026, 26(5), 1687). Its figures state more, but only as
//! pictures.

/// Where a figure of the paper has values that neither its text nor a table states.
pub const PICTURE_ONLY: &str = "only as a picture";

/// Section 5.3 on Figure 6: the weights that improve all configurations, and the one that is taken.
pub const GOOD_WEIGHTS: [f64; 2] = [0.5, 0.8];
/// See [`GOOD_WEIGHTS`].
pub const WEIGHT: f64 = 0.6;

/// Section 5.4.2 on Figure 8: what is said of each configuration of [`STARTS`].
pub const STARTS_SAID: [&str; 4] = [
    "robust, stable convergence",
    "robust, stable convergence",
    "robust, stable convergence",
    "the performance degrades",
];

/// Section 5.5: the mean errors of its method stay below these in all 24 configurations: E_o (degrees), E_p (mm), E_r (%),
/// E_l (%).
pub const MAXIMA: [f64; 4] = [0.77, 2.74, 0.24, 1.76];

/// Section 5.4: mean errors of its method with endpoints disturbed by up to 2 pixels (below these), and by 4 pixels.
pub const ENDPOINTS: [(u32, [f64; 4]); 2] = [(2, [1.96, 3.38, 6.00, 5.00]), (4, [3.20, 5.77, 12.02, 7.89])];

/// Table 1: standard deviations of direction (degrees), centre (mm) and radius (%) of a disturbed start.
pub const STARTS: [(&str, [f64; 3]); 4] = [
    ("low", [3.0, 3.0, 5.0]),
    ("medium", [5.0, 5.0, 10.0]),
    ("medium", [8.0, 8.0, 15.0]),
    ("high", [10.0, 15.0, 20.0]),
];

/// Table 2: mean and standard deviation of the seconds of a fit: RANSAC and Eberly on an Intel i5-12400F, points alone
/// and the paper's method on an NVIDIA RTX 3060 Ti beside it.
pub const SECONDS: [(&str, f64, f64); 4] = [
    ("RANSAC (CPU)", 0.017, 0.010),
    ("Eberly (CPU)", 7.904, 2.715),
    ("points alone (GPU)", 0.565, 0.037),
    ("the paper's method (GPU)", 0.805, 0.109),
];

/// Section 5.1: radii (mm) and tilts (degrees) of its configurations, all but the smallest radius at the largest tilt.
pub const RADII: [u32; 5] = [20, 30, 40, 50, 60];
/// See [`RADII`].
pub const TILTS: [u32; 5] = [0, 10, 20, 30, 40];

/// The 24 configurations.
pub fn configurations() -> Vec<(u32, u32)> {
    let all = TILTS.iter().flat_map(|tilt| RADII.iter().map(move |radius| (*radius, *tilt)));
    all.filter(|configuration| *configuration != (20, 40)).collect()
}

/// Section 5.3: the six configurations of its validation subset.
pub fn validation() -> Vec<(u32, u32)> {
    [0, 30].iter().flat_map(|tilt| [20, 30, 60].iter().map(move |radius| (*radius, *tilt))).collect()
}
