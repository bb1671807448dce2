//! The covariance of the robust objective at the exact view, with the noise of the plan in place of residuals.
//!
//! A fit minimises Σ w e²; to first order an error ε of the data moves its minimum by −A⁻¹ Σ w ε J with A = Σ w J Jᵀ, so that
//! the covariance is A⁻¹ B A⁻¹ with B = Σ w² σ² J Jᵀ: w follows from what a fit takes the deviations for, σ is what they are.
//! Nothing is drawn at random. The sixth unknown is the bend b that the points share (see `residuals/shared.rs`).

use super::view::SeenPoint;
use super::{Deviations, Plan};
use crate::error::{Error, Result};
use crate::fitter::larger_deviation;
use crate::geometry::{LimbFrame, LocalFrame, Tangent, TangentMap};
use crate::memory::List;
use crate::noise::NoiseModel;
use crate::residuals::{
    ArcRay, ArcTerm, PixelResiduals, PixelSegment, PixelTerm, PointRows, Rim, SharedErrors, on_wall,
};
use crate::statistics::median;
use nalgebra::{SMatrix, SVector, Vector3};

/// What a located limb scatters by in units of the Cramér–Rao bound: blur, levels and shading are found from the same pixels.
/// By captures of the twin with steps of 10 and 25 times the noise.
const LIMB_LOSS: f64 = 1.65;

/// What a limb scatters by in a perfect image, in pixels at either end: it is looked for from where the depth says. By captures
/// of the twin with steps of 70 times the noise.
const LIMB_JITTER: f64 = 0.006;

/// The deviation that a fit takes a limb for in a perfect image, in pixels at either end: the floor of
/// [`limb_location`](crate::limb_location) and of its blocks.
const LIMB_FLOOR: f64 = 0.075;

/// The same two of a sample of an arc, in pixels: its loss, and its floor.
const SAMPLE_LOSS: f64 = 1.7;
const SAMPLE_FLOOR: f64 = 0.05;

/// A fit takes the samples of an arc for so much less certain: by how much they scatter more than they say.
const SAMPLE_SCATTER: f64 = 1.7;

/// Deviation of an end for reasons that its pixels do not show.
const END_FLOOR: f64 = 0.1;

/// Fewer independent points tell no noise from residuals, as in a fit.
const LEAST_INDEPENDENT: usize = 8;

/// The step of central differences, in units of the radius.
const STEP: f64 = 1e-5;

/// What is to be expected of measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// How much captures of one scene scatter: by the noise of depth and image.
    pub scatter: Deviations,
    /// How far a measurement is off: by that noise, by what all points of a frame share, and by what a limb or an end is off for
    /// other reasons than noise. It is what a fit states as its uncertainty.
    pub total: Deviations,
    /// Pixels that see the lateral surface.
    pub points: usize,
    /// How many of them are independent.
    pub independent_points: f64,
}

type Six = SVector<f64, 6>;
type SixMap = SMatrix<f64, 6, 6>;

/// A in the tangent of the frame and b, and B twice.
struct Information {
    matrix: SixMap,
    scatter: SixMap,
    total: SixMap,
}

impl Information {
    /// Adds a residual that a fit takes for one of the deviation `stated`, with errors of two deviations.
    fn add(&mut self, jacobian: &Six, stated: f64, scatter: f64, total: f64) {
        let square = jacobian * jacobian.transpose();
        self.matrix += square / stated.powi(2);
        self.scatter += square * (scatter.powi(2) / stated.powi(4));
        self.total += square * (total.powi(2) / stated.powi(4));
    }
}

/// A Jacobian with its derivative by b.
fn six(jacobian: &Tangent, bend: f64) -> Six {
    Six::new(jacobian[0], jacobian[1], jacobian[2], jacobian[3], jacobian[4], bend)
}

