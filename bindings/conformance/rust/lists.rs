//! The calls that list something.

use super::read::optional_cylinder;
use super::write::{Fields, Output};
use super::{Array, Runner, mask_view};
use cylfuse::error::{Error, Result};
use cylfuse::fitter::{NotVisible, Part};
use cylfuse::geometry::Cylinder;
use serde_json::Value;

/// The number of `CYLFUSE_LIMB_STATUS_...`; those below 2 are no reasons.
fn reason(reason: NotVisible) -> f64 {
    match reason {
        NotVisible::NoLimbs => 2.0,
        NotVisible::TooShort => 3.0,
        NotVisible::NoEdge => 4.0,
        NotVisible::OutOfReach => 5.0,
        NotVisible::Uncertain => 6.0,
        NotVisible::Patchy => 7.0,
        NotVisible::SameLine => 8.0,
    }
}

/// The number of `CYLFUSE_PART_...`.
fn number_of(part: Part) -> f64 {
    match part {
        Part::Body => 1.0,
        Part::Cap => 2.0,
        Part::InnerWall => 3.0,
        Part::Other => 4.0,
        Part::Behind => 5.0,
    }
}

impl Runner<'_> {
    /// Lists of a fit need one.
    fn need_result(&self, call: &'static str) -> Result<()> {
        let missing = Error::BadState { call, missing: "a result", remedy: "fit first" };
        self.fitter.result().map(|_| ()).ok_or(missing)
    }

    pub fn point_weights(&self) -> Result<Fields> {
        self.need_result("listing weights")?;
        let weights = self.fitter.point_weights(None)?;
        let inliers: Vec<f64> = weights.iter().map(|&weight| f64::from(u8::from(weight > 0.0))).collect();
        Ok(Output::default().list("weights", &weights).list("inliers", &inliers).0)
    }

    pub fn point_parts(&self, model: Option<&Cylinder>) -> Result<Fields> {
        let parts: Vec<f64> = self.fitter.point_parts(model)?.into_iter().map(number_of).collect();
        Ok(Output::default().list("parts", &parts).0)
    }

    pub fn limbs(&self) -> Result<Fields> {
        self.need_result("listing limbs")?;
        let (mut views, mut limbs, mut statuses, mut samples) = (vec![], vec![], vec![], vec![]);
        let (mut lines, mut deviations) = (vec![], vec![]);
        for view in 0..self.fitter.view_count() {
            for limb in 0..2 {
                let seen = self.fitter.limbs_of(view).map(|limbs| &limbs[limb]);
                let line = seen.map(|seen| seen.line);
                views.push(view as f64);
                limbs.push(limb as f64);
                statuses.push(match line {
                    Some(Ok(_)) => 0.0,
                    None => 1.0,
                    Some(Err(why)) => reason(why),
                });
                samples.push(seen.map_or(0.0, |seen| seen.samples.len() as f64));
                let line = line.and_then(std::result::Result::ok);
                lines.extend(
                    line.map_or([f64::NAN; 4], |l| [l.ends[0].x, l.ends[0].y, l.ends[1].x, l.ends[1].y]),
                );
                deviations.push(line.map_or(f64::NAN, |line| line.sigma));
            }
        }
        Ok(Output::default()
            .list("view", &views)
            .list("limb", &limbs)
            .list("status", &statuses)
            .list("samples", &samples)
            .list("line", &lines)
            .list("deviation", &deviations)
            .0)
    }

    pub fn limb_samples(&self) -> Result<Fields> {
        self.need_result("listing limb samples")?;
        let (mut pixels, mut deviations, mut weights, mut limbs) = (vec![], vec![], vec![], vec![]);
        if let (Some(seen), Some(camera)) = (self.fitter.limbs(), self.fitter.camera()) {
            for (limb, observation) in seen.iter().enumerate() {
                for sample in &observation.samples {
                    let Some(pixel) = camera.project(&camera.ideal_ray(&sample.position)) else { continue };
                    pixels.extend([pixel.x, pixel.y]);
                    deviations.push(sample.sigma);
                    weights.push(if observation.uses(sample) { sample.weight } else { 0.0 });
                    limbs.push(limb as f64);
                }
            }
        }
        let views = vec![self.fitter.selected_view() as f64; limbs.len()];
        Ok(Output::default()
            .list("view", &views)
            .list("limb", &limbs)
            .list("pixel", &pixels)
            .list("deviation", &deviations)
            .list("weight", &weights)
            .0)
    }

    pub fn end_samples(&self, step: &Value, mask: Option<&Array>) -> Result<Fields> {
        let model = optional_cylinder(&step["model"])?;
        let (_, arcs) = self.fitter.extent_and_arcs(model.as_ref(), mask.map(mask_view).as_ref())?;
        let (mut views, mut ends, mut pixels, mut normals, mut deviations) =
            (vec![], vec![], vec![], vec![], vec![]);
        for (view, of_view) in arcs.iter().enumerate() {
            for (end, samples) in of_view.iter().enumerate() {
                for sample in samples {
                    views.push(view as f64);
                    ends.push(end as f64);
                    pixels.extend([sample.pixel.x, sample.pixel.y]);
                    normals.extend([sample.normal.x, sample.normal.y]);
                    deviations.push(sample.deviation);
                }
            }
        }
        Ok(Output::default()
            .list("view", &views)
            .list("end", &ends)
            .list("pixel", &pixels)
            .list("normal", &normals)
            .list("deviation", &deviations)
            .0)
    }
}
