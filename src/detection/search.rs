//! The search: patches of several sizes, cylinders grown from them, and the choice among those.

use super::candidate::{Candidate, Look, Marks, Scene, Sides};
use super::effort::Effort;
use super::evidence::Evidence;
use super::grid::Grid;
use super::limb_pairs::{ImageEdges, ON_LIMB};
use super::moments::Moments;
use super::noise::Noise;
use super::surface::Surface;
use super::{DetectionOptions, parts, patch, planes};
use crate::error::{Result, cancelled_if};
use crate::geometry::Cylinder;
use nalgebra::Vector2;

/// Half the side of a patch in cells. The smallest is that of a cylinder 15 pixels wide, the largest bends enough for
/// a cylinder as wide as the image.
const SIZES: [usize; 4] = [2, 4, 8, 14];

constants! {
    /// The least radius in cells: where a body is less than 10 pixels wide, depth mixes it with what is beside it, and the
    /// edge of a box is as round.
    THINNEST = 1.7, "cells";

    /// How far the direction of a short cylinder may be off, in radians: the fit has to keep to a known direction, the
    /// search does not.
    DIRECTION_ERROR = 0.1, "rad";

    /// Patches with fewer cells lead to nothing.
    FEWEST = 12.0, "cells";

    /// The part of what a candidate explains that counts where its score is zero: of two that explain the same cells the
    /// better explanation wins, unless it is no cylinder.
    LEAST_SHARE = 0.25, "";

    /// A cylinder that grew from a strip is at most this many times as wide as that: otherwise it was a strip of something wider.
    WIDER = 1.5, "";

    /// Pairs of edges that differ by less than this, in radians and by parts of the radius, are the same limbs.
    ALIKE = 0.08, "";

    /// The part of both limbs together that edges next to a pair must cover.
    COVERED = 0.6, "limb";

    /// Candidates with less are forgotten.
    pub(super) LEAST_SCORE = 0.01, "";

    /// With this score what is explained is not explained again.
    CERTAIN = 0.9, "";

    /// How far the limbs of a cylinder by depth alone may be from the edges in the image, in pixels: depth is drawn out by
    /// two.
    FAR_FROM_LIMB = 4.0, "px";

    /// With this score the cells of what a patch led to start nothing else.
    EXPLAINED = 0.5, "";

    /// What explains less is not looked at closely.
    LEAST_GAIN = 5.0, "log odds";

    /// A pair of edges is not looked at where so much of the depth between them is explained.
    KNOWN = 0.8, "";

    /// How far edges may be from the limbs of a cylinder by a pair of them.
    PAIR_REACH = 2.0 * ON_LIMB.value, "px";

    /// A candidate is skipped where less than this part of its cells is still unexplained.
    LITTLE_LEFT = 0.2, "";

    /// A candidate is dropped, unless it can be divided, where less than this part of its cells is still unexplained.
    ENOUGH_LEFT = 0.6, "";
}

/// The column and the row of pixels at a position on the plane z = 1.
pub(super) type PixelOf<'a> = dyn Fn(&Vector2<f64>) -> Option<(usize, usize)> + 'a;

/// Where patches begin.
#[derive(Clone, Copy)]
pub(super) struct Seeds {
    /// They lie half the side of a patch divided by this apart, and at least two cells.
    pub density: usize,
    /// A cell that so many candidates hold starts none: a bound on the time.
    pub most_visits: u8,
    /// Whether the outline of a narrow patch gives a cylinder where its bend gives none.
    pub strips: bool,
}

/// Those of a whole scene.
const SEEDS: Seeds = Seeds { density: 1, most_visits: 3, strips: false };

/// Most pairs of edges that are looked at closely, the longest first: a bound on the time.
const MOST_PAIRS: usize = 200;

/// Visits up to which each stage may go. What one leaves is for the next.
struct Limits {
    pairs: u64,
    patches: u64,
    edges: u64,
    joining: u64,
    dividing: u64,
    choice: u64,
}

/// The frames of ../shared/scenes take up to 1.7, 2.7, 3.1, 3.5, 4.3 and 4.3 million; scenes with more bodies than an image
/// of 640 x 480 can show well, and depth that bends everywhere, a hundred million.
const LIMITS: Limits = Limits {
    pairs: 4_000_000,
    patches: 6_000_000,
    edges: 7_000_000,
    joining: 7_500_000,
    dividing: 9_000_000,
    choice: 10_000_000,
};

/// A candidate that was judged.
pub(super) struct Judged {
    pub candidate: Candidate,
    pub evidence: Evidence,
    pub score: f64,
}

