//! The ends in the grey image: the arc of the end circle that bounds the visible surface.
//!
//! Along a generator the surface has one brightness, as far as it is plain, and something else begins at the end:
//! the background, or the cap where it faces the camera. So the profile along every generator is a blurred step,
//! and all steps lie on one end circle: the position of that circle is the only unknown they share. Brightness on
//! both sides, and with it the polarity, is free on every generator; background texture meets few of them in the
//! same position. Where the cap is seen at a flat angle its far rim lies within a few pixels of the near one: the
//! profile has two steps then, with the brightness of the cap between them. So it has where an open end shows the edge of its
//! wall, a ring that is wider or narrower than the blur. The far rim, where cap or inner wall are seen, is one more arc of the same
//! circle, with the same behind it on the way inward.

mod profile;
mod samples;
mod windows;

use super::LastArc;
use super::silhouette::{RoughEnd, contains};
use super::surface::{Generator, Surface};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{Mask, ReducedImage, from_reduced};
use crate::residuals::Rim;
use crate::statistics::{DEVIATION_OF_MEDIAN, independent_part, median, median_absolute};
use nalgebra::Vector2;
use profile::{Profile, Steps, Template, WALLS, gain};
use samples::{Room, Sampled};
use std::borrow::Cow;
use std::f64::consts::PI;

constants! {
    /// How far about the rough end the arc is searched, in standard deviations of the rough end.
    SEARCH_DEVIATIONS = 5.0, "σ";

    /// The same about where the arc was in the last image of a sequence, in pixels: beyond that it has moved.
    LAST_PIXELS = 1.6, "px";

    /// Half the window that a step is judged in, in pixels across the arc: several times the blur of an image.
    WINDOW_PIXELS = 5.0, "px";

    /// Distance of the samples of a profile, in pixels across the arc.
    SAMPLE_PIXELS = 0.5, "px";

    /// Steps of the search, in pixels: less than the blur of any image.
    COARSE_PIXELS = 0.4, "px";

    /// The most generators that are sampled; fewer when they would be less than a pixel apart.
    GENERATORS = 48.0, "";

    /// The fewest that make an arc.
    LEAST_GENERATORS = 5.0, "";

    /// The distance in pixels that generators keep from the limbs, where the background shines in.
    LIMB_MARGIN_PIXELS = 2.5, "px";

    /// A generator that the arc meets at a sine below this is nearly along it: its profile says little.
    LEAST_SINE = 0.35, "";

    /// The mean gain in log-likelihood per generator from which on an arc is believed.
    LEAST_GAIN = 2.0, "";

    /// By how much the edge of a wall must explain a generator better than none, in log-likelihood: docs/measurements-ends.md.
    WALL_GAIN = 6.0, "";

    /// What a template leaves out, as a part of the contrast: no wall is made of that.
    MODEL_CONTRAST = 0.02, "contrast";

    /// How far from the common arc the step of one generator is looked for, in pixels: an arc seen with a wrong tilt of
    /// the axis by some degrees departs by so much.
    SAMPLE_REACH_PIXELS = 2.5, "px";

    /// The far rim of the cap shines so many blurs into a window before it.
    RIM_BLURS = 2.0, "σ";

    /// The error of an arc in standard errors of its samples: they err together over longer stretches than the correlation
    /// of neighbours shows (docs/measurements-ends.md).
    SAMPLES_ERROR = 2.0, "σ";

    /// Standard deviation in pixels of what the model of the profile leaves out: of an end, and of a sample of its own.
    MODEL_DEVIATION = 0.1, "px";
    SAMPLE_DEVIATION = 0.05, "px";

    /// Samples of a window that are independent, by pixel: neighbours share pixels.
    INDEPENDENT = 1.0, "1/px";

    /// Standard deviation of an end beyond which all is cut off at white, in blurs: docs/measurements-ends.md.
    CUT_OFF_DEVIATION = 1.0, "σ";
}

/// Width of the edge of a wall that is tried, in pixels in the middle of the arc.
const WALL_PIXELS: [f64; WALLS] = [1.0, 1.7, 3.0];

/// Blur of the image that is tried, standard deviation in pixels. The first is for the search.
const BLURS: [f64; 7] = [1.0, 0.5, 0.7, 1.4, 1.9, 2.5, 0.35];