impl Plan {
    /// The standard deviations to be expected of a fit with a mask and an image.
    ///
    /// # Errors
    /// `InvalidArgument` for a value out of range, `TooFewPoints` when the pixels that see the surface are worth fewer than 8
    /// points with independent noise, `Numerical` where the view does not determine the cylinder.
    pub fn expected(&self) -> Result<Expected> {
        self.check()?;
        let cylinder = self.cylinder()?;
        let limbs = LimbFrame::new(&cylinder).ok_or_else(undetermined)?;
        let frame = LocalFrame::new(&cylinder, &self.center(), self.radius);
        let seen = self.points(&cylinder, &limbs);
        let share = self.depth.correlation.powi(-2);
        let independent_points = seen.len() as f64 * share;
        if !(independent_points >= LEAST_INDEPENDENT as f64) {
            return Err(Error::TooFewPoints {
                usable: independent_points as usize,
                given: seen.len(),
                left_out: String::new(),
                needed: LEAST_INDEPENDENT,
                remedy: "plan a shorter distance or a camera of more pixels; pixels whose noise is alike count once",
            });
        }
        let mut information = self.of_points(&frame, &seen, share)?;
        self.add_limbs(&mut information, &frame, &limbs)?;
        let arcs = [-0.5, 0.5].map(|part| self.arc(&cylinder, &limbs, part * self.length));
        let of_samples = self.step.ends.map(|noise| SAMPLE_LOSS * self.step.position_deviation(noise, 1.0));
        for (arc, deviation) in arcs.iter().zip(of_samples) {
            let Some(arc) = arc else { continue };
            let stated = SAMPLE_SCATTER * deviation.hypot(SAMPLE_FLOOR);
            let term = ArcTerm { ends: [List::from(&arc[..])].into() };
            for row in term.pixel_rows(&frame).ok_or_else(undetermined)? {
                information.add(&six(&row.jacobian, 0.0), stated, deviation, stated);
            }
        }
        let inverse = information.matrix.cholesky().ok_or_else(undetermined)?.inverse();
        let deviations = |errors: &SixMap, end_floor: f64| {
            let covariance: TangentMap = (inverse * errors * inverse).fixed_view::<5, 5>(0, 0).into();
            let length = || {
                let [start, end] = arcs.each_ref();
                let (start, end) = (start.as_ref()?, end.as_ref()?);
                let by_cylinder = of_length(&frame, start, end)?;
                let of_ends = end_variance(start, of_samples[0], end_floor)
                    + end_variance(end, of_samples[1], end_floor);
                Some((by_cylinder.dot(&(covariance * by_cylinder)) + of_ends).sqrt())
            };
            Deviations {
                radius: frame.unit * covariance[(4, 4)].max(0.0).sqrt(),
                direction: larger_deviation(&covariance.fixed_view::<2, 2>(2, 2).into()),
                position: frame.unit * larger_deviation(&covariance.fixed_view::<2, 2>(0, 0).into()),
                length: length(),
            }
        };
        Ok(Expected {
            scatter: deviations(&information.scatter, 0.0),
            total: deviations(&information.total, END_FLOOR),
            points: seen.len(),
            independent_points,
        })
    }

