//! The probability that there is a cylinder, by the evidence.

use super::Evidence;

constants! {
    /// The radius of a cone must change by this part over what is seen of it to be told from a cylinder: cups taper by
    /// more, and depth next to outlines bends a short cylinder by nearly as much.
    TAPERED = 0.2, "";

    /// The sides of a cylinder tell as much as this many independent samples at most.
    MOST_SAMPLES = 8.0, "";

    /// The least slope of the side of a cup or a cone: 1.7 degrees.
    SLOPE = 0.03, "";

    /// Evidence that a slope of the side takes away: of the cylinders in rendered scenes one in ten seems to have a slope
    /// of 0.06 or more, of cones and other bodies that passed for one, three in four.
    SLANT = 50.0, "log odds";

    /// Slopes of less than this are none.
    LEAST_SLOPE = 0.02, "";

    /// The parts of both limbs together that edges cover where the limbs are known to be straight and parallel.
    BOTH_LIMBS = 1.2, "limb";

    /// A cone is a rarer body than a cylinder, and what depth does next to outlines looks like one: logarithm of the odds.
    CONE_PRIOR = 3.0, "log odds";

    /// Evidence where nothing lies beyond the limbs. It falls to zero where about three pixels do.
    OVERHANG = 10.0, "log odds";

    /// More evidence than this tells nothing more: what is left is what no model here knows.
    pub(super) MOST = 4.0, "log odds";

    /// Cylinders longer than this many radii are no more certain for it.
    LONG = 6.0, "radius";

    /// The standard deviation of the slopes of bodies that count as cylinders, and of what depth drifts along them: trunks and cast columns
    /// taper by a hundredth, which many points tell for certain.
    USUAL_SLOPE = 0.01, "";

    /// Standard deviations of a slope and slopes beyond these tell nothing more.
    MOST_DEVIATIONS = 6.0, "σ";
    STEEP = 0.3, "";

    /// The odds of a cylinder where its depth may as well be flat: of bodies with two straight parallel sides one in fifty is a bar
    /// or a board. The odds of the depth multiply these; whatever else is known of a body, a flat one shows it, too.
    ROUND = 50.0, "odds";

    /// From a standard deviation of the depth of a cell on that is this part of the radius, these odds are even: the front of a cylinder lies
    /// within one radius of depth, so that noise hides its shape, and straight sides may be chance. Rendered boards and pipes tell where.
    HIDDEN = 0.4, "radius";

    /// A fit is taken to multiply the odds of a cylinder by less than this. In those scenes it does so by up to 15 by depth alone and by
    /// up to 20 with an image in 99.8 of 100 candidates; with 17 nothing more is found in ../shared/scenes.
    MOST_BY_FIT = 13.0, "odds";

    /// The same where the depth shows both limbs, but edges cover less than [`ONE_LIMB`] of them together: in recorded scenes, where depth
    /// lies pixels beside the image, limbs may be located by the fit alone.
    MOST_BY_LIMBS = 40.0, "odds";

    /// The parts of both limbs together that edges of the image cover where they hold the radius: as much as one whole limb.
    pub(crate) ONE_LIMB = 1.0, "limb";

    /// The depth shows a limb where so much of it is visible.
    SHOWN = 0.5, "";

    /// Standard deviations of a radius, as a part of it, that count: better is luck, worse tells nothing more.
    LEAST_DEVIATION = 5e-4, "radius";
    MOST_DEVIATION = 0.3, "radius";

    /// One side in twenty of a cylinder, but three in five of an edge seem to go on smoothly: ln(0.95 / 0.4) for one that does not, and
    /// −ln(0.05 / 0.6) against one that does.
    AT_LIMB = 0.87, "log odds";
    BEYOND_LIMB = 2.48, "log odds";

    /// Likewise one cell in twenty is seen through, or one in three.
    ON_SURFACE = 0.35, "log odds";
    THROUGH = 2.2, "log odds";

    /// Evidence of each radius of what is covered across the axis beyond the least: less than half of the width tells little of a circle.
    ACROSS = 12.0, "log odds";
    LEAST_ACROSS = 0.8, "radius";

    /// Evidence that each pixel beyond the limbs takes away: fattening makes two pixels of them, an edge that is taken for a thin cylinder
    /// more.
    OF_OVERHANG = 3.0, "log odds/px";
}

