//! A surface and the cells that it explains: growth from a start, and what it gains.

use super::distances::{self, Numbers};
use super::effort::Effort;
use super::grid::Grid;
use super::limb_pairs::{ImageEdges, ON_LIMB, Support};
use super::noise::Noise;
use super::outline::{Normals, Side, outline};
use super::search::PixelOf;
use super::surface::{OUTLINE_PIXELS, OUTLINE_SHIFT_PIXELS, Optics, REACH, Surface, Tangent, fit};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::{median, min_max};

/// Rounds of collecting and fitting; most settle in two.
const ROUNDS: usize = 4;

constants! {
    /// Fewest cells that five numbers may be fitted to: twice as many.
    FEWEST = 10.0, "cells";

    /// The square of an inset counts up to this: outlines are uneven.
    MOST_INSET = 16.0, "σ²";

    /// What an edge along a limb is worth for each pixel of its length, as a logarithm of odds: one in twenty edges of
    /// ten pixels lies there by chance.
    GAIN_PER_PIXEL = 0.3, "log odds/px";

    /// The part of a limb that edges must cover to hold it.
    LEAST_COVERED = 0.2, "limb";

    /// How far from a start the cells may be that a fit is made to first, and the steps of that fit.
    FIRST_REACH = 4.0 * REACH.value, "σ";
    FIRST_STEPS = 6.0, "";

    /// Steps of the fits that follow.
    LAST_STEPS = 4.0, "";

    /// What belongs to a cylinder has settled where it grows or shrinks by this part of itself at most.
    pub(crate) SETTLED = 0.02, "";
}

/// Most cells that a surface is fitted to, evenly chosen from more: a bound on the time.
const FITTED: usize = 8000;

/// What the steps of the search work on.
pub(super) struct Scene<'a> {
    pub grid: &'a Grid,
    /// What is asked of its cells again and again.
    pub numbers: Vec<Numbers>,
    pub noise: Noise,
    /// Whether a cell was measured and belongs to no plane.
    pub open: Vec<bool>,
    /// The normals at the cells.
    pub normals: Normals,
    /// How the scene was measured.
    pub optics: Optics,
    /// The image and where its pixels are, if there is one.
    pub image: Option<(&'a ImageEdges, &'a PixelOf<'a>)>,
    /// What the search has done.
    pub effort: &'a Effort<'a>,
}

/// What holds the sides of a cylinder that grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sides {
    /// The outline of its cells.
    Outline,
    /// The edges within so many pixels of its limbs; the outline where there are none.
    Edges { reach: f64 },
}

/// A surface as its cells and the image see it: what it is worth and the evidence for it follow from this alike.
pub(super) struct Look {
    /// What the surface explains, cells and edges of the image, less the penalty for its numbers and what contradicts its
    /// outline.
    pub worth: f64,
    /// The squared distances of the cells in standard deviations.
    pub misfits: List<f64>,
    /// Where the rays of the cells pass across the axis; this and what follows are those of a cylinder.
    pub across: List<f64>,
    /// Where the cells begin and end along the axis.
    pub range: [f64; 2],
    /// How the surface ends at its two sides.
    pub sides: List<Side>,
    /// The edges of the image on the limbs.
    pub support: Option<Support>,
}

/// A surface with its cells.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub surface: Surface,
    pub cells: List<usize>,
    /// How much better than nothing the surface explains the cells: the logarithm of a likelihood ratio, with as many
    /// samples as the correlation of the noise leaves; with the edges of the image that lie on its limbs.
    pub gain: f64,
    /// What held its sides.
    pub sides: Sides,
}

