//! Fitting, and what can be asked about a model.

use super::constants::{cylfuse_log_level, cylfuse_phase, cylfuse_residual_kind};
use super::handle::{Content, Log, cylfuse_fitter, enter};
use super::options::saturated;
use super::sized::Output;
use super::status::{Failure, cylfuse_status};
use super::structs::{
    cylfuse_cylinder, cylfuse_diagnosis, cylfuse_limb_sample, cylfuse_progress, cylfuse_result,
};
use super::views::{Slot, cylinder, optional_cylinder, write_all};
use crate::error::Error;
use crate::fitter::{FitResult, Fitter};
use crate::limb_location::{LimbObservation, LimbSample};
use crate::solver::Iteration;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

impl From<&FitResult> for cylfuse_result {
    fn from(result: &FitResult) -> Self {
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let FitResult { uncertainty, radii, .. } = result;
        let mut covariance = [f64::NAN; 49];
        if let Some(uncertainty) = uncertainty {
            covariance.copy_from_slice(uncertainty.covariance().as_slice());
        }
        Self {
            struct_size: size_of::<Self>() as u32,
            termination: result.termination.into(),
            start_kind: result.start_kind.into(),
            flags: super::constants::cylfuse_result_flags(result.flags.bits()),
            iterations: saturated(result.iterations),
            rejected_steps: saturated(result.rejected_steps),
            segments_used: saturated(result.segments_used),
            segments_given: saturated(result.segments_given),
            points_used: result.points_used as u64,
            points_given: result.points_given as u64,
            model: (&result.cylinder).into(),
            start_model: (&result.start).into(),
            initial_cost: result.initial_cost,
            cost: result.cost,
            energy_points: result.energy_points,
            energy_edges: or_nan(result.energy_edges),
            edge_weight: or_nan(result.edge_weight),
            point_rms: result.point_rms,
            edge_rms_pixels: or_nan(result.edge_rms_pixels),
            near_wall_fraction: or_nan(result.near_wall_fraction),
            condition: result.condition,
            lambda: result.lambda,
            gradient_norm: result.gradient_norm,
            step_norm: result.step_norm,
            seconds_start: result.seconds.start,
            seconds_solve: result.seconds.solve,
            seconds_total: result.seconds.total,
            radius_deviation: or_nan(uncertainty.map(|u| u.radius())),
            direction_deviation: or_nan(uncertainty.map(|u| u.direction())),
            position_deviation: or_nan(uncertainty.map(|u| u.position())),
            radius_from_points: or_nan(radii.map(|r| r.from_points)),
            radius_from_points_deviation: or_nan(radii.map(|r| r.from_points_deviation)),
            radius_from_limbs: or_nan(radii.map(|r| r.from_limbs)),
            radius_from_limbs_deviation: or_nan(radii.map(|r| r.from_limbs_deviation)),
            radius_z_score: or_nan(radii.map(|r| r.z_score())),
            covariance,
            limbs_located: saturated(result.limbs_located),
            reserved: 0,
        }
    }
}

fn fit(content: &mut Content, cancelled: &AtomicBool) -> Result<FitResult, Failure> {
    let (log, progress) = (content.log, content.progress);
    let max_iterations = saturated(content.fitter.options().limits.max_iterations);
    let mut phase = cylfuse_phase::START;
    let mut report = |iteration: &Iteration| {
        log_iteration(&log, phase, iteration);
        let mut stop = false;
        if let Some(function) = progress.function {
            let state = cylfuse_progress {
                struct_size: size_of::<cylfuse_progress>() as u32,
                phase,
                iteration: saturated(iteration.iteration),
                max_iterations,
                cost: iteration.cost,
                lambda: iteration.lambda,
                model: (&iteration.cylinder).into(),
            };
            // SAFETY: the caller gave the function for this use; the struct lives until it returns.
            stop = unsafe { function(&raw const state, progress.user_data) } != 0;
        }
        phase = cylfuse_phase::SOLVE;
        // After the callback, which may be what asks for it.
        if stop || cancelled.load(Ordering::Acquire) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let outcome = content.fitter.fit_with(&mut report);
    // What asked to cancel meant this fit, even if it came too late for it.
    cancelled.store(false, Ordering::Release);
    let result = outcome?;
    log_result(&log, &result);
    Ok(result)
}

fn log_iteration(log: &Log, phase: cylfuse_phase, iteration: &Iteration) {
    if phase == cylfuse_phase::SOLVE {
        log.write(cylfuse_log_level::DEBUG, || {
            let Iteration { iteration, cost, lambda, cylinder } = iteration;
            format!("solve {iteration}: cost {cost:e}, lambda {lambda:e}, radius {}", cylinder.radius)
        });
    }
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

/// Estimates the cylinder from everything that was pushed.
///
/// @param fitter the fitter
/// @param out_result where the result goes; set its `struct_size` before
/// @return TOO_FEW_POINTS, PLANAR_POINTS, COLLINEAR_POINTS, NO_START, NUMERICAL when the data do not determine a
///   cylinder; UNSUPPORTED, BAD_STATE, EDGE_GEOMETRY when they do not go with the options; CANCELLED. The last
///   result stays then. No convergence and other doubts are not errors but fields of the result.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_fit(
    fitter: *mut cylfuse_fitter,
    out_result: *mut cylfuse_result,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, cancelled| {
            let out = Output::new(out_result, "out_result")?;
            out.write(&(&fit(content, cancelled)?).into());
            Ok(())
        })
    }
}