/// A logarithm of odds beyond this tells nothing more: a bound that keeps what is infinite finite.
const MOST_LOG_ODDS: f64 = 1e4;

/// What [`Evidence::terms`] count in the logarithm of the odds, and what is added to that. After a fit: by logistic
/// regressions on the candidates in scenes of the twin, from the example `score_weights` before located limbs told the slope and [`USUAL_SLOPE`] counted. Before it, where the search takes
/// its choice by them: by regressions on ../shared/scenes as well, whose program is not kept.
struct Weights {
    terms: [f64; 12],
    constant: f64,
}

/// Depth alone, before a fit.
const DEPTH: Weights =
    Weights { terms: [0.61, 0.63, -3.8, 0.49, -0.82, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], constant: -0.23 };

/// Depth alone, after a fit.
const DEPTH_FITTED: Weights = Weights {
    terms: [-0.067, 0.512, -3.629, 0.295, -3.062, 0.0, -0.779, -1.584, -15.192, 0.095, 2.398, 0.099],
    constant: -0.608,
};

/// Depth and image, before a fit.
const IMAGE: Weights =
    Weights { terms: [0.74, 0.7, -4.53, 0.46, -0.87, 2.31, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], constant: -0.51 };

/// Depth and image, after a fit.
const IMAGE_FITTED: Weights = Weights {
    terms: [0.304, 0.472, -4.46, 0.4, -1.83, 1.144, -0.769, -0.824, -22.344, 0.03, 2.566, -0.542],
    constant: -1.05,
};

/// The least score before a fit that the fit may raise to a given one.
pub(crate) fn least_before_fit(score: f64, has_image: bool) -> f64 {
    with_odds_divided(score, if has_image { MOST_BY_LIMBS.get() } else { MOST_BY_FIT.get() })
}

/// The probability whose odds are those of a score divided by a number.
pub(crate) fn with_odds_divided(score: f64, by: f64) -> f64 {
    score / (score + (1.0 - score) * by)
}

impl Evidence {
    /// The probability that there is a cylinder.
    #[must_use]
    pub fn score(&self) -> f64 {
        let weights = match (self.limbs, self.radius_deviation) {
            (None, None) => DEPTH,
            (None, Some(_)) => DEPTH_FITTED,
            (Some(_), None) => IMAGE,
            (Some(_), Some(_)) => IMAGE_FITTED,
        };
        let sum: f64 = weights.terms.iter().zip(self.terms()).map(|(weight, term)| weight * term).sum();
        let sides = if self.scatter < HIDDEN.get() { ROUND.get().ln() } else { 0.0 };
        let round = sides + self.over_flat();
        1.0 / (1.0 + (-sum - weights.constant).exp() + (-round).exp())
    }

    /// The highest score that a fit may lead to: with edges along both limbs, and a radius as certain as counts.
    #[must_use]
    pub(crate) fn highest_after_fit(&self) -> f64 {
        Self { limbs: self.limbs.map(|_| [1.0; 2]), radius_deviation: Some(0.0), ..*self }.score()
    }

    /// Whether a fit may raise the score before it to a given one.
    pub(crate) fn may_reach(&self, score: f64) -> bool {
        let uncovered = self.limbs.is_some_and(|limbs| limbs.iter().sum::<f64>() < ONE_LIMB.get());
        let shown = self.visible.iter().all(|part| *part >= SHOWN.get());
        self.score() >= least_before_fit(score, uncovered && shown)
    }

