//! What speaks for a cylinder and against it: other surfaces, its limbs, and what is seen where it should be.

use super::candidate::{Candidate, Look, Marks, Scene, Sides};
use super::distances::{self, LANES, Sight};
use super::grid::Grid;
use super::outline::{Beyond, DRAWN_OUT, Side};
use super::planes::PlaneSums;
use super::rays::Band;
use super::score::{MOST, ONE_LIMB};
use super::surface::{REACH, Surface, middle, slope};
use crate::geometry::{Cylinder, any_orthogonal};
use crate::memory::List;
use crate::statistics::{min_max, ordered_single};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// What depth and image say about one candidate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evidence {
    /// Logarithm of the likelihood ratio of the cylinder and nothing at all, less the penalty for its five numbers.
    pub gain: f64,
    /// How much better than the best plane, in the same measure.
    pub over_plane: f64,
    /// How much better than two planes that meet along the axis.
    pub over_edge: f64,
    /// How much better than the best sphere.
    pub over_sphere: f64,
    /// How much better than the best cone, which counts where that tapers.
    pub over_cone: f64,
    /// The part of the lines along the axis at whose side the surface goes on smoothly instead of ending at the limb.
    pub open_sides: f64,
    /// The part of the cells within the outline that lie off the surface, but not in a recess of it, nor far in front of it.
    pub seen_through: f64,
    /// Independent samples of the sides.
    pub side_samples: f64,
    /// What the cells cover across the axis, in radii from −1 to 1: where they begin and end.
    pub across: [f64; 2],
    /// How far cells lie beyond the limbs, in pixels.
    pub overhang: f64,
    /// What they cover along it, in radii.
    pub length: f64,
    /// The root mean square distance in standard deviations.
    pub rms: f64,
    /// The part of each limb that edges of the image cover; without an image, `None`.
    pub limbs: Option<[f64; 2]>,
    /// The part of the lines at whose either side nothing hides the limb.
    pub visible: [f64; 2],
    /// Standard deviation of the radius by a fit, as a part of it: infinite where the data do not tell; `None` before a
    /// fit.
    pub radius_deviation: Option<f64>,
    /// The taper of the best cone: change of radius over the length, by the radius.
    pub taper: f64,
    /// By how much the radius seems to grow along the axis, and the standard deviation of that: by the depth, after a fit by both limbs
    /// where they were located; `None` where nothing tells.
    pub slope: Option<[f64; 2]>,
    /// The radius in pixels.
    pub radius_pixels: f64,
    /// The standard deviation of the depth of a cell, as a part of the radius.
    pub scatter: f64,
}

constants! {
    /// Lids are wider than their cans by this part of the radius.
    LID = 0.04, "radius";

    /// What rays see is looked at within this part of the radius: nearer to the limbs depth is drawn to what lies beside them.
    SEEN_PART = 0.8, "radius";

    /// Edges along both sides of what has this radius in pixels or less may be those of a stripe on a smooth surface: filters of the depth
    /// smooth a step over half of it to either side of a limb.
    WIDEST_STRIPE = 2.0 * DRAWN_OUT.value, "px";

    /// Steps of the fits of other surfaces.
    STEPS = 6.0, "";

    /// What rays see is not looked at nearer to the ends.
    ENDS = 0.1, "length";

    /// A cell farther off the surface than this (or than a lid) counts as seen through. One more than `IN_FRONT` in front of it belongs to
    /// something else.
    OFF = 1.3 * REACH.value, "σ";
    IN_FRONT = 0.5, "radius";

    /// One that is no farther behind it than this is neither: keyways and grooves are as deep. They are told from depth that windows smear
    /// over a gap where the body has so many pixels of radius.
    RECESS = 0.25, "radius";
    WIDE_RECESS = 80.0, "px";
}

/// A ray that is met with a cylinder takes as long as so many visits.
const VISITS_OF_RAY: usize = 2;

