//! Fitting, and what a fit found.

use super::callbacks::Log;
use super::constants::cylfuse_log_level;
use super::handle::{Cancel, Content, cylfuse_fitter, enter_to_change, enter_to_read};
use super::options::saturated;
use super::outcomes::{cylfuse_phase, cylfuse_result_flags};
use super::results::{
    cylfuse_cylinder_diagnosis, cylfuse_cylinder_estimate, cylfuse_progress, cylfuse_result,
};
use super::sized::Output;
use super::status::{Failure, cylfuse_status};
use super::structs::cylfuse_cylinder;
use super::views::{cylinder, optional_cylinder};
use crate::error::Error;
use crate::fitter::{FitResult, Fitter};
use crate::solver::Iteration;
use std::ops::ControlFlow;

fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

impl From<&FitResult> for cylfuse_result {
    fn from(result: &FitResult) -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            flags: cylfuse_result_flags(result.flags.bits()),
            termination: result.termination.into(),
            iterations: saturated(result.iterations),
            rejected_steps: saturated(result.rejected_steps),
            limbs_located: saturated(result.limbs_located),
            segments_given: saturated(result.segments_given),
            segments_used: saturated(result.segments_used),
            points_given: result.points_given as u64,
            points_used: result.points_used as u64,
            independent_points: result.independent_points,
            point_deviation: result.point_scale,
            point_rms: result.point_rms,
            edge_rms_pixels: or_nan(result.edge_rms_pixels),
            near_wall_fraction: or_nan(result.near_wall_fraction),
            initial_cost: result.initial_cost,
            cost: result.cost,
            energy_points: result.energy_points,
            energy_edges: or_nan(result.energy_edges),
            edge_weight: or_nan(result.edge_weight),
            condition: result.condition,
            gradient_norm: result.gradient_norm,
            step_norm: result.step_norm,
            lambda: result.lambda,
            seconds_start: result.seconds.start,
            seconds_solve: result.seconds.solve,
            seconds_total: result.seconds.total,
        }
    }
}

impl From<&FitResult> for cylfuse_cylinder_estimate {
    fn from(result: &FitResult) -> Self {
        let FitResult { uncertainty, radii, .. } = result;
        let mut covariance = [f64::NAN; 49];
        if let Some(uncertainty) = uncertainty {
            covariance.copy_from_slice(uncertainty.covariance().as_slice());
        }
        Self {
            struct_size: size_of::<Self>() as u32,
            start_kind: result.start_kind.into(),
            model: (&result.cylinder).into(),
            start_model: (&result.start).into(),
            radius_deviation: or_nan(uncertainty.map(|u| u.radius())),
            direction_deviation: or_nan(uncertainty.map(|u| u.direction())),
            position_deviation: or_nan(uncertainty.map(|u| u.position())),
            radius_from_points: or_nan(radii.map(|r| r.from_points)),
            radius_from_points_deviation: or_nan(radii.map(|r| r.from_points_deviation)),
            radius_from_limbs: or_nan(radii.map(|r| r.from_limbs)),
            radius_from_limbs_deviation: or_nan(radii.map(|r| r.from_limbs_deviation)),
            radius_z_score: or_nan(radii.map(|r| r.z_score())),
            covariance,
        }
    }
}

/// Where a result goes: both parts, or the one that is wanted.
struct Outcome {
    result: Option<Output<cylfuse_result>>,
    estimate: Option<Output<cylfuse_cylinder_estimate>>,
}

impl Outcome {
    /// # Safety
    /// As [`Output::new`], for each.
    unsafe fn new(
        result: *mut cylfuse_result,
        estimate: *mut cylfuse_cylinder_estimate,
    ) -> Result<Self, Failure> {
        // SAFETY: the caller promises of `result` NULL or room for its `struct_size`.
        let result = unsafe { Output::optional(result, "out_result") }?;
        // SAFETY: the caller promises the same of `estimate`.
        let estimate = unsafe { Output::optional(estimate, "out_estimate") }?;
        Ok(Self { result, estimate })
    }

    fn write(self, outcome: &FitResult) {
        if let Some(result) = self.result {
            result.write(&outcome.into());
        }
        if let Some(estimate) = self.estimate {
            estimate.write(&outcome.into());
        }
    }
}