/// What a search finds.
pub(super) struct Searched {
    /// The cylinders, best first.
    pub cylinders: Vec<Judged>,
    /// See [`super::Detections::shift`].
    pub shift: Option<[i32; 2]>,
    /// Whether each cell has an error of its own: finer ones lose nothing then.
    pub independent: bool,
}

/// What tells limbs beside the surface.
pub(super) enum Limbs<'a> {
    /// The edges of an image.
    Edges(&'a ImageEdges, &'a PixelOf<'a>),
    /// The outline of a depth image without an image.
    Outline,
    /// Nothing: a bare cloud has no outline of its own.
    None,
}

/// The cylinders of a grid.
pub(super) fn search(
    grid: &mut Grid,
    pixel: f64,
    limbs: &Limbs<'_>,
    options: &DetectionOptions,
    effort: &Effort<'_>,
) -> Result<Searched> {
    let cancelled = || cancelled_if(effort.ask());
    let Some(noise) = Noise::of_scene(grid) else {
        return Ok(Searched { cylinders: Vec::new(), shift: None, independent: false });
    };
    cancelled()?;
    let planes = planes::find_planes(grid, &noise, effort);
    cancelled()?;
    let image = if let Limbs::Edges(edges, pixel_of) = *limbs { Some((edges, pixel_of)) } else { None };
    let by_outline = matches!(limbs, Limbs::Outline);
    let independent = !noise.is_shared();
    let scene = Scene::new(grid, noise, planes::open(grid, &planes), image, pixel, effort);
    let mut marks = Marks::of_open(&scene.open);
    let mut explained = vec![false; grid.cells.len()];
    effort.limit(LIMITS.pairs);
    let mut found = by_pairs(&scene, options, &mut explained, &mut marks);
    effort.limit(LIMITS.patches);
    let seeds = Seeds { strips: by_outline, ..SEEDS };
    // Of those that are alike the best alone is moved to edges.
    let by_depth = distinct(candidates(&scene, options, seeds, &mut explained, &mut marks));
    effort.limit(LIMITS.edges);
    found.extend(by_edges(&scene, &by_depth, options, &mut marks));
    found.extend(by_depth);
    cancelled()?;
    let mut found = distinct(found);
    effort.limit(LIMITS.joining);
    parts::join(&scene, &mut found, options, &mut marks);
    let mut cylinders = select(&scene, &mut found, options, &mut marks);
    cancelled()?;
    if by_outline {
        settle(&scene, &mut cylinders, options, &mut marks);
    }
    let shift = scene.shift(&cylinders, &mut marks);
    Ok(Searched { cylinders, shift, independent })
}

/// Whether two cylinders are nearly one.
pub(super) fn same(a: &Cylinder, b: &Cylinder) -> bool {
    let change = a.compare(b);
    change.angle < ALIKE.get()
        && change.radius_relative.abs() < ALIKE.get()
        && change.axis_distance < ALIKE.get() * a.radius
}

/// The best of candidates that are alike.
pub(super) fn distinct(mut found: Vec<Judged>) -> Vec<Judged> {
    found.sort_by(|a, b| b.priority().total_cmp(&a.priority()));
    let mut kept: Vec<Judged> = Vec::new();
    for judged in found {
        let alike = |other: &Judged| {
            let (Surface::Cylinder(a, _), Surface::Cylinder(b, _)) =
                (&judged.candidate.surface, &other.candidate.surface)
            else {
                return false;
            };
            // A cell of its own makes a candidate another part of the same cylinder, which is for joining.
            same(b, a)
                && other.candidate.cells.contains(&judged.candidate.cells[judged.candidate.cells.len() / 2])
                && judged.candidate.cells.len() <= other.candidate.cells.len()
        };
        if !kept.iter().any(alike) {
            kept.push(judged);
        }
    }
    kept
}

impl Judged {
    /// A candidate with its evidence, if it is worth a closer look.
    pub fn new(
        scene: &Scene<'_>,
        grown: (Candidate, Look),
        options: &DetectionOptions,
        marks: &mut Marks,
    ) -> Option<Self> {
        Self::with_score(scene, grown, 0.0, options, marks)
    }

    /// The same for a caller who forgets those with a score below `least`, whose evidence need not be complete.
    fn with_score(
        scene: &Scene<'_>,
        (candidate, look): (Candidate, Look),
        least: f64,
        options: &DetectionOptions,
        marks: &mut Marks,
    ) -> Option<Self> {
        if !plausible(scene, &candidate, options) {
            return None;
        }
        let evidence = scene.judge(&candidate, &look, least, marks)?;
        Some(Self { candidate, evidence, score: evidence.score() })
    }

    /// Which of the candidates that explain the same cells is chosen: the one of the highest priority.
    fn priority(&self) -> f64 {
        self.candidate.gain * (LEAST_SHARE.get() + (1.0 - LEAST_SHARE.get()) * self.score)
    }
}

