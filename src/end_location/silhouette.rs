//! The ends in the mask: where the generators of the surface leave it.

use super::EndState;
use super::surface::{Generator, Surface};
use super::surroundings::{Border, Surroundings};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{Mask, pixel_at};
use crate::parts::BodyEnd;
use crate::residuals::{Progress, Reweighting, Scale};
use nalgebra::Vector2;
use pulp::Arch;

constants! {
    /// Generators that are followed out of the mask.
    GENERATORS = 41.0, "";

    /// The part of the width that they cover: beside the limbs the boundary of a mask is that of the limbs.
    WIDTH_PART = 0.85, "";

    /// Steps along a generator or across a limb, in pixels of the drawing: finer than the pixels of the mask.
    STEP_PIXELS = 0.5, "drawn px";

    /// How far about a limb the boundary of the mask is looked for, in pixels of the drawing: more than a mask is off by.
    LIMB_REACH_PIXELS = 6.0, "drawn px";

    /// Positions along each limb at which the mask's boundary is looked at.
    LIMB_SAMPLES = 64.0, "";

    /// Standard deviation of what is left of a mask's bias after it was read off at the limbs, in deviations of a boundary.
    BIAS_LEFT = 0.5, "σ";

    /// Ends farther from the others than 4.685 times this count for nothing, in deviations of a boundary: short of an
    /// occluder.
    ROBUST_DEVIATION = 0.8, "σ";

    /// The fewest generators inside the image that tell an end of which the border cuts off the rest.
    LEAST_INSIDE = 3.0, "";

    /// Rounds of reweighting of the mean of the generators.
    REWEIGHTINGS = 10.0, "";
}

/// Positions on a generator whose pixels are found side by side.
const BLOCK: usize = 16;

/// The mask beside the model.
#[derive(Clone, Copy)]
pub(super) struct Silhouette<'a> {
    surface: Surface<'a>,
    mask: &'a Mask,
    extremes: (f64, f64),
    noise: ImageNoise,
    /// How far the mask reaches beyond the surface, in pixels, where it is known.
    bias: Option<f64>,
}

/// An end as the mask shows it.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoughEnd {
    /// Position along the axis.
    pub position: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Length along the axis of one pixel across the arc of the end.
    pub pixel: f64,
    /// Whether it is told inside the image, whose border may cut off a part of it.
    pub inside: bool,
}

impl<'a> Silhouette<'a> {
    pub fn new(
        surface: Surface<'a>,
        mask: &'a Mask,
        extremes: (f64, f64),
        noise: ImageNoise,
        limbs_known: bool,
    ) -> Self {
        let mut silhouette = Self { surface, mask, extremes, noise, bias: None };
        if limbs_known {
            silhouette.bias = silhouette.bias_at_limbs();
        }
        silhouette
    }

    /// The same mask about a wider surface. Its bias stays that beside the body: the limbs of a collar are too short to show it.
    pub fn wider(&self, surface: Surface<'a>, extremes: (f64, f64)) -> Self {
        Self { surface, extremes, ..*self }
    }

