//! What is said about a cylinder: costs, warnings, residuals, and what the data determine.

use super::constraints::Constraints;
use super::data::{self, Data};
use super::options::StartKind;
use super::result::{FitResult, Flags, Seconds};
use super::scales::Scales;
use super::start::Candidate;
use super::taper::Taper;
use super::uncertainty::{DISAGREEMENT, ImageShift, MASK_DISAGREEMENT, RadiusComparison, Uncertainty};
use crate::error::{Error, Result};
use crate::geometry::{Cylinder, LocalFrame, Tangent};
use crate::memory::List;
use crate::noise::LARGEST_DEPTH_NOISE;
use crate::observations::{Dropped, PointCloud};
use crate::residuals::{NormalEquations, Objective, Sum};
use crate::solver::{Convergence, LeastSquares, Rank, Termination};
use nalgebra::Vector3;

/// A radius is called weak when its standard deviation would be more than this part of it, even if the noise
/// of all points were independent.
const WEAK_RADIUS: f64 = 0.05;

/// The input resolution, as a part of the radius, from which on digits are missing.
const COARSE: f64 = 1e-4;

/// The scale of the points, in standard deviations of their noise where the caller told it, from which on they do not lie
/// on the surface.
const TOLD_DEVIATIONS: f64 = 3.0;

/// The same as a part of the radius where no camera tells how far away the points are. About a marker of 8 mm, the
/// thinnest of 745 cylinders, good points scatter by 0.24 of it.
const POOR_PART: f64 = 0.25;

/// Which residuals to list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResidualKind {
    /// Signed distance of every used point of the selected view from the surface, in the unit of length.
    Points,
    /// Signed distance of every endpoint of the usable segments of the selected view from its limb line, in pixels.
    Edges,
}

/// What the data determine at a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diagnosis {
    /// Rank, condition and singular values of the Jacobian, in units of the size of the data.
    pub rank: Rank,
    /// How the step along which the residuals change least moves the axis at the middle of the points, in the unit of
    /// length.
    pub weakest_shift: Vector3<f64>,
    /// How that step tilts the axis, in radians towards this vector.
    pub weakest_tilt: Vector3<f64>,
    /// How that step changes the radius, in the unit of length.
    pub weakest_radius: f64,
}

/// Rank, condition and the weakest direction of the stacked Jacobian at a cylinder.
pub(super) fn diagnose(data: &Data<'_>, constraints: &Constraints, cylinder: &Cylinder) -> Result<Diagnosis> {
    let rows = data.rows(constraints, cylinder).ok_or_else(infinite_cost)?;
    let rank = LeastSquares::new(&rows)?.rank()?;
    let LocalFrame { u, v, unit, .. } = data.frame(cylinder);
    let weakest = rank.weakest;
    Ok(Diagnosis {
        rank,
        weakest_shift: (u * weakest[0] + v * weakest[1]) * unit,
        weakest_tilt: u * weakest[2] + v * weakest[3],
        weakest_radius: weakest[4] * unit,
    })
}

/// Everything about a cylinder, found by a fit or given, but how it was reached. `scales` are those at the cylinder where
/// they are known.
pub(super) fn describe(
    data: &Data<'_>,
    constraints: &Constraints,
    start: &Candidate,
    cylinder: &Cylinder,
    scales: Option<&Scales>,
) -> Result<FitResult> {
    let own;
    let scales = match scales {
        Some(scales) => scales,
        None => {
            own = data.scales(cylinder);
            &own
        }
    };
    // For the direction that the result shows.
    let frame = data.frame(&data.canonical(cylinder));
    let objective = data.objective(constraints, cylinder, scales);
    let equations = objective.linearise(&frame).ok_or_else(infinite_cost)?;
    let squared = data.unit * data.unit;
    let count = data.count();
    let (walls, energy_points) = data.walls_and_energy(&frame.cylinder);
    let walls = data.near_wall().then_some(walls);
    let (frame, objective, equations) = (&frame, &objective, &equations);
    let described = Described { data, constraints, cylinder, scales, frame, objective, equations };
    let stated = described.stated();
    let mut flags = described.warnings(&stated);
    flags.set(Flags::HIDDEN_WALL, walls.is_some_and(|walls| walls.fraction() < 0.5));
    let dropped = dropped(data);
    flags.set(Flags::POINTS_NOT_FINITE, dropped.not_finite > 0);
    let gradient_norm = data.options.cylinder_limits.free_gradient(frame, &equations.gradient).norm();
    if !gradient_norm.is_finite() {
        return Err(Error::Numerical { what: "the gradient at the cylinder" });
    }
    Ok(FitResult {
        cylinder: data.canonical(cylinder),
        uncertainty: stated.uncertainty,
        radii: stated.radii,
        shift: stated.shift,
        taper: stated.taper,
        start: start.cylinder.with_canonical_direction(),
        start_kind: start.kind,
        termination: None,
        iterations: 0,
        rejected_steps: 0,
        initial_cost: equations.cost * squared,
        cost: equations.cost * squared,
        energy_points,
        energy_edges: energy_of_edges(data, constraints, cylinder),
        edge_weight: data.options.has_edge_weight().then_some(constraints.edge_weight),
        points_used: count,
        points_given: clouds(data).map(PointCloud::given).sum(),
        dropped,
        segments_used: constraints.segments_used(),
        segments_given: data.views.iter().map(|view| view.view.segments.len()).sum(),
        limbs_located: constraints.limbs_located(),
        point_rms: energy_points.sqrt(),
        point_scale: if count > 0 { scales.all } else { 0.0 },
        independent_points: independent_points(data, scales),
        edge_rms_pixels: edge_rms_pixels(data, cylinder).filter(|_| !flags.contains(Flags::EDGES_IGNORED)),
        near_wall_fraction: walls.map(|walls| walls.fraction()),
        condition: condition(equations),
        lambda: 0.0,
        gradient_norm,
        step_norm: 0.0,
        flags,
        seconds: Seconds::default(),
    })
}

