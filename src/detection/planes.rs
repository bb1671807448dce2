//! Large planes: table, walls, faces of boxes, caps. Seeds are blocks of cells; planes grow and then have to be flat.

use super::candidate::Marks;
use super::effort::Effort;
use super::grid::{Cell, Grid};
use super::moments::Moments;
use super::noise::Noise;
use super::surface::REACH;
use crate::memory::List;
use crate::statistics::median;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Cells along the side of a block, the smallest piece that a plane starts from.
const BLOCK: usize = 4;

constants! {
    /// Fewest cells of a plane: four blocks.
    FEWEST = (4 * BLOCK * BLOCK) as f64, "cells";

    /// The most that a plane may bend between its middle and its border, in standard deviations: a strip of a cylinder,
    /// which ends where the surface leaves the reach of its plane, bends by two thirds of the 2 · [`REACH`] that it spans.
    FLAT = 1.5, "σ";

    /// The most that the cells of a plane may spread, in standard deviations: where the plane only passes through curved
    /// bodies side by side, cells fill its reach evenly, which gives 1.7.
    SPREAD = 1.4, "σ";

    /// The same for planes narrower than [`WIDE`]. A strip that bends by [`FLAT`] gives 1.1; what cuts through a body and goes on over
    /// the table that it stands on gives more than this, though it does not bend.
    SPREAD_OF_NARROW = 1.3, "σ";

    /// What is wider, in cells, is no part of a body: a third of the image.
    WIDE = 60.0, "cells";

    /// The least width of a plane in cells. Strips that bend less than [`FLAT`] are facets of any cylinder with a radius of
    /// up to 125 pixels, but narrower than this.
    NARROWEST = 10.0, "cells";

    /// The most that the cells of a block may spread about its plane, and about that which grows over it.
    OF_BLOCK = 2.0, "σ";

    /// The part of the cells of a block that must be measured.
    MEASURED = 0.75, "";
}

/// Sums over cells for the plane w = a + b x + c y through them: their number, and those of x, y, x², xy, y², w, xw, yw
/// and w².
#[derive(Clone, Copy, Default)]
pub(super) struct PlaneSums([f64; 10]);

impl PlaneSums {
    pub fn add(&mut self, &Cell { x, y, w, .. }: &Cell) {
        self.join(&Self([1.0, x, y, x * x, x * y, y * y, w, x * w, y * w, w * w]));
    }

    fn join(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, number)| *sum += number);
    }

    /// These but for those of some cells.
    pub fn without(&self, some: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - some.0[k]))
    }

    /// The plane (a, b, c).
    pub fn plane(&self) -> Option<Vector3<f64>> {
        Some(self.matrix().cholesky()?.solve(&self.vector()))
    }

    /// The plane, and the root mean square residual.
    fn solve(&self) -> Option<(Vector3<f64>, f64)> {
        let plane = self.plane()?;
        let rest = (self.squares() - plane.dot(&self.vector())).max(0.0);
        Some((plane, (rest / (self.count() - 3.0).max(1.0)).sqrt()))
    }

    fn matrix(&self) -> Matrix3<f64> {
        let [count, x, y, xx, xy, yy, ..] = self.0;
        Matrix3::new(count, x, y, x, xx, xy, y, xy, yy)
    }

    fn vector(&self) -> Vector3<f64> {
        let [.., w, xw, yw, _] = self.0;
        Vector3::new(w, xw, yw)
    }

    fn squares(&self) -> f64 {
        self.0[9]
    }

    fn count(&self) -> f64 {
        self.0[0]
    }
}