fn fit(content: &mut Content, cancel: &Cancel<'_>) -> Result<FitResult, Failure> {
    let (log, progress) = (content.log, content.progress);
    let max_iterations = saturated(content.fitter.options().limits.max_iterations);
    let mut logged = None;
    let mut report = |iteration: &Iteration| {
        // Before the first iteration there is no cylinder yet, and so no cost.
        let started = iteration.cost.is_finite();
        let phase = if started { cylfuse_phase::SOLVE } else { cylfuse_phase::START };
        // The last iteration is reported again where the fit only asks whether to go on.
        if started && logged != Some(*iteration) {
            log_iteration(&log, iteration);
            logged = Some(*iteration);
        }
        let mut stop = false;
        if let Some(function) = progress.function {
            let cylinder = cylfuse_cylinder::from(&iteration.cylinder);
            let state = cylfuse_progress {
                struct_size: size_of::<cylfuse_progress>() as u32,
                phase,
                iteration: saturated(iteration.iteration),
                max_iterations,
                cost: iteration.cost,
                lambda: iteration.lambda,
                cylinder: if started { &raw const cylinder } else { std::ptr::null() },
            };
            // SAFETY: the caller gave the function for this use; the structs live until it returns.
            stop = unsafe { function(&raw const state, progress.user_data) } != 0;
        }
        // After the callback, which may be what asks for it.
        if stop || cancel.is_asked_for() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let result = content.fitter.fit_with(&mut report)?;
    log_result(&log, &result);
    Ok(result)
}

fn log_iteration(log: &Log, iteration: &Iteration) {
    log.write(cylfuse_log_level::DEBUG, || {
        let Iteration { iteration, cost, lambda, cylinder } = iteration;
        format!("solve {iteration}: cost {cost:e}, lambda {lambda:e}, radius {}", cylinder.radius)
    });
}

fn log_result(log: &Log, result: &FitResult) {
    log.write(cylfuse_log_level::INFO, || {
        let FitResult { start_kind, start, .. } = result;
        format!("start from {start_kind:?}: radius {}, cost {:e}", start.radius, result.initial_cost)
    });
    log.write(cylfuse_log_level::INFO, || {
        let FitResult { iterations, cylinder, cost, .. } = result;
        let why = result.termination.map_or_else(|| "no iteration".into(), |end| format!("ended by {end:?}"));
        format!("{why} after {iterations} solves: radius {}, cost {cost:e}", cylinder.radius)
    });
    for (name, _) in result.flags.iter_names() {
        log.write(cylfuse_log_level::WARNING, || format!("the result has the flag {name}"));
    }
}

/// Estimates the cylinder from everything that was pushed into all views.
///
/// @param fitter the fitter
/// @param out_result where the result goes; `cylfuse_result_init` comes before. May be NULL.
/// @param out_estimate where the cylinder goes; `cylfuse_cylinder_estimate_init` comes before. May be NULL.
/// @return TOO_FEW_POINTS for fewer than 5 usable points, PLANAR_POINTS, COLLINEAR_POINTS, NO_START, NUMERICAL when the data
///   do not determine a cylinder; UNSUPPORTED, BAD_STATE, EDGE_GEOMETRY when they do not go with the options; OUT_OF_MEMORY; CANCELLED.
///   The last result stays then. Lack of convergence and other warnings are not errors but fields of the result.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_fit(
    fitter: *mut cylfuse_fitter,
    out_result: *mut cylfuse_result,
    out_estimate: *mut cylfuse_cylinder_estimate,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, cancel| {
        // SAFETY: as the header asks, `out_result` and `out_estimate` are each NULL or room for their `struct_size`.
        let out = unsafe { Outcome::new(out_result, out_estimate) }?;
        out.write(&fit(content, cancel)?);
        Ok(())
    })
}

/// Says what a fit would report for a given cylinder, without iterating. The last result stays.
///
/// @param fitter the fitter
/// @param model the cylinder, in the reference frame
/// @param out_result where the result goes; `cylfuse_result_init` comes before. May be NULL.
/// @param out_estimate where the deviations go; `cylfuse_cylinder_estimate_init` comes before. May be NULL.
/// @return INVALID_ARGUMENT for a bad model, else as `cylfuse_fitter_fit`; EDGE_GEOMETRY where the cost is
///   infinite
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_evaluate(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    out_result: *mut cylfuse_result,
    out_estimate: *mut cylfuse_cylinder_estimate,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_result` and `out_estimate` are each NULL or room for their `struct_size`.
        let out = unsafe { Outcome::new(out_result, out_estimate) }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { cylinder(model, "model") }?;
        out.write(&content.fitter.evaluate(&model)?);
        Ok(())
    })
}

/// Reads the result of the last fit that succeeded.
///
/// @param fitter the fitter
/// @param out_result where the result goes; `cylfuse_result_init` comes before
/// @return BAD_STATE when there is none
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_get_result(
    fitter: *const cylfuse_fitter,
    out_result: *mut cylfuse_result,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_result` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_result, "out_result") }?;
        out.write(&last_result(&content.fitter, "reading the result")?.into());
        Ok(())
    })
}

/// Reads the cylinder of the last fit that succeeded.
///
/// @param fitter the fitter
/// @param out_estimate where the cylinder goes; `cylfuse_cylinder_estimate_init` comes before
/// @return BAD_STATE when there is none
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_get_cylinder(
    fitter: *const cylfuse_fitter,
    out_estimate: *mut cylfuse_cylinder_estimate,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_estimate` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_estimate, "out_estimate") }?;
        out.write(&last_result(&content.fitter, "reading the cylinder")?.into());
        Ok(())
    })
}

pub(super) fn last_result<'a>(fitter: &'a Fitter, call: &'static str) -> Result<&'a FitResult, Failure> {
    let missing = Error::BadState { call, missing: "a result", remedy: "fit first" };
    fitter.result().ok_or(missing.into())
}

/// Says what the data determine at a model, by an orthogonal factorisation of the whole Jacobian: more precise
/// than `condition` of a result, and far slower.
///
/// @param fitter the fitter
/// @param model the model; NULL = that of the last fit
/// @param out_diagnosis where the diagnosis goes; `cylfuse_cylinder_diagnosis_init` comes before
/// @return BAD_STATE without a model and a result, EDGE_GEOMETRY where the cost is infinite; else as
///   `cylfuse_fitter_fit`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_diagnose(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    out_diagnosis: *mut cylfuse_cylinder_diagnosis,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_diagnosis` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_diagnosis, "out_diagnosis") }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        let diagnosis = content.fitter.diagnose(model.as_ref())?;
        out.write(&cylfuse_cylinder_diagnosis {
            struct_size: size_of::<cylfuse_cylinder_diagnosis>() as u32,
            rank: saturated(diagnosis.rank.rank),
            singular_values: diagnosis.rank.singular_values,
            condition: diagnosis.rank.condition,
            weakest_shift: diagnosis.weakest_shift.into(),
            weakest_tilt: diagnosis.weakest_tilt.into(),
            weakest_radius: diagnosis.weakest_radius,
        });
        Ok(())
    })
}