/// An end as the image shows it.
#[derive(Debug, Clone)]
pub(super) struct ArcEnd {
    pub position: f64,
    /// Standard deviation by what the image shows.
    pub deviation: f64,
    /// Standard deviation of what the model of the profile leaves out.
    pub model: f64,
    /// Samples on the near rim and on the far one.
    pub samples: [List<ArcSample>; 2],
    pub blur: f64,
}

/// A point of the image at which the surface ends on one generator of the model, located on its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcSample {
    /// Where, in pixels of the (distorted) image.
    pub pixel: Vector2<f64>,
    /// The direction across the arc, away from the surface: a unit vector.
    pub normal: Vector2<f64>,
    /// Standard deviation along `normal`, in pixels.
    pub deviation: f64,
    /// How fast the arc moves across itself when the end moves along the axis, in pixels by length.
    pub across: f64,
}

/// The step of one generator alone.
struct LocatedStep {
    /// The angle of the generator about the axis.
    angle: f64,
    /// How fast the arc moves across itself there when the end moves along the axis, in pixels by length; negative on the far rim.
    across: f64,
    /// How far it is outward of the rough end, in pixels across the arc.
    edge: f64,
    /// Its standard deviation, likewise.
    deviation: f64,
}

/// Where arcs are searched.
pub(super) struct ArcSearch<'a> {
    /// The grey image, on a grid that its blur fills.
    pub image: ReducedImage<'a>,
    /// The surface on that grid. All lengths in pixels here are in its pixels.
    pub surface: Surface<'a>,
    /// The mask of the body, on its own grid.
    pub mask: &'a Mask,
    /// What is known of mask and image, in pixels of the image.
    pub noise: ImageNoise,
}

impl ArcSearch<'_> {
    /// Searches the arc about a rough end; first where it was in the last image of a sequence, if that is not farther off
    /// than the search reaches. Where the cap or the inner wall is seen `inside` an end, the far rim tells where it is as well.
    pub fn locate(
        &self,
        rough: &RoughEnd,
        outward: f64,
        inside: &Sees<'_>,
        last: Option<LastArc>,
    ) -> Option<ArcEnd> {
        let factor = self.image.factor();
        let reduced = RoughEnd { pixel: rough.pixel * factor as f64, ..*rough };
        let search = SEARCH_DEVIATIONS.get() * rough.deviation;
        let known = last.filter(|last| (last.position - rough.position).abs() <= search);
        let near = known.and_then(|last| {
            let rough = RoughEnd { position: last.position, ..reduced };
            let blur = last.blur / factor as f64;
            locate(self, &rough, outward, inside, LAST_PIXELS.get() * rough.pixel, Some(blur))
        });
        let mut end = near.or_else(|| locate(self, &reduced, outward, inside, search, None))?;
        end.blur *= factor as f64;
        for sample in end.samples.iter_mut().flatten() {
            sample.pixel = sample.pixel.map(|x| from_reduced(x, factor));
            sample.deviation *= factor as f64;
            sample.across *= factor as f64;
        }
        Some(end)
    }
}

/// Whether something is seen at a pixel of the grid of the mask.
pub(super) type Sees<'a> = dyn Fn(&Vector2<f64>) -> bool + 'a;