/// What the description of a cylinder is made from.
struct Described<'a, 's> {
    data: &'a Data<'a>,
    constraints: &'a Constraints,
    cylinder: &'a Cylinder,
    scales: &'a Scales,
    /// The frame, objective and normal equations at the cylinder with the direction that the result shows.
    frame: &'a LocalFrame,
    objective: &'a Sum<'s>,
    equations: &'a NormalEquations,
}

/// What is stated of a cylinder by its data; `None` where they do not tell.
struct Stated {
    uncertainty: Option<Uncertainty>,
    /// The radius by limbs and the one by points.
    radii: Option<RadiusComparison>,
    /// The same by the sides of a mask. A mask is a hint: the radius by its sides is none by limbs.
    by_sides: Option<RadiusComparison>,
    shift: Option<ImageShift>,
    taper: Option<Taper>,
}

impl Described<'_, '_> {
    /// The input resolution of the points.
    fn resolution(&self) -> f64 {
        clouds(self.data).map(PointCloud::resolution).fold(0.0, f64::max)
    }

    /// Whether the resolution is so coarse that digits of the radius are missing.
    fn is_coarse(&self) -> bool {
        self.resolution() > COARSE * self.cylinder.radius
    }

    fn stated(&self) -> Stated {
        let Self { data, constraints, cylinder, scales, frame, objective, .. } = *self;
        // Where the noise is below the steps of the coordinates, what is left of the points is rounding, which is no noise.
        let unknown =
            self.is_coarse() && self.resolution() > scales.all || data.is_exact_by_chance(cylinder, scales);
        let (taper_of_points, tilt) = data.taper_of_points(frame, scales).unzip();
        let beside: List<Tangent> =
            data.deviation_along_rays(frame, scales).into_iter().chain(tilt).collect();
        let (uncertainty, radii, shift) = match unknown {
            true => (None, None, None),
            false => data.uncertainty(constraints, frame, scales, objective, &beside),
        };
        let (radii, by_sides) = if constraints.has_limbs() { (radii, None) } else { (None, radii) };
        let limbs = constraints.views.first().and_then(|view| view.limbs.as_ref());
        let by_limbs = limbs.and_then(|limbs| data.taper(limbs, &data.canonical(cylinder), scales));
        let taper = by_limbs.or(taper_of_points);
        Stated { uncertainty, radii, by_sides, shift, taper }
    }

    /// The warnings of the stages of the fit, and those by what is stated, by points, masks and lines.
    fn warnings(&self, stated: &Stated) -> Flags {
        let Self { data, constraints, cylinder, scales, frame, objective, equations } = *self;
        let Stated { radii, by_sides, shift, taper, .. } = *stated;
        let uncertainty = stated.uncertainty.as_ref();
        let scale_held = constraints.edge_weight == 1.0 && !data.has_fixed_radius();
        let weak = scale_held || is_weak(data, equations, cylinder) || hides_radius(uncertainty, cylinder);
        let mut flags = constraints.flags;
        flags.set(Flags::SCALE_HELD, scale_held);
        flags.set(Flags::WEAK_RADIUS, weak);
        flags.set(Flags::RESOLUTION_LOST, self.is_coarse());
        flags.set(Flags::UNCERTAINTY_UNKNOWN, data.options.method.minimises() && uncertainty.is_none());
        flags.set(Flags::DEPTH_SHIFTED, shift.is_some_and(|shift| shift.is_wrong()));
        flags |= data.contradicted(frame, scales, objective);
        flags |= warnings_of_points(data, cylinder, frame, scales);
        flags |= warnings_of_masks(data, constraints, cylinder, scales, (uncertainty, by_sides));
        if radii.is_some_and(|radii| radii.disagree(DISAGREEMENT))
            || leaves_lines(data, constraints, cylinder)
        {
            flags |= Flags::POINTS_AND_LIMBS_DISAGREE;
        }
        if taper.is_some_and(Taper::is_wrong) {
            flags |= Flags::BODY_TAPERS;
        }
        flags
    }
}

