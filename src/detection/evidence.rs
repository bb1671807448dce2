//! What speaks for a cylinder and against it: other surfaces, its limbs, and what is seen where it should be.

use super::candidate::{Candidate, Marks, Scene, Sides};
use super::grid::Cell;
use super::limb_pairs::ON_LIMB;
use super::outline::{Beyond, outline, passes};
use super::surface::{REACH, Surface, slope};
use crate::geometry::Cylinder;
use nalgebra::Vector3;

/// What the depth says about one candidate.
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
    /// The part of the lines at whose side something farther away is seen next to the limb.
    pub closed_sides: f64,
    /// The part of the cells within the outline that lie off the surface, but not far in front of it.
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
    /// How far inside of either limb the outline of the cells is, less what sensors do, in standard deviations.
    pub insets: [f64; 2],
    /// Standard deviation of the radius by a fit, as a part of it: infinite where the data do not tell; `None` before a
    /// fit.
    pub radius_deviation: Option<f64>,
    /// The taper of the best cone: change of radius over the length, by the radius.
    pub taper: f64,
    /// By how much the radius seems to grow along the axis, and the standard deviation of that, by the depth; `None` where it
    /// does not tell, and with an image, where limbs do.
    pub slope: Option<[f64; 2]>,
    /// The radius in pixels.
    pub radius_pixels: f64,
}

/// The radius of a cone must change by this part over what is seen of it to be told from a cylinder: cups taper by
/// more, and depth next to outlines bends a short cylinder by nearly as much.
const TAPERED: f64 = 0.2;

/// The sides of a cylinder tell as much as this many independent samples at most.
const MOST_SAMPLES: f64 = 8.0;

/// The least slope of the side of a cup or a cone: 1.7 degrees.
const SLOPE: f64 = 0.03;

/// Evidence that a slope of the side takes away: of the cylinders in rendered scenes one in ten seems to have a slope
/// of 0.06 or more, of cones and other bodies that passed for one, three in four.
const SLANT: f64 = 50.0;

/// Slopes of less than this are none.
const LEAST_SLOPE: f64 = 0.02;

/// The parts of both limbs together that edges cover where the limbs are known to be straight and parallel.
const BOTH_LIMBS: f64 = 1.2;

/// Lids are wider than their cans by this part of the radius.
const LID: f64 = 0.04;

/// A cone is a rarer body than a cylinder, and what depth does next to outlines looks like one: logarithm of the odds.
const CONE_PRIOR: f64 = 3.0;

/// Evidence that is left where nothing lies beyond the limbs, and where three pixels do is none.
const OVERHANG: f64 = 10.0;

/// More evidence than this tells nothing more: what is left is what no model here knows.
const MOST: f64 = 4.0;

/// Cylinders longer than this many radii are no more certain for it.
const LONG: f64 = 6.0;

/// Evidence of the shape with which a candidate need not be looked at any more.
const HOPELESS: f64 = -4.0;

/// What each kind of evidence counts in the logarithm of the odds.
struct Weights {
    depth: f64,
    shape: f64,
    rms: f64,
    length: f64,
    seen_through: f64,
    limbs: f64,
    deviation: f64,
    constant: f64,
}

/// Weights by logistic regression on the candidates in ../shared/scenes and in 157 scenes of the twin, which count half
/// and have a constant of their own: depth alone, before a fit. Cylinders are rarer among the candidates of the twin; the
/// constant is that of ../shared/scenes with an image, and that of the twin by depth alone, to which boxes look like
/// cylinders.
const DEPTH: Weights = Weights {
    depth: 0.61,
    shape: 0.63,
    rms: -3.8,
    length: 0.49,
    seen_through: -0.82,
    limbs: 0.0,
    deviation: 0.0,
    constant: -0.23,
};

/// Depth alone, after a fit: the weights of [`Evidence::terms_of_depth`], by a logistic regression on the candidates in 150
/// scenes of the twin.
const DEPTH_FITTED: [f64; 10] = [0.415, -2.62, 0.301, -3.12, -0.786, -1.34, -13.9, 0.118, 2.58, 0.435];