/// For each cell of a grid the number of its plane from 1 on, or 0.
pub(super) fn find_planes(grid: &Grid, noise: &Noise, effort: &Effort<'_>) -> Vec<u16> {
    let (columns, rows) = (grid.columns / BLOCK, grid.rows / BLOCK);
    let blocks: List<Option<(PlaneSums, f64)>> =
        (0..columns * rows).map(|k| block(grid, k % columns, k / columns, noise)).collect();
    let mut order: List<usize> = (0..blocks.len()).filter(|&k| blocks[k].is_some()).collect();
    let rms = |k: usize| blocks[k].map_or(f64::INFINITY, |(_, rms)| rms);
    order.sort_by(|&a, &b| rms(a).total_cmp(&rms(b)));
    let mut taken = List::filled(false, blocks.len());
    let mut owner = vec![0_u16; grid.cells.len()];
    let mut number = 0_u16;
    let (mut seen_blocks, mut seen_cells) = (Marks::new(blocks.len()), Marks::new(grid.cells.len()));
    for seed in order {
        if taken[seed] {
            continue;
        }
        if effort.ask() {
            break;
        }
        let Some((plane, members)) = grow(&blocks, (columns, rows), seed, &taken, noise, &mut seen_blocks)
        else {
            continue;
        };
        // A seed that leads nowhere is not tried again, its neighbours are.
        taken[seed] = true;
        if members.len() * BLOCK * BLOCK < FEWEST.count() {
            continue;
        }
        let start = (seed % columns, seed / columns);
        let Some(found) = settle(grid, noise, plane, start, &owner, &mut seen_cells) else { continue };
        let Some(next) = number.checked_add(1) else { break };
        number = next;
        members.iter().for_each(|&k| taken[k] = true);
        found.iter().for_each(|&k| owner[k] = number);
    }
    owner
}

/// Which cells were measured and belong to no plane.
pub(super) fn open(grid: &Grid, planes: &[u16]) -> Vec<bool> {
    grid.cells.iter().zip(planes).map(|(cell, &plane)| cell.measured() && plane == 0).collect()
}

/// The sums of a block of cells without a step, if a plane explains them.
fn block(grid: &Grid, column: usize, row: usize, noise: &Noise) -> Option<(PlaneSums, f64)> {
    let mut sums = PlaneSums::default();
    for y in row * BLOCK..(row + 1) * BLOCK {
        for x in column * BLOCK..(column + 1) * BLOCK {
            let cell = grid.at(x, y);
            if cell.measured() {
                sums.add(cell);
            }
        }
    }
    if sums.count() < MEASURED.get() * (BLOCK * BLOCK) as f64 {
        return None;
    }
    let (_, rms) = sums.solve()?;
    (rms <= OF_BLOCK.get() * noise.deviation).then_some((sums, rms))
}

/// Grows a plane over neighbouring blocks.
fn grow(
    blocks: &[Option<(PlaneSums, f64)>],
    (columns, rows): (usize, usize),
    seed: usize,
    taken: &[bool],
    noise: &Noise,
    seen: &mut Marks,
) -> Option<(Vector3<f64>, List<usize>)> {
    let mut sums = blocks[seed]?.0;
    let (mut plane, _) = sums.solve()?;
    let mut members = List::new();
    members.push(seed);
    seen.next();
    seen.set(seed);
    let (mut next, mut solved_at) = (0, 1);
    while next < members.len() {
        let k = members[next];
        next += 1;
        let (column, row) = (k % columns, k / columns);
        let around = [
            (column > 0).then(|| k - 1),
            (column + 1 < columns).then_some(k + 1),
            (row > 0).then(|| k - columns),
            (row + 1 < rows).then_some(k + columns),
        ];
        for neighbour in around.into_iter().flatten() {
            if seen.has(neighbour) || taken[neighbour] {
                continue;
            }
            let Some((block, _)) = &blocks[neighbour] else { continue };
            // The mean square distance of the block from the plane, by its sums.
            let square =
                block.squares() - 2.0 * plane.dot(&block.vector()) + plane.dot(&(block.matrix() * plane));
            if square / block.count() <= (OF_BLOCK.get() * noise.deviation).powi(2) {
                seen.set(neighbour);
                members.push(neighbour);
                sums.join(block);
            }
        }
        if 2 * members.len() >= 3 * solved_at {
            plane = sums.solve()?.0;
            solved_at = members.len();
        }
    }
    Some((sums.solve()?.0, members))
}