/// The arc within `search` of a rough end. `blur` is that of the image, where it is known.
fn locate(
    arcs: &ArcSearch<'_>,
    rough: &RoughEnd,
    outward: f64,
    inside: &Sees<'_>,
    search: f64,
    blur: Option<f64>,
) -> Option<ArcEnd> {
    let surface = &arcs.surface;
    let profiles = sample(arcs, rough, outward, inside, search);
    if profiles.len() < LEAST_GENERATORS.count() {
        return None;
    }
    let noise = if arcs.noise.value > 0.0 { arcs.noise.value } else { noise(&profiles) };
    let tried = Steps::tried();
    let told = if arcs.noise.blur > 0.0 { Some(arcs.noise.blur) } else { blur };
    let told = told.map(|blur| match tried.iter().find(|steps| (steps.blur - blur).abs() < 1e-9) {
        Some(steps) => Cow::Borrowed(steps),
        None => Cow::Owned(Steps::new(blur)),
    });
    let (coarse, template) = coarse_position(&profiles, rough, search, noise, &tried[..], told.as_deref())?;
    let score = |shift: f64| gain(&profiles, shift, template, noise);
    let side = 0.25 * COARSE_PIXELS.get() * rough.pixel;
    let fine = (-3..=3).map(|k| coarse + 2.0 * side * f64::from(k)).map(|shift| (shift, score(shift)));
    let (mut shift, mut value) = fine.max_by(|a, b| a.1.total_cmp(&b.1))?;
    // A parabola through three scores, twice; its curvature is one over the variance.
    let mut variance = 0.0;
    for _ in 0..2 {
        let (before, after) = (score(shift - side), score(shift + side));
        let curvature = (before - 2.0 * value + after) / (side * side);
        if !(curvature < 0.0) {
            return None;
        }
        variance = -1.0 / curvature;
        shift += (0.5 * (after - before) / side * variance).clamp(-side, side);
        value = score(shift);
    }
    let mean = value / by_rim(&profiles);
    if !(mean >= LEAST_GAIN.get()) {
        return None;
    }
    // A step that is cut off at white seems to lie inside, and an arc of such steps seems narrower than it is.
    let whole = || profiles.iter().filter(|profile| !profile.is_cut_off(shift * profile.across));
    let share = 1.0 - whole().count() as f64 / profiles.len() as f64;
    let cut_off = CUT_OFF_DEVIATION.get() * share * template.steps.blur * rough.pixel;
    let steps: List<LocatedStep> = whole()
        .filter_map(|profile| {
            let (edge, deviation) = profile.step(shift * profile.across, template, noise)?;
            let &Profile { angle, across, .. } = profile;
            Some(LocatedStep { angle, across, edge, deviation })
        })
        .collect();
    let reach = SAMPLE_REACH_PIXELS.get() * rough.pixel;
    let error = SAMPLES_ERROR.get() * standard_error(&steps, shift).unwrap_or(reach);
    let sample = |step: &LocatedStep| {
        let generator = surface.generator(step.angle);
        let at = |edge: f64| generator.pixel(rough.position + outward * edge / step.across);
        let tangent = generator.pixel_beside(rough.position)? - generator.pixel(rough.position)?;
        let normal = Vector2::new(-tangent.y, tangent.x).normalize();
        let (pixel, ahead) = (at(step.edge)?, at(step.edge + 1.0)?);
        // Across the far rim steps are taken inward.
        let outward = (ahead - pixel) * step.across.signum();
        let normal = if normal.dot(&outward) < 0.0 { -normal } else { normal };
        let deviation = step.deviation.hypot(SAMPLE_DEVIATION.get());
        Some(ArcSample { pixel, normal, deviation, across: step.across.abs() })
    };
    let on =
        |near: bool| steps.iter().filter(|step| near == (step.across > 0.0)).filter_map(sample).collect();
    Some(ArcEnd {
        position: rough.position + outward * shift,
        deviation: (variance + cut_off * cut_off + error * error).sqrt(),
        model: MODEL_DEVIATION.get() * rough.pixel,
        samples: [on(true), on(false)],
        blur: template.steps.blur,
    })
}

/// How many generators make one answer of where the end is: each rim gives one.
fn by_rim(profiles: &[Profile]) -> f64 {
    let near = profiles.iter().filter(|profile| profile.across > 0.0).count();
    near.max(profiles.len() - near) as f64
}

/// The standard error of the common position of steps by how much they scatter about it, of which neighbours err alike: a shadow, a
/// label or a lid moves many of them. `None` for none.
fn standard_error(steps: &[LocatedStep], shift: f64) -> Option<f64> {
    let apart: List<f64> = steps.iter().map(|step| step.edge / step.across - shift).collect();
    let independent = (independent_part(&apart) * apart.len() as f64).max(1.0);
    let scatter = DEVIATION_OF_MEDIAN * median_absolute(apart.iter().copied());
    (!steps.is_empty()).then(|| scatter / independent.sqrt())
}