    pub fn surface(&self) -> &Surface<'a> {
        &self.surface
    }

    /// How far the mask reaches beyond the surface, in pixels, where it is known.
    pub fn bias(&self) -> Option<f64> {
        self.bias
    }

    pub fn mask(&self) -> &'a Mask {
        self.mask
    }

    pub fn noise(&self) -> &ImageNoise {
        &self.noise
    }

    /// The middle between the extremes of the mask.
    pub fn middle(&self) -> f64 {
        0.5 * (self.extremes.0 + self.extremes.1)
    }

    /// The extreme of the mask towards `outward`.
    pub fn extreme(&self, outward: f64) -> f64 {
        if outward < 0.0 { self.extremes.0 } else { self.extremes.1 }
    }

    /// The end towards `outward`; `None` when no generator shows it.
    pub fn end(&self, surroundings: &Surroundings<'_>, outward: f64) -> Option<RoughEnd> {
        let (extreme, noise) = (self.extreme(outward), &self.noise);
        let mut ends = List::with_capacity(GENERATORS.count());
        for angle in self.surface.generators(GENERATORS.count(), WIDTH_PART.get()) {
            let generator = self.surface.generator(angle);
            let Some(crossing) = generator.crossing(extreme) else { continue };
            let step = STEP_PIXELS.get() * noise.pixel / crossing.along;
            let Some(position) = self.last_in_mask(&generator, step, outward) else { continue };
            let (state, border) = surroundings.state_on(&generator.point(position), outward);
            ends.push(GeneratorEnd { state, position, across: crossing.across, border });
        }
        let mean = |ends: &[GeneratorEnd]| robust_mean(ends, ROBUST_DEVIATION.get() * noise.boundary);
        // Generators that an occluder covers end early, and so do those that the border of the image cuts off.
        let open = chosen(&ends, |end| end.state != EndState::Hidden);
        let uncut = chosen(&open, |end| end.state != EndState::Cut);
        // Beside the border a mask that stops short of it looks like an end. One that reaches it elsewhere does not.
        let some =
            |border: Border| open.iter().filter(|end| end.border == border).count() >= LEAST_INSIDE.count();
        let enough = surroundings.drawn
            && uncut.len() >= LEAST_INSIDE.count()
            && (some(Border::Far) || some(Border::Reached));
        // Of an end inside the image those that are cut off do not go on beyond the others.
        let is_off = |end: &&GeneratorEnd, position: f64| {
            let off = (end.position - position) * outward * end.across;
            off > noise.beyond()[0] || off < -noise.beyond()[0] && end.state != EndState::Cut
        };
        let off = |position: f64| open.iter().filter(|end| is_off(end, position)).count();
        let told = mean(&uncut).filter(|(position, _)| enough && 4 * off(*position) <= uncut.len());
        let used = match told {
            Some(_) => uncut,
            None if open.is_empty() => ends,
            None => open,
        };
        let (position, across) = told.or_else(|| mean(&used))?;
        let pixel = 1.0 / across;
        let width = 2.0 * WIDTH_PART.get() * self.surface.half_width(extreme)?;
        let independent =
            (width * used.len() as f64 / GENERATORS.count() as f64 / noise.correlation).max(1.0);
        let bias = self.bias.unwrap_or(0.0);
        let left = if self.bias.is_some() { BIAS_LEFT.get() * noise.boundary } else { noise.unevenness };
        Some(RoughEnd {
            position: position - outward * bias * pixel,
            deviation: (noise.boundary * noise.boundary / independent + left * left).sqrt() * pixel,
            pixel,
            inside: told.is_some(),
        })
    }

    /// An end that the depth shows within the mask.
    pub fn of_depth(&self, end: &BodyEnd, outward: f64) -> Option<RoughEnd> {
        let [position, deviation] = end.rim(outward);
        let pixel = 1.0 / self.surface.crossing(0.0, position)?.across;
        pixel.is_finite().then_some(RoughEnd { position, deviation, pixel, inside: true })
    }

    /// Where a generator leaves the mask for the last time.
    fn last_in_mask(&self, generator: &Generator<'_>, step: f64, outward: f64) -> Option<f64> {
        let (middle, extreme) = (self.middle(), self.extreme(outward));
        // The extreme is one of a grid, see its stride, and not of the border.
        let beyond = self.noise.beyond()[3] / (STEP_PIXELS.get() * self.noise.pixel);
        let steps = ((extreme - middle).abs() / step + beyond).ceil() as usize;
        let position = |k: usize| middle + outward * step * k as f64;
        // The extreme bounds all; the first position in the mask on the way back is the last on the way out.
        let mut numbers = [[0.0; BLOCK]; 3];
        let mut end = steps + 1;
        while end > 0 {
            let first = end.saturating_sub(BLOCK);
            let [positions, x, y] = numbers.each_mut().map(|numbers| &mut numbers[..end - first]);
            positions.iter_mut().zip(first..).for_each(|(number, k)| *number = position(k));
            Arch::new().dispatch(|| generator.pixels(positions, x, y));
            let pixels = x.iter().zip(&*y).map(|(x, y)| Vector2::new(*x, *y));
            if let Some(last) = pixels.rev().position(|pixel| contains(self.mask, &pixel)) {
                return Some(position(end - 1 - last) + 0.5 * outward * step);
            }
            end = first;
        }
        None
    }

    /// How far the boundary of the mask lies outside the limbs of the model in pixels, the mean of both limbs so
    /// that a shift of the model drops out; `None` when a limb is not seen.
    fn bias_at_limbs(&self) -> Option<f64> {
        let limb = self.surface.limb_angle();
        let half_width = self.surface.half_width(self.middle())?;
        let reach = (LIMB_REACH_PIXELS.get() * self.noise.pixel).min(0.6 * half_width);
        let middle = self.surface.generator(0.0);
        let mut sum = 0.0;
        for angle in [-limb, limb] {
            let generator = self.surface.generator(angle);
            let mut offsets = List::new();
            for k in 0..LIMB_SAMPLES.count() {
                // Beside the ends the boundary turns away from the limb.
                let part = 0.15 + 0.7 * k as f64 / (LIMB_SAMPLES.count() - 1) as f64;
                let position = self.extremes.0 + part * (self.extremes.1 - self.extremes.0);
                offsets.extend(self.boundary_at_limb([&generator, &middle], position, reach));
            }
            if offsets.len() < LIMB_SAMPLES.count() / 8 {
                return None;
            }
            offsets.sort_unstable_by(f64::total_cmp);
            sum += offsets[offsets.len() / 2];
        }
        Some(0.5 * sum)
    }

    /// The offset of the mask's boundary from a limb, in pixels outward; `None` where something
    /// else than the limb bounds the mask.
    fn boundary_at_limb(
        &self,
        [limb, middle]: [&Generator<'_>; 2],
        position: f64,
        reach: f64,
    ) -> Option<f64> {
        let radius = self.surface.cylinder.radius;
        let at = limb.pixel(position)?;
        let along = limb.pixel(position + 0.01 * radius)? - at;
        let inward = middle.pixel(position)? - at;
        let normal = Vector2::new(-along.y, along.x).normalize();
        let outward = if normal.dot(&inward) < 0.0 { normal } else { -normal };
        let step = STEP_PIXELS.get() * self.noise.pixel;
        let steps = ((reach + LIMB_REACH_PIXELS.get() * self.noise.pixel) / step) as usize;
        let offset = |k: usize| step * k as f64 - reach;
        let pixel = |k: usize| at + outward * offset(k);
        let first_out = (0..=steps).find(|&k| !contains(self.mask, &pixel(k)))?;
        let inside = self.surface.camera.contains(&pixel(first_out));
        (first_out > 0 && inside).then(|| offset(first_out) - 0.5 * step)
    }
}

