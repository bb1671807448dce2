//! From rough limb lines to lines within a few hundredths of a pixel: the profile model, fitted to short
//! blocks of both limbs at once.
//!
//! Each block has its own two levels of brightness, outside and inside (eliminated by variable projection);
//! each limb has its line and its shading relative to the level inside; the image has its blur. Gauss–Newton steps on
//! lines, shading and blur; in every step the blocks that disagree with the others about the line lose weight.

use super::block::{LimbState, ShadedSums, StripLine, Window, fit_blocks, shaded_sums, sums_of_blocks};
use super::gather::Near;
use super::limb::{AMBIGUOUS, BLUR, ELSEWHERE, LONGEST_STEP, Limb, SCAN_REACH};
use super::profile::{Kernel, MARGIN, ShadedProfile};
use crate::memory::List;
use nalgebra::{SMatrix, SVector, Vector2};
use smallvec::SmallVec;

constants! {
    /// Blur where the iteration starts, standard deviation in pixels: a lens in focus and the aperture of a pixel.
    FIRST_BLUR = 0.8, "px";

    /// More blur than this leaves no limb within the profile.
    pub(super) MOST_BLUR = 2.0, "px";

    /// Gauss–Newton steps at most; five to eight are usual.
    STEPS = 15.0, "";

    /// Steps after which a position of the limbs is dropped that is worse than the best so far by more than `AMBIGUOUS`, and from
    /// which on the same pixels are looked at while the lines hardly move.
    FIRST_STEPS = 4.0, "";

    /// The iteration ends when no line moves by more, in pixels.
    SETTLED = 1e-3, "px";

    /// The same where a limb is known from another image: a seventh of what its pixels do not show. No other position waits to
    /// be told apart.
    SETTLED_AGAIN = 1e-2, "px";

    /// Positions this close to each other are one, in pixels.
    SAME_POSITION = 0.1, "px";

    /// The standard deviation of the offset of a line that moves when less of its surroundings is looked at, in parts of
    /// what it moves: the windows show a part of what is wrong.
    LEFT_OUT = 1.4, "";

    /// The part that one position has of the weight of all from which on the limbs can be nowhere else.
    UNAMBIGUOUS = 0.99, "";
}

/// Blur cannot be less than that of the aperture of a pixel, 1/√12.
const LEAST_BLUR: f64 = 0.29;

/// One over the variance of a blur that the caller states: no image says otherwise.
const STATED_WEIGHT: f64 = 1e12;

/// One of something for each limb.
type Several<T> = SmallVec<[T; 2]>;

/// What is common to the limbs when they are refined.
pub(super) struct RefinedImage {
    /// The blur, which is the stated one where that is above 0.
    pub blur: f64,
    /// Whether the limbs can be nowhere else.
    pub unambiguous: bool,
}

