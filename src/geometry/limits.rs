//! Limits that a cylinder keeps while it is optimised: an interval of radii, and a cone of axis directions.
//!
//! With the direction written as Exp_a(w), the direction at the angle ‖w‖ from the middle a of the cone, the limits
//! are an interval for the radius and a disc for w: a convex set. A step minimises the quadratic model of the cost
//! over that set, so that a minimum on the border is found there, and not by cutting off one outside.

use super::chart::{LocalFrame, Tangent, TangentMap};
use super::cylinder::Cylinder;
use super::line::Line;
use super::motion::RigidMotion;
use super::rotation::{any_orthogonal, rotate_direction};
use crate::error::{Error, Result, not_negative};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::f64::consts::FRAC_PI_2;

/// The directions within an angle of a given one, whatever their sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCone {
    /// The middle of the cone, of any length but 0.
    pub direction: Vector3<f64>,
    /// The largest angle from the middle, in radians from 0 to π/2; 0 for a direction that is known.
    pub max_angle: f64,
}

impl AxisCone {
    /// The middle of the cone, of unit length.
    #[must_use]
    pub fn middle(&self) -> Vector3<f64> {
        self.direction.normalize()
    }

    /// The angle of an axis direction of unit length from the middle of the cone.
    fn angle(&self, direction: &Vector3<f64>) -> f64 {
        let line = |direction| Line { point: Vector3::zeros(), direction };
        line(self.middle()).angle(&line(*direction))
    }

    /// Whether an axis direction of unit length lies in the cone.
    #[must_use]
    pub fn contains(&self, direction: &Vector3<f64>) -> bool {
        // Every direction is within π/2, whatever rounding says.
        self.max_angle >= FRAC_PI_2 || self.angle(direction) <= self.max_angle
    }

    /// The direction of the cone nearest to one of unit length, of the same sign.
    #[must_use]
    pub fn nearest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        if self.contains(direction) {
            return *direction;
        }
        let chart = ConeChart::new(self, direction);
        chart.direction(self, &(chart.position * (self.max_angle / chart.position.norm())))
    }

    /// The direction Exp_a(w) for w in some fixed basis across the middle a. What lies outside by rounding is moved
    /// inside.
    #[must_use]
    pub fn direction_at(&self, w: &Vector2<f64>) -> Vector3<f64> {
        ConeChart::new(self, &self.middle()).direction(self, w)
    }
}

/// Limits of the radius and of the direction of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderLimits {
    /// The smallest radius, in the unit of length of the data; 0 for no limit.
    pub radius_min: f64,
    /// The largest radius, in the unit of length of the data; infinity for no limit. Equal to the smallest one it
    /// fixes the radius.
    pub radius_max: f64,
    /// The directions that the axis may have; `None` for all.
    pub axis: Option<AxisCone>,
}

impl Default for CylinderLimits {
    fn default() -> Self {
        Self { radius_min: 0.0, radius_max: f64::INFINITY, axis: None }
    }
}

/// The largest limit of a radius: its square and those of its ratios to any length stay numbers.
const LARGEST_LIMIT: f64 = 1e100;

/// An axis this near to the border of its cone is on it, as a part of the angle of the cone. The steps put it there
/// to rounding.
const ON_BORDER: f64 = 1e-9;

/// The same in radians, for cones as narrow as the rounding of a direction.
const DIRECTION_ROUNDING: f64 = 1e-15;

impl CylinderLimits {
    /// Checks every value.
    ///
    /// # Errors
    /// `InvalidArgument` that names the limit, its value and what it must be.
    pub fn check(&self) -> Result<()> {
        let Self { radius_min, radius_max, axis } = *self;
        not_negative("radius_min", radius_min)?;
        if !(radius_max > 0.0 && radius_max >= radius_min) {
            let requirement = format!("be greater than 0 and at least radius_min, {radius_min}");
            return Err(Error::argument("radius_max", radius_max, requirement));
        }
        let finite = [("radius_min", radius_min), ("radius_max", radius_max)];
        if let Some((name, limit)) =
            finite.into_iter().find(|(_, limit)| limit.is_finite() && *limit > LARGEST_LIMIT)
        {
            let requirement =
                format!("be at most {LARGEST_LIMIT:e}; without radius_max there is no upper limit");
            return Err(Error::argument(name, limit, requirement));
        }
        let Some(AxisCone { direction, max_angle }) = axis else { return Ok(()) };
        let norm = direction.norm();
        if !(norm > 0.0 && norm.is_finite()) {
            let given = format!("{:?}", direction.as_slice());
            let what = if norm == 0.0 { "not be zero" } else { "have a finite length" };
            let requirement = format!("{what}; leave it at its default for any direction");
            return Err(Error::argument("axis", given, requirement));
        }
        if !(0.0..=FRAC_PI_2).contains(&max_angle) {
            let requirement = "lie in [0, pi/2]: give radians";
            return Err(Error::argument("axis_max_angle", max_angle, requirement));
        }
        Ok(())
    }

