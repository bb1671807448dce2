//! Cylinders, cones and spheres through cells: signed distances, and their fits by Gauss–Newton steps.

use super::grid::Cell;
use crate::geometry::{Cylinder, Line, any_orthogonal, rotate_direction};
use nalgebra::{SMatrix, SVector, Vector3};

/// Cells farther from a surface than this many standard deviations do not belong to it.
pub(super) const REACH: f64 = 3.0;

/// How far a cell may be off across the line of sight, in pixels: matching windows and mixed pixels move outlines.
const LATERAL_PIXELS: f64 = 0.5;

/// A surface of revolution about a line, or of a sphere.
#[derive(Debug, Clone, Copy)]
pub(super) enum Surface {
    /// A cylinder, and how far outside of its surface its limbs are measured: depth next to an outline is drawn to
    /// what lies beside it.
    Cylinder(Cylinder, f64),
    /// A cylinder whose radius grows along the axis by this much per length, from the point of the axis on.
    Cone(Cylinder, f64),
    /// Centre and radius.
    Sphere(Vector3<f64>, f64),
}

/// Where a point is relative to a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Signed distance, positive outside.
    pub distance: f64,
    /// The outward normal of the surface next to it.
    pub normal: Vector3<f64>,
    /// Position along the axis from its point.
    pub along: f64,
}

impl Surface {
    pub fn place(&self, p: &Vector3<f64>) -> Place {
        match self {
            Self::Cylinder(cylinder, _) => place_at_axis(cylinder, 0.0, p),
            Self::Cone(cylinder, taper) => place_at_axis(cylinder, *taper, p),
            Self::Sphere(center, radius) => {
                let offset = p - center;
                let norm = offset.norm().max(f64::MIN_POSITIVE);
                Place { distance: norm - radius, normal: offset / norm, along: 0.0 }
            }
        }
    }

    /// The numbers that a fit finds.
    pub fn parameters(&self) -> f64 {
        match self {
            Self::Cylinder(..) => 5.0,
            Self::Cone(..) => 6.0,
            Self::Sphere(..) => 4.0,
        }
    }

    /// Two directions across the axis, in which it shifts and tilts.
    fn across(&self) -> (Vector3<f64>, Vector3<f64>) {
        match self {
            Self::Cylinder(cylinder, _) | Self::Cone(cylinder, _) => any_orthogonal(&cylinder.axis.direction),
            Self::Sphere(..) => (Vector3::x(), Vector3::y()),
        }
    }

    /// The derivative of the distance by the parameters.
    fn gradient(&self, place: &Place, (u, v): (&Vector3<f64>, &Vector3<f64>)) -> SVector<f64, 6> {
        match self {
            Self::Cylinder(..) | Self::Cone(..) => {
                let (nu, nv) = (place.normal.dot(u), place.normal.dot(v));
                SVector::from([-nu, -nv, -nu * place.along, -nv * place.along, -1.0, -place.along])
            }
            Self::Sphere(..) => {
                let n = &place.normal;
                SVector::from([-n.x, -n.y, -n.z, -1.0, 0.0, 0.0])
            }
        }
    }

    fn step(&self, delta: &SVector<f64, 6>) -> Option<Self> {
        let moved = |cylinder: &Cylinder| {
            let Line { point, direction } = cylinder.axis;
            let (u, v) = any_orthogonal(&direction);
            let tilt = u * delta[2] + v * delta[3];
            // More than a radian at once is no step of an iteration that gets anywhere.
            (tilt.norm() < 1.0).then(|| Cylinder {
                axis: Line {
                    point: point + u * delta[0] + v * delta[1],
                    direction: rotate_direction(&direction, &tilt),
                },
                radius: (cylinder.radius + delta[4]).clamp(0.5 * cylinder.radius, 2.0 * cylinder.radius),
            })
        };
        match self {
            Self::Cylinder(cylinder, bias) => Some(Self::Cylinder(moved(cylinder)?, bias + delta[5])),
            Self::Cone(cylinder, taper) => Some(Self::Cone(moved(cylinder)?, taper + delta[5])),
            Self::Sphere(center, radius) => {
                let center = center + Vector3::new(delta[0], delta[1], delta[2]);
                Some(Self::Sphere(center, (radius + delta[3]).clamp(0.5 * radius, 2.0 * radius)))
            }
        }
    }

    /// The same surface with the point of its axis next to a point.
    pub fn at(&self, p: &Vector3<f64>) -> Self {
        let shifted = |cylinder: &Cylinder| {
            let Line { point, direction } = cylinder.axis;
            let along = (p - point).dot(&direction);
            (Line { point: point + direction * along, direction }, along)
        };
        match self {
            Self::Cylinder(cylinder, bias) => {
                Self::Cylinder(Cylinder { axis: shifted(cylinder).0, radius: cylinder.radius }, *bias)
            }
            Self::Cone(cylinder, taper) => {
                let (axis, along) = shifted(cylinder);
                Self::Cone(Cylinder { axis, radius: cylinder.radius + taper * along }, *taper)
            }
            Self::Sphere(..) => *self,
        }
    }