    /// The points, and the errors that they share.
    fn of_points(&self, frame: &LocalFrame, seen: &[SeenPoint], share: f64) -> Result<Information> {
        let rows = PointRows::new(frame);
        let points: Vec<(Tangent, f64)> = (seen.iter())
            .map(|seen| (rows.row(&seen.point).1, self.depth.at(seen.point.z) * seen.across / frame.unit))
            .collect();
        // A fit takes all points for alike, with the median of their deviations.
        let mut sorted: Vec<f64> = points.iter().map(|point| point.1).collect();
        let scale = median(&mut sorted);
        // How the axis moves with the radius of the points.
        let square: TangentMap = points.iter().map(|(jacobian, _)| jacobian * jacobian.transpose()).sum();
        let inverse = square.fixed_view::<2, 2>(0, 0).try_inverse().ok_or_else(undetermined)?;
        let shift = -inverse * square.fixed_view::<2, 1>(0, 4);
        let bend = Tangent::new(shift[0], shift[1], 0.0, 0.0, 1.0);
        let [matrix, scatter, total] = [SixMap::zeros(); 3];
        let mut information = Information { matrix, scatter, total };
        // Of 1 / `share` points that are alike each has the weight of a part.
        let stated = scale / share.sqrt();
        for (jacobian, deviation) in &points {
            let own = deviation / share.sqrt();
            information.add(&six(jacobian, jacobian.dot(&bend)), stated, own, own);
        }
        let part = NoiseModel::default().depth_shared;
        let count = seen.len() as f64;
        let middle = seen.iter().map(|seen| seen.point).sum::<Vector3<f64>>() / count;
        let spread = seen.iter().map(|seen| (seen.point - middle).norm_squared()).sum::<f64>() / count;
        let shared = SharedErrors::of_offset(part * self.distance, self.distance, spread.sqrt());
        let size = shared.bend / frame.unit;
        for step in shared.steps(frame) {
            let error = information.matrix * six(&step, 0.0);
            information.total += error * error.transpose();
        }
        // b is known to that size.
        information.matrix[(5, 5)] += size.powi(-2);
        information.total[(5, 5)] += size.powi(-2);
        Ok(information)
    }

    /// The limb lines: two residuals each, where offset and slope of the line are worth as much.
    fn add_limbs(&self, information: &mut Information, frame: &LocalFrame, limbs: &LimbFrame) -> Result<()> {
        for (limb, noise) in self.step.limbs.into_iter().enumerate() {
            let Some([from, to]) = self.limb_in_image(limbs, limb) else { continue };
            let along = to - from;
            let (middle, half) = ((from + to) / 2.0, along / 12.0_f64.sqrt());
            // Each of two positions has twice the variance of the middle.
            let noise = LIMB_LOSS * 2.0_f64.sqrt() * self.step.position_deviation(noise, along.norm());
            let scatter = noise.hypot(LIMB_JITTER);
            let stated = noise.hypot(LIMB_FLOOR);
            let segment = PixelSegment {
                endpoints: [middle - half, middle + half],
                weight: 1.0,
                limb: None,
                growth: 0.0,
            };
            let term = PixelTerm::new([segment], self.camera.line_projection());
            for row in term.pixel_rows(frame).ok_or_else(undetermined)? {
                information.add(&six(&row.jacobian, 0.0), stated, scatter, stated);
            }
        }
        Ok(())
    }
}

/// How the length follows the cylinder, in units of length by units of the frame: the arcs stay where they are in the image.
fn of_length(frame: &LocalFrame, start: &[ArcRay], end: &[ArcRay]) -> Option<Tangent> {
    let mut derivative = Tangent::zeros();
    for k in 0..5 {
        let at = |size: f64| {
            let cylinder = frame.retract(&Tangent::ith(k, size));
            let position = |arc: &[ArcRay]| {
                let sum: Option<f64> =
                    arc.iter().map(|sample| Some(on_wall(&cylinder, &sample.ray, Rim::Near)?.0)).sum();
                Some(sum? / arc.len() as f64)
            };
            Some(position(end)? - position(start)?)
        };
        derivative[k] = (at(STEP)? - at(-STEP)?) / (2.0 * STEP);
    }
    Some(derivative)
}

/// The variance of an end along the axis by the samples of its arc and its floor in pixels.
fn end_variance(arc: &[ArcRay], deviation: f64, floor: f64) -> f64 {
    let information: f64 = arc.iter().map(|at| (at.across / deviation).powi(2)).sum();
    let across = arc.iter().map(|at| at.across).sum::<f64>() / arc.len() as f64;
    information.recip() + (floor / across).powi(2)
}

fn undetermined() -> Error {
    Error::Numerical { what: "the view does not determine the cylinder" }
}
