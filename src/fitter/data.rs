//! What is fitted: the checked data of one fit, with their middle and size. Nothing here changes during a fit.

use super::continued::Last;
use super::edges::UsableEdges;
use super::options::{ChartChoice, Method, NearWall, ObjectiveKind, Options};
use super::subsample::Neighbours;
use super::view::View;
use crate::camera::Camera;
use crate::error::{Error, Result, short};
use crate::geometry::{Cylinder, CylinderLimits, LocalFrame, RigidMotion, Walls};
use crate::memory::{ByView, List};
use crate::noise::ImageNoise;
use crate::observations::{Dropped, EdgeSegment};
use crate::residuals::PointTerm;
use crate::workers::Workers;
use nalgebra::{Matrix3, Vector3};

/// Degrees of freedom of a cylinder, so the least number of points.
pub(super) const LEAST_POINTS: usize = 5;

/// Spread across a line, relative to the spread along it, below which points are collinear.
const COLLINEAR: f64 = 1e-4;

/// Spread across a plane, relative to the largest spread, below which points are exactly coplanar: the surface
/// of a cylinder over an arc of 1° still has ten times as much.
const COPLANAR: f64 = 1e-6;

/// A radius of more than this many times the spread of the points across the axis is no radius: over such an
/// arc, 1° and less, the surface is a plane.
const LARGEST_RADIUS: f64 = 100.0;

/// A radius that is asked for may be this many times the size of the points: over the arc that is left, 0.01°, the
/// bend of the surface is lost in the rounding of f32 coordinates.
const LARGEST_KNOWN_RADIUS: f64 = 1e4;

/// Points that tell one view from another.
const KEY_POINTS: usize = 8;

/// The data of one fit.
pub(super) struct Data<'a> {
    pub options: &'a Options,
    pub views: ByView<ViewData<'a>>,
    /// The model that the caller gave to start from.
    pub start: Option<&'a Cylinder>,
    /// What the last fit of a sequence left to go on from.
    pub last: Option<&'a Last>,
    /// Mean of the points.
    pub center: Vector3<f64>,
    /// Their covariance; 0 where there are too few.
    pub covariance: Matrix3<f64>,
    /// Root mean square distance of the points from their mean.
    pub unit: f64,
    /// w_L as far as edges can count: 0 where there are none for the paper's objective.
    pub edge_weight: f64,
}

/// The data of one view.
#[derive(Clone)]
pub(super) struct ViewData<'a> {
    /// Which view of the fitter it is.
    pub index: usize,
    pub view: &'a View,
    /// From the reference frame.
    pub into_view: RigidMotion,
    pub points: PointTerm<'a>,
    /// How many points these stand for.
    pub stands_for: usize,
    /// The points that tell how their noise is correlated.
    pub neighbours: &'a Neighbours,
    /// The given segments that can be limbs.
    pub edges: UsableEdges,
    /// The cylinder of two of them, where it is known already.
    pub of_limbs: Option<Cylinder>,
    /// Whether the mask is known to hold the body alone about the cylinder of the last fit.
    pub whole: bool,
    /// Whether the origin of the view is an observer that sees the points.
    pub observed: bool,
    /// The noise model in pixels of the image.
    pub noise: ImageNoise,
}

impl ViewData<'_> {
    /// The camera of the view.
    pub fn camera(&self) -> Option<&Camera> {
        self.view.camera()
    }

    /// A cylinder in the coordinates of the view.
    pub fn seen(&self, cylinder: &Cylinder) -> Cylinder {
        self.into_view.cylinder(cylinder)
    }

    /// The points in the reference frame.
    pub fn points_in_reference(&self) -> impl Iterator<Item = Vector3<f64>> + Clone + '_ {
        let to_reference = self.into_view.inverse();
        self.view.cloud.points().map(move |p| to_reference.point(&p))
    }

    /// How many points are at most so far from a cylinder.
    pub fn points_within(&self, cylinder: &Cylinder, center: &Vector3<f64>, limit: f64) -> usize {
        let frame = LocalFrame::new(cylinder, center, 1.0);
        self.points.count_within(&frame.moved(&self.into_view), limit)
    }

    /// Signed distances of the points from a cylinder.
    pub fn distances(&self, cylinder: &Cylinder, center: &Vector3<f64>) -> List<f64> {
        let frame = LocalFrame::new(cylinder, center, 1.0);
        self.points.distances(&frame.moved(&self.into_view))
    }
}