/// The cells around a seed that a plane explains, and the plane fitted to them; `None` when they bend.
fn settle(
    grid: &Grid,
    noise: &Noise,
    mut plane: Vector3<f64>,
    (column, row): (usize, usize),
    owner: &[u16],
    seen: &mut Marks,
) -> Option<List<usize>> {
    let mut found = None;
    for _ in 0..2 {
        let cells = flood(grid, noise, &plane, (column, row), owner, seen);
        if cells.len() < FEWEST.count() {
            return None;
        }
        let moments = Moments::new(grid, &cells);
        let (fitted, spread) = moments.plane()?;
        plane = fitted;
        found = Some((cells, moments, spread));
    }
    let (cells, moments, spread) = found?;
    let width = width(&moments);
    if !(width >= NARROWEST.get()) {
        return None;
    }
    let most_spread = if width < WIDE.get() { SPREAD_OF_NARROW.get() } else { SPREAD.get() };
    if spread > most_spread * noise.deviation || bend(&moments)? > FLAT.get() * noise.deviation {
        return None;
    }
    // What cuts through a body goes on over the table that it meets as a thin line, which hides how the rest bends.
    let bend_of_core = bend(&Moments::new(grid, &core(grid, &cells)));
    // Where it cuts into a body that crosses this one, the few cells beside the strip hide that, too.
    let bends = [bend_of_core, bend_of_squares(grid, &moments, &cells)];
    bends.into_iter().flatten().all(|bend| bend <= FLAT.get() * noise.deviation).then_some(cells)
}

/// How far cells bend across their longer extent, as [`bend`]: the median of the squares into which they are cut along it.
/// `None` where these are fewer than three.
fn bend_of_squares(grid: &Grid, moments: &Moments, cells: &[usize]) -> Option<f64> {
    let extents = moments.covariance().symmetric_eigen();
    let variances = extents.eigenvalues;
    let (short, long) = if variances[0] < variances[1] { (0, 1) } else { (1, 0) };
    let squares = (variances[long] / variances[short]).sqrt() as usize;
    if squares < 3 {
        return None;
    }
    let [along, across] = [long, short].map(|k| extents.eigenvectors.column(k).into_owned());
    let middle = moments.on_plane(&moments.mean());
    let length = 2.0 * (3.0 * variances[long]).sqrt() * grid.spacing;
    let square_of = |&k: &usize| {
        let cell = &grid.cells[k];
        let part = along.dot(&(Vector2::new(cell.x, cell.y) - middle)) / length + 0.5;
        // Below zero is the first.
        ((part * squares as f64) as usize).min(squares - 1)
    };
    let of_cells: List<usize> = cells.iter().map(square_of).collect();
    let mut own = List::with_capacity(cells.len());
    let bend = |square: usize| {
        own.clear();
        own.extend(cells.iter().zip(&of_cells).filter(|(_, of)| **of == square).map(|(&k, _)| k));
        let moments = Moments::new(grid, &own);
        Some(bend_along(&curvature(&moments)?, &moments.covariance(), &across))
    };
    let mut bends: List<f64> = (0..squares).filter_map(bend).collect();
    Some(median(&mut bends).abs())
}

fn flood(
    grid: &Grid,
    noise: &Noise,
    plane: &Vector3<f64>,
    (column, row): (usize, usize),
    owner: &[u16],
    seen: &mut Marks,
) -> List<usize> {
    let near = |k: usize| {
        let cell = &grid.cells[k];
        owner[k] == 0
            && cell.measured()
            && (plane.dot(&Vector3::new(1.0, cell.x, cell.y)) - cell.w).abs() <= REACH.get() * noise.deviation
    };
    seen.next();
    let mut cells = List::new();
    for y in row * BLOCK..(row + 1) * BLOCK {
        for x in column * BLOCK..(column + 1) * BLOCK {
            let k = y * grid.columns + x;
            if near(k) {
                seen.set(k);
                cells.push(k);
            }
        }
    }
    let mut next = 0;
    while next < cells.len() {
        let k = cells[next];
        next += 1;
        for neighbour in grid.neighbours(k) {
            if seen.set(neighbour) && near(neighbour) {
                cells.push(neighbour);
            }
        }
    }
    cells
}