/// What the regression adds to these terms.
const DEPTH_FITTED_CONSTANT: f64 = -3.65;

/// Depth and image, before a fit.
const IMAGE: Weights = Weights {
    depth: 0.74,
    shape: 0.7,
    rms: -4.53,
    length: 0.46,
    seen_through: -0.87,
    limbs: 2.31,
    deviation: 0.0,
    constant: -0.51,
};

/// Depth and image, after a fit.
const IMAGE_FITTED: Weights = Weights {
    depth: 0.55,
    shape: 0.59,
    rms: -3.86,
    length: 0.41,
    seen_through: -0.9,
    limbs: 1.78,
    deviation: -0.85,
    constant: -3.42,
};

/// Odds, standard deviations of a slope and slopes beyond these tell nothing more.
const MOST_ODDS: f64 = 1e4;
const MOST_DEVIATIONS: f64 = 6.0;
const STEEP: f64 = 0.3;

/// A fit multiplies the odds of a cylinder by less than this: of 540 in those scenes it did by more for one.
const MOST_BY_FIT: f64 = 9.0;

/// Standard deviations of a radius, as a part of it, that count: better is luck, worse tells nothing more.
const DEVIATIONS: [f64; 2] = [5e-4, 0.3];

/// The least score before a fit that the fit may raise to a given one.
pub(crate) fn least_before_fit(score: f64) -> f64 {
    score / (score + (1.0 - score) * MOST_BY_FIT)
}

/// A ray that is met with a cylinder takes as long as so many visits.
const VISITS_OF_RAY: usize = 2;

impl Evidence {
    /// The probability that there is a cylinder.
    #[must_use]
    pub fn score(&self) -> f64 {
        if let (None, Some(deviation)) = (self.limbs, self.radius_deviation) {
            let terms = self.terms_of_depth(deviation);
            let logit = DEPTH_FITTED_CONSTANT
                + DEPTH_FITTED.iter().zip(terms).map(|(weight, term)| weight * term).sum::<f64>();
            return 1.0 / (1.0 + (-logit).exp());
        }
        let weights = match (self.limbs, self.radius_deviation) {
            (None, _) => DEPTH,
            (Some(_), None) => IMAGE,
            (Some(_), Some(_)) => IMAGE_FITTED,
        };
        let [least, most] = DEVIATIONS;
        let logit = weights.depth * self.depth()
            + weights.shape * self.shape()
            + weights.rms * self.rms
            + weights.length * self.length.min(LONG)
            + weights.seen_through * self.seen_through * self.side_samples.min(MOST_SAMPLES)
            + weights.limbs * self.limbs.map_or(0.0, |[a, b]| a + b)
            + weights.deviation * self.radius_deviation.unwrap_or(most).clamp(least, most).ln()
            + weights.constant;
        1.0 / (1.0 + (-logit).exp())
    }

    /// What the score by depth alone is made of after a fit with this standard deviation of the radius: shape, root mean
    /// square distance, length, what is seen through, logarithm of that deviation, the slope of the radius in standard
    /// deviations and as it is, the evidence against a sphere, the part of a side that is visible, the radius in pixels.
    #[must_use]
    pub fn terms_of_depth(&self, deviation: f64) -> [f64; 10] {
        let [least, most] = DEVIATIONS;
        let [slope, uncertainty] = self.slope.unwrap_or([0.0, f64::INFINITY]).map(f64::abs);
        let sphere = self.over_sphere.clamp(-MOST_ODDS, MOST_ODDS);
        [
            self.shape(),
            self.rms,
            self.length.min(LONG),
            self.seen_through * self.side_samples.min(MOST_SAMPLES),
            deviation.clamp(least, most).ln(),
            (slope / uncertainty).min(MOST_DEVIATIONS),
            slope.min(STEEP),
            sphere.signum() * sphere.abs().ln_1p(),
            self.visible[0].max(self.visible[1]),
            self.radius_pixels.max(1.0).ln(),
        ]
    }