    /// What the score is made of: the evidence of depth and shape, root mean square distance, length, what is seen
    /// through, edges on limbs, the logarithm of the standard deviation of the radius by a fit, the slope of the radius in
    /// standard deviations, its own and that of usual bodies together, and as it is, the evidence against a sphere, the part of a side that is visible, the logarithm
    /// of the radius in pixels. What is not known is 0.
    #[must_use]
    pub fn terms(&self) -> [f64; 12] {
        let [least, most] = [LEAST_DEVIATION.get(), MOST_DEVIATION.get()];
        let [slope, uncertainty] = self.slope.unwrap_or([0.0, f64::INFINITY]).map(f64::abs);
        let sphere = self.over_sphere.clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
        [
            self.depth(),
            self.shape(),
            self.rms,
            self.length.min(LONG.get()),
            self.seen_through * self.side_samples.min(MOST_SAMPLES.get()),
            self.limbs.map_or(0.0, |[a, b]| a + b),
            self.radius_deviation.map_or(0.0, |deviation| deviation.clamp(least, most).ln()),
            (slope / uncertainty.hypot(USUAL_SLOPE.get())).min(MOST_DEVIATIONS.get()),
            slope.min(STEEP.get()),
            sphere.signum() * sphere.abs().ln_1p(),
            self.visible[0].max(self.visible[1]),
            self.radius_pixels.max(1.0).ln(),
        ]
    }

    /// The evidence of the depth that something is round: the logarithm of the odds against nothing, a plane, and two
    /// planes that meet, whichever is least.
    fn depth(&self) -> f64 {
        self.gain.min(self.over_flat()).clamp(-MOST.get(), MOST.get())
    }

    /// The logarithm of the odds against a plane and two planes that meet.
    fn over_flat(&self) -> f64 {
        self.over_plane.min(self.over_edge)
    }

