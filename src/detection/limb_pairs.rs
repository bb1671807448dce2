//! The image's say: which straight edges lie on the limbs of a cylinder, and cylinders by pairs of edges.

use super::candidate::Scene;
use super::edges::Edge;
use super::rays::passes;
use super::surface::{REACH, Tangent};
use crate::geometry::{Cylinder, LimbFrame, Line, rejection};
use crate::memory::List;
use nalgebra::{SMatrix, SVector, Vector2, Vector3};

constants! {
    /// How far an edge on a limb is from it in pixels: edges are found to a fraction of one, short ones less well.
    pub(super) ON_LIMB = 1.5, "px";

    /// Standard deviation of an edge from the limb, in pixels.
    EDGE_PIXELS = 0.7, "px";

    /// An edge is as good as one measurement in this many pixels.
    PIXELS_PER_TANGENT = 10.0, "px";

    /// Limbs converge by up to 15 degrees: its cosine.
    ALONG = 0.966, "";

    /// The least distance of two limbs in pixels.
    NARROWEST = 8.0, "px";

    /// Two edges must stand side by side over this part of their distance.
    SIDE_BY_SIDE = 0.35, "";

    /// The part of the width between two limbs whose depth is looked at: beyond it is drawn to what lies beside.
    INNER = 0.7, "";

    /// The shortest stretch in pixels over which two edges stand side by side.
    SHORTEST_OVERLAP = 8.0, "px";

    /// How far from an edge it is asked whether something beyond it stands in front, in cells, and by how much that is then nearer, in
    /// radii. Of equal cylinders side by side the next one is nearer by 1.8 sin α radii where their plane is aslant by α, and what
    /// is seen of one narrower than it by 1 − cos α: 4 % with half a radius.
    FROM_EDGE = 2.0, "cells";
    IN_FRONT = 0.5, "radius";

    /// Fewest cells between two edges.
    FEWEST = 8.0, "cells";

    /// Allowed ratio of the measured curvature of the depth between two limbs to that of a cylinder. Matching windows
    /// flatten the depth up to threefold.
    FLATTEST = 0.3, "";
    ROUNDEST = 1.7, "";

    /// The ratio may miss these bounds by so many of its deviations.
    CURVATURE_ERROR = 2.0, "σ";

    /// An edge may be as far from a limb as this part of its length and so many pixels more: a short one turns by less on a limb.
    OF_LENGTH = 0.2, "length";
    AND_PIXELS = 0.3, "px";

    /// How far cells may lie off the surface between two edges, in standard deviations and widths together.
    PROFILE_REACH = 4.0, "σ";
    PROFILE_OFF = 0.1, "width";

    /// The part of the cells that lie so near at least.
    ON_PROFILE = 2.0 / 3.0, "";
}

/// Pieces of the limb that edges cover or not.
const PIECES: usize = 32;

/// Pairs of edges, most of which are not parallel, that take as long as one visit.
const PAIRS_PER_VISIT: usize = 8;

/// The depth between two edges takes as long to look at as so many visits.
const VISITS_OF_PROFILE: usize = 200;

/// A ray on the plane z = 1.
fn image(p: &Vector3<f64>) -> Option<Vector2<f64>> {
    (p.z > 0.0).then(|| p.xy() / p.z)
}

/// The straight edges of an image.
#[derive(Debug, Clone, Default)]
pub(super) struct ImageEdges {
    pub edges: Vec<Edge>,
    lengths: Vec<f64>,
    /// The side of a pixel on the plane z = 1.
    pub pixel: f64,
}

/// The edges on the limbs of a cylinder.
#[derive(Debug, Clone, Default)]
pub(super) struct Support {
    /// The part of each limb that edges cover: at the negative and the positive side of [`passes`].
    pub covered: [f64; 2],
    /// How long that is, in pixels.
    pub length: f64,
    /// Rays along them.
    pub tangents: List<Tangent>,
    /// The limbs at these sides, and the pieces of each that edges cover.
    limbs: [Option<(Limb, u32)>; 2],
}

