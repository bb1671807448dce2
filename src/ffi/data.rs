//! Pushing observations. Each call adds to what was pushed before.

use super::constants::cylfuse_log_level;
use super::handle::{Content, cylfuse_fitter, enter_to_change, enter_to_read};
use super::results::cylfuse_counts;
use super::sized::{Output, read, read_optional};
use super::status::{Failure, cylfuse_status};
use super::structs::{
    cylfuse_depth_view, cylfuse_image_view, cylfuse_mask_view, cylfuse_points_view, cylfuse_segments_view,
};
use super::views;
use crate::observations::MaskView;

/// A mask that may be missing.
///
/// # Safety
/// `mask` is NULL or a mask whose pixels are readable during `'a`.
pub(super) unsafe fn optional_mask<'a>(
    mask: *const cylfuse_mask_view,
) -> Result<Option<MaskView<'a>>, Failure> {
    // SAFETY: the caller promises a mask or NULL.
    let mask = unsafe { read_optional(mask, "mask") }?;
    // SAFETY: the caller promises that its pixels can be read during `'a`.
    mask.map(|mask| unsafe { views::mask_view(&mask) }).transpose()
}

pub(super) fn log_points(content: &Content, what: &str) {
    content.log.write(cylfuse_log_level::INFO, || {
        let cloud = content.fitter.cloud();
        format!("{what} pushed: {} of {} points so far are usable", cloud.len(), cloud.given())
    });
}

/// Adds points to the selected view, in its camera frame (x right, y down, z forward) when edges, the near-wall rule,
/// completion or extent matter, else in any frame. Points with a coordinate that is not finite, a weight of 0 or outside the
/// mask are left out and counted.
///
/// @param fitter the fitter
/// @param points read during the call only
/// @param mask selects pixels of an organised cloud, of the same size as it; NULL = all. Read during the call
///   only.
/// @return SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT for a negative weight or a bad stride, OUT_OF_MEMORY;
///   nothing is added then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_push_points(
    fitter: *mut cylfuse_fitter,
    points: *const cylfuse_points_view,
    mask: *const cylfuse_mask_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `points` is NULL or points that can be read.
        let view = unsafe { read(points, "points") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let points = unsafe { views::points_view(&view) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        content.fitter.push_points(&points, mask.as_ref())?;
        log_points(content, "cloud");
        Ok(())
    })
}

/// Adds the points of a depth image of the selected view; `cylfuse_fitter_set_intrinsics` comes before. Pixels without
/// a depth, out of range, outside the mask or hidden from the colour camera are left out and counted. The image and the
/// mask are kept, in place of earlier ones, for completion and extent.
///
/// @param fitter the fitter
/// @param depth read during the call only
/// @param mask in the pixels of the colour image; NULL = all pixels. Read during the call only.
/// @return BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel is usable,
///   INVALID_ARGUMENT for a bad scale, range or stride, OUT_OF_MEMORY; nothing is added then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_push_depth(
    fitter: *mut cylfuse_fitter,
    depth: *const cylfuse_depth_view,
    mask: *const cylfuse_mask_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `depth` is NULL or a depth image that can be read.
        let view = unsafe { read(depth, "depth") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let (depth, range) = unsafe { views::depth_view(&view) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        content.fitter.push_depth(&depth, mask.as_ref(), &range)?;
        log_points(content, "depth image");
        Ok(())
    })
}

/// Takes the image of the selected view, grey or in colour, in place of an earlier one;
/// `cylfuse_fitter_set_intrinsics` comes before.
/// With the objective ROBUST the limbs and the arcs of the ends are located in it and join the fit; with the extent
/// rule LOCATED the ends are. The objective PAPER and the methods other than FUSED never look at it. Without a mask and
/// without edges the limbs are looked for beside the outline of the points, where these are as dense as the image.
///
/// @param fitter the fitter
/// @param image read during the call only
/// @return BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad stride or gamma, or a value that is
///   not finite or that the gamma forbids, OUT_OF_MEMORY; the earlier image stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_push_image(
    fitter: *mut cylfuse_fitter,
    image: *const cylfuse_image_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `image` is NULL or an image that can be read.
        let view = unsafe { read(image, "image") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let image = unsafe { views::image_view(&view) }?;
        content.fitter.push_image(&image)?;
        content.log.write(cylfuse_log_level::INFO, || "image pushed".into());
        Ok(())
    })
}

/// Adds edge segments to the selected view: pieces of the two limb lines in the (distorted) image, any number of
/// either. A fit with segments needs intrinsics.
///
/// @param fitter the fitter
/// @param segments read during the call only
/// @return INVALID_ARGUMENT when a coordinate is not finite or a weight is negative, OUT_OF_MEMORY; nothing is
///   added then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_push_edges(
    fitter: *mut cylfuse_fitter,
    segments: *const cylfuse_segments_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `segments` is NULL or segments that can be read.
        let view = unsafe { read(segments, "segments") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let segments = unsafe { views::segments(&view) }?;
        content.fitter.push_edges(&segments)?;
        let count = content.fitter.segments().len();
        content.log.write(cylfuse_log_level::INFO, || format!("edges pushed: {count} segments so far"));
        Ok(())
    })
}

/// Says what was pushed into the selected view since the fitter was created or cleared, and what was left out by
/// reason.
///
/// @param fitter the fitter
/// @param out_counts where the counts go; `cylfuse_counts_init` comes before
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_counts(
    fitter: *const cylfuse_fitter,
    out_counts: *mut cylfuse_counts,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_counts` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_counts, "out_counts") }?;
        let cloud = content.fitter.cloud();
        let dropped = cloud.dropped();
        out.write(&cylfuse_counts {
            struct_size: size_of::<cylfuse_counts>() as u32,
            view: content.fitter.selected_view() as u32,
            points_given: cloud.given() as u64,
            points_used: cloud.len() as u64,
            dropped_not_finite: dropped.not_finite as u64,
            dropped_zero_weight: dropped.zero_weight as u64,
            dropped_outside_mask: dropped.outside_mask as u64,
            dropped_no_depth: dropped.no_depth as u64,
            dropped_out_of_range: dropped.out_of_range as u64,
            dropped_outside_camera: dropped.outside_camera as u64,
            segments_given: content.fitter.segments().len() as u64,
            dropped_hidden: dropped.hidden as u64,
        });
        Ok(())
    })
}
