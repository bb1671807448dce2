//! What can be listed about a fit: residuals, limbs, their samples, arcs of the ends, weights of points.

use super::constants::cylfuse_residual_kind;
use super::data::optional_mask;
use super::handle::{cylfuse_fitter, enter_to_read};
use super::lists::{Room, write_numbers};
use super::options::saturated;
use super::outcomes::{cylfuse_limb_status, cylfuse_part};
use super::results::{cylfuse_end_sample, cylfuse_limb, cylfuse_limb_sample};
use super::sized::OutputArray;
use super::solve::last_result;
use super::status::{Failure, cylfuse_status};
use super::structs::{cylfuse_cylinder, cylfuse_mask_view};
use super::views::{Slot, optional_cylinder};
use crate::camera::Camera;
use crate::error::Error;
use crate::extent::ArcSample;
use crate::fitter::ResidualKind;
use crate::limb_location::{LimbObservation, LimbSample};

/// Lists residuals of the selected view.
///
/// @param fitter the fitter
/// @param model the model, in the reference frame; NULL = that of the last fit
/// @param kind which residuals
/// @param out room for `capacity` doubles, of any alignment; may be NULL when `capacity` is 0
/// @param capacity `points_used` of `cylfuse_fitter_counts` is enough for POINTS, 2 a segment for EDGES
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a model and a result, EDGE_GEOMETRY for EDGES when the camera is inside the
///   cylinder, NUMERICAL where no number holds a residual, BUFFER_TOO_SMALL, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_residuals(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    kind: cylfuse_residual_kind,
    out: *mut f64,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let count = unsafe { Slot::new(out_count, "out_count") }?;
        let kind = kind.read("kind")?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        if kind == ResidualKind::Edges {
            let residuals = content.fitter.residuals(model.as_ref(), kind)?;
            // SAFETY: as the header asks, `out` is NULL or room for `capacity` doubles.
            return unsafe { write_numbers(residuals.into_iter(), out, capacity, &count) };
        }
        // Without a list in between, for which memory may run out.
        let cylinder = content.fitter.model_or_result("listing residuals", model.as_ref())?;
        let seen = content.fitter.view().seen(&cylinder);
        let distances = content.fitter.cloud().points().map(|point| seen.distance(&point));
        if distances.clone().any(|distance| !distance.is_finite()) {
            return Err(Error::Numerical { what: "the residuals" }.into());
        }
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` doubles.
        unsafe { write_numbers(distances, out, capacity, &count) }
    })
}

/// Lists how much each point of the selected view counts at the cylinder of the last fit, in the order of the residuals
/// POINTS: by the weights of the objective ROBUST, whatever was minimised.
///
/// @param fitter the fitter
/// @param out_weights room for `capacity` doubles, of any alignment: from 1 for a point on the surface down to 0 for an
///   outlier, without the weight that the point was given. NULL = not wanted.
/// @param out_inliers room for `capacity` bytes: 1 for a point whose weight is above 0, else 0. NULL = not wanted.
/// @param capacity `points_used` of `cylfuse_fitter_counts` is enough
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a result, BUFFER_TOO_SMALL; else as `cylfuse_fitter_fit`, when data were cleared since
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_point_weights(
    fitter: *const cylfuse_fitter,
    out_weights: *mut f64,
    out_inliers: *mut u8,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let count = unsafe { Slot::new(out_count, "out_count") }?;
        last_result(&content.fitter, "listing weights")?;
        let weights = content.fitter.point_weights(None)?;
        let (needed, name) = (weights.len(), "the output");
        count.write(needed);
        if needed > capacity {
            return Err(Failure::BufferTooSmall { name, capacity, needed });
        }
        if !out_weights.is_null() {
            // SAFETY: as the header asks, `out_weights` is NULL or room for `capacity` doubles.
            let out = unsafe { Room::new(out_weights, needed, capacity, name) }?;
            out.fill(weights.iter().copied());
        }
        if !out_inliers.is_null() {
            let inliers = weights.iter().map(|weight| (*weight > 0.0).into());
            // SAFETY: as the header asks, `out_inliers` is NULL or room for `capacity` bytes.
            let out = unsafe { Room::new(out_inliers, needed, capacity, name) }?;
            out.fill(inliers);
        }
        Ok(())
    })
}

/// Tells what each point of the selected view belongs to, in the order of the residuals POINTS: the lateral surface of the
/// cylinder, or what else a mask of a whole object holds. A depth image tells where within the mask the lateral surface
/// ends; without one it goes on, and no point is of a cap.
///
/// @param fitter the fitter
/// @param model the model, in the reference frame; NULL = that of the last fit
/// @param out room for `capacity` parts, of one byte each; may be NULL when `capacity` is 0
/// @param capacity `points_used` of `cylfuse_fitter_counts` is enough
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a model and a result, BUFFER_TOO_SMALL, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_point_parts(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    out: *mut cylfuse_part,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let count = unsafe { Slot::new(out_count, "out_count") }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        let parts = content.fitter.point_parts(model.as_ref())?;
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` parts.
        unsafe { write_numbers(parts.into_iter().map(cylfuse_part::from), out, capacity, &count) }
    })
}