    pub fn radius(&self) -> f64 {
        match self {
            Self::Cylinder(cylinder, _) | Self::Cone(cylinder, _) => cylinder.radius,
            Self::Sphere(_, radius) => *radius,
        }
    }

    /// Whether the observer at the origin sees this wall at a point with this outward normal: from outside the near
    /// wall.
    pub fn faces(&self, p: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
        let inside = match self {
            Self::Cylinder(cylinder, _) | Self::Cone(cylinder, _) => cylinder.contains_origin(),
            Self::Sphere(center, radius) => center.norm() <= *radius,
        };
        (normal.dot(p) < 0.0) != inside
    }
}

fn place_at_axis(cylinder: &Cylinder, taper: f64, p: &Vector3<f64>) -> Place {
    let offset = p - cylinder.axis.point;
    let along = offset.dot(&cylinder.axis.direction);
    let across = offset - cylinder.axis.direction * along;
    let norm = across.norm().max(f64::MIN_POSITIVE);
    Place { distance: norm - cylinder.radius - taper * along, normal: across / norm, along }
}

/// A ray that touches a cylinder, beside a limb.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    pub ray: Vector3<f64>,
    /// How far inside of the limb it passes, in pixels.
    pub inset: f64,
    /// Standard deviation of that, in pixels.
    pub deviation: f64,
    /// As how many measurements it counts.
    pub weight: f64,
}

/// How the scene was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    /// The side of a pixel on the plane z = 1.
    pub pixel: f64,
    /// Cells that share one error.
    pub cells_per_sample: f64,
}

/// How far depth next to a limb is off across the line of sight, in pixels: matching windows of 7 to 11 pixels draw it
/// out by 2, mixed pixels of time of flight in by 1.
const BIAS_PIXELS: f64 = 2.5;

/// How far inside of the limb the outline of what is measured is, in pixels: time of flight reaches it, structured
/// light ends 0 to 3 pixels before it, as the surface turns away.
pub(super) const OUTLINE_SHIFT_PIXELS: f64 = 1.2;

/// Standard deviation of that, in pixels.
pub(super) const OUTLINE_PIXELS: f64 = 1.5;

impl Surface {
    /// How a bias at the limbs shows at a place: its sixth power of the position across, which vanishes in the middle,
    /// and is 0.1 at 0.7 radii.
    fn bias_shape(&self, place: &Place, ray: &Vector3<f64>) -> f64 {
        let Self::Cylinder(cylinder, _) = self else { return 0.0 };
        let d = &cylinder.axis.direction;
        let along = ray.dot(d);
        let flat = (ray.norm_squared() - along * along).max(f64::MIN_POSITIVE);
        let cosine = place.normal.dot(ray);
        (1.0 - cosine * cosine / flat).max(0.0).powi(3)
    }

    /// The place of a cell, its distance from where the surface is measured, the standard deviation of that, and the
    /// share of the bias in it.
    pub fn residual(&self, cell: &Cell, pixel: f64) -> (Place, f64, f64, f64) {
        let place = self.place(&cell.point);
        let ray = Vector3::new(cell.x, cell.y, 1.0);
        let along = place.normal.dot(&ray);
        let length = ray.norm_squared();
        let lateral = LATERAL_PIXELS * pixel * cell.point.z;
        let across = ((length - along * along) / length).max(0.0);
        let variance = along * along * cell.sigma * cell.sigma + lateral * lateral * across;
        let shape = self.bias_shape(&place, &ray);
        let bias = if let Self::Cylinder(_, bias) = self { *bias } else { 0.0 };
        (place, place.distance - bias * shape, variance.sqrt(), shape)
    }
}

/// By how much the radius of a cylinder seems to grow along its axis, and the standard deviation of that: one step from the
/// cylinder to the cone that explains cells and sides best, the bias at the limbs among the unknowns.
pub(super) fn slope(
    surface: &Surface,
    cells: &[&Cell],
    tangents: &[Tangent],
    optics: Optics,
) -> Option<[f64; 2]> {
    let mut center = Vector3::zeros();
    for cell in cells {
        center += cell.point / cells.len() as f64;
    }
    let surface = surface.at(&center);
    let Surface::Cylinder(cylinder, bias) = surface else { return None };
    let mut matrix = SMatrix::<f64, 7, 7>::zeros();
    let mut vector = SVector::<f64, 7>::zeros();
    let (u, v) = surface.across();
    let radius = cylinder.radius;
    let pixel = optics.pixel * center.z;
    let mut add = |place: &Place, distance: f64, sigma: f64, shape: f64, weight: f64| {
        let ratio = distance / (REACH * sigma);
        if ratio.abs() < 1.0 {
            let part = 1.0 - ratio * ratio;
            let weight = weight * part * part / (sigma * sigma);
            let own = surface.gradient(place, (&u, &v));
            // Tilts and slopes in radii: all numbers are lengths.
            let along = [own[2], own[3], -place.along].map(|row| row / radius);
            let row = SVector::from([own[0], own[1], along[0], along[1], own[4], -shape, along[2]]);
            matrix += row * row.transpose() * weight;
            vector += row * (weight * distance);
        }
    };
    for cell in cells {
        let (place, distance, sigma, shape) = surface.residual(cell, optics.pixel);
        add(&place, distance, sigma, shape, 1.0 / optics.cells_per_sample);
    }
    for Tangent { ray, inset, deviation, weight } in tangents {
        let place = surface.place(&(ray * cylinder.axis.nearest_on_ray(ray)));
        add(&place, place.distance + inset * pixel, deviation * pixel, 0.0, *weight);
    }
    let sigma = BIAS_PIXELS * pixel;
    matrix[(5, 5)] += 1.0 / (sigma * sigma);
    vector[5] += bias / (sigma * sigma);
    let inverse = matrix.cholesky()?.inverse();
    let step = -(inverse * vector);
    Some([step[6] / radius, inverse[(6, 6)].sqrt() / radius])
}