impl<'a> Data<'a> {
    /// Checks views and options against each other.
    pub fn new(
        options: &'a Options,
        views: impl Iterator<Item = &'a View> + Clone,
        start: Option<&'a Cylinder>,
    ) -> Result<Self> {
        let fused = options.method == Method::Fused;
        let paper = options.has_edge_weight();
        if options.chart == ChartChoice::Orthonormal && !options.cylinder_limits.is_none() {
            return Err(Error::Unsupported {
                what: "the orthonormal chart knows no limits of radius or axis".into(),
                remedy: "choose the chart auto or local, or take the limits away",
            });
        }
        let view_count = views.clone().count();
        for view in views.clone().filter(|_| fused) {
            let count = view.segments.len();
            if count > 0 && view.camera().is_none() {
                return Err(Error::BadState {
                    call: "fit",
                    missing: "intrinsics to use the edge segments",
                    remedy: "set the intrinsics or clear the segments",
                });
            }
            // Of several views some may have no edges.
            let nothing_to_do = view_count > 1 && count == 0;
            if paper && options.edge_weight > 0.0 && count != 2 && !nothing_to_do {
                return Err(Error::Unsupported {
                    what: format!("the paper's objective takes exactly 2 edge segments, not {count}"),
                    remedy: "push two segments, set the edge weight to 0, or use the robust objective",
                });
            }
        }
        let mut views: ByView<ViewData<'a>> =
            views.enumerate().map(|(index, view)| ViewData::new(options, index, view)).collect();
        // One order whatever that of the caller was.
        if views.len() > 1 {
            views.sort_by_cached_key(ViewData::key);
        }
        let has_limbs = views.iter().any(|view| view.edges.limb_pair().is_some());
        let edge_weight = if paper && has_limbs { options.edge_weight } else { 0.0 };
        let given = views.iter().map(|view| view.view.cloud.given()).sum();
        Self::with(options, views, start, edge_weight, given)
    }