/// Lists the two limbs of the last fit in each view, view after view: where they were located in the image, or why
/// they were not. All are NOT_SEARCHED once data or options have changed since.
///
/// @param fitter the fitter
/// @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
///   is 0
/// @param element_size `sizeof(cylfuse_limb)`
/// @param capacity how many elements `out` holds
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a result, STRUCT_SIZE, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_limbs(
    fitter: *const cylfuse_fitter,
    out: *mut cylfuse_limb,
    element_size: usize,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` elements of `element_size` bytes and
        // `out_count` NULL or writable.
        let out = unsafe { OutputArray::new(out, element_size, capacity, out_count) }?;
        last_result(&content.fitter, "listing limbs")?;
        let (fitter, views) = (&content.fitter, content.fitter.view_count());
        out.write((0..views).flat_map(|view| {
            let seen = fitter.limbs_of(view);
            [0, 1].map(|limb| describe(view, limb, seen.map(|limbs| &limbs[limb])))
        }))
    })
}

fn describe(view: usize, limb: usize, seen: Option<&LimbObservation>) -> cylfuse_limb {
    let line = seen.map(|seen| seen.line);
    let status = match line {
        None => cylfuse_limb_status::NOT_SEARCHED,
        Some(Ok(_)) => cylfuse_limb_status::LOCATED,
        Some(Err(reason)) => reason.into(),
    };
    let line = line.and_then(Result::ok);
    cylfuse_limb {
        view: saturated(view),
        limb: saturated(limb),
        status,
        samples: saturated(seen.map_or(0, |seen| seen.samples.len())),
        line: line.map_or([f64::NAN; 4], |l| [l.ends[0].x, l.ends[0].y, l.ends[1].x, l.ends[1].y]),
        deviation: line.map_or(f64::NAN, |line| line.sigma),
    }
}

/// Lists what the last fit saw of the limbs in the image of the selected view, piece by piece, used and refused; all
/// samples of a limb that was not located in the end are refused. Empty when the image was not searched, and once data or
/// options have changed since.
///
/// @param fitter the fitter
/// @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
///   is 0
/// @param element_size `sizeof(cylfuse_limb_sample)`
/// @param capacity how many elements `out` holds
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE without a result, STRUCT_SIZE, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_limb_samples(
    fitter: *const cylfuse_fitter,
    out: *mut cylfuse_limb_sample,
    element_size: usize,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` elements of `element_size` bytes and
        // `out_count` NULL or writable.
        let out = unsafe { OutputArray::new(out, element_size, capacity, out_count) }?;
        last_result(&content.fitter, "listing limb samples")?;
        let Some((limbs, camera)) = content.fitter.limbs().zip(content.fitter.camera()) else {
            return out.write(std::iter::empty());
        };
        let view = saturated(content.fitter.selected_view());
        out.write((0..).zip(limbs).flat_map(move |(limb, observation)| {
            let samples = observation.samples.iter();
            samples.filter_map(move |sample| limb_sample(camera, (view, limb), observation, sample))
        }))
    })
}

/// `None` when a camera that was set after the fit does not see the place.
fn limb_sample(
    camera: &Camera,
    (view, limb): (u32, u32),
    observation: &LimbObservation,
    sample: &LimbSample,
) -> Option<cylfuse_limb_sample> {
    let pixel = camera.project(&camera.ideal_ray(&sample.position))?;
    let weight = if observation.uses(sample) { sample.weight } else { 0.0 };
    Some(cylfuse_limb_sample { view, limb, pixel: pixel.into(), deviation: sample.sigma, weight })
}

/// Lists the samples on the arcs of both ends that `cylfuse_fitter_extent` finds in the images, view after view: first
/// those of the start, then those of the end. There are none for an end that the image of a view does not show.
///
/// @param fitter the fitter, with intrinsics
/// @param model the model, in the reference frame; NULL = that of the last fit
/// @param mask the region, of the size of the intrinsics; NULL = the mask of the view
/// @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
///   is 0
/// @param element_size `sizeof(cylfuse_end_sample)`
/// @param capacity how many elements `out` holds
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return as `cylfuse_fitter_extent`; BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_end_samples(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    mask: *const cylfuse_mask_view,
    out: *mut cylfuse_end_sample,
    element_size: usize,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` elements of `element_size` bytes and
        // `out_count` NULL or writable.
        let out = unsafe { OutputArray::new(out, element_size, capacity, out_count) }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        let (_, arcs) = content.fitter.extent_and_arcs(model.as_ref(), mask.as_ref())?;
        let ends = (0..)
            .zip(&arcs)
            .flat_map(|(view, ends)| (0..).zip(ends).map(move |(end, samples)| (view, end, samples)));
        out.write(ends.flat_map(|(view, end, samples)| {
            samples.iter().map(move |sample: &ArcSample| cylfuse_end_sample {
                view,
                end,
                pixel: sample.pixel.into(),
                normal: sample.normal.into(),
                deviation: sample.deviation,
            })
        }))
    })
}