/// Says what a fit would report for a given model, without iterating. The last result stays.
///
/// @param fitter the fitter
/// @param model the model
/// @param out_result where the result goes; set its `struct_size` before
/// @return INVALID_ARGUMENT for a bad model, else as `cylfuse_fitter_fit`; EDGE_GEOMETRY where the cost is
///   infinite
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_evaluate(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    out_result: *mut cylfuse_result,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            let out = Output::new(out_result, "out_result")?;
            out.write(&(&content.fitter.evaluate(&cylinder(model, "model")?)?).into());
            Ok(())
        })
    }
}

/// Reads the result of the last fit that succeeded.
///
/// @param fitter the fitter
/// @param out_result where the result goes; set its `struct_size` before
/// @return BAD_STATE when there is none
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_get_result(
    fitter: *const cylfuse_fitter,
    out_result: *mut cylfuse_result,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            let out = Output::new(out_result, "out_result")?;
            let result = content.fitter.result().ok_or(Error::BadState {
                call: "reading the result",
                missing: "a result",
                remedy: "fit first",
            })?;
            out.write(&result.into());
            Ok(())
        })
    }
}

/// Lists residuals.
///
/// @param fitter the fitter
/// @param model the model; NULL = that of the last fit
/// @param kind which residuals
/// @param out room for `capacity` doubles, of any alignment; may be NULL when `capacity` is 0
/// @param capacity `points_used` of `cylfuse_fitter_counts` is enough for POINTS, 2 a segment for EDGES
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a model and a result, EDGE_GEOMETRY for EDGES when the camera is inside the
///   cylinder, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_residuals(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    kind: cylfuse_residual_kind,
    out: *mut f64,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            let count = Slot::new(out_count, "out_count")?;
            let kind = kind.read("kind")?;
            let model = optional_cylinder(model)?;
            let residuals = content.fitter.residuals(model.as_ref(), kind)?;
            let written = write_all(&residuals, out, capacity, "out");
            if matches!(written, Ok(()) | Err(Failure::BufferTooSmall { .. })) {
                count.write(residuals.len());
            }
            written
        })
    }
}

/// Lists what the last fit saw of the limbs in the grey image, piece by piece, used and refused; all samples of a
/// limb that was not located in the end are refused. Empty when the image was not searched.
///
/// @param fitter the fitter
/// @param out room for `capacity` samples, of any alignment; may be NULL when `capacity` is 0
/// @param capacity how many samples `out` holds
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a result, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_limb_samples(
    fitter: *const cylfuse_fitter,
    out: *mut cylfuse_limb_sample,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            let count = Slot::new(out_count, "out_count")?;
            let samples = limb_samples(&content.fitter)?;
            let written = write_all(&samples, out, capacity, "out");
            if matches!(written, Ok(()) | Err(Failure::BufferTooSmall { .. })) {
                count.write(samples.len());
            }
            written
        })
    }
}

fn limb_samples(fitter: &Fitter) -> Result<Vec<cylfuse_limb_sample>, Failure> {
    if fitter.result().is_none() {
        let (call, missing) = ("listing limb samples", "a result");
        return Err(Error::BadState { call, missing, remedy: "fit first" }.into());
    }
    let (Some(limbs), Some(camera)) = (fitter.limbs(), fitter.camera()) else { return Ok(Vec::new()) };
    let of_limb = |(limb, observation): (u32, &'_ LimbObservation)| {
        let sample = |sample: &LimbSample| {
            // A camera that was set after the fit may not see the place.
            let pixel = camera.project(&camera.ideal_ray(&sample.position))?;
            let sigma = sample.sigma;
            let weight = if observation.uses(sample) { sample.weight } else { 0.0 };
            Some(cylfuse_limb_sample { pixel: pixel.into(), sigma, weight, limb, reserved: 0 })
        };
        observation.samples.iter().filter_map(sample).collect::<Vec<_>>()
    };
    Ok((0..).zip(limbs).flat_map(of_limb).collect())
}

/// Says what the data determine at a model, by an orthogonal factorisation of the whole Jacobian: more precise
/// than `condition` of a result, and far slower.
///
/// @param fitter the fitter
/// @param model the model; NULL = that of the last fit
/// @param out_diagnosis where the diagnosis goes; set its `struct_size` before
/// @return BAD_STATE without a model and a result, EDGE_GEOMETRY where the cost is infinite, TOO_FEW_POINTS,
///   NUMERICAL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_diagnose(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    out_diagnosis: *mut cylfuse_diagnosis,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            let out = Output::new(out_diagnosis, "out_diagnosis")?;
            let diagnosis = content.fitter.diagnose(optional_cylinder(model)?.as_ref())?;
            out.write(&cylfuse_diagnosis {
                struct_size: 0,
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
}