/// The arc by which the image, together with the rough end, is explained best: by how much it lies outward of that, and
/// how it looks. Rims, seams and labels make arcs too. Which of the arcs is the end is one question, not one for every
/// generator: the mean gain answers it together with the rough end.
fn coarse_position<'a>(
    profiles: &[Profile],
    rough: &RoughEnd,
    search: f64,
    noise: f64,
    tried: &'a [Steps],
    told: Option<&'a Steps>,
) -> Option<(f64, Template<'a>)> {
    let count = by_rim(profiles);
    let step = COARSE_PIXELS.get() * rough.pixel;
    let steps = (search / step).ceil() as i64;
    let score =
        |shift: f64, template: Template<'_>, noise: f64| gain(profiles, shift, template, noise) / count;
    let price = |shift: f64| 0.5 * (shift / rough.deviation).powi(2);
    let best = |wall: Option<usize>, noise: f64| {
        let look = |steps: &'a Steps| Template { steps, wall };
        let shift = |k: usize| step * (k as i64 - steps) as f64;
        let scores: List<f64> =
            (0..=2 * steps as usize).map(|k| score(shift(k), look(&tried[0]), noise)).collect();
        let evidence = |k: usize| scores[k] - price(shift(k));
        let peak = (1..scores.len() - 1)
            .filter(|&k| scores[k] >= scores[k - 1] && scores[k] >= scores[k + 1])
            .max_by(|a, b| evidence(*a).total_cmp(&evidence(*b)))?;
        // The position hardly depends on the blur, so one after the other.
        let steps = match told {
            Some(told) => told,
            None => {
                let others = tried[1..].iter().map(|steps| (steps, score(shift(peak), look(steps), noise)));
                let all = std::iter::once((&tried[0], scores[peak])).chain(others);
                all.max_by(|a, b| a.1.total_cmp(&b.1))?.0
            }
        };
        Some((shift(peak), look(steps)))
    };
    let plain = best(None, noise)?;
    if !profiles.iter().any(|profile| profile.cap.is_finite()) {
        return Some(plain);
    }
    // A step that explains what is there, as it mostly does, leaves a wall nothing to gain.
    let noise = noise.max(MODEL_CONTRAST.get() * contrast(profiles));
    let (shift, template) = plain;
    let unexplained =
        profiles.iter().map(|profile| profile.unexplained(shift * profile.across, template, noise));
    if unexplained.sum::<f64>() <= WALL_GAIN.get() * count {
        return Some(plain);
    }
    let with_evidence = |(shift, template)| (score(shift, template, noise) - price(shift), (shift, template));
    let (least, _) = with_evidence(plain);
    let walls = (0..WALLS).filter_map(|wall| best(Some(wall), noise)).map(with_evidence);
    let found = walls.filter(|wall| wall.0 > least + WALL_GAIN.get()).max_by(|a, b| a.0.total_cmp(&b.0));
    Some(found.map_or(plain, |found| found.1))
}

/// Samples the image along the generators: outward across the near rim, and, where a cap or an inner wall is seen,
/// inward across the far rim, behind which the same follows in the same order: the edge of a wall, the cap, the other rim.
fn sample(
    arcs: &ArcSearch<'_>,
    rough: &RoughEnd,
    outward: f64,
    inside: &Sees<'_>,
    search: f64,
) -> List<Profile> {
    let surface = &arcs.surface;
    let Some(half_width) = surface.half_width(rough.position) else { return List::new() };
    let part = 1.0 - LIMB_MARGIN_PIXELS.get() / half_width;
    if !(part > 0.0) {
        return List::new();
    }
    let count = GENERATORS.count().min((2.0 * part * half_width) as usize);
    let inner = WALL_PIXELS.map(|width| inner_circle(surface, rough, outward, width));
    let mut profiles = List::with_capacity(2 * count);
    let mut room = Room::default();
    let mut sample = |angle: f64, rim: Rim, sees: &Sees<'_>| {
        let generator = surface.generator(angle);
        let crossing = generator.crossing(rough.position)?;
        if crossing.across < LEAST_SINE.get() * crossing.along {
            return None;
        }
        let width =
            |circle: f64| cap_width(&generator, rough.position, outward, circle, rim) * crossing.across;
        let cap = width(1.0);
        let (margin, sign) = match rim {
            Rim::Near => (WINDOW_PIXELS.get(), 1.0),
            Rim::Far => (WINDOW_PIXELS.get().min(0.5 * cap), -1.0),
        };
        let before = generator.pixel(rough.position - outward * margin / crossing.across)?;
        // Where what the rim bounds is covered there is no end to be seen.
        if !sees(&before.map(|x| from_reduced(x, arcs.image.factor()))) {
            return None;
        }
        let reach = ((search * crossing.across + WINDOW_PIXELS.get()) / SAMPLE_PIXELS.get()).ceil() as i32;
        let sampled = Sampled {
            image: &arcs.image,
            generator: &generator,
            position: rough.position,
            outward: sign * outward,
            across: crossing.across,
            reach,
        };
        let (samples, cut_off) = sampled.take(&mut room)?;
        let walls = inner.map(|circle| if circle < 1.0 { width(circle).min(cap) } else { cap });
        let profile = Profile::new(angle, sign * crossing.across, cap, walls, samples, f64::from(reach));
        Some(profile.with_cut_off(cut_off))
    };
    let angles = || surface.generators(count, part);
    let body = |pixel: &Vector2<f64>| contains(arcs.mask, pixel);
    profiles.extend(angles().filter_map(|angle| sample(angle, Rim::Near, &body)));
    if surface.cylinder.end_faces_origin(rough.position, outward) {
        profiles.extend(angles().filter_map(|angle| sample(PI - angle, Rim::Far, inside)));
    }
    profiles
}