/// The cells of blocks of which more than half belong to them.
fn core(grid: &Grid, cells: &[usize]) -> List<usize> {
    let columns = grid.columns.div_ceil(BLOCK);
    // Divisions of 32 bits take less; there are fewer cells.
    let (width, side) = (grid.columns as u32, BLOCK as u32);
    let block = |&k: &usize| {
        let k = k as u32;
        (k / width / side) as usize * columns + (k % width / side) as usize
    };
    let blocks: List<usize> = cells.iter().map(block).collect();
    let mut counts = List::filled(0_usize, columns * grid.rows.div_ceil(BLOCK));
    blocks.iter().for_each(|&block| counts[block] += 1);
    let inner = cells.iter().zip(&blocks).filter(|(_, block)| 2 * counts[**block] > BLOCK * BLOCK);
    inner.map(|(&k, _)| k).collect()
}

/// The width of cells, in cells: that of a uniform stretch is 2 √3 standard deviations. NaN where rounding leaves a negative
/// variance.
fn width(moments: &Moments) -> f64 {
    (12.0 * moments.covariance().symmetric_eigenvalues().min()).sqrt()
}

/// How far a quadratic surface through cells bends off its plane over their extent, in w, across their shorter extent or along the
/// longer, whichever is more. `None` for too few cells.
fn bend(moments: &Moments) -> Option<f64> {
    let curvature = curvature(moments)?;
    let covariance = moments.covariance();
    let axes = covariance.symmetric_eigen().eigenvectors;
    let bends = [0, 1].map(|k| bend_along(&curvature, &covariance, &axes.column(k).into()).abs());
    Some(bends[0].max(bends[1]))
}

/// The same along a direction, with its sign: the curvature times half of the square of half the extent.
fn bend_along(curvature: &Matrix2<f64>, covariance: &Matrix2<f64>, direction: &Vector2<f64>) -> f64 {
    // Half the extent of a uniform stretch is √3 standard deviations.
    1.5 * direction.dot(&(covariance * direction)) * direction.dot(&(curvature * direction))
}

/// The second derivatives of the quadratic surface through cells; `None` for too few of them.
fn curvature(moments: &Moments) -> Option<Matrix2<f64>> {
    let (matrix, vector) = moments.equations();
    let surface = matrix.cholesky()?.solve(&vector);
    Some(Matrix2::new(surface[3], surface[4], surface[4], surface[5]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::grid::Cell;

    /// A strip, 13 by 200 cells, of a surface that bends across it, and beside its middle a patch of cells on its plane: where that cuts
    /// into another body.
    #[test]
    fn a_patch_beside_a_strip_does_not_hide_how_that_bends() {
        let (columns, rows, spacing) = (60, 200, 0.005);
        let cell = |k: usize| {
            let (column, row) = (k % columns, k / columns);
            let across = (column as f64 - 6.0) / 6.5;
            let beside = (16..60).contains(&column) && (90..105).contains(&row);
            // It bends by 3 between its middle and its sides, from -1 to 2.
            let w = if column < 13 { 2.0 - 3.0 * across * across } else { 0.0 };
            let seen = column < 13 || beside;
            let (x, y) = (spacing * column as f64, spacing * row as f64);
            (seen, Cell { x, y, w, point: Vector3::zeros(), sigma: 0.0, fill: 1.0 })
        };
        let (seen, cells): (Vec<bool>, Vec<Cell>) = (0..columns * rows).map(cell).unzip();
        let bounds = Default::default();
        let grid = Grid {
            columns,
            rows,
            side: 3,
            spacing,
            cells,
            rays: Default::default(),
            bounds,
            inner: Vec::new(),
        };
        let whole: Vec<usize> = (0..columns * rows).filter(|&k| seen[k]).collect();
        let strip: Vec<usize> = whole.iter().copied().filter(|k| k % columns < 13).collect();
        let moments = |cells: &[usize]| Moments::new(&grid, cells);
        assert!(bend(&moments(&strip)).unwrap() > 2.5);
        assert!(bend(&moments(&whole)).unwrap() < FLAT.get());
        let of_squares = bend_of_squares(&grid, &moments(&whole), &whole).unwrap();
        assert!((2.5..3.5).contains(&of_squares), "{of_squares}");
        assert_eq!(bend_of_squares(&grid, &moments(&strip[..13 * 30]), &strip[..13 * 30]), None);
    }
}