impl Support {
    /// Whether an edge covers the limb on a side, −1 or 1, next to a ray.
    pub fn covers(&self, sign: f64, ray: &Vector3<f64>) -> bool {
        let limb = self.limbs[usize::from(sign > 0.0)].as_ref();
        limb.is_some_and(|(limb, pieces)| limb.piece_at(&ray.xy()).is_some_and(|k| pieces >> k & 1 == 1))
    }
}

/// A limb of a cylinder on the plane z = 1.
#[derive(Debug, Clone)]
pub(super) struct Limb {
    pub start: Vector2<f64>,
    /// The directions along and across it, of length 1.
    along: Vector2<f64>,
    pub across: Vector2<f64>,
    length: f64,
    /// 0 at the negative side of [`passes`], 1 at the positive one.
    side: usize,
}

impl Limb {
    /// The piece of it next to a position; `None` where that lies before its start or beyond its end.
    fn piece_at(&self, position: &Vector2<f64>) -> Option<usize> {
        let t = (position - self.start).dot(&self.along) / self.length * PIECES as f64;
        (t >= 0.0 && t < PIECES as f64).then_some(t as usize)
    }

    /// The pieces of it that an edge runs along, one bit each; `None` where it lies before its start or beyond its end.
    pub fn pieces(&self, edge: &Edge) -> Option<u32> {
        let mut range = edge.ends.map(|p| (p - self.start).dot(&self.along) / self.length);
        range.sort_by(f64::total_cmp);
        if range[1] <= 0.0 || range[0] >= 1.0 {
            return None;
        }
        let piece = |t: f64| (t * PIECES as f64).round().clamp(0.0, PIECES as f64) as usize;
        Some((piece(range[0])..piece(range[1])).fold(0, |pieces, k| pieces | 1 << k))
    }
}

/// The part of a limb that is in some pieces of it.
pub(super) fn part(pieces: u32) -> f64 {
    f64::from(pieces.count_ones()) / PIECES as f64
}

/// A cylinder by two edges.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub cylinder: Cylinder,
    /// Cells between the edges.
    pub cells: List<usize>,
    /// How long the edges stand side by side, in pixels.
    pub length: f64,
}

impl ImageEdges {
    pub fn new(edges: Vec<Edge>, pixel: f64) -> Self {
        let lengths = edges.iter().map(Edge::length).collect();
        Self { edges, lengths, pixel }
    }

    /// The limbs of a cylinder between two positions along its axis.
    pub fn limbs(&self, cylinder: &Cylinder, [first, last]: [f64; 2]) -> Option<[Limb; 2]> {
        let of = |line: Line| {
            let at = |along: f64| image(&line.nearest_to(&cylinder.axis.at(along)));
            let (start, end) = (at(first)?, at(last)?);
            let side = usize::from(passes(cylinder, start.x, start.y)? > 0.0);
            let length = (end - start).norm();
            let along = (end - start) / length;
            let across = Vector2::new(-along.y, along.x);
            (length > self.pixel).then_some(Limb { start, along, across, length, side })
        };
        let [a, b] = LimbFrame::new(cylinder)?.limb_lines();
        Some([of(a)?, of(b)?])
    }

    /// The edges within `reach` pixels of the limbs of a cylinder between two positions along its axis.
    pub fn support(&self, cylinder: &Cylinder, range: [f64; 2], reach: f64) -> Option<Support> {
        let mut support = Support::default();
        for limb in self.limbs(cylinder, range)? {
            let mut pieces = 0_u32;
            for (edge, edge_length) in self.edges.iter().zip(&self.lengths) {
                let reach =
                    (reach * self.pixel).min(OF_LENGTH.get() * edge_length + AND_PIXELS.get() * self.pixel);
                if edge.ends.iter().any(|p| (p - limb.start).dot(&limb.across).abs() > reach) {
                    continue;
                }
                let Some(covered) = limb.pieces(edge) else { continue };
                pieces |= covered;
                let count = (edge_length / (PIXELS_PER_TANGENT.get() * self.pixel)).ceil().max(2.0);
                for k in 0..count as usize {
                    let p = edge.ends[0].lerp(&edge.ends[1], (k as f64 + 0.5) / count);
                    let ray = Vector3::new(p.x, p.y, 1.0);
                    support.tangents.push(Tangent {
                        ray,
                        inset: 0.0,
                        deviation: EDGE_PIXELS.get(),
                        weight: 1.0,
                    });
                }
            }
            let covered = part(pieces);
            support.covered[limb.side] = covered;
            support.length += covered * limb.length / self.pixel;
            let side = limb.side;
            support.limbs[side] = Some((limb, pieces));
        }
        Some(support)
    }
}