impl Scene<'_> {
    /// By how much the radius of a candidate seems to grow along its axis: [`Evidence::slope`].
    pub fn slope(&self, candidate: &Candidate, mark: &mut Marks) -> Option<[f64; 2]> {
        let cells = &candidate.cells;
        let tangents = self.tangents(&candidate.surface, &candidate.cells, candidate.sides, mark);
        self.effort.spend(cells.len() + tangents.len());
        slope(&candidate.surface, (&self.grid.cells, cells), &tangents, self.optics)
    }

    /// What speaks for or against a candidate after a look at it, but for the slope, which only the score of a fit asks for. Where
    /// the score is below `least` whatever else is looked at, it is not looked at.
    pub fn judge(
        &self,
        candidate: &Candidate,
        look: &Look,
        least: f64,
        mark: &mut Marks,
    ) -> Option<Evidence> {
        let Surface::Cylinder(cylinder, _) = candidate.surface else { return None };
        if self.effort.is_spent() {
            return None;
        }
        let Look { misfits, across, range: [first, last], sides, support, .. } = look;
        if across.iter().any(|across| across.is_nan()) {
            return None;
        }
        let gain = self.gain_by(misfits) - self.penalty(&candidate.surface, candidate.cells.len());
        let mut evidence = Evidence { gain, ..Evidence::default() };
        let [mut left, mut right] = min_max(across);
        let squares: f64 = misfits.iter().map(|misfit| misfit.min(REACH.get() * REACH.get())).sum();
        evidence.rms = (squares / candidate.cells.len() as f64).sqrt();
        let depth = self.grid.cells[candidate.cells[candidate.cells.len() / 2]].point.z;
        // Where all surfaces bend the noise seems larger than it is, but cells lie near theirs.
        let deviation = evidence.rms.min(1.0) * self.noise.deviation * depth * depth;
        evidence.scatter = deviation / cylinder.radius;
        if cylinder.contains_origin() {
            // From inside, rays pass the axis at any distance; the turn of the wall tells how much of it is seen.
            let half = 0.5 * self.turn(candidate);
            (left, right) = (-half.sin(), half.sin());
        }
        evidence.length = (last - first) / cylinder.radius;
        evidence.across = [left, right];
        let pixels = cylinder.radius / (depth * self.optics.pixel);
        evidence.overhang = (left.abs().max(right.abs()) - 1.0).max(0.0) * pixels;
        evidence.radius_pixels = pixels;
        evidence.side_samples = sides.len() as f64 / self.noise.cells_per_sample.sqrt();
        // Where another body touches this one its surface does not go on.
        let touched = |side: &Side| side.beyond == Beyond::Smooth && self.valley(&cylinder, side);
        let touched: List<bool> = sides.iter().map(touched).collect();
        self.effort.spend(sides.len());
        // Nor does it where the image has an edge along the limb: filters of the depth smooth the step there. What is narrower
        // than such a step may be a stripe.
        let edges = support.as_ref().filter(|_| pixels > WIDEST_STRIPE.get());
        let on_edge = |side: &Side| edges.is_some_and(|edges| edges.covers(side.sign, &side.ray));
        let open = sides
            .iter()
            .zip(&touched)
            .filter(|(side, touched)| side.beyond == Beyond::Smooth && !**touched && !on_edge(side));
        evidence.open_sides = open.count() as f64 / sides.len().max(1) as f64;
        // With an image edges tell whether the limbs are seen.
        let by_depth = self.image.is_none();
        evidence.visible = [-1.0, 1.0].map(|sign| {
            let lines = sides.iter().zip(&touched).filter(|(side, _)| side.sign == sign);
            let (seen, all) = lines.fold((0.0, 0.0), |(seen, all), (side, touched)| {
                let to_its_end = side.limb().is_some() || by_depth && *touched;
                (seen + f64::from(u8::from(to_its_end)), all + 1.0)
            });
            seen / f64::max(all, 1.0)
        });
        evidence.limbs = self.image.map(|_| support.as_ref().map_or([0.0; 2], |support| support.covered));
        [evidence.over_plane, evidence.over_edge, evidence.over_sphere] = [f64::INFINITY; 3];
        // What is seen behind and every other surface only lower the score.
        if evidence.score() >= least {
            self.see_through(&cylinder, candidate, look.range, &mut evidence);
            // What the shape rules out as far as it can needs no other surface, which would take most of the time, unless edges
            // are along more than one limb.
            if evidence.shape() > -MOST.get() || evidence.limbs.is_some_and(|[a, b]| a + b > ONE_LIMB.get()) {
                let length = evidence.length * cylinder.radius;
                self.compare(candidate, across, length, least, &mut evidence, mark);
            }
        }
        // Half of the evidence is none.
        (!self.effort.is_spent()).then_some(evidence)
    }

    /// The angle by which the normals of the surface turn over the cells.
    fn turn(&self, candidate: &Candidate) -> f64 {
        let normals =
            || candidate.cells.iter().map(|&k| candidate.surface.project(&self.grid.cells[k].point).normal);
        let middle = normals().sum::<Vector3<f64>>();
        2.0 * normals().map(|normal| normal.angle(&middle)).fold(0.0, f64::max)
    }

    /// Plane, sphere and cone on the same cells, which lie `across` the axis, and on those that they would explain besides,
    /// until the score is below `least`.
    fn compare(
        &self,
        candidate: &Candidate,
        across: &[f64],
        length: f64,
        least: f64,
        evidence: &mut Evidence,
        mark: &mut Marks,
    ) {
        let cells = &candidate.cells;
        let Surface::Cylinder(cylinder, _) = candidate.surface else { return };
        // Edges of the image hold a radius that depth, which matching windows flatten, may not agree with. What the
        // others explain is compared with the cylinder that explains the depth best.
        let surface = match candidate.sides {
            Sides::Outline => None,
            Sides::Edges { .. } => self.refit(&candidate.surface, cells, Sides::Outline, mark),
        };
        let surface = surface
            .filter(|surface| self.gain(surface, cells) > self.gain(&candidate.surface, cells))
            .unwrap_or(candidate.surface);
        let own = self.gain(&surface, cells);
        let numbers = (cells.len() as f64 / self.noise.cells_per_sample).max(2.0).ln();
        // Three numbers of a plane, six of two and the position of the edge, five of a cylinder.
        evidence.over_plane = own - self.plane_gain(cells) - numbers;
        evidence.over_edge = own - self.edge_gain(across, cells) + numbers;
        if evidence.score() < least {
            return;
        }
        let fitted = |start: Surface| self.fit(&start, cells, &[], REACH.get(), STEPS.count());
        let mut margin = |other: &Surface| {
            let (other, _) = self.grow(other, cells, Sides::Outline, mark)?;
            mark.next();
            cells.iter().for_each(|&k| {
                mark.set(k);
            });
            let mut all = List::new();
            all.extend_from_slice(cells);
            all.extend(other.cells.iter().copied().filter(|&k| mark.set(k)));
            let difference = self.gain(&surface, &all) - self.gain(&other.surface, &all);
            let penalty = self.penalty(&other.surface, all.len()) - self.penalty(&surface, all.len());
            Some((difference + penalty, other.surface))
        };
        let middle = middle(&self.grid.cells, cells);
        let on_axis = cylinder.axis.nearest_to(&middle);
        let sphere = fitted(Surface::Sphere(on_axis, cylinder.radius));
        if let Some(sphere) = &sphere {
            // What it explains besides these cells is more evidence for it.
            let penalty = self.penalty(sphere, cells.len()) - self.penalty(&surface, cells.len());
            evidence.over_sphere = own - self.gain(sphere, cells) + penalty;
            if evidence.score() < least {
                return;
            }
        }
        evidence.over_sphere = sphere.and_then(|sphere| margin(&sphere)).map_or(own, |(margin, _)| margin);
        if evidence.score() < least {
            return;
        }
        let cone = fitted(Surface::Cone(cylinder, 0.0));
        if let Some((margin, Surface::Cone(cone, taper))) = cone.and_then(|cone| margin(&cone)) {
            evidence.taper = taper * length / cone.radius;
            evidence.over_cone = margin;
        }
    }

    /// The gain of the best two planes through cells that an edge along the axis divides.
    fn edge_gain(&self, across: &[f64], cells: &[usize]) -> f64 {
        // One number to compare: in its upper half where the cell is, which has 32 bits, in its lower half which one it is.
        let order =
            |(across, index): (&f64, u32)| u64::from(ordered_single(*across as f32)) << 32 | u64::from(index);
        let mut order: List<u64> = across.iter().zip(0..).map(order).collect();
        order.sort_unstable();
        let sorted: List<usize> = order.iter().map(|order| cells[*order as u32 as usize]).collect();
        // The sums of all before an edge are those of the edge before it, and some more.
        let all = self.plane_sums(&sorted);
        let (mut before, mut first) = (PlaneSums::default(), 0);
        (2..=6)
            .map(|eighths| {
                let edge = sorted.len() * eighths / 8;
                sorted[first..edge].iter().for_each(|&k| before.add(&self.grid.cells[k]));
                first = edge;
                let (left, right) = sorted.split_at(edge);
                self.gain_of_plane(&before, left) + self.gain_of_plane(&all.without(&before), right)
            })
            .fold(0.0, f64::max)
    }

    /// The gain of the plane through cells.
    fn plane_gain(&self, cells: &[usize]) -> f64 {
        self.gain_of_plane(&self.plane_sums(cells), cells)
    }

    fn plane_sums(&self, cells: &[usize]) -> PlaneSums {
        let mut sums = PlaneSums::default();
        cells.iter().for_each(|&k| sums.add(&self.grid.cells[k]));
        sums
    }

    /// The same with the sums over the cells.
    fn gain_of_plane(&self, sums: &PlaneSums, cells: &[usize]) -> f64 {
        self.effort.spend(cells.len());
        let Some(plane) = sums.plane() else { return 0.0 };
        let (a, b, c) = (plane.x, plane.y, plane.z);
        let per_variance = self.noise.deviation.powi(-2);
        let sum: f64 = cells
            .iter()
            .map(|&k| {
                let cell = &self.grid.cells[k];
                let residual = cell.w - (a + b * cell.x + c * cell.y);
                (REACH.get() * REACH.get() - residual * residual * per_variance).max(0.0)
            })
            .sum();
        0.5 * sum / self.noise.cells_per_sample
    }

    /// How many cells inside of the outline see something behind.
    fn see_through(
        &self,
        cylinder: &Cylinder,
        candidate: &Candidate,
        [first, last]: [f64; 2],
        evidence: &mut Evidence,
    ) {
        let grid = self.grid;
        let depth = grid.cells[candidate.cells[0]].point.z;
        let margin = (2.0 * cylinder.radius / (grid.spacing * depth)).min(grid.columns as f64) as usize;
        let (mut through, mut on) = (0.0, 0.0);
        let seen = Band::new(cylinder, SEEN_PART.get());
        let inset = ENDS.get() * (last - first);
        let recess =
            if evidence.radius_pixels >= WIDE_RECESS.get() { RECESS.get() * cylinder.radius } else { 0.0 };
        // The cells around the support, as far as the cylinder may reach.
        let [columns, rows] = grid.around(&candidate.cells, margin);
        let in_view = InView::of_piece(cylinder, [first + inset, last - inset]);
        let columns = grid.within(0, columns, in_view.low[0], in_view.high[0]);
        let rows = grid.within(1, rows, in_view.low[1], in_view.high[1]);
        self.effort.spend(VISITS_OF_RAY * rows.len() * columns.len());
        let (mut asked, mut sights) = (List::new(), List::new());
        Arch::new().dispatch(Within {
            grid,
            seen: &seen,
            in_view: &in_view,
            rows,
            columns,
            found: &mut asked,
        });
        let of_cylinder = (&candidate.surface, cylinder);
        distances::sights(of_cylinder, self.optics.pixel, &self.numbers, &asked, &mut sights);
        for Sight { behind, information, along } in sights.iter().copied() {
            if along < first + inset || along > last - inset {
                continue;
            }
            let tolerance = (OFF.get() / information.sqrt()).max(LID.get() * cylinder.radius);
            if behind > tolerance.max(recess)
                || behind < -tolerance && behind > -IN_FRONT.get() * cylinder.radius
            {
                through += 1.0;
            } else if behind.abs() <= tolerance {
                on += 1.0;
            }
        }
        evidence.seen_through = through / f64::max(through + on, 1.0);
    }
}