/// Fits a surface to cells from a start. Cells beyond `reach` standard deviations do not count; `reach` shrinks to
/// [`REACH`] within the steps.
pub(super) fn fit(
    start: &Surface,
    cells: &[&Cell],
    tangents: &[Tangent],
    optics: Optics,
    mut reach: f64,
    steps: usize,
) -> Option<Surface> {
    let mut center = Vector3::zeros();
    for cell in cells {
        center += cell.point / cells.len() as f64;
    }
    let mut surface = start.at(&center);
    for _ in 0..steps {
        if !(surface.radius() > 0.0 && surface.radius().is_finite()) {
            return None;
        }
        let mut matrix = SMatrix::<f64, 6, 6>::zeros();
        let mut vector = SVector::<f64, 6>::zeros();
        let mut count = 0;
        let (u, v) = surface.across();
        for cell in cells {
            let (place, distance, sigma, shape) = surface.residual(cell, optics.pixel);
            let ratio = distance / sigma;
            if ratio.abs() > reach {
                continue;
            }
            count += 1;
            // Tukey's weight: what is nearly out counts little.
            let part = 1.0 - (ratio / reach).powi(2);
            let weight = part * part / (sigma * sigma * optics.cells_per_sample);
            let mut row = surface.gradient(&place, (&u, &v));
            if matches!(surface, Surface::Cylinder(..)) {
                row[5] = -shape;
            }
            for i in 0..6 {
                for j in 0..=i {
                    matrix[(i, j)] += weight * row[i] * row[j];
                }
            }
            vector += row * (weight * distance);
        }
        if count < 8 {
            return None;
        }
        let mut parameters = surface.parameters() as usize;
        if let Surface::Cylinder(cylinder, bias) = surface {
            for Tangent { ray, inset, deviation, weight } in tangents {
                let place = surface.place(&(ray * cylinder.axis.nearest_on_ray(ray)));
                let distance = place.distance + inset * optics.pixel * center.z;
                let sigma = deviation * optics.pixel * center.z;
                let ratio = distance / sigma;
                if ratio.abs() > reach {
                    continue;
                }
                let part = 1.0 - (ratio / reach).powi(2);
                let weight = weight * part * part / (sigma * sigma);
                let mut row = surface.gradient(&place, (&u, &v));
                row[5] = 0.0;
                for i in 0..6 {
                    for j in 0..=i {
                        matrix[(i, j)] += weight * row[i] * row[j];
                    }
                }
                vector += row * (weight * distance);
            }
            let sigma = BIAS_PIXELS * optics.pixel * center.z;
            matrix[(5, 5)] += 1.0 / (sigma * sigma);
            vector[5] += bias / (sigma * sigma);
            parameters = 6;
        }
        let radius = surface.radius();
        for i in 0..6 {
            for j in 0..i {
                matrix[(j, i)] = matrix[(i, j)];
            }
            if i >= parameters {
                matrix.row_mut(i).fill(0.0);
                matrix.column_mut(i).fill(0.0);
                vector[i] = 0.0;
                matrix[(i, i)] = 1.0;
            }
        }
        // Nearly undetermined combinations stay: a ten-thousandth of what the best determined one is.
        let scale = matrix[(4, 4)].max(matrix[(0, 0)]) * 1e-4;
        for i in 0..parameters {
            let lever = if matches!(surface, Surface::Sphere(..))
                || !(matches!(i, 2 | 3) || i == 5 && matches!(surface, Surface::Cone(..)))
            {
                1.0
            } else {
                radius * radius
            };
            matrix[(i, i)] += scale * lever;
        }
        let delta = matrix.cholesky()?.solve(&-vector);
        let moved = surface.step(&delta)?;
        let change = (moved.radius() - surface.radius()).abs() / radius;
        surface = moved;
        let settled = reach <= REACH && change < 1e-4;
        reach = (0.5 * reach).max(REACH);
        if settled {
            break;
        }
    }
    surface.radius().is_finite().then_some(surface)
}
