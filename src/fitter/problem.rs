//! What is fitted: the checked data of one fit with its size and middle.

use super::edges::UsableEdges;
use super::options::{ChartChoice, Method, NearWall, ObjectiveKind, Options};
use super::result::Flags;
use super::starts::Candidate;
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::geometry::{Cylinder, CylinderLimits};
use crate::noise::{ImageNoise, NoiseModel};
use crate::observations::PointCloud;
use crate::residuals::{ArcTerm, LimbTerm, PixelSegment, PixelTerm, PointTerm, RobustScales};
use nalgebra::{Matrix3, Vector3};
use std::cell::Cell;

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

/// The data of one fit.
pub(super) struct Problem<'a> {
    pub options: &'a Options,
    pub cloud: &'a PointCloud,
    pub edges: UsableEdges,
    pub points: PointTerm<'a>,
    /// The paper's edge term, where exactly two segments are usable.
    pub limbs: Option<LimbTerm>,
    /// The pixel distances of the lines that the robust objective holds the limbs to: at first the usable segments.
    pub pixels: Option<PixelTerm>,
    /// How many of these lines were located in the image.
    pub limbs_located: usize,
    /// The arcs of the ends, for the robust objective.
    pub arcs: ArcTerm,
    /// Mean of the points.
    pub center: Vector3<f64>,
    /// Root mean square distance of the points from their mean.
    pub unit: f64,
    pub near_wall: bool,
    /// The camera at the origin, where there is one.
    pub camera: Option<&'a Camera>,
    /// What is known of the errors in its image.
    pub noise: ImageNoise,
    /// w_L, 0 where no edges count.
    pub edge_weight: f64,
    /// Whether the minimum is only a step on the way: what is located in the image from there moves it again.
    pub passing: bool,
    /// The last cylinder whose scales were asked for, and these.
    pub last_scales: Cell<Option<(Cylinder, RobustScales)>>,
    /// Linear solves so far.
    pub solves: Cell<usize>,
}

/// What is known of the errors in the image of a camera.
pub(crate) fn image_noise(camera: Option<&Camera>) -> ImageNoise {
    NoiseModel::default().in_image(camera.map_or((1, 1), Camera::size))
}

