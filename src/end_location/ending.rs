//! One end of a surface: what mask, depth and image say of it together.

use super::arc::{ArcEnd, ArcSearch};
use super::silhouette::{RoughEnd, Silhouette, contains};
use super::surface::Surface;
use super::surroundings::Surroundings;
use super::{End, EndSearch, EndSource, EndState, LastArc, MaskContent, border, extreme};
use crate::observations::{Mask, ReducedImage};
use crate::parts::{BodyEnd, EndSign, turn};
use nalgebra::Vector2;

/// What shows where a surface ends: the body, or what closes it.
#[derive(Clone, Copy)]
pub(super) struct Ending<'a> {
    pub search: &'a EndSearch<'a>,
    /// The mask with what lies beyond the body.
    pub whole: &'a Mask,
    pub silhouette: Silhouette<'a>,
    pub surroundings: Surroundings<'a>,
}

impl Ending<'_> {
    /// The end on the side of `outward` (± 1, along the axis direction), which the depth has `told`, and whose arc was at `last` in the
    /// last image of a sequence.
    pub fn locate(&self, told: Option<&BodyEnd>, outward: f64, last: Option<LastArc>) -> End {
        let Self { silhouette, surroundings, .. } = self;
        let of_depth = told.and_then(|end| silhouette.of_depth(end, outward));
        let rim = told.is_some();
        let of_mask = || silhouette.end(surroundings, outward).map(|end| self.within_turn(end, outward));
        let Some(rough) = of_depth.or_else(of_mask) else {
            return End { rim, ..extreme(silhouette.extreme(outward), outward, surroundings) };
        };
        let inside = rough.inside.then(|| surroundings.state_inside(rough.position, outward)).flatten();
        let state = inside.unwrap_or_else(|| surroundings.state(rough.position, outward));
        let cut = || border::last_inside(silhouette, surroundings.drawn, outward, rough.pixel);
        if let Some([position, deviation]) = (state == EndState::Cut).then(cut).flatten() {
            return End { rim, ..End::new(position, Some(deviation), state, EndSource::Border) };
        }
        // A shoulder has no rim that an image could show.
        let rounded = told.is_some_and(|end| end.sign == EndSign::Shoulder);
        let arc = || self.arc(&rough, rim, outward, last);
        match (state != EndState::Hidden && !rounded).then(arc).flatten() {
            Some(arc) => {
                let [position, deviation, part] = together(&rough, &arc);
                let source = if part >= 0.5 { EndSource::Image } else { EndSource::Mask };
                let [samples, far_rim] = arc.samples;
                let arc = Some(LastArc { position: arc.position, blur: arc.blur });
                End { rim, samples, far_rim, arc, ..End::new(position, Some(deviation), state, source) }
            }
            None => End { rim, ..End::new(rough.position, Some(rough.deviation), state, EndSource::Mask) },
        }
    }

    /// The end of a region, which stops where the depth begins to turn to what is behind: anywhere up to where it is half way.
    fn within_turn(&self, end: RoughEnd, outward: f64) -> RoughEnd {
        let EndSearch { camera, depth, content, noise, .. } = *self.search;
        let depth = depth.filter(|_| content == MaskContent::Region);
        let turn = depth
            .and_then(|depth| turn(camera, depth, self.surroundings.cylinder, &noise, end.position, outward));
        let off = turn.map_or(0.0, |turn| (turn - end.position) / 3.0_f64.sqrt());
        RoughEnd { deviation: end.deviation.hypot(off), ..end }
    }

    /// The arc of a rough end in the grey image. What the mask goes on over `beyond` the body is the cap or the inner wall.
    fn arc(&self, rough: &RoughEnd, beyond: bool, outward: f64, last: Option<LastArc>) -> Option<ArcEnd> {
        let Self { search, whole, silhouette, surroundings } = self;
        let factor = search.noise.factor(search.blur, 1);
        let camera = search.camera.reduced(factor);
        let arcs = ArcSearch {
            image: ReducedImage::new(search.image?, factor),
            surface: Surface { camera: &camera, ..*silhouette.surface() },
            mask: search.mask,
            noise: search.noise.reduced(factor),
        };
        let inside = |pixel: &Vector2<f64>| {
            beyond && contains(whole, pixel)
                || search.content != MaskContent::Region
                    && surroundings.shows_inside(pixel, rough.position, outward)
        };
        arcs.locate(rough, outward, &inside, last)
    }
}

/// The mean of an arc and the rough end by their variances, its standard deviation, and the part that the arc has in it.
/// What the model of the arc leaves out is added afterwards: an arc that is good to a tenth of a pixel would otherwise be
/// drawn to a mask that is drawn to half of one.
fn together(rough: &RoughEnd, arc: &ArcEnd) -> [f64; 3] {
    let [of_rough, of_arc] = [rough.deviation, arc.deviation].map(|deviation| deviation * deviation);
    let part = of_rough / (of_rough + of_arc);
    let position = rough.position + part * (arc.position - rough.position);
    [position, (part * of_arc).sqrt().hypot(arc.model), part]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::List;

    #[test]
    fn an_arc_that_is_uncertain_gives_way_to_the_rough_end() {
        let rough = RoughEnd { position: 0.1, deviation: 1e-3, pixel: 1e-3, inside: true };
        let arc = |deviation: f64| ArcEnd {
            position: 0.104,
            deviation,
            model: 3e-4,
            samples: [List::new(), List::new()],
            blur: 1.0,
        };
        let [position, deviation, part] = together(&rough, &arc(1e-4));
        assert!((position - 0.104).abs() < 5e-5 && part > 0.98, "{position} {part}");
        assert!((3e-4..3.3e-4).contains(&deviation), "{deviation}");
        let [position, deviation, part] = together(&rough, &arc(2e-3));
        assert!((position - 0.1008).abs() < 1e-6 && (part - 0.2).abs() < 1e-9, "{position} {part}");
        assert!((9e-4..1e-3).contains(&deviation), "{deviation}");
    }
}