    /// The evidence of the depth that something is round: the logarithm of the odds against nothing, a plane, and two
    /// planes that meet, whichever is least.
    fn depth(&self) -> f64 {
        self.gain.min(self.over_plane).min(self.over_edge).clamp(-MOST, MOST)
    }

    /// The evidence that it is no sphere, no cone, and nothing that goes on beyond its sides, likewise. Straight limbs
    /// in an image say the same.
    fn shape(&self) -> f64 {
        // Along a contact with another body, or a long straight side, neighbouring lines end in the same way.
        let samples = self.side_samples.min(MOST_SAMPLES);
        // One side in twenty of a cylinder, but three in five of an edge seem to go on smoothly; the logarithms of the
        // likelihood ratios are ln(0.95 / 0.4) and ln(0.05 / 0.6).
        let sides = samples * (0.87 * (1.0 - self.open_sides) - 2.48 * self.open_sides);
        // Likewise one cell in twenty, or one in three.
        let through = self.side_samples * (0.35 * (1.0 - self.seen_through) - 2.2 * self.seen_through);
        // Depth that drifts over a long pipe tapers it as well, but not by a degree or two.
        let tapers = self.taper.abs() > TAPERED && self.taper.abs() > SLOPE * self.length;
        let cone = if tapers { self.over_cone + CONE_PRIOR } else { f64::INFINITY };
        // Depth next to outlines tapers a short cylinder too, but rarely by as much as a cup.
        let slope = self.taper.abs() / self.length.max(f64::MIN_POSITIVE);
        // Edges along both limbs of a cylinder are along none of a cone.
        let straight = self.limbs.is_some_and(|[a, b]| a + b > BOTH_LIMBS);
        let slant = if straight { MOST } else { MOST - SLANT * (slope - LEAST_SLOPE) };
        // Less than half of the width tells little of a circle; from inside the whole wall may be seen.
        let covered = 12.0 * (self.across[1] - self.across[0] - 0.8);
        // Cells beyond the limbs: fattening makes two pixels of them, an edge that is taken for a thin cylinder more.
        let overhang = OVERHANG - 3.0 * self.overhang;
        [covered, overhang, self.over_sphere, cone, slant, sides, through]
            .into_iter()
            .fold(f64::INFINITY, f64::min)
            .clamp(-MOST, MOST)
    }
}