impl<'a> Problem<'a> {
    pub fn new(
        options: &'a Options,
        cloud: &'a PointCloud,
        camera: Option<&'a Camera>,
        segments: &'a [crate::observations::EdgeSegment],
        start: Option<&Cylinder>,
    ) -> Result<Self> {
        let paper = options.method == Method::Fused && options.objective == ObjectiveKind::Paper;
        let fused = options.method == Method::Fused;
        if fused && !segments.is_empty() && camera.is_none() {
            return Err(Error::BadState {
                call: "fit",
                missing: "intrinsics to use the edge segments",
                remedy: "set the intrinsics or clear the segments",
            });
        }
        if paper && options.edge_weight > 0.0 && segments.len() != 2 {
            return Err(Error::Unsupported {
                what: format!("the paper's objective takes exactly 2 edge segments, not {}", segments.len()),
                remedy: "push two segments, set the edge weight to 0, or use the robust objective",
            });
        }
        if options.chart == ChartChoice::Orthonormal && !options.cylinder_limits.is_none() {
            return Err(Error::Unsupported {
                what: "the orthonormal chart knows no limits of radius or axis".into(),
                remedy: "choose the chart auto or local, or take the limits away",
            });
        }
        let noise = image_noise(camera);
        let edges = UsableEdges::new(camera, &noise, if fused { segments } else { &[] });
        let limbs = edges.limb_term(camera);
        let edge_weight = if paper && limbs.is_some() { options.edge_weight } else { 0.0 };
        let edges_alone = edge_weight == 1.0 && start.is_some();
        if cloud.len() < LEAST_POINTS && !edges_alone {
            return Err(Error::TooFewPoints {
                usable: cloud.len(),
                given: cloud.given(),
                needed: LEAST_POINTS,
                remedy: "push more points, or check mask, depth scale and depth range",
            });
        }
        let (center, unit) = if cloud.len() < LEAST_POINTS {
            let start = start.map_or(Vector3::zeros(), |start| start.axis.nearest_to_origin());
            (start, start.norm().max(f64::MIN_POSITIVE))
        } else {
            size(cloud)?
        };
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            count => count,
        };
        let near_wall = match options.near_wall {
            NearWall::Auto => camera.is_some(),
            NearWall::On => true,
            NearWall::Off => false,
        };
        let pixels = edges.pixel_term(camera);
        let points = PointTerm::new(cloud, threads);
        Ok(Self {
            options,
            cloud,
            edges,
            points,
            limbs,
            pixels,
            limbs_located: 0,
            arcs: ArcTerm::default(),
            center,
            unit,
            near_wall,
            camera,
            noise,
            edge_weight,
            passing: false,
            last_scales: Cell::new(None),
            solves: Cell::new(0),
        })
    }

    /// Whether the objective has the weight w_L.
    pub fn has_edge_weight(&self) -> bool {
        self.options.method == Method::Fused && self.options.objective == ObjectiveKind::Paper
    }

    /// Segments that count in the objective.
    pub fn segments_used(&self) -> usize {
        if self.has_edge_weight() && self.edge_weight == 0.0 { 0 } else { self.edges.segments.len() }
    }

    /// Whether something that was seen in the image tells of the limbs: a mask is a hint only.
    pub fn has_limbs(&self) -> bool {
        self.pixels.is_some() && (self.limbs_located > 0 || !self.edges.segments.is_empty())
    }

    /// Holds the limbs to these lines and no others.
    pub fn hold_to(&mut self, lines: &[PixelSegment]) {
        let camera = self.camera.filter(|_| !lines.is_empty());
        self.pixels = camera.map(|camera| PixelTerm::new(lines.to_vec(), camera.line_projection()));
    }

    /// Gives the edges up when no candidate has limbs that they could belong to.
    pub fn ignore_edges_without_limbs(&mut self, candidates: &[Candidate]) {
        if !candidates.iter().any(|candidate| self.edges_are_finite(&candidate.cylinder)) {
            let inside = candidates.iter().all(|candidate| candidate.cylinder.contains_origin());
            self.ignore_edges(if inside { Flags::CAMERA_INSIDE } else { Flags::EDGES_BEHIND });
        }
    }

    /// Gives the edges up for the whole fit.
    pub fn ignore_edges(&mut self, reason: Flags) {
        self.edges.drop_all();
        self.edges.flags |= reason;
        self.limbs = None;
        self.pixels = None;
        self.arcs = ArcTerm::default();
        self.edge_weight = 0.0;
    }

    /// The cylinder with its axis point nearest to the middle of the points and the largest component of its
    /// direction positive, so that the same axis always reads the same.
    pub fn canonical(&self, cylinder: &Cylinder) -> Cylinder {
        let mut moved = *cylinder;
        moved.axis.point = cylinder.axis.nearest_to(&self.center);
        let direction = cylinder.axis.direction;
        if direction[direction.iamax()] < 0.0 {
            moved.axis.direction = -direction;
        }
        moved
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

    /// Whether the radius was given and not estimated.
    pub fn has_fixed_radius(&self) -> bool {
        self.options.cylinder_limits.fix_radius()
    }

    /// Refuses a radius that is out of proportion to the points, unless the limits chose it.
    pub fn check_radius(&self, cylinder: &Cylinder) -> Result<()> {
        if self.cloud.is_empty() || cylinder.radius >= self.options.cylinder_limits.radius_max {
            return Ok(());
        }
        // Spread across the axis, seen at most a few hundred points: this is a proportion, not a measurement.
        let sample = self.cloud.sample(500);
        let across = |p: &Vector3<f64>| (p - self.center).cross(&cylinder.axis.direction).norm_squared();
        let spread = (sample.iter().map(across).sum::<f64>() / sample.len() as f64).sqrt();
        if cylinder.radius > LARGEST_RADIUS * spread {
            return Err(Error::PlanarPoints { radius: cylinder.radius, spread, limit: LARGEST_RADIUS });
        }
        Ok(())
    }
}

/// Mean and size of the points; refuses those that no cylinder is determined by.
fn size(cloud: &PointCloud) -> Result<(Vector3<f64>, f64)> {
    let count = cloud.len() as f64;
    let origin = *cloud.origin();
    let mean = cloud.points().fold(Vector3::zeros(), |sum, p| sum + (p - origin)) / count;
    let covariance = cloud.points().fold(Matrix3::zeros(), |sum, p| {
        let q = p - origin - mean;
        sum + q * q.transpose()
    }) / count;
    let mut spreads = covariance.symmetric_eigenvalues().map(|value| value.max(0.0).sqrt());
    spreads.as_mut_slice().sort_unstable_by(|a, b| b.total_cmp(a));
    let unit = covariance.trace().sqrt();
    if !(unit.is_finite() && (origin + mean).iter().all(|x| x.is_finite())) {
        return Err(Error::Numerical { what: "the spread of the points overflows" });
    }
    if spreads[1] <= COLLINEAR * spreads[0] {
        return Err(Error::CollinearPoints { along: spreads[0], across: spreads[1] });
    }
    if spreads[2] <= COPLANAR * spreads[0] {
        return Err(Error::PlanarPoints { radius: f64::INFINITY, spread: spreads[1], limit: LARGEST_RADIUS });
    }
    Ok((origin + mean, unit))
}
