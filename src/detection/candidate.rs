//! A surface and the cells that it explains: growth from a start, and what it gains.

use super::grid::{Cell, Grid};
use super::noise::Noise;
use super::outline::{Side, outline};
use super::surface::{Optics, REACH, Surface, fit};
use nalgebra::Vector3;

/// Rounds of collecting and fitting; most settle in two.
const ROUNDS: usize = 4;

/// Fewest cells that five numbers may be fitted to: twice as many.
const FEWEST: usize = 10;

/// What the steps of the search work on.
pub(super) struct Scene<'a> {
    pub grid: &'a Grid,
    pub noise: Noise,
    /// Number of the plane of each cell plus 1; 0 for none.
    pub planes: &'a [u16],
    /// How depth was measured.
    pub optics: Optics,
}

/// A surface with its cells.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub surface: Surface,
    pub cells: Vec<usize>,
    /// How much better than nothing the surface explains the cells: the logarithm of a likelihood ratio, with as many
    /// samples as the correlation of the noise leaves.
    pub gain: f64,
}

impl Scene<'_> {
    /// Squared distance of a cell from the surface in standard deviations, infinite on the wall that is not seen.
    pub fn misfit(&self, surface: &Surface, cell: &Cell) -> f64 {
        let (place, distance, sigma, _) = surface.residual(cell, self.optics.pixel);
        if !surface.faces(&cell.point, &place.normal) {
            return f64::INFINITY;
        }
        (distance / sigma).powi(2)
    }

    /// The gain of a surface over cells.
    pub fn gain(&self, surface: &Surface, cells: &[usize]) -> f64 {
        let sum: f64 =
            cells.iter().map(|&k| (REACH * REACH - self.misfit(surface, &self.grid.cells[k])).max(0.0)).sum();
        0.5 * sum / self.noise.cells_per_sample
    }

    /// The penalty for the numbers of a surface that was fitted to this many cells.
    pub fn penalty(&self, surface: &Surface, cells: usize) -> f64 {
        0.5 * surface.parameters() * (cells as f64 / self.noise.cells_per_sample).max(2.0).ln()
    }

    /// The cells next to each other that lie on a surface, from those of `seeds` that do.
    pub fn flood(
        &self,
        surface: &Surface,
        seeds: &[usize],
        free: &dyn Fn(usize) -> bool,
        mark: &mut Marks,
    ) -> Vec<usize> {
        mark.next();
        let on = |k: usize| {
            let cell = &self.grid.cells[k];
            cell.measured() && free(k) && self.misfit(surface, cell) <= REACH * REACH
        };
        let mut cells = Vec::new();
        for &k in seeds {
            if mark.set(k) && on(k) {
                cells.push(k);
            }
        }
        let mut next = 0;
        while next < cells.len() {
            let k = cells[next];
            next += 1;
            for neighbour in self.grid.neighbours(k) {
                if mark.set(neighbour) && on(neighbour) {
                    cells.push(neighbour);
                }
            }
        }
        cells
    }

    /// The rays along the sides of a cylinder where nothing nearer hides them.
    fn outline_rays(&self, surface: &Surface, cells: &[usize], mark: &mut Marks) -> Vec<Vector3<f64>> {
        let Surface::Cylinder(cylinder, _) = surface else { return Vec::new() };
        outline(self, cylinder, cells, mark).iter().filter_map(Side::limb).collect()
    }

    /// Fits a surface to cells again, all of them within reach at first.
    pub fn refit(&self, surface: &Surface, cells: &[usize], mark: &mut Marks) -> Option<Surface> {
        let refs: Vec<&Cell> = cells.iter().map(|&k| &self.grid.cells[k]).collect();
        let surface = fit(surface, &refs, &[], self.optics, 4.0 * REACH, 6)?;
        let rays = self.outline_rays(&surface, cells, mark);
        fit(&surface, &refs, &rays, self.optics, REACH, 4)
    }

    /// Grows a surface from a start that fits some cells.
    pub fn grow(
        &self,
        start: &Surface,
        seeds: &[usize],
        free: &dyn Fn(usize) -> bool,
        mark: &mut Marks,
    ) -> Option<Candidate> {
        let refs: Vec<&Cell> = seeds.iter().map(|&k| &self.grid.cells[k]).collect();
        let mut surface = fit(start, &refs, &[], self.optics, 4.0 * REACH, 6)?;
        let mut cells = seeds.to_vec();
        let mut before = 0;
        for _ in 0..ROUNDS {
            cells = self.flood(&surface, &cells, free, mark);
            if cells.len() < FEWEST {
                return None;
            }
            let refs: Vec<&Cell> = cells.iter().map(|&k| &self.grid.cells[k]).collect();
            let rays = self.outline_rays(&surface, &cells, mark);
            surface = fit(&surface, &refs, &rays, self.optics, REACH, 4)?;
            // Two per cent more or fewer cells change nothing.
            if cells.len().abs_diff(before) * 50 <= cells.len() {
                break;
            }
            before = cells.len();
        }
        let cells = self.flood(&surface, &cells, free, mark);
        let gain = self.gain(&surface, &cells) - self.penalty(&surface, cells.len());
        (cells.len() >= FEWEST).then_some(Candidate { surface, cells, gain })
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

    pub fn next(&mut self) {
        self.number += 1;
    }

    /// Marks a cell; whether it was not marked yet.
    pub fn set(&mut self, k: usize) -> bool {
        let new = self.marks[k] != self.number;
        self.marks[k] = self.number;
        new
    }

    pub fn has(&self, k: usize) -> bool {
        self.marks[k] == self.number
    }
}
