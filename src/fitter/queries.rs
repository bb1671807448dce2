//! What can be asked about a cylinder, given or of the last fit: what a fit would report, residuals, weights and parts of the points, rank.

use super::describe::{self, Diagnosis, ResidualKind};
use super::edges::UsableEdges;
use super::options::StartKind;
use super::result::FitResult;
use super::start::Candidate;
use super::{BYTES_OF_DIAGNOSIS, BYTES_OF_FIT, Fitter};
use crate::error::{Error, Result, with_room};
use crate::geometry::Cylinder;
use crate::parts::{Part, Parts};
use crate::residuals::{Loss, LossInFrame, PointRows, Robust, RobustScales};

impl Fitter {
    /// What a fit would report for a given model in the reference frame, without iterating: with the limb lines and arcs
    /// of the last fit, or with the given segments where data or options have changed since.
    ///
    /// # Errors
    /// Those of data and options as in [`Fitter::fit`], such as `TooFewPoints`; `EdgeGeometry` where the cost is
    /// infinite; `Numerical` where the gradient overflows; `OutOfMemory`.
    pub fn evaluate(&self, cylinder: &Cylinder) -> Result<FitResult> {
        self.check_memory(BYTES_OF_FIT)?;
        self.memory.lend(|| {
            let data = self.data()?;
            let start = Candidate { kind: StartKind::Model, cylinder: *cylinder };
            describe::describe(&data, &self.constraints(&data), &start, cylinder, None)
        })
    }

    /// The same, kept as if a fit had given it: [`Flags::NOT_CONVERGED`] says that it is no minimum, and how far it is from one is
    /// in its uncertainty.
    ///
    /// # Errors
    /// Those of [`Fitter::evaluate`]. The last result stays then.
    pub(crate) fn keep(&mut self, cylinder: &Cylinder) -> Result<FitResult> {
        self.check_memory(BYTES_OF_FIT)?;
        let result = self.memory.lend(|| {
            let data = self.data()?;
            describe::describe_beside_minimum(&data, &self.constraints(&data), cylinder)
        })?;
        self.result = Some(result);
        Ok(result)
    }

    /// Residuals of a model, or of the last fit, in the selected view.
    ///
    /// # Errors
    /// `BadState` without a model and a result; `EdgeGeometry` for edges when there are no limbs; `Numerical` where no number
    /// holds a residual; `OutOfMemory`.
    pub fn residuals(&self, cylinder: Option<&Cylinder>, kind: ResidualKind) -> Result<Vec<f64>> {
        let view = self.view();
        let seen = view.seen(&self.model_or_result("listing residuals", cylinder)?);
        let residuals = match kind {
            ResidualKind::Points => listed(view.cloud.len(), view.cloud.points().map(|p| seen.distance(&p)))?,
            ResidualKind::Edges => {
                let Some(camera) = view.camera() else { return Ok(Vec::new()) };
                let noise = self.options.noise.in_image(camera.size());
                let edges = UsableEdges::new(Some(camera), &view.segments, &noise);
                let distances = edges.distances(camera, &seen).ok_or_else(|| Error::EdgeGeometry {
                    reason: "the camera is inside the cylinder, which has no limbs then".into(),
                    remedy: "ask for the residuals of the points",
                })?;
                distances.to_vec()
            }
        };
        if residuals.iter().any(|residual| !residual.is_finite()) {
            return Err(Error::Numerical { what: "the residuals" });
        }
        Ok(residuals)
    }

    /// How much each used point of the selected view counts at a model, or at the last fit: from 1 on the surface down to
    /// 0 for an outlier, by the weight of the robust objective at the scale of the residuals. With a plain objective all
    /// points count alike all the same; this says which it should not trust.
    ///
    /// # Errors
    /// `BadState` without a model and a result; those of data and options as in [`Fitter::fit`], such as `TooFewPoints`;
    /// `OutOfMemory`.
    pub fn point_weights(&self, cylinder: Option<&Cylinder>) -> Result<Vec<f64>> {
        let cylinder = self.model_or_result("listing the weights of the points", cylinder)?;
        self.check_memory(BYTES_OF_FIT)?;
        self.memory.lend(|| self.weights_at(&cylinder))
    }

    fn weights_at(&self, cylinder: &Cylinder) -> Result<Vec<f64>> {
        let cloud = &self.view().cloud;
        let data = self.data()?;
        let scales = data.scales(cylinder);
        let mut views = data.views.iter().zip(&scales.views);
        let selected = views.find(|(view, _)| view.index == self.selected);
        let Some((view, &RobustScales { point: scale, .. })) = selected else { return Ok(Vec::new()) };
        let frame = data.frame(cylinder).moved(&view.into_view);
        let loss = Robust { scale, observed: view.observed }.at(&frame);
        let rows = PointRows::new(&frame);
        let weight = |point| {
            let (residual, facing) = rows.residual(&point);
            loss.influence(residual, facing).weight
        };
        listed(cloud.len(), cloud.points().map(weight))
    }

    /// What each used point of the selected view belongs to, at a model or at the last fit: the lateral surface, a cap,
    /// the inner wall, something in front, something behind. The depth image tells where within the mask the lateral
    /// surface ends; without one it goes on.
    ///
    /// # Errors
    /// `BadState` without a model and a result, `OutOfMemory`.
    pub fn point_parts(&self, cylinder: Option<&Cylinder>) -> Result<Vec<Part>> {
        let cylinder = self.model_or_result("telling the parts of the points", cylinder)?;
        let view = self.view();
        let seen = view.seen(&cylinder);
        self.memory.lend(|| {
            let parts = view.parts(&seen, &self.options.noise);
            let parts = parts.unwrap_or_else(|| Parts::of_points(&seen, view.cloud.points()));
            listed(view.cloud.len(), view.cloud.points().map(|point| parts.of_point(&point)))
        })
    }

    /// Rank, condition and the weakest direction of the stacked Jacobian at a model, or at the last fit, by
    /// orthogonal factorisation.
    ///
    /// # Errors
    /// `BadState` without a model and a result; those of data and options as in [`Fitter::fit`], such as `TooFewPoints`;
    /// `EdgeGeometry` where the cost is infinite; `Numerical` where numbers overflow or the factorisation does not
    /// converge; `OutOfMemory`.
    pub fn diagnose(&self, cylinder: Option<&Cylinder>) -> Result<Diagnosis> {
        let cylinder = self.model_or_result("diagnosing", cylinder)?;
        self.check_memory(BYTES_OF_DIAGNOSIS)?;
        self.memory.lend(|| {
            let data = self.data()?;
            describe::diagnose(&data, &self.constraints(&data), &cylinder)
        })
    }

    /// The given model, or that of the last fit.
    pub(crate) fn model_or_result(
        &self,
        call: &'static str,
        cylinder: Option<&Cylinder>,
    ) -> Result<Cylinder> {
        let missing = Error::BadState { call, missing: "a model", remedy: "give one or fit first" };
        cylinder.copied().or(self.result.map(|result| result.cylinder)).ok_or(missing)
    }
}

/// A list in memory that is asked for.
fn listed<T>(count: usize, numbers: impl Iterator<Item = T>) -> Result<Vec<T>> {
    let mut list = with_room(count, "the list")?;
    list.extend(numbers);
    Ok(list)
}