    /// These limits for cylinders that are moved: the cone of the axis turns with them.
    #[must_use]
    pub fn moved(&self, by: &RigidMotion) -> Self {
        let moved = |cone: AxisCone| AxisCone { direction: by.direction(&cone.direction), ..cone };
        Self { axis: self.axis.map(moved), ..*self }
    }

    /// Wider limits: the radii times two factors, the cone by an angle. Where these were more than limits may be, the same.
    #[must_use]
    pub(crate) fn widened(&self, [least, most]: [f64; 2], angle: f64) -> Self {
        let wider = |cone: AxisCone| AxisCone { max_angle: (cone.max_angle + angle).min(FRAC_PI_2), ..cone };
        let limits = Self {
            radius_min: least * self.radius_min,
            radius_max: most * self.radius_max,
            axis: self.axis.map(wider),
        };
        if limits.check().is_ok() { limits } else { *self }
    }

    /// The cone that limits the axis; `None` where every direction lies in it.
    #[must_use]
    pub fn cone(&self) -> Option<&AxisCone> {
        self.axis.as_ref().filter(|cone| cone.max_angle < FRAC_PI_2)
    }

    /// Whether the radius has any limit.
    #[must_use]
    pub fn limit_radius(&self) -> bool {
        self.radius_min > 0.0 || self.radius_max < f64::INFINITY
    }

    /// Whether nothing is limited.
    #[must_use]
    pub fn is_none(&self) -> bool {
        !self.limit_radius() && self.cone().is_none()
    }

    /// Whether the limits leave one radius only.
    #[must_use]
    pub fn fix_radius(&self) -> bool {
        self.radius_min == self.radius_max
    }

    /// Whether the limits leave one direction only.
    #[must_use]
    pub fn fix_axis(&self) -> bool {
        self.cone().is_some_and(|cone| cone.max_angle == 0.0)
    }

    /// Whether a cylinder keeps the limits.
    #[must_use]
    pub fn contain(&self, cylinder: &Cylinder) -> bool {
        (self.radius_min..=self.radius_max).contains(&cylinder.radius)
            && self.cone().is_none_or(|cone| cone.contains(&cylinder.axis.direction))
    }

    /// Whether a limit holds the radius of a cylinder: it is at one end of an interval.
    #[must_use]
    pub fn hold_radius(&self, cylinder: &Cylinder) -> bool {
        let at_end = cylinder.radius == self.radius_min || cylinder.radius == self.radius_max;
        self.limit_radius() && !self.fix_radius() && at_end
    }

    /// Whether a limit holds the axis of a cylinder: it is on the border of a cone with more than one direction.
    #[must_use]
    pub fn hold_axis(&self, cylinder: &Cylinder) -> bool {
        // Without the barrier the compiler compares the angle before it looks whether there is a cone, which is no error
        // but is one to Valgrind.
        if std::hint::black_box(self.axis.is_none()) {
            return false;
        }
        self.cone().is_some_and(|cone| {
            let slack = (ON_BORDER * cone.max_angle).max(DIRECTION_ROUNDING);
            cone.max_angle > 0.0 && cone.angle(&cylinder.axis.direction) >= cone.max_angle - slack
        })
    }

    /// The cylinder moved into the limits: its direction turned about the axis point nearest to the middle of the
    /// data, and its axis moved as much as its radius changes, so that the surface stays where it faces the data.
    #[must_use]
    pub fn nearest(&self, cylinder: &Cylinder, data_center: &Vector3<f64>) -> Cylinder {
        if self.contain(cylinder) {
            return *cylinder;
        }
        let point = cylinder.axis.nearest_to(data_center);
        let direction = cylinder.axis.direction;
        let direction = self.cone().map_or(direction, |cone| cone.nearest(&direction));
        let radius = cylinder.radius.clamp(self.radius_min, self.radius_max);
        let mut axis = Line { point, direction };
        let away = point - data_center;
        let distance = away.norm();
        if radius != cylinder.radius && distance > 0.0 {
            axis.point += away * ((radius - cylinder.radius) / distance);
        }
        Cylinder { axis, radius }
    }

