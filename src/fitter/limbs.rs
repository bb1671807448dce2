//! The limbs of a first fit, located in the image for a second one.

use super::Fitter;
use super::options::{EdgeUse, Method, ObjectiveKind, Options};
use super::problem::Problem;
use super::rough::{CONTRADICTION, RoughFit};
use super::solve::Report;
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use crate::limb_location::{LimbObservation, LimbSearch, locate_limbs};
use crate::noise::ImageNoise;
use crate::residuals::PixelSegment;
use crate::solver::Convergence;

/// How many standard deviations a limb may be from that of a rough fit at most.
const REACH_DEVIATIONS: f64 = 4.0;

/// How many standard deviations of both a given segment may be from a located line.
const AGREEING_DEVIATIONS: f64 = 3.0;

/// The lines that a fit holds the limbs to.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines {
    pub segments: Vec<PixelSegment>,
    /// How many of them were located in the image.
    pub located: usize,
}

/// The fit to the limbs that the image shows.
pub(super) struct LocatedFit {
    pub lines: Lines,
    pub convergence: Convergence,
    /// What the image shows of the limbs; `None` when it was not searched.
    pub observations: Option<[LimbObservation; 2]>,
}

/// By limb: the line that the image shows.
type Located = [Option<PixelSegment>; 2];

impl Fitter {
    /// Whether the fit looks at the image.
    pub(super) fn locates(&self) -> bool {
        let Options { method, objective, .. } = self.options();
        self.image.is_some() && *method == Method::Fused && *objective == ObjectiveKind::Robust
    }

    /// Locates the limbs near those of a rough fit and fits again with them. A limb that is not seen, or that
    /// contradicts the points, is left to what the rough fit held it to.
    pub(super) fn fit_to_located(
        &self,
        problem: &mut Problem<'_>,
        rough: &RoughFit,
        report: Report<'_>,
    ) -> Result<LocatedFit> {
        let noise = problem.noise;
        let mut observations = self.observe(&rough.convergence.cylinder, rough, rough.deviation, &noise);
        let mut located = observations.as_ref().map_or([None, None], |limbs| lines_of(limbs, &noise));
        let mut fit = None;
        if let [Some(_), None] | [None, Some(_)] = located {
            fit = problem.fit_to(&located, rough, report)?;
            if let (Some(fit), Some(seen)) = (&fit, &mut observations)
                && let Some(again) =
                    self.observe(&fit.convergence.cylinder, rough, noise.limb_of_segments(), &noise)
            {
                // One limb tells where to look for the other.
                let missing = usize::from(located[0].is_some());
                let [first, second] = again;
                seen[missing] = if missing == 0 { first } else { second };
                located = lines_of(seen, &noise);
            }
        }
        if let [Some(_), Some(_)] = located {
            fit = problem.fit_to(&located, rough, report)?;
            if fit.is_none() {
                // One of them is something else: the one that the points contradict more.
                let first = problem.fit_to(&[located[0], None], rough, report)?;
                let second = problem.fit_to(&[None, located[1]], rough, report)?;
                fit = first.into_iter().chain(second).min_by(|a, b| a.scale.total_cmp(&b.scale));
            }
        }
        let (lines, convergence) = match fit {
            Some(fit) => (fit.lines, fit.convergence),
            None => (lines(rough, &[None, None], &noise), rough.convergence),
        };
        problem.hold_to(&lines.segments);
        Ok(LocatedFit { lines, convergence, observations })
    }

    /// What the image shows of the limbs near those of a cylinder; `None` when it is not to be searched.
    fn observe(
        &self,
        cylinder: &Cylinder,
        rough: &RoughFit,
        deviation: f64,
        noise: &ImageNoise,
    ) -> Option<[LimbObservation; 2]> {
        if self.options.edge_use == EdgeUse::AsGiven {
            return None;
        }
        let (image, camera, range) = (self.image.as_ref()?, self.camera.as_ref()?, rough.range?);
        let search = LimbSearch {
            range,
            reach: [REACH_DEVIATIONS * deviation; 2],
            deviation: [deviation; 2],
            noise: *noise,
        };
        Some(locate_limbs(image, camera, cylinder, &search))
    }
}

/// The lines that were located, each weighed by its own standard deviation.
fn lines_of(observations: &[LimbObservation; 2], noise: &ImageNoise) -> Located {
    [0, 1].map(|limb| {
        let line = observations[limb].line.ok()?;
        let weight = (noise.endpoint / line.sigma).powi(2);
        Some(PixelSegment { endpoints: line.ends, weight, limb: Some(limb) })
    })
}

/// A fit to one or two located limbs that the points do not contradict.
struct Agreeing {
    lines: Lines,
    convergence: Convergence,
    /// Scale of the points.
    scale: f64,
}

impl Problem<'_> {
    /// The fit to located limbs; `None` where they contradict the points.
    fn fit_to(
        &mut self,
        located: &Located,
        rough: &RoughFit,
        report: Report<'_>,
    ) -> Result<Option<Agreeing>> {
        let before = &rough.convergence;
        let lines = lines(rough, located, &self.noise);
        self.hold_to(&lines.segments);
        let minimum = self.minimise(&before.cylinder, report);
        let checked = minimum.and_then(|minimum| self.check_radius(&minimum.cylinder).map(|()| minimum));
        let mut convergence = match checked {
            Ok(convergence) => convergence,
            Err(error @ Error::Cancelled { .. }) => return Err(error),
            Err(_) => return Ok(None),
        };
        convergence.add_work_of(before);
        let scale = self.point_scale(&convergence.cylinder);
        let agrees = scale <= CONTRADICTION * self.point_scale(&before.cylinder);
        Ok(agrees.then_some(Agreeing { lines, convergence, scale }))
    }
}

/// Whether a given segment lies on a located line, as far as both are known.
fn agree(line: &PixelSegment, given: &PixelSegment, noise: &ImageNoise) -> bool {
    let along = (line.endpoints[1] - line.endpoints[0]).normalize();
    let variance = noise.endpoint.powi(2) * (1.0 / line.weight + 1.0 / given.weight);
    let limit = AGREEING_DEVIATIONS * variance.sqrt();
    given.endpoints.iter().all(|q| along.perp(&(q - line.endpoints[0])).abs() <= limit)
}

/// The lines of a fit: the located limbs with the given segments that agree with them, and the guides of the others.
fn lines(rough: &RoughFit, located: &Located, noise: &ImageNoise) -> Lines {
    let of_limb = |limb: usize| match &located[limb] {
        Some(line) => {
            let agreeing = rough.guides.given.iter().filter(|given| given.limb == Some(limb));
            agreeing.filter(|given| agree(line, given, noise)).chain([line]).copied().collect()
        }
        None => rough.guides.of_limb(limb, located[1 - limb].as_ref(), noise),
    };
    Lines { segments: [of_limb(0), of_limb(1)].concat(), located: located.iter().flatten().count() }
}