    /// One view alone, in the same reference frame.
    pub fn only(&self, view: usize) -> Result<Data<'a>> {
        let view = self.views[view].clone();
        let given = view.view.cloud.given();
        Self::with(self.options, ByView::One(view), self.start, self.edge_weight, given)
    }

    /// The same data without edges.
    pub fn without_edges(&self) -> Data<'a> {
        let mut views = self.views.clone();
        for view in &mut views {
            view.edges.clear();
            view.of_limbs = None;
        }
        Data { views, edge_weight: 0.0, ..*self }
    }

    fn with(
        options: &'a Options,
        views: ByView<ViewData<'a>>,
        start: Option<&'a Cylinder>,
        edge_weight: f64,
        given: usize,
    ) -> Result<Self> {
        let usable: usize = views.iter().map(|view| view.points.count()).sum();
        let edges_alone = edge_weight == 1.0 && start.is_some();
        if usable < LEAST_POINTS && !edges_alone {
            let mut dropped = Dropped::default();
            views.iter().for_each(|view| dropped.add(view.view.cloud.dropped()));
            // Points pushed as such have neither mask nor range.
            let of_depth = dropped.no_depth + dropped.out_of_range + dropped.outside_mask > 0;
            let remedy = match of_depth {
                true => "push more points, or check mask, depth scale and depth range",
                false => "push more points",
            };
            let left_out = dropped.in_words();
            return Err(Error::TooFewPoints { usable, given, left_out, needed: LEAST_POINTS, remedy });
        }
        let center = Vector3::zeros();
        let covariance = Matrix3::zeros();
        let mut data = Self { options, views, start, last: None, center, covariance, unit: 1.0, edge_weight };
        if usable < LEAST_POINTS {
            data.center = start.map_or(Vector3::zeros(), |start| start.axis.nearest_to_origin());
            data.unit = data.center.norm().max(f64::MIN_POSITIVE);
            return Ok(data);
        }
        (data.center, data.covariance) = data.middle_and_covariance()?;
        data.unit = data.covariance.trace().sqrt();
        let smallest = options.cylinder_limits.radius_min;
        if smallest > LARGEST_KNOWN_RADIUS * data.unit {
            let requirement = format!(
                "be at most {LARGEST_KNOWN_RADIUS} times the size of the points, {}: check its unit",
                short(data.unit)
            );
            return Err(Error::argument("options.radius_min", smallest, requirement));
        }
        Ok(data)
    }

    /// All points in the reference frame.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> + Clone + '_ {
        self.views.iter().flat_map(ViewData::points_in_reference)
    }

    /// All points with their weights.
    pub fn weighted_points(&self) -> impl Iterator<Item = (Vector3<f64>, f64)> + Clone + '_ {
        self.views.iter().flat_map(|view| {
            let weights = (0..view.view.cloud.len()).map(|index| view.view.cloud.weight(index));
            view.points_in_reference().zip(weights)
        })
    }

    /// The number of points.
    pub fn count(&self) -> usize {
        self.views.iter().map(|view| view.points.count()).sum()
    }

    /// At most `count` points, evenly spread over those of each view, in the frames of the views.
    pub fn samples(&self, count: usize) -> List<List<Vector3<f64>>> {
        self.views.iter().map(|view| view.view.cloud.sampled(count / self.views.len()).collect()).collect()
    }

    /// The same points in the reference frame.
    pub fn sample(&self, count: usize) -> List<Vector3<f64>> {
        self.in_reference(&self.samples(count))
    }

    /// Points in the frames of the views in the reference frame.
    pub fn in_reference(&self, by_view: &[List<Vector3<f64>>]) -> List<Vector3<f64>> {
        let mut all = List::new();
        for (view, points) in self.views.iter().zip(by_view) {
            let to_reference = view.into_view.inverse();
            all.extend(points.iter().map(|p| to_reference.point(p)));
        }
        all
    }

    /// Mean and covariance of the points; refuses those that no cylinder is determined by.
    fn middle_and_covariance(&self) -> Result<(Vector3<f64>, Matrix3<f64>)> {
        let count = self.count() as f64;
        let views: List<(f64, Vector3<f64>, Matrix3<f64>)> = self.views.iter().filter_map(of_view).collect();
        // Differences of nearby points first: all may be far from the origin of coordinates.
        let origin = views.first().map_or(Vector3::zeros(), |view| view.1);
        let mean = views.iter().map(|(part, mean, _)| (mean - origin) * (part / count)).sum::<Vector3<f64>>();
        let covariance: Matrix3<f64> = views
            .iter()
            .map(|(part, of_view, covariance)| {
                let q = of_view - origin - mean;
                (covariance + q * q.transpose()) * (part / count)
            })
            .sum();
        let mut spreads = covariance.symmetric_eigenvalues().map(|value| value.max(0.0).sqrt());
        spreads.as_mut_slice().sort_unstable_by(|a, b| b.total_cmp(a));
        if !(covariance.trace().is_finite() && (origin + mean).iter().all(|x| x.is_finite())) {
            return Err(Error::Numerical {
                what: "the spread of the points overflows, as a coordinate is near 1e154 or beyond",
            });
        }
        if spreads[1] <= COLLINEAR * spreads[0] {
            return Err(Error::CollinearPoints { along: spreads[0], across: spreads[1] });
        }
        if spreads[2] <= COPLANAR * spreads[0] {
            let limit = LARGEST_RADIUS;
            let (radius, spread, axis_limited) = (f64::INFINITY, spreads[1], false);
            return Err(Error::PlanarPoints { radius, spread, limit, axis_limited });
        }
        Ok((origin + mean, covariance))
    }

    /// Whether the objective is the robust one.
    pub fn is_robust(&self) -> bool {
        self.options.is_robust()
    }

    /// Whether the objective is that of the paper (or its points alone).
    pub fn is_paper(&self) -> bool {
        self.options.method == Method::Points || self.options.objective == ObjectiveKind::Paper
    }

    /// Whether the fit looks at an image.
    pub fn locates(&self) -> bool {
        self.is_robust() && self.views.iter().any(|view| view.view.image().is_some())
    }

    /// Whether the points of any view must lie on the wall that faces it.
    pub fn near_wall(&self) -> bool {
        self.views.iter().any(|view| view.observed)
    }

    /// The points on the wall that their observers see, among those that have one, and E_P over all views.
    pub fn walls_and_energy(&self, cylinder: &Cylinder) -> (Walls, f64) {
        let frame = self.frame(cylinder);
        let views = || self.views.iter().filter(|view| view.points.count() > 0);
        let total: f64 = views().map(|view| view.points.total_weight()).sum();
        let (mut all, mut mean) = (Walls::default(), 0.0);
        for view in views() {
            let (walls, energy) = view.points.walls_and_energy(&frame.moved(&view.into_view));
            mean += view.points.total_weight() / total * energy;
            if view.observed {
                all.visible += walls.visible;
                all.total += walls.total;
            }
        }
        (all, mean)
    }

    /// Whether the observer of a view is inside a cylinder.
    pub fn observer_inside(&self, cylinder: &Cylinder) -> bool {
        self.views.iter().any(|view| view.observed && view.seen(cylinder).contains_origin())
    }

    /// The cylinder moved away from the first observer by two radii: see [`Cylinder::mirrored_away`].
    pub fn mirrored_away(&self, cylinder: &Cylinder) -> Cylinder {
        match self.views.iter().find(|view| view.observed) {
            Some(view) => view.into_view.inverse().cylinder(&view.seen(cylinder).mirrored_away()),
            None => cylinder.mirrored_away(),
        }
    }

    /// The cylinder with its axis point nearest to the middle of the points and the largest component of its
    /// direction positive, so that the same axis always reads the same.
    pub fn canonical(&self, cylinder: &Cylinder) -> Cylinder {
        let mut moved = cylinder.with_canonical_direction();
        moved.axis.point = cylinder.axis.nearest_to(&self.center);
        moved
    }

    /// The frame at a cylinder.
    pub fn frame(&self, cylinder: &Cylinder) -> LocalFrame {
        LocalFrame::new(cylinder, &self.center, self.unit)
    }

    /// The limits of an iteration. The edges alone (w_L = 1) determine r / ‖c‖ and no radius: what the limits say
    /// of it is left to the choice of the scale.
    pub fn limits_of_iteration(&self) -> CylinderLimits {
        let axis = self.options.cylinder_limits.axis;
        match self.edge_weight == 1.0 {
            true => CylinderLimits { axis, ..CylinderLimits::default() },
            false => self.options.cylinder_limits,
        }
    }

    /// The cylinder moved into the limits.
    pub fn within_limits(&self, cylinder: &Cylinder) -> Cylinder {
        self.limits_of_iteration().nearest(cylinder, &self.center)
    }

    /// Whether the radius was given and not estimated.
    pub fn has_fixed_radius(&self) -> bool {
        self.options.cylinder_limits.fix_radius()
    }

    /// Refuses a radius that is out of proportion to the points, unless the limits chose it.
    pub fn check_radius(&self, cylinder: &Cylinder) -> Result<()> {
        if self.count() < LEAST_POINTS || cylinder.radius >= self.options.cylinder_limits.radius_max {
            return Ok(());
        }
        let along = cylinder.axis.direction;
        let spread = (self.covariance.trace() - along.dot(&(self.covariance * along))).max(0.0).sqrt();
        if cylinder.radius > LARGEST_RADIUS * spread {
            let axis_limited = self.options.cylinder_limits.cone().is_some();
            let (radius, limit) = (cylinder.radius, LARGEST_RADIUS);
            return Err(Error::PlanarPoints { radius, spread, limit, axis_limited });
        }
        Ok(())
    }
}