/// The length along the axis by which the generator at an angle must be continued across a rim until its position on
/// the cap leaves (`circle` 1) or enters (below 1) a circle about the axis, of this part of the radius; infinite where
/// the cap is not seen or it never does.
fn cap_width(generator: &Generator<'_>, position: f64, outward: f64, circle: f64, rim: Rim) -> f64 {
    let surface = &generator.surface;
    if !surface.cylinder.end_faces_origin(position, outward) {
        return f64::INFINITY;
    }
    let direction = surface.cylinder.axis.direction;
    let point = generator.point(position);
    let height = point.dot(&direction);
    // The ray of the continued generator meets the plane of the cap at λ times its position a across the axis, beyond the near
    // rim with λ above, beyond the far one below 1. On the circle about c is |λ a − c| = R: with λ = 1 on that of the
    // surface, and, by Vieta, with the other.
    let across = point - direction * height;
    let center = surface.frame.toward * surface.frame.distance;
    let radius = circle * surface.cylinder.radius;
    let (a, b) = (across.norm_squared(), across.dot(&center));
    let c = center.norm_squared() - radius * radius;
    let root = (b * b - a * c).sqrt();
    let other = match rim {
        _ if circle >= 1.0 => c / a,
        Rim::Near => (b - root) / a,
        Rim::Far => (b + root) / a,
    };
    let crosses = match rim {
        Rim::Near => other > 1.0,
        Rim::Far => other > 0.0 && other < 1.0,
    };
    if crosses { height.abs() * (1.0 - other.recip()).abs() } else { f64::INFINITY }
}

/// The part of the radius at which the edge of a wall ends that is so many pixels wide in the middle of the arc; 1 where
/// the cap is not seen.
fn inner_circle(surface: &Surface<'_>, rough: &RoughEnd, outward: f64, width: f64) -> f64 {
    let point = surface.point(0.0, rough.position);
    let direction = surface.cylinder.axis.direction;
    let height = point.dot(&direction);
    let part = width * rough.pixel / height.abs();
    if !(surface.cylinder.end_faces_origin(rough.position, outward) && part < 1.0) {
        return 1.0;
    }
    let across = (point - direction * height) / (1.0 - part);
    let center = surface.frame.toward * surface.frame.distance;
    ((across - center).norm() / surface.cylinder.radius).max(0.0)
}

/// The noise of the samples: the median size of their second difference over a step of one pixel, at which they
/// hardly share pixels, on the inner half of the profiles. Not below a thousandth of the contrast.
fn noise(profiles: &[Profile]) -> f64 {
    let mut differences: List<f64> = List::new();
    for Profile { samples, zero, .. } in profiles.iter().filter(|profile| profile.across > 0.0) {
        differences
            .extend((4..=*zero as usize).map(|k| (samples[k - 4] - 2.0 * samples[k - 2] + samples[k]).abs()));
    }
    // (1, −2, 1) has the norm √6.
    (DEVIATION_OF_MEDIAN * median(&mut differences) / 6.0_f64.sqrt())
        .max(1e-3 * contrast(profiles))
        .max(f64::MIN_POSITIVE)
}

/// How far the samples go up and down.
fn contrast(profiles: &[Profile]) -> f64 {
    let samples = || profiles.iter().flat_map(|profile| profile.samples.iter().copied());
    samples().fold(f64::NEG_INFINITY, f64::max) - samples().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