impl Scene<'_> {
    /// By how much the radius of a candidate seems to grow along its axis: [`Evidence::slope`].
    pub fn slope(&self, candidate: &Candidate, mark: &mut Marks) -> Option<[f64; 2]> {
        let cells: Vec<&Cell> = candidate.cells.iter().map(|&k| &self.grid.cells[k]).collect();
        let tangents = self.tangents(&candidate.surface, &candidate.cells, candidate.sides, mark);
        self.effort.spend(cells.len() + tangents.len());
        slope(&candidate.surface, &cells, &tangents, self.optics)
    }

    /// What speaks for or against a candidate, but for the slope, which only the score of a fit asks for.
    pub fn judge(&self, candidate: &Candidate, mark: &mut Marks) -> Option<Evidence> {
        let Surface::Cylinder(cylinder, _) = candidate.surface else { return None };
        if self.effort.is_spent() {
            return None;
        }
        let gain = self.gain(&candidate.surface, &candidate.cells)
            - self.penalty(&candidate.surface, candidate.cells.len());
        let mut evidence = Evidence { gain, ..Evidence::default() };
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut squares = 0.0;
        let misfit = self.misfit(&candidate.surface);
        for &k in &candidate.cells {
            let cell = &self.grid.cells[k];
            let across = passes(&cylinder, cell.x, cell.y)?;
            let along = candidate.surface.place(&cell.point).along;
            (first, last) = (first.min(along), last.max(along));
            (left, right) = (left.min(across), right.max(across));
            squares += misfit(cell).min(REACH * REACH);
        }
        if cylinder.contains_origin() {
            // From inside, rays pass the axis at any distance; the turn of the wall tells how much of it is seen.
            let half = 0.5 * self.turn(candidate);
            (left, right) = (-half.sin(), half.sin());
        }
        evidence.rms = (squares / candidate.cells.len() as f64).sqrt();
        evidence.length = (last - first) / cylinder.radius;
        evidence.across = [left, right];
        let depth = self.grid.cells[candidate.cells[candidate.cells.len() / 2]].point.z;
        let pixels = cylinder.radius / (depth * self.optics.pixel);
        evidence.overhang = (left.abs().max(right.abs()) - 1.0).max(0.0) * pixels;
        evidence.radius_pixels = pixels;
        self.effort.spend(candidate.cells.len());
        let sides = outline(self, &cylinder, &candidate.cells, mark);
        let part = |beyond: Beyond| {
            sides.iter().filter(|side| side.beyond == beyond).count() as f64 / sides.len().max(1) as f64
        };
        evidence.side_samples = sides.len() as f64 / self.noise.cells_per_sample.sqrt();
        evidence.open_sides = part(Beyond::Smooth);
        evidence.closed_sides = part(Beyond::Farther);
        evidence.insets = self.insets(&cylinder, &sides);
        evidence.visible = [-1.0, 1.0].map(|sign| {
            let lines = sides.iter().filter(|side| side.sign == sign);
            let (seen, all) = lines.fold((0.0, 0.0), |(seen, all), side| {
                (seen + f64::from(u8::from(side.limb().is_some())), all + 1.0)
            });
            seen / f64::max(all, 1.0)
        });
        evidence.limbs =
            self.image.map(|_| self.support(&cylinder, [first, last], ON_LIMB).unwrap_or_default().covered);
        self.see_through(&cylinder, candidate, [first, last], &mut evidence);
        // What the sides rule out needs no other surface, which would take most of the time.
        [evidence.over_plane, evidence.over_edge, evidence.over_sphere] = [f64::INFINITY; 3];
        if evidence.shape() > HOPELESS || evidence.limbs.is_some_and(|[a, b]| a + b > 1.0) {
            self.compare(candidate, evidence.length * cylinder.radius, &mut evidence, mark);
        }
        // Half of the evidence is none.
        (!self.effort.is_spent()).then_some(evidence)
    }

    /// The angle by which the normals of the surface turn over the cells.
    fn turn(&self, candidate: &Candidate) -> f64 {
        let normals =
            || candidate.cells.iter().map(|&k| candidate.surface.place(&self.grid.cells[k].point).normal);
        let middle = normals().sum::<Vector3<f64>>();
        2.0 * normals().map(|normal| normal.angle(&middle)).fold(0.0, f64::max)
    }

    /// Plane, sphere and cone on the same cells and on those that they would explain besides.
    fn compare(&self, candidate: &Candidate, length: f64, evidence: &mut Evidence, mark: &mut Marks) {
        let cells = &candidate.cells;
        let refs: Vec<_> = cells.iter().map(|&k| &self.grid.cells[k]).collect();
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
        // Three numbers of a plane, six of two and the place of the edge, five of a cylinder.
        evidence.over_plane = own - self.plane_gain(cells) - numbers;
        evidence.over_edge = own - self.edge_gain(&cylinder, cells) + numbers;
        let free = |k: usize| self.planes[k] == 0;
        let mut margin = |start: Surface| {
            let other = self.fit(&start, &refs, &[], REACH, 6)?;
            let other = self.grow(&other, cells, Sides::Outline, &free, mark)?;
            mark.next();
            cells.iter().for_each(|&k| {
                mark.set(k);
            });
            let mut all = cells.clone();
            all.extend(other.cells.iter().copied().filter(|&k| mark.set(k)));
            let difference = self.gain(&surface, &all) - self.gain(&other.surface, &all);
            let penalty = self.penalty(&other.surface, all.len()) - self.penalty(&surface, all.len());
            Some((difference + penalty, other.surface))
        };
        let mut middle = Vector3::zeros();
        for cell in &refs {
            middle += cell.point / refs.len() as f64;
        }
        let on_axis = cylinder.axis.point
            + cylinder.axis.direction * (middle - cylinder.axis.point).dot(&cylinder.axis.direction);
        evidence.over_sphere =
            margin(Surface::Sphere(on_axis, cylinder.radius)).map_or(own, |(margin, _)| margin);
        if let Some((margin, Surface::Cone(cone, taper))) = margin(Surface::Cone(cylinder, 0.0)) {
            evidence.taper = taper * length / cone.radius;
            evidence.over_cone = margin;
        }
    }

    /// The gain of the best two planes through cells that an edge along the axis divides.
    fn edge_gain(&self, cylinder: &Cylinder, cells: &[usize]) -> f64 {
        let mut order: Vec<(f64, usize)> = cells
            .iter()
            .map(|&k| {
                let cell = &self.grid.cells[k];
                (passes(cylinder, cell.x, cell.y).unwrap_or(0.0), k)
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sorted: Vec<usize> = order.into_iter().map(|(_, k)| k).collect();
        (2..=6)
            .map(|eighths| {
                let (left, right) = sorted.split_at(sorted.len() * eighths / 8);
                self.plane_gain(left) + self.plane_gain(right)
            })
            .fold(0.0, f64::max)
    }

    /// The gain of the plane through cells.
    fn plane_gain(&self, cells: &[usize]) -> f64 {
        self.effort.spend(cells.len());
        let mut matrix = nalgebra::Matrix3::zeros();
        let mut vector = Vector3::zeros();
        for &k in cells {
            let cell = &self.grid.cells[k];
            let row = Vector3::new(1.0, cell.x, cell.y);
            matrix += row * row.transpose();
            vector += row * cell.w;
        }
        let Some(cholesky) = matrix.cholesky() else { return 0.0 };
        let plane = cholesky.solve(&vector);
        let sum: f64 = cells
            .iter()
            .map(|&k| {
                let cell = &self.grid.cells[k];
                let residual = cell.w - plane.dot(&Vector3::new(1.0, cell.x, cell.y));
                (REACH * REACH - (residual / self.noise.deviation).powi(2)).max(0.0)
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
        // The cells around the support, as far as the cylinder may reach.
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for &k in &candidate.cells {
            let (x, y) = (k % grid.columns, k / grid.columns);
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        let depth = grid.cells[candidate.cells[0]].point.z;
        let margin = (2.0 * cylinder.radius / (grid.spacing * depth)).min(grid.columns as f64) as usize;
        let (mut through, mut on) = (0.0, 0.0);
        let inset = 0.1 * (last - first);
        let rows = low[1].saturating_sub(margin)..(high[1] + margin + 1).min(grid.rows);
        let columns = low[0].saturating_sub(margin)..(high[0] + margin + 1).min(grid.columns);
        self.effort.spend(VISITS_OF_RAY * rows.len() * columns.len());
        for y in rows {
            for x in columns.clone() {
                let cell = grid.at(x, y);
                if !cell.measured() {
                    continue;
                }
                let ray = Vector3::new(cell.x, cell.y, 1.0);
                if !passes(cylinder, cell.x, cell.y).is_some_and(|across| across.abs() <= 0.8) {
                    continue;
                }
                let Some(hit) = cylinder.first_hit(&ray) else { continue };
                let along = (hit - cylinder.axis.point).dot(&cylinder.axis.direction);
                if along < first + inset || along > last - inset {
                    continue;
                }
                let normal = candidate.surface.place(&hit).normal;
                let (_, _, variance) =
                    candidate.surface.residual(&Cell { point: hit, ..*cell }, self.optics.pixel);
                let behind = (cell.point.z - hit.z) * normal.dot(&ray).abs();
                let tolerance = (1.3 * REACH * variance.sqrt()).max(LID * cylinder.radius);
                if behind > tolerance || behind < -tolerance && behind > -0.5 * cylinder.radius {
                    through += 1.0;
                } else if behind.abs() <= tolerance {
                    on += 1.0;
                }
            }
        }
        evidence.seen_through = through / f64::max(through + on, 1.0);
    }
}