    /// The minimum within the limits of the model gᵀδ + ½ δᵀHδ of a cost about the cylinder of a frame, which keeps
    /// the limits: the step in the tangent of the frame, and the cylinder there. `None` when H is not positive
    /// definite.
    #[must_use]
    pub fn step(
        &self,
        frame: &LocalFrame,
        hessian: &TangentMap,
        gradient: &Tangent,
    ) -> Option<(Tangent, Cylinder)> {
        if self.is_none() {
            let delta = -hessian.cholesky()?.solve(gradient);
            return Some((delta, frame.retract(&delta)));
        }
        let direction = frame.cylinder.axis.direction;
        let chart = self.cone().map(|cone| (cone, ConeChart::new(cone, &direction)));
        let map = chart.as_ref().map_or(TangentMap::identity(), |(_, chart)| chart.tangent_map(frame));
        let model = Model { hessian: map.transpose() * hessian * map, gradient: map.transpose() * gradient };
        let disc = chart.as_ref().map(|(cone, chart)| (chart.position, cone.max_angle));

        let from = frame.cylinder.radius;
        let with_radius = |radius: f64| {
            Some((model.with_fixed(4, (radius - from) / frame.unit).minimum_in_disc(disc)?, radius))
        };
        let (delta, radius) = if self.fix_radius() {
            with_radius(self.radius_min)?
        } else {
            // The model is convex: where its minimum without a limit of the radius lies beyond one, that with the
            // limit lies on it.
            let free = model.minimum_in_disc(disc)?;
            match from + free[4] * frame.unit {
                radius if radius > self.radius_max => with_radius(self.radius_max)?,
                radius if radius < self.radius_min && self.radius_min > 0.0 => with_radius(self.radius_min)?,
                radius => (free, radius),
            }
        };
        let direction = chart.as_ref().map_or_else(
            || frame.retract(&delta).axis.direction,
            |(cone, chart)| chart.direction(cone, &(chart.position + delta.fixed_rows::<2>(2))),
        );
        let point = frame.cylinder.axis.point + (frame.u * delta[0] + frame.v * delta[1]) * frame.unit;
        Some((map * delta, Cylinder { axis: Line { point, direction }, radius }))
    }

    /// What is left of a gradient at a cylinder that keeps the limits when nothing may leave them: 0 at a minimum
    /// within the limits. In the tangent of the frame, or for a cone in that of Exp_a(w).
    #[must_use]
    pub fn free_gradient(&self, frame: &LocalFrame, gradient: &Tangent) -> Tangent {
        let mut free = *gradient;
        let radius = frame.cylinder.radius;
        let held =
            (radius == self.radius_min && free[4] > 0.0) || (radius == self.radius_max && free[4] < 0.0);
        if held || self.fix_radius() {
            free[4] = 0.0;
        }
        let Some(cone) = self.cone() else { return free };
        let chart = ConeChart::new(cone, &frame.cylinder.axis.direction);
        free = chart.tangent_map(frame).transpose() * free;
        if cone.max_angle == 0.0 {
            free.fixed_rows_mut::<2>(2).fill(0.0);
        } else if self.hold_axis(&frame.cylinder) {
            let outward = chart.position.normalize();
            let along = free.fixed_rows::<2>(2).dot(&outward);
            if along < 0.0 {
                let rest = free.fixed_rows::<2>(2) - outward * along;
                free.fixed_rows_mut::<2>(2).copy_from(&rest);
            }
        }
        free
    }
}

/// The coordinates w of a direction about the middle a of a cone.
struct ConeChart {
    middle: Vector3<f64>,
    /// Two directions across the middle.
    basis: [Vector3<f64>; 2],
    /// w of the direction that the chart was made for.
    position: Vector2<f64>,
    /// −1 when that direction is opposite to the cone, else 1.
    sign: f64,
}

impl ConeChart {
    fn new(cone: &AxisCone, direction: &Vector3<f64>) -> Self {
        let middle = cone.middle();
        let (first, second) = any_orthogonal(&middle);
        let cosine = middle.dot(direction);
        let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
        let across = Vector2::new(first.dot(direction), second.dot(direction)) * sign;
        let sine = across.norm();
        let position = if sine > 0.0 { across * (sine.atan2(cosine.abs()) / sine) } else { Vector2::zeros() };
        Self { middle, basis: [first, second], position, sign }
    }

    /// The direction at w, of the sign of the chart and in the cone to the last bit.
    fn direction(&self, cone: &AxisCone, w: &Vector2<f64>) -> Vector3<f64> {
        let mut w = *w;
        let mut inward = f64::EPSILON;
        while cone.max_angle > 0.0 && inward < 1.0 {
            let tangent = self.basis[0] * w.x + self.basis[1] * w.y;
            let direction = rotate_direction(&self.middle, &tangent);
            if cone.contains(&direction) {
                return direction * self.sign;
            }
            w *= 1.0 - inward;
            inward *= 2.0;
        }
        self.middle * self.sign
    }