/// Where on the plane z = 1 a piece of a cylinder is seen, at most.
struct InView {
    low: [f64; 2],
    high: [f64; 2],
}

impl InView {
    /// Of the piece between two positions along the axis.
    fn of_piece(cylinder: &Cylinder, along: [f64; 2]) -> Self {
        let Cylinder { axis, radius } = cylinder;
        let (u, v) = any_orthogonal(&axis.direction);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        // The corners of a box around it: what is seen of it lies between them.
        for corner in 0..8 {
            let sign = |bit: u32| if corner >> bit & 1 == 0 { -radius } else { *radius };
            let point = axis.at(along[corner & 1]) + u * sign(1) + v * sign(2);
            if point.z <= 0.0 {
                return Self { low: [f64::NEG_INFINITY; 2], high: [f64::INFINITY; 2] };
            }
            for (k, coordinate) in [point.x / point.z, point.y / point.z].into_iter().enumerate() {
                (low[k], high[k]) = (low[k].min(coordinate), high[k].max(coordinate));
            }
        }
        Self { low, high }
    }

    #[inline(always)]
    fn contains(&self, x: f64, y: f64) -> bool {
        let Self { low, high } = self;
        // Without branches.
        (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
    }
}

/// The measured cells of some rows and columns whose rays pass within a band and a view.
struct Within<'a> {
    grid: &'a Grid,
    seen: &'a Band,
    in_view: &'a InView,
    rows: Range<usize>,
    columns: Range<usize>,
    found: &'a mut List<usize>,
}

impl WithSimd for Within<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "closures are not inlined for sure")]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { grid, seen, in_view, rows, columns, found } = self;
        for y in rows {
            let row = y * grid.columns + columns.start..y * grid.columns + columns.end;
            let [x, y] = [&grid.rays[0][row.clone()], &grid.rays[1][row.clone()]];
            for (some, (x, y)) in x.chunks(LANES).zip(y.chunks(LANES)).enumerate() {
                let mut within = [false; LANES];
                let mut any = false;
                for (within, (x, y)) in within.iter_mut().zip(x.iter().zip(y)) {
                    *within = (seen.excess(*x, *y, 1.0) < 0.0) & in_view.contains(*x, *y);
                    any |= *within;
                }
                // Most have none.
                if !any {
                    continue;
                }
                let first = row.start + some * LANES;
                for k in 0..x.len() {
                    if within[k] && grid.cells[first + k].measured() {
                        found.push(first + k);
                    }
                }
            }
        }
    }
}