impl Scene<'_> {
    /// Cylinders by two edges of the image and the depth between them, with the cells there, best first.
    pub fn pairs(&self) -> Vec<Pair> {
        let mut found = Vec::new();
        let edges = self.image.map_or(&[][..], |(image, _)| &image.edges);
        let directions: Vec<_> = edges.iter().map(Edge::direction).collect();
        for (k, a) in edges.iter().enumerate() {
            // The edges come by their strength.
            self.effort.spend((edges.len() - k).div_ceil(PAIRS_PER_VISIT));
            if self.effort.is_spent() {
                break;
            }
            for (b, direction) in edges.iter().zip(&directions).skip(k + 1) {
                if directions[k].dot(direction).abs() >= ALONG.get() {
                    found.extend(self.pair(a, b));
                }
            }
        }
        found.sort_by(|a, b| b.length.total_cmp(&a.length));
        found
    }

    fn pair(&self, a: &Edge, b: &Edge) -> Option<Pair> {
        let pixel = self.optics.pixel;
        let (da, mut db) = (a.direction(), b.direction());
        if da.dot(&db) < 0.0 {
            db = -db;
        }
        let along = (da + db).normalize();
        let across = Vector2::new(-along.y, along.x);
        let range = |edge: &Edge| {
            let mut range = edge.ends.map(|p| p.dot(&along));
            range.sort_by(f64::total_cmp);
            range
        };
        let (ra, rb) = (range(a), range(b));
        let (low, high) = (ra[0].max(rb[0]), ra[1].min(rb[1]));
        let middle = 0.5 * (low + high);
        // Where each edge crosses the middle.
        let cross = |edge: &Edge, direction: &Vector2<f64>| {
            let m = edge.middle();
            m + direction * ((middle - m.dot(&along)) / direction.dot(&along))
        };
        let (pa, pb) = (cross(a, &da), cross(b, &db));
        let width = (pb - pa).dot(&across).abs();
        let length = high - low;
        if width < NARROWEST.get() * pixel
            || length < SHORTEST_OVERLAP.get() * pixel
            || length < SIDE_BY_SIDE.get() * width
        {
            return None;
        }
        let center = 0.5 * (pa + pb);
        let seed = self.cell_at(&center)?;
        if !self.open[seed] {
            return None;
        }
        self.effort.spend(VISITS_OF_PROFILE);
        let (fit, cells) = self.profile(&center, &along, &across, length, width)?;
        let w = fit[0];
        let ray = Vector3::new(center.x, center.y, 1.0);
        let near = ray / w;
        let radius = 0.5 * width / w;
        let outward = if (pb - pa).dot(&across) > 0.0 { across } else { -across };
        let sides = [[pa, da * length, -outward], [pb, db * length, outward]];
        if sides.into_iter().any(|side| self.hides(side, width, radius)) {
            return None;
        }
        let generator = Vector3::new(along.x, along.y, 0.0) / w - ray * (fit[2] / (0.5 * length) / (w * w));
        let direction = generator.normalize();
        let away = rejection(&near, &direction).normalize();
        let cylinder = Cylinder { axis: Line { point: near + away * radius, direction }, radius };
        Some(Pair { cylinder, cells, length: length / pixel })
    }

    /// Whether what lies beyond an edge stands in front of a body with this radius on its inner side: then the edge is not the limb
    /// of that body, but of what hides it. The edge goes through a point, `along` is as long as it is taken, and `outward`, of
    /// length 1, leads out of the body, which is `width` wide.
    pub fn hides(&self, [point, along, outward]: [Vector2<f64>; 3], width: f64, radius: f64) -> bool {
        let spacing = self.grid.spacing;
        let steps = (along.norm() / spacing).round().clamp(3.0, 24.0) as usize;
        let (mut nearer, mut all) = (0, 0);
        for step in 0..steps {
            let edge = point + along * ((step as f64 + 0.5) / steps as f64 - 0.5);
            let at = |distance: f64| {
                let k = self.cell_at(&(edge + outward * distance))?;
                Some(&self.grid.cells[k]).filter(|cell| cell.measured())
            };
            let Some(inner) = at(-(FROM_EDGE.get() * spacing).min(0.5 * width)) else { continue };
            all += 1;
            nearer += usize::from(at(FROM_EDGE.get() * spacing).is_some_and(|outer| {
                let step = inner.point.z - outer.point.z;
                step > IN_FRONT.get() * radius && step > REACH.get() * (inner.sigma + outer.sigma)
            }));
        }
        2 * nearer > all
    }

    /// The cell at a position on the plane z = 1.
    fn cell_at(&self, p: &Vector2<f64>) -> Option<usize> {
        let (grid, (_, pixel_of)) = (self.grid, self.image?);
        let (column, row) = pixel_of(p)?;
        let (column, row) = (column / grid.side, row / grid.side);
        (column < grid.columns && row < grid.rows).then(|| row * grid.columns + column)
    }

    /// The quadratic w = a + b s + c t + d s² over the cells between two limbs, with s across and t along from −1 to
    /// 1; `None` where they bend unlike a cylinder, or are few.
    fn profile(
        &self,
        center: &Vector2<f64>,
        along: &Vector2<f64>,
        across: &Vector2<f64>,
        length: f64,
        width: f64,
    ) -> Option<(SVector<f64, 4>, List<usize>)> {
        let spacing = self.grid.spacing;
        let steps = |size: f64| (size / spacing).round().clamp(3.0, 24.0) as usize;
        let (rows, columns) = (steps(length), steps(INNER.get() * width));
        let mut cells = List::with_capacity(rows * columns);
        let mut missing = 0;
        for row in 0..rows {
            for column in 0..columns {
                let t = (row as f64 + 0.5) / rows as f64 - 0.5;
                let s = (column as f64 + 0.5) / columns as f64 - 0.5;
                let p = center + along * (t * length) + across * (s * INNER.get() * width);
                match self.cell_at(&p) {
                    Some(k) if self.open[k] => cells.push(k),
                    _ => missing += 1,
                }
            }
        }
        cells.sort_unstable();
        cells.dedup();
        if cells.len() < FEWEST.count() || missing * 2 > rows * columns {
            return None;
        }
        let mut solution = SVector::<f64, 4>::zeros();
        let mut reach = f64::INFINITY;
        let mut uncertainty = 0.0;
        for _ in 0..3 {
            let mut matrix = SMatrix::<f64, 4, 4>::zeros();
            let mut vector = SVector::<f64, 4>::zeros();
            let mut residuals = List::with_capacity(cells.len());
            for &k in &cells {
                let cell = &self.grid.cells[k];
                let offset = Vector2::new(cell.x, cell.y) - center;
                let (s, t) = (offset.dot(across) / (0.5 * width), offset.dot(along) / (0.5 * length));
                let row = SVector::<f64, 4>::from([1.0, s, t, s * s]);
                let residual = cell.w - row.dot(&solution);
                residuals.push(residual.abs());
                if residual.abs() <= reach {
                    matrix += row * row.transpose();
                    vector += row * cell.w;
                }
            }
            if reach.is_finite() {
                let within = residuals.iter().filter(|&&r| r <= reach).count();
                if (within as f64) < ON_PROFILE.get() * cells.len() as f64 {
                    return None;
                }
            }
            let inverse = matrix.cholesky()?.inverse();
            solution = inverse * vector;
            uncertainty = self.noise.deviation * (self.noise.cells_per_sample * inverse[(3, 3)]).sqrt();
            reach = PROFILE_REACH.get() * self.noise.deviation + PROFILE_OFF.get() * width * solution[0];
        }
        if !(solution[0] > 0.0) {
            return None;
        }
        // z = z₀ + x² / (2 r) with x = z₀ s width / 2 and r = z₀ width / 2: w = w₀ (1 − s² width / 4).
        let expected = -0.25 * width * solution[0];
        let ratio = solution[3] / expected;
        let uncertain = CURVATURE_ERROR.get() * uncertainty / expected.abs();
        (ratio + uncertain >= FLATTEST.get() && ratio - uncertain <= ROUNDEST.get() && ratio > 0.0)
            .then_some((solution, cells))
    }
}