/// The number of points of a view with their mean and covariance in the reference frame; `None` for none.
fn of_view(view: &ViewData<'_>) -> Option<(f64, Vector3<f64>, Matrix3<f64>)> {
    let to_reference = view.into_view.inverse();
    let (mean, covariance) = view.view.mean_and_covariance()?;
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let rotation = Matrix3::from_columns(&axes.map(|axis| to_reference.direction(&axis)));
    let covariance = rotation * covariance * rotation.transpose();
    Some((view.points.count() as f64, to_reference.point(&mean), covariance))
}

impl<'a> ViewData<'a> {
    /// Tells views apart by what was measured in them.
    fn key(&self) -> (usize, Vec<[u64; 3]>) {
        let sample = self.view.cloud.sampled(KEY_POINTS);
        (self.view.cloud.len(), sample.map(|p| [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()]).collect())
    }

    fn new(options: &Options, index: usize, view: &'a View) -> Self {
        let fused = options.method == Method::Fused;
        let observed = match options.near_wall {
            NearWall::Auto => view.camera().is_some(),
            NearWall::On => true,
            NearWall::Off => false,
        };
        let size = view.camera().map_or((1, 1), Camera::size);
        let noise = options.noise.in_image(size);
        let workers = (options.threads != 1).then(|| Workers::asked(options.threads));
        let neighbours = view.neighbours(observed);
        let segments: &[EdgeSegment] = if fused { &view.segments } else { &[] };
        Self {
            index,
            view,
            into_view: view.pose().inverse(),
            points: PointTerm::new(&view.cloud, workers).with_part(neighbours.part()),
            stands_for: view.cloud.len(),
            neighbours,
            edges: UsableEdges::new(view.camera(), segments, &noise),
            of_limbs: None,
            whole: false,
            observed,
            noise,
        }
    }
}