    /// The evidence that it is no sphere, no cone, and nothing that goes on beyond its sides, likewise. Straight limbs
    /// in an image say the same.
    pub(super) fn shape(&self) -> f64 {
        // Along a contact with another body, or a long straight side, neighbouring lines end in the same way.
        let samples = self.side_samples.min(MOST_SAMPLES.get());
        let sides = samples * (AT_LIMB.get() * (1.0 - self.open_sides) - BEYOND_LIMB.get() * self.open_sides);
        let through = self.side_samples
            * (ON_SURFACE.get() * (1.0 - self.seen_through) - THROUGH.get() * self.seen_through);
        // Depth that drifts over a long pipe tapers it as well, but not by a degree or two.
        let tapers = self.taper.abs() > TAPERED.get() && self.taper.abs() > SLOPE.get() * self.length;
        let cone = if tapers { self.over_cone + CONE_PRIOR.get() } else { f64::INFINITY };
        // Depth next to outlines tapers a short cylinder too, but rarely by as much as a cup.
        let slope = self.taper.abs() / self.length.max(f64::MIN_POSITIVE);
        // Edges along both limbs of a cylinder are along none of a cone.
        let straight = self.limbs.is_some_and(|[a, b]| a + b > BOTH_LIMBS.get());
        let slant =
            if straight { MOST.get() } else { MOST.get() - SLANT.get() * (slope - LEAST_SLOPE.get()) };
        // From inside the whole wall may be seen.
        let covered = ACROSS.get() * (self.across[1] - self.across[0] - LEAST_ACROSS.get());
        let overhang = OVERHANG.get() - OF_OVERHANG.get() * self.overhang;
        [covered, overhang, self.over_sphere, cone, slant, sides, through]
            .into_iter()
            .fold(f64::INFINITY, f64::min)
            .clamp(-MOST.get(), MOST.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A good cylinder, as far as the depth tells.
    fn good() -> Evidence {
        let odds = 100.0;
        Evidence {
            gain: odds,
            over_plane: odds,
            over_edge: odds,
            over_sphere: odds,
            over_cone: odds,
            side_samples: 20.0,
            across: [-1.0, 1.0],
            length: 4.0,
            rms: 1.0,
            visible: [1.0; 2],
            slope: Some([0.0, 0.01]),
            radius_pixels: 30.0,
            ..Evidence::default()
        }
    }

    #[test]
    fn what_speaks_against_a_cylinder_lowers_every_score() {
        let stages = [(None, None), (None, Some(0.01)), (Some([1.0; 2]), None), (Some([1.0; 2]), Some(0.01))];
        for (limbs, radius_deviation) in stages {
            let good = Evidence { limbs, radius_deviation, ..good() };
            assert!(good.score() > 0.9, "{}", good.score());
            let worse = [
                Evidence { open_sides: 1.0, ..good },
                Evidence { rms: 2.0, ..good },
                Evidence { length: 0.5, ..good },
                Evidence { seen_through: 0.5, ..good },
            ];
            assert!(worse.iter().all(|worse| worse.score() < good.score()));
        }
    }

    #[test]
    fn what_the_depth_shows_flat_is_no_cylinder_whatever_the_image_shows() {
        let board = Evidence { limbs: Some([1.0; 2]), radius_deviation: Some(1e-3), length: 40.0, ..good() };
        assert!(board.score() > 0.99, "{}", board.score());
        for flat in [Evidence { over_plane: -9.0, ..board }, Evidence { over_edge: -9.0, ..board }] {
            assert!(flat.score() < 0.01, "{}", flat.score());
        }
        // The depth tells nothing.
        let told_nothing = Evidence { over_plane: 0.0, ..board };
        assert!((0.9..0.98).contains(&told_nothing.score()), "{}", told_nothing.score());
        // Nor could it, for noise; but where it tells all the same it is believed.
        let hidden = Evidence { scatter: 0.5, ..told_nothing };
        assert!((0.4..=0.5).contains(&hidden.score()), "{}", hidden.score());
        let seen = Evidence { scatter: 0.5, ..board };
        assert_eq!(seen.score(), board.score());
    }

    #[test]
    fn a_trunk_tapers_and_is_a_cylinder() {
        let fitted =
            |slope| Evidence { radius_deviation: Some(0.01), slope: Some([slope, 0.001]), ..good() }.score();
        let [straight, trunk, cup] = [0.0, 0.01, 0.08].map(fitted);
        assert!(trunk > 0.9 && straight > trunk && cup < 0.1, "{straight} {trunk} {cup}");
    }

    #[test]
    fn no_fit_leads_to_more_than_the_highest_score() {
        let bodies = [good(), Evidence { taper: 0.5, over_cone: -2.0, seen_through: 0.3, ..good() }];
        for seen in bodies {
            assert!(seen.highest_after_fit() < 1.0);
            for limbs in [[0.0; 2], [0.9, 0.2], [0.5, 0.8], [1.0; 2]] {
                for radius_deviation in [1e-3, 0.1, f64::INFINITY].map(Some) {
                    let by_depth = Evidence { radius_deviation, ..seen };
                    assert!(by_depth.score() <= seen.highest_after_fit());
                    let with_image = Evidence { limbs: Some(limbs), ..by_depth };
                    let before = Evidence { limbs: Some([0.0; 2]), ..seen };
                    assert!(with_image.score() <= before.highest_after_fit());
                }
            }
        }
    }

    #[test]
    fn a_slope_of_the_radius_counts_after_a_fit_with_and_without_an_image() {
        for limbs in [None, Some([1.0; 2])] {
            let of = |slope, radius_deviation| {
                Evidence { limbs, radius_deviation, slope: Some([slope, 0.01]), ..good() }.score()
            };
            let sloped = of(0.1, Some(0.01));
            assert!(sloped < of(0.0, Some(0.01)), "{sloped}");
            assert_eq!(sloped.to_bits(), of(-0.1, Some(0.01)).to_bits());
        }
    }
}