/// Where a generator leaves the mask.
#[derive(Clone, Copy)]
struct GeneratorEnd {
    /// What lies beyond.
    state: EndState,
    position: f64,
    /// Pixels across the arc of the end by length along the axis.
    across: f64,
    border: Border,
}

fn chosen(ends: &[GeneratorEnd], choose: impl Fn(&GeneratorEnd) -> bool) -> List<GeneratorEnd> {
    ends.iter().filter(|end| choose(end)).copied().collect()
}

/// Whether a mask holds the pixel at a position.
pub(crate) fn contains(mask: &Mask, pixel: &Vector2<f64>) -> bool {
    pixel_at(pixel).is_some_and(|(column, row)| mask.contains(column, row))
}

/// A location of the ends of generators whose standard deviation is `deviation` over their pixels by length, robust against a minority
/// of others, and the root mean square of these numbers there.
fn robust_mean(ends: &[GeneratorEnd], deviation: f64) -> Option<(f64, f64)> {
    let mut sorted = List::from(ends);
    sorted.sort_by(|a, b| a.position.total_cmp(&b.position));
    let total: f64 = sorted.iter().map(|end| end.across * end.across).sum();
    let mut below = 0.0;
    let mut location = sorted.iter().find_map(|end| {
        below += end.across * end.across;
        (below >= 0.5 * total).then_some(end.position)
    })?;
    let mut across = 0.0;
    let distances = |location: f64, residuals: &mut [f64]| {
        for (end, residual) in sorted.iter().zip(residuals) {
            *residual = (end.position - location) * end.across;
        }
    };
    let mut residuals = List::filled(0.0, sorted.len());
    distances(location, &mut residuals);
    let reweighting = Reweighting { rounds: REWEIGHTINGS.count(), scale: Scale::Known(deviation) };
    reweighting.continue_from(&mut residuals, |weights, residuals| {
        let (mut sum, mut total, mut count) = (0.0, 0.0, 0.0);
        for (end, weight) in sorted.iter().zip(weights) {
            sum += weight * end.across * end.across * end.position;
            total += weight * end.across * end.across;
            count += weight;
        }
        if !(total > 0.0) {
            return None;
        }
        location = sum / total;
        across = (total / count).sqrt();
        distances(location, residuals);
        Some(Progress::Moved)
    })?;
    Some((location, across))
}