    /// The derivative of the tangent of a frame, whose direction is that of the chart, in (shift, w, radius).
    fn tangent_map(&self, frame: &LocalFrame) -> TangentMap {
        let angle = self.position.norm();
        let (sin, cos) = angle.sin_cos();
        let outward = if angle > 0.0 { self.position / angle } else { Vector2::x() };
        let sideways = Vector2::new(-outward.y, outward.x);
        let in_space = |w: &Vector2<f64>| self.basis[0] * w.x + self.basis[1] * w.y;
        // Along the great circle through the middle, and along the circle around it, which is shorter by sin x / x.
        let along = (in_space(&outward) * cos - self.middle * sin) * self.sign;
        let around = in_space(&sideways) * (self.sign * if angle > 0.0 { sin / angle } else { 1.0 });
        let tilts = Matrix2::new(
            along.dot(&frame.u),
            around.dot(&frame.u),
            along.dot(&frame.v),
            around.dot(&frame.v),
        ) * Matrix2::new(outward.x, outward.y, sideways.x, sideways.y);
        let mut map = TangentMap::identity();
        map.fixed_view_mut::<2, 2>(2, 2).copy_from(&tilts);
        map
    }
}

/// gᵀδ + ½ δᵀHδ.
struct Model {
    hessian: TangentMap,
    gradient: Tangent,
}

impl Model {
    /// The model of the other unknowns when one has a given value.
    fn with_fixed(&self, index: usize, value: f64) -> Self {
        let Self { mut hessian, mut gradient } = *self;
        gradient += hessian.column(index) * value;
        hessian.column_mut(index).fill(0.0);
        hessian.row_mut(index).fill(0.0);
        // An equation of its own, with the value as its solution.
        hessian[(index, index)] = 1.0;
        gradient[index] = -value;
        Self { hessian, gradient }
    }

    /// The minimum where the unknowns 2 and 3, added to a position, lie in a disc of the given radius.
    fn minimum_in_disc(&self, disc: Option<(Vector2<f64>, f64)>) -> Option<Tangent> {
        let with_both = |delta: Vector2<f64>| self.with_fixed(2, delta.x).with_fixed(3, delta.y).minimum();
        match disc {
            None => self.minimum(),
            Some((position, 0.0)) => with_both(-position),
            Some((position, radius)) => {
                let inverse = self.hessian.cholesky()?.inverse();
                let free = -(inverse * self.gradient);
                let target = position + free.fixed_rows::<2>(2);
                if !free.iter().all(|x| x.is_finite()) {
                    return None;
                }
                if target.norm() <= radius {
                    return Some(free);
                }
                // The other unknowns eliminated.
                let reduced = inverse.fixed_view::<2, 2>(2, 2).into_owned().try_inverse()?;
                with_both(nearest_in_disc(&reduced, &target, radius)? - position)
            }
        }
    }

    fn minimum(&self) -> Option<Tangent> {
        Some(-self.hessian.cholesky()?.solve(&self.gradient))
            .filter(|delta| delta.iter().all(|x| x.is_finite()))
    }
}

/// The point y of a disc that minimises (y − t)ᵀS(y − t) for a target t outside: (S + μ) y = S t with the multiplier
/// μ > 0 for which y lies on the circle.
fn nearest_in_disc(matrix: &Matrix2<f64>, target: &Vector2<f64>, radius: f64) -> Option<Vector2<f64>> {
    /// Newton's method for 1/‖y‖ climbs to the multiplier from below, in a handful of steps.
    const MOST_STEPS: usize = 60;
    let eigen = ((matrix + matrix.transpose()) * 0.5).symmetric_eigen();
    let values = eigen.eigenvalues;
    if !(values.min() > 0.0 && values.max().is_finite()) {
        return None;
    }
    let load = (eigen.eigenvectors.transpose() * target).component_mul(&values);
    let at = |multiplier: f64| load.component_div(&values.add_scalar(multiplier));
    let mut multiplier = 0.0;
    for _ in 0..MOST_STEPS {
        let y = at(multiplier);
        let norm = y.norm();
        let slope = -y.component_mul(&y).component_div(&values.add_scalar(multiplier)).sum() / norm;
        let step = (norm - radius) / radius * (norm / -slope);
        if !(step > 4.0 * f64::EPSILON * multiplier) {
            break;
        }
        multiplier += step;
    }
    let y = eigen.eigenvectors * at(multiplier);
    Some(y * (radius / y.norm()))
}

#[cfg(test)]
mod tests;