impl<'a> Scene<'a> {
    /// `pixel` is the side of a pixel on the plane z = 1.
    pub fn new(
        grid: &'a Grid,
        noise: Noise,
        open: Vec<bool>,
        image: Option<(&'a ImageEdges, &'a PixelOf<'a>)>,
        pixel: f64,
        effort: &'a Effort<'a>,
    ) -> Self {
        Self {
            grid,
            numbers: distances::numbers(&grid.cells),
            noise,
            open,
            normals: Normals::new(grid.cells.len()),
            optics: Optics { pixel, cells_per_sample: noise.cells_per_sample },
            image,
            effort,
        }
    }

    /// The squared distances of cells from a surface in standard deviations, infinite on the wall that is not seen.
    pub fn misfits(&self, surface: &Surface, cells: &[usize]) -> List<f64> {
        let mut misfits = List::new();
        distances::misfits(surface, self.optics.pixel, &self.numbers, cells, &mut misfits);
        misfits
    }

    /// The gain of a surface over cells.
    pub fn gain(&self, surface: &Surface, cells: &[usize]) -> f64 {
        self.effort.spend(cells.len());
        self.gain_by(&self.misfits(surface, cells))
    }

    /// The gain over cells with these squared distances.
    pub fn gain_by(&self, misfits: &[f64]) -> f64 {
        let sum: f64 = misfits.iter().map(|misfit| (REACH.get() * REACH.get() - misfit).max(0.0)).sum();
        0.5 * sum / self.noise.cells_per_sample
    }

    /// How far inside of each limb the outline of cells is, less what sensors do, in standard deviations; 0 where it is
    /// hidden.
    fn insets(&self, cylinder: &Cylinder, sides: &[Side]) -> [f64; 2] {
        [-1.0, 1.0].map(|sign| {
            let mut insets: List<f64> = sides
                .iter()
                .filter(|side| side.sign == sign)
                .filter_map(Side::limb)
                .map(|ray| {
                    let t = cylinder.axis.nearest_on_ray(&ray);
                    (cylinder.radius - cylinder.axis.distance(&(ray * t))) / (t * self.optics.pixel)
                })
                .collect();
            if insets.is_empty() {
                return 0.0;
            }
            (median(&mut insets) - OUTLINE_SHIFT_PIXELS.get()) / OUTLINE_PIXELS.get()
        })
    }

    /// A look at a surface with its cells.
    pub fn look(&self, surface: &Surface, cells: &[usize], mark: &mut Marks) -> Look {
        self.effort.spend(cells.len());
        self.look_by(surface, cells, self.misfits(surface, cells), mark)
    }

    /// The same where the squared distances of the cells are known.
    fn look_by(&self, surface: &Surface, cells: &[usize], misfits: List<f64>, mark: &mut Marks) -> Look {
        let (gain, penalty) = (self.gain_by(&misfits), self.penalty(surface, cells.len()));
        let (mut across, mut along) = (List::new(), List::new());
        let Surface::Cylinder(cylinder, _) = surface else {
            let worth = gain - penalty;
            return Look { worth, misfits, across, range: [0.0; 2], sides: List::new(), support: None };
        };
        distances::across_and_along(cylinder, &self.numbers, cells, &mut across, &mut along);
        let range = min_max(&along);
        let sides = outline(self, cylinder, cells, (&across, &along, range), mark);
        let insets = self.insets(cylinder, &sides);
        let outline: f64 = insets.iter().map(|inset| 0.5 * (inset * inset).min(MOST_INSET.get())).sum();
        let support = self.support(cylinder, range, ON_LIMB.get());
        let edges = support.as_ref().map_or(0.0, |support| support.length * GAIN_PER_PIXEL.get());
        Look { worth: gain + edges - outline - penalty, misfits, across, range, sides, support }
    }

    /// The penalty for the numbers of a surface that was fitted to this many cells.
    pub fn penalty(&self, surface: &Surface, cells: usize) -> f64 {
        0.5 * surface.parameters() * (cells as f64 / self.noise.cells_per_sample).max(2.0).ln()
    }

    /// The cells next to each other that lie on a surface, from those of `seeds` that do, and their squared distances.
    fn flood(&self, surface: &Surface, seeds: &[usize], mark: &mut Marks) -> (List<usize>, List<f64>) {
        mark.next();
        let grid = self.grid;
        let (mut asked, mut misfits) = (List::new(), List::new());
        let (mut cells, mut of_cells) = (List::new(), List::new());
        asked.extend(seeds.iter().copied().filter(|&k| mark.set(k)));
        // Ring by ring.
        while !asked.is_empty() {
            distances::misfits(surface, self.optics.pixel, &self.numbers, &asked, &mut misfits);
            let first = cells.len();
            for (&k, &misfit) in asked.iter().zip(&misfits) {
                if misfit <= REACH.get() * REACH.get() {
                    cells.push(k);
                    of_cells.push(misfit);
                }
            }
            asked.clear();
            for &k in &cells[first..] {
                for next in grid.neighbours(k) {
                    if mark.set(next) {
                        asked.push(next);
                    }
                }
            }
        }
        self.effort.spend(cells.len());
        (cells, of_cells)
    }

    /// What touches the sides of a cylinder: the outline of its cells where nothing nearer hides it, or the edges on
    /// its limbs.
    pub fn tangents(
        &self,
        surface: &Surface,
        cells: &[usize],
        sides: Sides,
        mark: &mut Marks,
    ) -> List<Tangent> {
        let Surface::Cylinder(cylinder, _) = surface else { return List::new() };
        if let (Sides::Edges { reach }, true) = (sides, self.image.is_some()) {
            let range = self.range(cylinder, cells);
            let support = self.support(cylinder, range, reach).unwrap_or_default();
            if support.covered.iter().all(|&covered| covered >= LEAST_COVERED.get()) {
                return support.tangents;
            }
        }
        let (mut across, mut along) = (List::new(), List::new());
        distances::across_and_along(cylinder, &self.numbers, cells, &mut across, &mut along);
        let sides = outline(self, cylinder, cells, (&across, &along, min_max(&along)), mark);
        let rays: List<_> = sides.iter().filter_map(Side::limb).collect();
        // What a sensor does to an outline it does all along: each of the two sides is one measurement.
        let weight = 2.0 / rays.len() as f64;
        let tangent =
            |ray| Tangent { ray, inset: OUTLINE_SHIFT_PIXELS.get(), deviation: OUTLINE_PIXELS.get(), weight };
        rays.into_iter().map(tangent).collect()
    }

    /// Where cells begin and end along the axis of a cylinder, from its point.
    pub fn range(&self, cylinder: &Cylinder, cells: &[usize]) -> [f64; 2] {
        let along = |&k: &usize| cylinder.axis.position_of(&self.grid.cells[k].point);
        min_max(&cells.iter().map(along).collect::<List<f64>>())
    }

    /// Fits a surface to cells again, all of them within reach at first.
    pub fn refit(
        &self,
        surface: &Surface,
        cells: &[usize],
        sides: Sides,
        mark: &mut Marks,
    ) -> Option<Surface> {
        let surface = self.fit(surface, cells, &[], FIRST_REACH.get(), FIRST_STEPS.count())?;
        let tangents = self.tangents(&surface, cells, sides, mark);
        self.fit(&surface, cells, &tangents, REACH.get(), LAST_STEPS.count())
    }

    /// Fits a surface to cells and tangents from a start.
    pub fn fit(
        &self,
        start: &Surface,
        cells: &[usize],
        tangents: &[Tangent],
        reach: f64,
        steps: usize,
    ) -> Option<Surface> {
        let stride = cells.len().div_ceil(FITTED).max(1);
        let thinned: List<usize>;
        let cells = if stride == 1 {
            cells
        } else {
            thinned = cells.iter().step_by(stride).copied().collect();
            &thinned
        };
        self.effort.spend(steps * (cells.len() + tangents.len()));
        if self.effort.is_spent() {
            return None;
        }
        fit(start, (&self.numbers, cells), tangents, self.optics, reach, steps)
    }

    /// The edges of the image on the limbs of a cylinder.
    pub fn support(&self, cylinder: &Cylinder, range: [f64; 2], reach: f64) -> Option<Support> {
        let (image, _) = self.image?;
        self.effort.spend(2 * image.edges.len());
        image.support(cylinder, range, reach)
    }

    /// Grows a surface from a start that fits some cells; with it comes a last look at it.
    pub fn grow(
        &self,
        start: &Surface,
        seeds: &[usize],
        sides: Sides,
        mark: &mut Marks,
    ) -> Option<(Candidate, Look)> {
        let tangents = match sides {
            Sides::Edges { .. } => self.tangents(start, seeds, sides, mark),
            Sides::Outline => List::new(),
        };
        let mut surface = self.fit(start, seeds, &tangents, FIRST_REACH.get(), FIRST_STEPS.count())?;
        let mut cells = List::from(seeds);
        let mut before = 0;
        for _ in 0..ROUNDS {
            cells = self.flood(&surface, &cells, mark).0;
            if cells.len() < FEWEST.count() {
                return None;
            }
            let tangents = self.tangents(&surface, &cells, sides, mark);
            surface = self.fit(&surface, &cells, &tangents, REACH.get(), LAST_STEPS.count())?;
            if cells.len().abs_diff(before) as f64 <= SETTLED.get() * cells.len() as f64 {
                break;
            }
            before = cells.len();
        }
        let (cells, misfits) = self.flood(&surface, &cells, mark);
        if cells.len() < FEWEST.count() {
            return None;
        }
        let look = self.look_by(&surface, &cells, misfits, mark);
        Some((Candidate { surface, cells, gain: look.worth, sides }, look))
    }
}

/// Which cells were visited, without clearing between visits.
pub(super) struct Marks {
    marks: Vec<u32>,
    number: u32,
}

impl Marks {
    pub fn new(cells: usize) -> Self {
        Self { marks: vec![0; cells], number: 0 }
    }

    /// Those of open cells: others are never new.
    pub fn of_open(open: &[bool]) -> Self {
        Self { marks: open.iter().map(|open| if *open { 0 } else { u32::MAX }).collect(), number: 0 }
    }

    pub fn next(&mut self) {
        self.number += 1;
    }

    /// Marks a cell; whether it was new.
    pub fn set(&mut self, k: usize) -> bool {
        let mark = &mut self.marks[k];
        let is_new = *mark < self.number;
        if is_new {
            *mark = self.number;
        }
        is_new
    }

    /// Whether a cell is not marked yet.
    pub fn is_new(&self, k: usize) -> bool {
        self.marks[k] < self.number
    }

    pub fn has(&self, k: usize) -> bool {
        self.marks[k] == self.number
    }
}