/// The points of each view.
fn clouds<'a>(data: &'a Data<'_>) -> impl Iterator<Item = &'a PointCloud> {
    data.views.iter().map(|view| &view.view.cloud)
}

/// What was left out of the data of all views.
fn dropped(data: &Data<'_>) -> Dropped {
    let mut dropped = Dropped::default();
    clouds(data).for_each(|cloud| dropped.add(cloud.dropped()));
    dropped
}

/// N_eff of all views.
fn independent_points(data: &Data<'_>, scales: &Scales) -> f64 {
    // A view without points has one in its scales, by which nothing is divided.
    let with_points = data.views.iter().zip(&scales.views).filter(|(view, _)| view.points.count() > 0);
    with_points.map(|(_, scales)| scales.independent_points).sum()
}

/// The condition of the Jacobian; infinite where the data leave a degree of freedom open.
fn condition(equations: &NormalEquations) -> f64 {
    let eigenvalues = equations.hessian.symmetric_eigenvalues();
    let smallest = eigenvalues.min().max(0.0);
    if smallest > 0.0 { (eigenvalues.max() / smallest).sqrt() } else { f64::INFINITY }
}

/// Whether the points hardly determine the radius, as if the weights were the inverse variances and the noise independent.
fn is_weak(data: &Data<'_>, equations: &NormalEquations, cylinder: &Cylinder) -> bool {
    let freedom = data.count().saturating_sub(data::LEAST_POINTS).max(1) as f64;
    let variance = equations.hessian.try_inverse().map_or(f64::INFINITY, |inverse| inverse[(4, 4)]);
    let deviation = data.unit * (equations.cost * variance / freedom).sqrt();
    !data.has_fixed_radius() && !(deviation <= WEAK_RADIUS * cylinder.radius)
}

/// Warnings about where cylinder and points lie.
fn warnings_of_points(data: &Data<'_>, cylinder: &Cylinder, frame: &LocalFrame, scales: &Scales) -> Flags {
    let limits = &data.options.cylinder_limits;
    let mut flags = Flags::empty();
    flags.set(Flags::CAMERA_INSIDE, data.observer_inside(cylinder));
    flags.set(Flags::RADIUS_AT_LIMIT, limits.hold_radius(cylinder));
    flags.set(Flags::AXIS_AT_LIMIT, limits.hold_axis(cylinder));
    let poor = scales.all > largest_scale(data, cylinder) || data.has_lack_of_fit(frame, scales);
    flags.set(Flags::POOR_FIT, data.count() > 0 && poor);
    flags
}

/// Warnings about masks, by what is stated of the cylinder and the radii by their sides and by points.
fn warnings_of_masks(
    data: &Data<'_>,
    constraints: &Constraints,
    cylinder: &Cylinder,
    scales: &Scales,
    (stated, by_sides): (Option<&Uncertainty>, Option<RadiusComparison>),
) -> Flags {
    let contested = by_sides.is_some_and(|radii| radii.disagree(MASK_DISAGREEMENT))
        && data.views.iter().any(|view| view.view.mask_is_drawn());
    let mut flags = Flags::empty();
    flags.set(Flags::MASK_DISAGREES, contested || data.mask_holds_another(cylinder, scales));
    if let Some(stated) = stated {
        flags |= data.masks_against(constraints, cylinder, scales, stated.radius());
    }
    flags
}

/// Whether a line that an image shows for a limb is not where the cylinder has one, by more than its error and a pixel of the drawing:
/// the points drew the fit away from it, or it was left out.
fn leaves_lines(data: &Data<'_>, constraints: &Constraints, cylinder: &Cylinder) -> bool {
    data.views.iter().zip(&constraints.views).any(|(view, constraints)| {
        let lines = constraints.limbs.iter().flatten().filter_map(|limb| limb.line.as_ref().ok());
        lines.into_iter().any(|line| view.leaves(line, &view.seen(cylinder)))
    })
}