/// Candidates by patches of the depth, among cells that are not explained yet.
pub(super) fn candidates(
    scene: &Scene<'_>,
    options: &DetectionOptions,
    Seeds { density, most_visits, strips }: Seeds,
    explained: &mut [bool],
    marks: &mut Marks,
) -> Vec<Judged> {
    let grid = scene.grid;
    let mut found: Vec<Judged> = Vec::new();
    let mut cells = Vec::new();
    let mut visits = vec![0_u8; grid.cells.len()];
    for half in SIZES {
        let stride = (half / density).max(2);
        // A strip is tried once with each size.
        let mut in_strips = vec![false; if strips { grid.cells.len() } else { 0 }];
        for row in (stride / 2..grid.rows).step_by(stride) {
            for column in (stride / 2..grid.columns).step_by(stride) {
                let seed = row * grid.columns + column;
                if !scene.open[seed] || explained[seed] || visits[seed] >= most_visits {
                    continue;
                }
                patch::collect(grid, seed, half, marks, &mut cells);
                if cells.len() < FEWEST.count() {
                    continue;
                }
                if scene.effort.is_spent() {
                    return found;
                }
                let moments = Moments::new(grid, &cells);
                let by_bend =
                    patch::hypothesis(grid, &moments, scene.noise.deviation, scene.noise.cells_per_sample);
                let judged = by_bend
                    .and_then(|start| {
                        judged_from(scene, (&start, f64::INFINITY), &cells, options, &mut visits, marks)
                    })
                    .or_else(|| {
                        let start = if strips && !in_strips[seed] {
                            patch::strip(grid, &moments)?
                        } else {
                            return None;
                        };
                        cells.iter().for_each(|&k| in_strips[k] = true);
                        let widest = WIDER.get() * start.radius;
                        judged_from(scene, (&start, widest), &cells, options, &mut visits, marks)
                    });
                let Some(judged) = judged else { continue };
                if judged.score > EXPLAINED.get() {
                    judged.candidate.cells.iter().for_each(|&k| explained[k] = true);
                }
                found.push(judged);
            }
        }
    }
    found
}

/// Candidates that depth gave, moved to the edges next to their limbs.
fn by_edges(
    scene: &Scene<'_>,
    found: &[Judged],
    options: &DetectionOptions,
    marks: &mut Marks,
) -> Vec<Judged> {
    let mut moved = Vec::new();
    if scene.image.is_none() {
        return moved;
    }
    for judged in found.iter().take_while(|_| !scene.effort.is_spent()) {
        let Candidate { surface, cells, gain, .. } = &judged.candidate;
        let sides = Sides::Edges { reach: FAR_FROM_LIMB.get() };
        let Some(grown) = scene.grow(surface, cells, sides, marks) else { continue };
        if grown.0.gain > *gain {
            let judged = Judged::with_score(scene, grown, LEAST_SCORE.get(), options, marks);
            moved.extend(judged.filter(|judged| judged.score > LEAST_SCORE.get()));
        }
    }
    moved
}

/// Candidates by two edges of the image each; what they explain well is marked.
fn by_pairs(
    scene: &Scene<'_>,
    options: &DetectionOptions,
    explained: &mut [bool],
    marks: &mut Marks,
) -> Vec<Judged> {
    if scene.image.is_none() {
        return Vec::new();
    }
    let mut found: Vec<Judged> = Vec::new();
    let mut tried: Vec<Cylinder> = Vec::new();
    let mut grown = 0;
    for pair in scene.pairs() {
        if grown == MOST_PAIRS || scene.effort.is_spent() {
            break;
        }
        let known = pair.cells.iter().filter(|&&k| explained[k]).count();
        // Edges are pieces of limbs, and many pairs of pieces are the same limbs.
        if tried.iter().any(|other| same(other, &pair.cylinder))
            || known as f64 > KNOWN.get() * pair.cells.len() as f64
        {
            continue;
        }
        tried.push(pair.cylinder);
        let range = scene.range(&pair.cylinder, &pair.cells);
        let support = scene.support(&pair.cylinder, range, PAIR_REACH.get()).unwrap_or_default();
        if support.covered.iter().sum::<f64>() < COVERED.get() {
            continue;
        }
        grown += 1;
        let sides = Sides::Edges { reach: PAIR_REACH.get() };
        let start = Surface::Cylinder(pair.cylinder, 0.0);
        let Some(grown) = scene.grow(&start, &pair.cells, sides, marks) else { continue };
        let Some(judged) = Judged::with_score(scene, grown, LEAST_SCORE.get(), options, marks) else {
            continue;
        };
        if let Surface::Cylinder(cylinder, _) = judged.candidate.surface {
            tried.push(cylinder);
        }
        if judged.score > CERTAIN.get() {
            judged.candidate.cells.iter().for_each(|&k| explained[k] = true);
        }
        if judged.score > LEAST_SCORE.get() {
            found.push(judged);
        }
    }
    found
}