/// Refines one or two limbs of a cylinder and the blur.
pub(super) fn refine(limbs: &mut [Limb<'_>], stated_blur: f64) -> RefinedImage {
    let blur = ExpectedBlur::new(stated_blur);
    let kernel = Kernel::new(blur.value, SCAN_REACH.get());
    let windows: Several<Near> =
        limbs.iter().map(|limb| Near::new(limb.strip, &limb.state.line, Window::full())).collect();
    let scans: List<List<LimbState>> =
        limbs.iter_mut().zip(&windows).map(|(limb, near)| limb.scan(&kernel, near)).collect();
    let mut starts: List<List<LimbState>> = List::from([List::new()]);
    for scan in &scans {
        let extended = |start: &List<LimbState>| {
            scan.iter().map(|state| start.iter().copied().chain([*state]).collect()).collect::<List<_>>()
        };
        starts = starts.iter().flat_map(extended).collect();
    }
    let several = starts.len() > 1;
    let mut modes: SmallVec<[Mode<'_>; 1]> = SmallVec::new();
    for start in &starts {
        for (limb, state) in limbs.iter_mut().zip(start) {
            limb.state = *state;
        }
        let Some((blur, path)) = follow(limbs, &blur, &windows, &modes) else { continue };
        let cost = if several { cost(limbs, blur, &windows) } else { 0.0 };
        modes.push(Mode { cost, limbs: limbs.iter().cloned().collect(), blur, path });
    }
    modes.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    modes[0].take_slopes(&blur);
    limbs.clone_from_slice(&modes[0].limbs);
    see_less(limbs, &blur, modes[0].blur);
    let weights: List<f64> = modes.iter().map(|mode| ((modes[0].cost - mode.cost) / 2.0).exp()).collect();
    let sum: f64 = weights.iter().sum();
    for (k, limb) in limbs.iter_mut().enumerate() {
        let line = |mode: &Mode<'_>| mode.limbs[k].state.line.vector();
        let lines = || modes.iter().map(line).zip(weights.iter().map(|weight| weight / sum));
        let mean = lines().fold(Vector2::zeros(), |mean, (line, weight)| mean + line * weight);
        for (line, weight) in lines() {
            limb.covariance += (line - mean) * (line - mean).transpose() * weight;
        }
        limb.state.line = StripLine { offset: mean[0], slope: mean[1] };
    }
    RefinedImage { blur: modes[0].blur, unambiguous: weights[0] > UNAMBIGUOUS.get() * sum }
}

/// Refines limbs that are about where they are expected, from the blur of another image of a sequence; returns the blur.
/// `None` where a line goes farther than `reach` from there. Where they are at `rest` the pixels about their lines there are
/// looked at from the first step on: no other position is near, and those that come and go with each step kept them from settling.
pub(super) fn refine_again(
    limbs: &mut [Limb<'_>],
    stated_blur: f64,
    last_blur: f64,
    reach: [f64; 2],
    rest: bool,
) -> Option<f64> {
    let settling = if rest { FIRST_STEPS.count() } else { 0 };
    let expected = ExpectedBlur::new(stated_blur);
    let mut blur = if stated_blur > 0.0 { expected.value } else { last_blur };
    let mut near = looked_at_by(limbs);
    for count in 1..=STEPS.count() {
        look_about(limbs, &mut near, settling + count);
        let moved = step(limbs, &near, &profiles(limbs, blur), &expected, &mut blur);
        if limbs.iter().zip(reach).any(|(limb, reach)| limb.is_beyond(reach)) {
            return None;
        }
        if moved < SETTLED_AGAIN.get() {
            break;
        }
    }
    see_less(limbs, &expected, blur);
    Some(blur)
}

/// Looks at less of the surroundings of the limbs. Where the profile is right the lines stay; where a shadow, a label or
/// another body comes in they move, by about as much as they are wrong. The difference of an efficient estimate and of one
/// from a part of the same data has the difference of their variances (Hausman, Econometrica 46, 1978).
fn see_less(limbs: &mut [Limb<'_>], expected: &ExpectedBlur, blur: f64) {
    let of_parts: List<[ShadedSums; 3]> = limbs
        .iter()
        .zip(&profiles(limbs, blur))
        .map(|(Limb { strip, state: LimbState { line, .. }, .. }, profile)| {
            Window::parts().map(|window| shaded_sums(profile, line, &Near::new(strip, line, window)))
        })
        .collect();
    for (outer, inner) in [(false, true), (true, false), (false, false)] {
        let mut near: SmallVec<[Limb<'_>; 2]> = limbs.iter().cloned().collect();
        for (limb, [background, about, surface]) in near.iter_mut().zip(&of_parts) {
            let mut sums = about.clone();
            for (_, part) in
                [(outer, background), (inner, surface)].into_iter().filter(|(looked_at, _)| *looked_at)
            {
                sums.add(part);
            }
            limb.blocks = fit_blocks(&sums, limb.noise, limb.background);
        }
        let mut blur = blur;
        solve(&mut near, expected, &mut blur);
        for (limb, near) in limbs.iter_mut().zip(&near) {
            let moved = near.state.line.offset - limb.state.line.offset;
            let variance = (near.covariance[(0, 0)] - limb.covariance[(0, 0)]).max(0.0);
            let more = moved * moved - variance;
            limb.misfit = limb.misfit.max(more * LEFT_OUT.get().powi(2));
        }
    }
}

/// What is known of the blur beforehand: the value in pixels and one over its variance.
struct ExpectedBlur {
    value: f64,
    weight: f64,
}

impl ExpectedBlur {
    /// The stated blur, or where it is 0 that of most images, to a pixel.
    fn new(stated: f64) -> Self {
        if stated > 0.0 {
            Self { value: stated.clamp(LEAST_BLUR, MOST_BLUR.get()), weight: STATED_WEIGHT }
        } else {
            Self { value: FIRST_BLUR.get(), weight: 1.0 }
        }
    }
}

/// One of several positions where the limbs may be.
struct Mode<'a> {
    cost: f64,
    limbs: SmallVec<[Limb<'a>; 2]>,
    blur: f64,
    /// The lines after each step that led there.
    path: List<List<StripLine>>,
}

impl Mode<'_> {
    /// Continues with slopes of the background where the scan found that they explain it better. They are for soft shadows, which
    /// move a line by tenths of a pixel: taken from the first step on they drew lines to edges inside the limb. If a line goes
    /// elsewhere, the result without slopes stays.
    fn take_slopes(&mut self, expected: &ExpectedBlur) {
        let (mut limbs, mut blur) = (self.limbs.clone(), self.blur);
        let mut sloped = false;
        for limb in &mut limbs {
            sloped |= limb.take_slopes();
        }
        if !sloped {
            return;
        }
        let mut near = looked_at_by(&limbs);
        for _ in 1..=STEPS.count() {
            look_about(&mut limbs, &mut near, FIRST_STEPS.count() + 1);
            let profiles = profiles(&limbs, blur);
            if step(&mut limbs, &near, &profiles, expected, &mut blur) < SETTLED.get() {
                break;
            }
        }
        let mut pairs = limbs.iter().zip(&self.limbs);
        if pairs.all(|(limb, before)| limb.is_along(&before.state.line, ELSEWHERE.get())) {
            (self.limbs, self.blur) = (limbs, blur);
        }
    }

    /// Whether limbs are there, or where the same steps led there from.
    fn leads_from(&self, limbs: &[Limb<'_>]) -> bool {
        let mut pairs = self.limbs.iter().zip(limbs);
        let along = |lines: &List<StripLine>| {
            let mut pairs = limbs.iter().zip(lines);
            pairs.all(|(limb, line)| limb.is_along(line, SAME_POSITION.get()))
        };
        pairs.all(|(a, b)| (a.state.line.offset - b.state.line.offset).abs() < SAME_POSITION.get())
            || self.path.iter().any(along)
    }
}

/// What speaks against the limbs by the pixels of some windows.
fn cost(limbs: &[Limb<'_>], blur: f64, windows: &[Near]) -> f64 {
    let kernel = Kernel::new(blur, SCAN_REACH.get());
    let cost = |(limb, window): (&Limb<'_>, &Near)| {
        let profile = limb.sharp.blurred(&kernel);
        let sums = sums_of_blocks(&profile, &limb.state.line, window);
        limb.cost(&sums)
    };
    limbs.iter().zip(windows).map(cost).sum()
}

/// Gauss–Newton steps from where the limbs are until they have settled; returns the blur, and the lines after each step.
/// `None` where they come to a position that is known, or that led to one, or to one that is far worse.
fn follow(
    limbs: &mut [Limb<'_>],
    expected: &ExpectedBlur,
    windows: &[Near],
    known: &[Mode<'_>],
) -> Option<(f64, List<List<StripLine>>)> {
    let mut blur = expected.value;
    let mut path = List::new();
    let mut near = looked_at_by(limbs);
    for count in 1..=STEPS.count() {
        look_about(limbs, &mut near, count);
        let moved = step(limbs, &near, &profiles(limbs, blur), expected, &mut blur);
        if known.iter().any(|mode| mode.leads_from(limbs)) {
            return None;
        }
        path.push(limbs.iter().map(|limb| limb.state.line).collect());
        if moved < SETTLED.get() {
            break;
        }
        if count == FIRST_STEPS.count() && !known.is_empty() {
            let least = known.iter().map(|mode| mode.cost).fold(f64::INFINITY, f64::min);
            if cost(limbs, blur, windows) > least + AMBIGUOUS.get() {
                return None;
            }
        }
    }
    Some((blur, path))
}

/// Looks at the pixels about the lines before a step. A pixel that enters or leaves moves a faint line by up to a tenth of a
/// pixel, and one that does so with every step lets it never settle. So the first steps look about where the lines are,
/// later ones at the same pixels until a line leaves them.
fn look_about(limbs: &mut [Limb<'_>], near: &mut [Near], count: usize) {
    for (limb, near) in limbs.iter_mut().zip(near) {
        if count <= FIRST_STEPS.count() || !limb.is_along(&limb.near, MARGIN) {
            limb.near = limb.state.line;
        }
        near.look(limb.strip, &limb.near);
    }
}

/// Room for the pixels that limbs look at, none yet.
fn looked_at_by(limbs: &[Limb<'_>]) -> Several<Near> {
    limbs.iter().map(|_| Near::default()).collect()
}

/// The profiles of limbs.
fn profiles(limbs: &[Limb<'_>], blur: f64) -> List<ShadedProfile> {
    let kernel = Kernel::new(blur, 0.0);
    limbs.iter().map(|limb| limb.sharp.shaded(&kernel, &limb.state.shading, limb.background)).collect()
}

/// A Gauss–Newton step on lines, shading and blur from where the limbs have these profiles; returns by how many pixels it
/// moved them, 0 where nothing is determined.
fn step(
    limbs: &mut [Limb<'_>],
    near: &[Near],
    profiles: &[ShadedProfile],
    expected: &ExpectedBlur,
    blur: &mut f64,
) -> f64 {
    for ((limb, near), profile) in limbs.iter_mut().zip(near).zip(profiles) {
        let sums = shaded_sums(profile, &limb.state.line, near);
        limb.blocks = fit_blocks(&sums, limb.noise, limb.background);
    }
    solve(limbs, expected, blur)
}

/// The step that the blocks of the limbs ask for.
fn solve(limbs: &mut [Limb<'_>], expected: &ExpectedBlur, blur: &mut f64) -> f64 {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    let mut right = SVector::<f64, 9>::zeros();
    // What is expected keeps the blur where no limb tells, and a missing limb harmless.
    normal[(BLUR, BLUR)] = expected.weight;
    right[BLUR] = expected.weight * (expected.value - *blur);
    for k in 4 * limbs.len()..BLUR {
        normal[(k, k)] = 1.0;
    }
    for (index, limb) in limbs.iter_mut().enumerate() {
        limb.weigh();
        limb.add_to(&mut normal, &mut right, 4 * index);
    }
    let Some(inverse) = normal.try_inverse() else { return 0.0 };
    let step = inverse * right;
    let mut moved: f64 = step[BLUR].abs();
    for (index, limb) in limbs.iter_mut().enumerate() {
        let covariance = inverse.fixed_view::<2, 2>(4 * index, 4 * index).into_owned();
        moved = moved.max(limb.take(&step.fixed_rows::<4>(4 * index).into_owned(), covariance));
    }
    *blur = (*blur + step[BLUR].clamp(-LONGEST_STEP.get(), LONGEST_STEP.get()))
        .clamp(LEAST_BLUR, MOST_BLUR.get());
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::limb_location::consensus::RoughLine;
    use crate::limb_location::limb::Expected;
    use crate::limb_location::shading::LimbShading;
    use crate::limb_location::strip::{Baseline, Grid, Strip};
    use crate::noise::NoiseModel;
    use crate::observations::{GreyImage, ImageView, ReducedImage};

    const SIZE: (usize, usize) = (80, 80);
    const LENGTH: f64 = 79.0;

    /// An upright limb at 40.3 before a background of brightness 100.
    struct Scene {
        contrast: f64,
        noise: f64,
        /// The part of the light that a shadow takes away beside the limb; it fades over ten pixels.
        shadow: f64,
    }

    /// A limb that the noise nearly hides.
    const FAINT: Scene = Scene { contrast: 12.0, noise: 6.0, shadow: 0.0 };

    impl Scene {
        fn image(&self, seed: u64) -> GreyImage {
            let mut state = seed;
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            let pixels = (0..SIZE.0 * SIZE.1).map(|k| {
                let u = (k % SIZE.0) as f64 - 40.3;
                let inside = 1.0 / (1.0 + (-2.0 * u).exp());
                let shadow = self.shadow * (1.0 + u.min(0.0) / 10.0).max(0.0) * (1.0 - inside);
                // Four uniform numbers are nearly Gaussian, with variance 1/3.
                let noise = ((0..4).map(|_| uniform()).sum::<f64>() - 2.0) * 3.0_f64.sqrt() * self.noise;
                (100.0 * (1.0 - shadow) + self.contrast * inside + noise).round() as u8
            });
            let bytes: Vec<u8> = pixels.collect();
            GreyImage::copy(&ImageView::from_u8(&bytes, SIZE).unwrap()).unwrap()
        }
    }

    /// Does something with so much of the limb of an image, from a rough line 0.3 pixels beside it.
    fn with_limb<R>(image: &GreyImage, noise: f64, length: f64, then: impl FnOnce(Limb<'_>) -> R) -> R {
        let intrinsics = Intrinsics {
            width: SIZE.0 as u32,
            height: SIZE.1 as u32,
            fx: 500.0,
            fy: 500.0,
            cx: 39.5,
            cy: 39.5,
            distortion: Distortion::None,
        };
        let camera = Camera::new(intrinsics).unwrap();
        let of_image = NoiseModel::default().in_image(SIZE);
        let grid =
            Grid { image: ReducedImage::new(image, 1), camera: &camera, noise: of_image, least_noise: 0.0 };
        let ideal =
            |x: f64, y: f64| camera.ideal_pixel(&camera.unproject(&Vector2::new(x, y)).unwrap()).unwrap();
        let baseline = Baseline::new(&[ideal(40.0, 0.0), ideal(40.0, length)], &ideal(60.0, 40.0)).unwrap();
        let strip = Strip::gather(&grid, &baseline, 10.0);
        let rough = RoughLine { ends: [0.0; 2], score: 0.0, visible: true };
        let half_length = baseline.half_length;
        let expected = Expected { rough, half_length, deviation: 1.5, noise };
        then(Limb::new(&strip, expected, &LimbShading::plain(0.3), 30.0))
    }

    /// How far the last step moves the limb, in pixels.
    fn last_step(limb: Limb<'_>) -> f64 {
        let mut limbs = [limb];
        let expected = ExpectedBlur::new(0.0);
        let (mut blur, mut moved) = (expected.value, f64::INFINITY);
        let mut near = looked_at_by(&limbs);
        for count in 1..=STEPS.count() {
            look_about(&mut limbs, &mut near, count);
            let profiles = profiles(&limbs, blur);
            moved = moved.min(step(&mut limbs, &near, &profiles, &expected, &mut blur));
        }
        moved
    }

    #[test]
    fn slopes_are_taken_where_the_scan_asked_for_them_and_nowhere_else() {
        let scanned = |shadow: f64, beside: f64| {
            let scene = Scene { contrast: 100.0, noise: 1.0, shadow };
            with_limb(&scene.image(1), scene.noise, LENGTH, |mut limb| {
                let near = Near::new(limb.strip, &limb.state.line, Window::full());
                limb.state = limb.scan(&Kernel::new(FIRST_BLUR.get(), SCAN_REACH.get()), &near)[0];
                limb.state.line.offset += beside;
                limb.take_slopes()
            })
        };
        assert!(scanned(0.1, 0.0));
        assert!(!scanned(0.1, 1.5));
        assert!(!scanned(0.0, 0.0));
    }

    #[test]
    fn a_line_that_ran_away_is_no_position_of_a_limb() {
        let scene = Scene { contrast: 100.0, noise: 1.0, shadow: 0.0 };
        let costs = with_limb(&scene.image(1), scene.noise, LENGTH, |mut limb| {
            let windows = [(); 2].map(|()| Near::new(limb.strip, &limb.state.line, Window::full()));
            limb.state = limb.scan(&Kernel::new(FIRST_BLUR.get(), SCAN_REACH.get()), &windows[0])[0];
            let [mut beside, mut away] = [limb.clone(), limb.clone()];
            beside.state.line.offset += 1.0;
            away.state.line.offset += 2.0 * SCAN_REACH.get();
            let pairs = [[&limb, &limb], [&limb, &away], [&beside, &away]];
            pairs.map(|pair| cost(&pair.map(Limb::clone), FIRST_BLUR.get(), &windows))
        });
        // Of the other limb it takes nothing.
        assert!(costs[0] < costs[1] && costs[1] < costs[2], "{costs:?}");
    }

    #[test]
    fn more_blocks_are_no_more_certain_of_a_position() {
        let scene = Scene { contrast: 20.0, noise: 3.0, shadow: 0.0 };
        let [short, long] = [0.5, 1.0].map(|part| {
            with_limb(&scene.image(1), scene.noise, part * LENGTH, |mut limb| {
                let windows = [Near::new(limb.strip, &limb.state.line, Window::full())];
                limb.state = limb.scan(&Kernel::new(FIRST_BLUR.get(), SCAN_REACH.get()), &windows[0])[0];
                let mut beside = limb.clone();
                beside.state.line.offset += 1.0;
                let [there, beside] = [limb, beside].map(|limb| cost(&[limb], FIRST_BLUR.get(), &windows));
                beside - there
            })
        });
        assert!(long > 1.0 && (0.8..1.25).contains(&(long / short)), "{short} and {long}");
    }

    #[test]
    fn faint_limbs_settle() {
        let settled = (0..20)
            .filter(|seed| with_limb(&FAINT.image(*seed), FAINT.noise, LENGTH, last_step) < SETTLED.get())
            .count();
        // With pixels that enter and leave at each step it was 8.
        assert!(settled >= 14, "{settled} of 20");
    }
}