/// The same for a cylinder that takes the place of a minimum and is none.
pub(super) fn describe_beside_minimum(
    data: &Data<'_>,
    constraints: &Constraints,
    cylinder: &Cylinder,
) -> Result<FitResult> {
    let start = Candidate { kind: StartKind::Model, cylinder: *cylinder };
    let mut result = describe(data, constraints, &start, cylinder, None)?;
    let about = |about| data.uncertainty_beside_minimum(constraints, cylinder, &about);
    result.uncertainty = result.uncertainty.and_then(about);
    result.flags |= Flags::NOT_CONVERGED;
    result
        .flags
        .set(Flags::UNCERTAINTY_UNKNOWN, data.options.method.minimises() && result.uncertainty.is_none());
    if hides_radius(result.uncertainty.as_ref(), cylinder) {
        result.flags |= Flags::WEAK_RADIUS;
    }
    Ok(result)
}

/// Whether the 95 % interval of what is stated reaches down to half of the radius.
fn hides_radius(uncertainty: Option<&Uncertainty>, cylinder: &Cylinder) -> bool {
    uncertainty.is_some_and(|stated| 4.0 * stated.radius() >= cylinder.radius)
}

/// The largest scale of points that lie on a cylinder: that of the view whose noise may be largest.
fn largest_scale(data: &Data<'_>, cylinder: &Cylinder) -> f64 {
    let observed = data.views.iter().filter(|view| view.observed);
    let distances = observed.map(|view| view.into_view.point(&data.center).norm());
    let of_distance = distances.map(|distance| LARGEST_DEPTH_NOISE * distance).reduce(f64::max);
    let told = TOLD_DEVIATIONS * data.options.noise.depth;
    of_distance.unwrap_or(POOR_PART * cylinder.radius).max(told)
}

/// E_L over the views with two usable segments that count.
fn energy_of_edges(data: &Data<'_>, constraints: &Constraints, cylinder: &Cylinder) -> Option<f64> {
    let terms = data.views.iter().filter_map(|view| Some((view.limb_term()?, view.seen(cylinder))));
    let energies = terms.map(|(term, seen)| term.energy(&seen)).collect::<Option<List<f64>>>()?;
    let counts = !constraints.flags.contains(Flags::EDGES_IGNORED) && !energies.is_empty();
    counts.then(|| energies.iter().sum::<f64>() / energies.len() as f64)
}

/// Root mean square distance in pixels of the endpoints of the usable segments from the limb lines.
fn edge_rms_pixels(data: &Data<'_>, cylinder: &Cylinder) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for view in data.views.iter().filter(|view| !view.edges.segments.is_empty()) {
        let distances = view.edges.distances(view.camera()?, &view.seen(cylinder))?;
        sum += distances.iter().map(|d| d * d).sum::<f64>();
        count += distances.len();
    }
    let rms = (sum / count as f64).sqrt();
    (count > 0 && rms.is_finite()).then_some(rms)
}

pub(super) fn infinite_cost() -> Error {
    Error::EdgeGeometry {
        reason: "the cost of the model is infinite: the camera is inside it, or an endpoint lies behind it"
            .into(),
        remedy: "give another model or clear the segments",
    }
}

impl FitResult {
    pub(super) fn add_convergence(&mut self, convergence: &Convergence) {
        self.termination = Some(convergence.termination);
        self.iterations = convergence.iterations;
        self.rejected_steps = convergence.rejected_steps;
        self.initial_cost = convergence.initial_cost;
        self.lambda = convergence.lambda;
        self.step_norm = convergence.step_norm;
        self.flags.set(Flags::NOT_CONVERGED, convergence.termination == Termination::MaxIterations);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitter::{Fitter, Options};
    use crate::observations::PointsView;

    #[test]
    fn a_cylinder_beside_the_minimum_is_no_more_certain_than_it_is_far_from_it() {
        let point = |k: u32| {
            let (turn, along) = (f64::from(k % 40) * 0.06 - 1.2, f64::from(k / 40) * 0.005);
            let radius = 0.05 + 0.0003 * (f64::from(k) * 12.9898).sin();
            [radius * turn.sin(), along, 0.7 - radius * turn.cos()]
        };
        let points: Vec<[f64; 3]> = (0..1600).map(point).collect();
        let mut fitter = Fitter::new();
        fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
        // Beside the minimum all residuals are alike.
        fitter.set_options(Options { independent_points: 400.0, ..Options::default() }).unwrap();
        let fitted = fitter.fit().unwrap();
        for part in [0.9, 0.95, 1.05, 1.1] {
            // The wall stays where it is.
            let mut beside = fitted.cylinder;
            beside.axis.point.z += (part - 1.0) * beside.radius;
            beside.radius *= part;
            let kept = fitter.keep(&beside).unwrap();
            assert!(kept.flags.contains(Flags::NOT_CONVERGED));
            let deviation = kept.uncertainty.unwrap().radius();
            let off = (beside.radius - fitted.cylinder.radius).abs();
            assert!(3.0 * deviation > off && deviation < 3.0 * off, "{part}: {deviation} {off}");
            assert_eq!(fitter.result().unwrap().uncertainty, kept.uncertainty);
        }
    }
}