/// Whether a candidate is worth a closer look.
fn plausible(scene: &Scene<'_>, candidate: &Candidate, options: &DetectionOptions) -> bool {
    let Surface::Cylinder(cylinder, _) = candidate.surface else { return false };
    let depth = scene.grid.cells[candidate.cells[0]].point.z;
    let allowed = options.limits.axis.is_none_or(|cone| {
        let line = crate::geometry::Line::new(cylinder.axis.point, cone.direction);
        cylinder.axis.angle(&line) <= cone.max_angle + DIRECTION_ERROR.get()
    });
    allowed
        && candidate.gain > LEAST_GAIN.get()
        && cylinder.radius >= THINNEST.get() * scene.grid.spacing * depth
        && cylinder.radius >= options.limits.radius_min
        && cylinder.radius <= options.limits.radius_max
        && candidate.cells.len() * scene.grid.side * scene.grid.side >= options.min_pixels
}

/// Candidates that do not share cells, the one that explains most first, or its parts where it is two cylinders.
fn select(
    scene: &Scene<'_>,
    found: &mut Vec<Judged>,
    options: &DetectionOptions,
    marks: &mut Marks,
) -> Vec<Judged> {
    let mut chosen: Vec<Judged> = Vec::new();
    let mut taken = vec![false; scene.grid.cells.len()];
    let by_priority = |a: &Judged, b: &Judged| a.priority().total_cmp(&b.priority());
    found.sort_by(by_priority);
    while let Some(mut judged) = found.pop() {
        let all = judged.candidate.cells.len();
        let left = judged.candidate.cells.iter().filter(|&&k| !taken[k]).count();
        // What others explain nearly all of is not divided either.
        if (left as f64) < LITTLE_LEFT.get() * all as f64 {
            continue;
        }
        scene.effort.limit(LIMITS.dividing);
        let parts = parts::divided(scene, &judged, options, marks);
        scene.effort.limit(LIMITS.choice);
        if let Some(parts) = parts {
            // They may be divided again.
            found.extend(parts);
            found.sort_by(by_priority);
            continue;
        }
        if (left as f64) < ENOUGH_LEFT.get() * all as f64 {
            continue;
        }
        judged.candidate.cells.retain(|&k| !taken[k]);
        if judged.candidate.cells.len() < all {
            let look = scene.look(&judged.candidate.surface, &judged.candidate.cells, marks);
            judged.candidate.gain = look.worth;
            let Some(evidence) = scene.judge(&judged.candidate, &look, options.min_score, marks) else {
                continue;
            };
            judged.evidence = evidence;
            judged.score = evidence.score();
        }
        if judged.score < options.min_score {
            continue;
        }
        judged.candidate.cells.iter().for_each(|&k| taken[k] = true);
        judged.evidence.slope = scene.slope(&judged.candidate, marks);
        chosen.push(judged);
    }
    chosen.sort_by(|a, b| b.score.total_cmp(&a.score));
    chosen.truncate(options.max_count.min(usize::from(u16::MAX)));
    chosen
}

/// What grows from a cylinder through cells of a patch to a radius of at most `widest`, and is good enough; its cells are visited.
fn judged_from(
    scene: &Scene<'_>,
    (start, widest): (&Cylinder, f64),
    cells: &[usize],
    options: &DetectionOptions,
    visits: &mut [u8],
    marks: &mut Marks,
) -> Option<Judged> {
    let grown = scene.grow(&Surface::Cylinder(*start, 0.0), cells, Sides::Outline, marks)?;
    if grown.0.surface.radius() > widest {
        return None;
    }
    grown.0.cells.iter().for_each(|&k| visits[k] = visits[k].saturating_add(1));
    Judged::with_score(scene, grown, LEAST_SCORE.get(), options, marks)
        .filter(|judged| judged.score > LEAST_SCORE.get())
}

/// Gives the cylinders that were chosen the surfaces of a last fit, where these keep the limits.
fn settle(scene: &Scene<'_>, chosen: &mut [Judged], options: &DetectionOptions, marks: &mut Marks) {
    for Judged { candidate, .. } in chosen {
        let Some(surface) = scene.settled(candidate, marks) else { continue };
        let settled = Candidate { surface, ..candidate.clone() };
        if plausible(scene, &settled, options) {
            *candidate = settled;
        }
    }
}
