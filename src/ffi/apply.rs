//! What follows a fit: completion, extent, the choice of edges.

use super::constants::cylfuse_layout;
use super::data::optional_mask;
use super::handle::{cylfuse_fitter, enter_to_read};
use super::lists::Room;
use super::options::saturated;
use super::results::{cylfuse_completion, cylfuse_extent};
use super::sized::{Output, read, zeroed};
use super::status::{Failure, cylfuse_status};
use super::structs::{
    cylfuse_cylinder, cylfuse_depth_out, cylfuse_mask_view, cylfuse_points_out, cylfuse_segments_view,
};
use super::views::{self, Grid, Slot, optional_cylinder, pixel_size};
use crate::completion::{CompletionCounts, Region};
use crate::error::positive;
use crate::extent::{Extent, ExtentUncertainty};
use crate::fitter::Fitter;
use crate::geometry::Cylinder;
use crate::observations::{LARGEST_STORED_DEPTH, MaskView, Pixels, Scalar};
use nalgebra::{Matrix3, Vector3};

const CALL: &str = "completing the points";

/// Says how many points a completion of the selected view may give at most.
///
/// @param fitter the fitter
/// @param mask the region; NULL = the mask of the view
/// @param layout for which layout
/// @param out_capacity where the number goes: the set pixels of the mask when packed, all pixels of the image
///   when organised
/// @return BAD_STATE without intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_complete_bound(
    fitter: *const cylfuse_fitter,
    mask: *const cylfuse_mask_view,
    layout: cylfuse_layout,
    out_capacity: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_capacity` is NULL or writable.
        let out = unsafe { Slot::new(out_capacity, "out_capacity") }?;
        let organised = layout.read("layout")?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        let region = Region::new(CALL, &content.fitter, mask.as_ref())?;
        out.write(bound(&region, organised));
        Ok(())
    })
}

fn bound(region: &Region<'_>, organised: bool) -> usize {
    let mask = &*region.mask;
    if organised { mask.width() * mask.height() } else { mask.count() }
}

/// Completes the cloud of the selected view: casts the ray of every pixel of a mask and takes its first meeting with
/// the cylinder, the near wall from outside, the far one from inside a pipe. The points are in the reference frame,
/// so that those of all views go together.
///
/// @param fitter the fitter, with intrinsics
/// @param model the model, in the reference frame; NULL = that of the last fit
/// @param mask the region, of the size of the intrinsics; NULL = the mask of the view
/// @param layout how the points are arranged
/// @param out the buffer: `cylfuse_fitter_complete_bound` says what is enough. Must not overlap with what the
///   other parameters point to.
/// @param out_completion what became of the pixels; `cylfuse_completion_init` comes before. After BUFFER_TOO_SMALL its
///   `count` is the capacity that is needed.
/// @return BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT,
///   BUFFER_TOO_SMALL; no point is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_complete(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    mask: *const cylfuse_mask_view,
    layout: cylfuse_layout,
    out: *const cylfuse_points_out,
    out_completion: *mut cylfuse_completion,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_completion` is NULL or room for its `struct_size`.
        let out_completion = unsafe { Output::new(out_completion, "out_completion") }?;
        let organised = layout.read("layout")?;
        // SAFETY: as the header asks, `out` is NULL or a buffer that can be written.
        let out = unsafe { read(out, "out") }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        // SAFETY: as the header asks, the buffer is NULL or can be written as its fields describe.
        let completed = unsafe { complete(&content.fitter, model.as_ref(), mask.as_ref(), organised, &out) };
        match completed {
            Ok((count, counts, out_of_range)) => {
                out_completion.write(&completion(&content.fitter, count, &counts, out_of_range));
                Ok(())
            }
            Err(Failure::BufferTooSmall { name, capacity, needed }) => {
                let view = saturated(content.fitter.selected_view());
                out_completion.write(&cylfuse_completion { view, count: needed as u64, ..zeroed() });
                Err(Failure::BufferTooSmall { name, capacity, needed })
            }
            Err(failure) => Err(failure),
        }
    })
}

fn completion(
    fitter: &Fitter,
    count: usize,
    counts: &CompletionCounts,
    out_of_range: u64,
) -> cylfuse_completion {
    cylfuse_completion {
        struct_size: size_of::<cylfuse_completion>() as u32,
        view: saturated(fitter.selected_view()),
        count: count as u64,
        hits: counts.hits as u64,
        misses: counts.misses as u64,
        outside_camera: counts.outside_camera as u64,
        out_of_range,
    }
}

/// How many points were written, what became of the pixels, and how many points the scalar does not hold.
///
/// # Safety
/// `out.data` is NULL or writable as the fields of `out` describe.
unsafe fn complete(
    fitter: &Fitter,
    model: Option<&Cylinder>,
    mask: Option<&MaskView<'_>>,
    organised: bool,
    out: &cylfuse_points_out,
) -> Result<(usize, CompletionCounts, u64), Failure> {
    let scalar = out.scalar.read("out.scalar")?;
    if !organised && out.row_stride != 0 {
        return Err(Failure::argument("out.row_stride", out.row_stride, "be 0 for packed points"));
    }
    let region = Region::new(CALL, fitter, mask)?;
    let bound = bound(&region, organised);
    if out.capacity < bound {
        // Fewer rays than pixels may hit; counting them first is only needed here.
        let needed = if organised { bound } else { fitter.complete(model, mask, &mut |_, _, _| ())?.hits };
        if out.capacity < needed {
            return Err(Failure::BufferTooSmall { name: "out.data", capacity: out.capacity, needed });
        }
    }
    let (width, height) = match organised {
        true => (region.mask.width(), region.mask.height()),
        false => (out.capacity.min(bound), 1),
    };
    let grid = Grid {
        name: "out.data",
        element: "point",
        width,
        height,
        element_size: 3 * scalar.size(),
        element_stride: out.point_stride,
        row_stride: out.row_stride,
    };
    let grid = grid.check(out.data)?;
    let (mut count, mut out_of_range) = (0, 0);
    let holds = |point: &Vector3<f64>| match scalar {
        Scalar::F32 => point.iter().all(|x| (*x as f32).is_finite()),
        Scalar::F64 => point.iter().all(|x| x.is_finite()),
    };
    let counts = fitter.complete(model, mask, &mut |column, row, point| {
        out_of_range += u64::from(point.as_ref().is_some_and(|point| !holds(point)));
        let point = point.filter(|point| holds(point));
        let offset = match (organised, &point) {
            (true, _) => grid.offset(column, row),
            (false, Some(_)) => grid.offset(count, 0),
            (false, None) => return,
        };
        let point = point.unwrap_or(Vector3::repeat(f64::NAN));
        // SAFETY: inside the checked grid: (column, row) is a pixel of the image, and a packed count is below
        // the number of hits, which fits the capacity.
        unsafe { write_point(out.data.cast::<u8>().offset(offset), scalar, &point) };
        count += 1;
    })?;
    Ok((count, counts, out_of_range))
}

/// # Safety
/// `at` is writable for three scalars.
unsafe fn write_point(at: *mut u8, scalar: Scalar, point: &Vector3<f64>) {
    match scalar {
        // SAFETY: the caller promises room for three scalars of this type, and the write assumes no alignment.
        Scalar::F32 => unsafe { at.cast::<[f32; 3]>().write_unaligned(point.map(|x| x as f32).into()) },
        // SAFETY: the caller promises room for three scalars of this type, and the write assumes no alignment.
        Scalar::F64 => unsafe { at.cast::<[f64; 3]>().write_unaligned((*point).into()) },
    }
}

/// Completes the depth image of the selected view, on the pixels of its colour image: writes the z in its camera frame of
/// every point of `cylfuse_fitter_complete`, and 0 where there is none.
///
/// @param fitter the fitter, with intrinsics
/// @param model the model, in the reference frame; NULL = that of the last fit
/// @param mask the region, of the size of the intrinsics; NULL = the mask of the view
/// @param out the image, of the size of the intrinsics: every pixel of it is written. Must not overlap with what
///   the other parameters point to.
/// @param out_completion what became of the pixels; `cylfuse_completion_init` comes before. Its `count` is the number of
///   pixels with a depth.
/// @return BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT; nothing is
///   written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_complete_depth(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    mask: *const cylfuse_mask_view,
    out: *const cylfuse_depth_out,
    out_completion: *mut cylfuse_completion,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_completion` is NULL or room for its `struct_size`.
        let out_completion = unsafe { Output::new(out_completion, "out_completion") }?;
        // SAFETY: as the header asks, `out` is NULL or a buffer that can be written.
        let out = unsafe { read(out, "out") }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        // SAFETY: as the header asks, the buffer is NULL or can be written as its fields describe.
        let completion = unsafe { complete_depth(&content.fitter, model.as_ref(), mask.as_ref(), &out) }?;
        out_completion.write(&completion);
        Ok(())
    })
}

/// # Safety
/// `out.data` is NULL or writable as the fields of `out` describe.
unsafe fn complete_depth(
    fitter: &Fitter,
    model: Option<&Cylinder>,
    mask: Option<&MaskView<'_>>,
    out: &cylfuse_depth_out,
) -> Result<cylfuse_completion, Failure> {
    let format = out.format.read("out.format")?;
    positive("out.scale", out.scale)?;
    let region = Region::new("completing the depth image", fitter, mask)?;
    let (width, height) = (out.width as usize, out.height as usize);
    region.mask.check_size("the depth image to be written", (width, height))?;
    let grid = Grid {
        name: "out.data",
        element: "pixel",
        width,
        height,
        element_size: pixel_size(format),
        element_stride: out.pixel_stride,
        row_stride: out.row_stride,
    };
    let grid = grid.check(out.data)?;
    let (mut count, mut out_of_range) = (0, 0);
    let counts = fitter.complete_depth(model, mask, &mut |column, row, depth| {
        let stored = depth.map_or(0.0, |depth| stored_depth(format, depth / out.scale));
        if stored > 0.0 {
            count += 1;
        } else if depth.is_some() {
            out_of_range += 1;
        }
        // SAFETY: (column, row) is a pixel of the image, which the checked grid covers.
        unsafe { write_depth(out.data.cast::<u8>().offset(grid.offset(column, row)), format, stored) };
    })?;
    Ok(completion(fitter, count, &counts, out_of_range))
}

/// What a pixel can hold of a depth in its unit; 0 when it cannot.
fn stored_depth(format: Pixels, value: f64) -> f64 {
    let stored = match format {
        Pixels::U16 => value.round(),
        Pixels::F32 => f64::from(value as f32),
    };
    let largest = match format {
        Pixels::U16 => f64::from(LARGEST_STORED_DEPTH),
        Pixels::F32 => f64::from(f32::MAX),
    };
    if stored <= largest { stored } else { 0.0 }
}

/// # Safety
/// `at` is writable for a pixel.
unsafe fn write_depth(at: *mut u8, format: Pixels, stored: f64) {
    match format {
        // SAFETY: the caller promises room for a pixel of this format, and the write assumes no alignment.
        Pixels::U16 => unsafe { at.cast::<u16>().write_unaligned(stored as u16) },
        // SAFETY: the caller promises room for a pixel of this format, and the write assumes no alignment.
        Pixels::F32 => unsafe { at.cast::<f32>().write_unaligned(stored as f32) },
    }
}

impl From<&Extent> for cylfuse_extent {
    fn from(extent: &Extent) -> Self {
        let uncertainty = extent.uncertainty.as_ref();
        let entries = |pick: fn(&ExtentUncertainty) -> &Matrix3<f64>| {
            let mut entries = [f64::NAN; 9];
            if let Some(uncertainty) = uncertainty {
                entries.copy_from_slice(pick(uncertainty).as_slice());
            }
            entries
        };
        Self {
            struct_size: size_of::<Self>() as u32,
            start_state: extent.start_state.into(),
            end_state: extent.end_state.into(),
            start_source: extent.start_source.into(),
            end_source: extent.end_source.into(),
            start_view: saturated(extent.start_view),
            end_view: saturated(extent.end_view),
            limbs_known: extent.limbs_known.into(),
            start: extent.start.into(),
            end: extent.end.into(),
            center: extent.center.into(),
            length: extent.length,
            start_deviation: extent.start_deviation.unwrap_or(f64::NAN),
            end_deviation: extent.end_deviation.unwrap_or(f64::NAN),
            length_deviation: uncertainty.map_or(f64::NAN, |uncertainty| uncertainty.length),
            start_covariance: entries(|uncertainty| &uncertainty.start),
            end_covariance: entries(|uncertainty| &uncertainty.end),
            center_covariance: entries(|uncertainty| &uncertainty.center),
        }
    }
}

/// Finds the visible piece of the cylinder and what its ends are: in a view with a camera and a mask by the `extent_rule`
/// of the options, in others, and from inside a pipe, by the points on the surface. A fit without a mask may have made an
/// outline of the points, which then serves as the mask. An end that is seen in several views is their mean by their
/// variances; one that is seen in none is the outermost of what they show, by views with a mask if there are any. The extent
/// of another model than the last fit's states no `length_deviation` and no covariances, which are NaN.
///
/// @param fitter the fitter
/// @param model the model, in the reference frame; NULL = that of the last fit
/// @param mask the region in the selected view, of the size of its intrinsics; NULL = the mask of the view
/// @param out_extent where the extent goes; `cylfuse_extent_init` comes before
/// @return BAD_STATE without a model, without points or a mask, and for a mask that is given without intrinsics;
///   SIZE_MISMATCH, EMPTY_MASK, EDGE_GEOMETRY when no ray of the mask meets the cylinder and no points lie along it
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_extent(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    mask: *const cylfuse_mask_view,
    out_extent: *mut cylfuse_extent,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_extent` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_extent, "out_extent") }?;
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        let extent = content.fitter.extent(model.as_ref(), mask.as_ref())?;
        out.write(&(&extent).into());
        Ok(())
    })
}

/// Selects, of straight edges that a line detector found in the image, those on the two limbs of a rough cylinder
/// beside the points that were pushed, such as a fit to these points alone. For each limb the edge with the longest
/// pieces wins, the nearer the limb the better, if they cover 30 % of it. Nothing is pushed.
///
/// @param fitter the fitter, with intrinsics and points
/// @param model the rough cylinder; NULL = that of the last fit
/// @param segments the edges in pixels of the (distorted) image; weights are ignored
/// @param reach how far a limb may be from that of the model, in pixels, 0 or greater; 0 = 15 % of the distance of
///   the limbs, at least 4
/// @param out_limbs room for `capacity` bytes, one for each segment: 1 or 2 for the limb that it lies on, in the
///   order of `cylfuse_cylinder_project`, 0 for none. May be NULL when `capacity` is 0.
/// @param capacity at least the count of the segments
/// @return BAD_STATE without model, intrinsics or points, INVALID_ARGUMENT for a bad segment or reach, EDGE_GEOMETRY
///   when the camera is inside the cylinder or a limb cannot be seen, BUFFER_TOO_SMALL; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_select_edges(
    fitter: *const cylfuse_fitter,
    model: *const cylfuse_cylinder,
    segments: *const cylfuse_segments_view,
    reach: f64,
    out_limbs: *mut u8,
    capacity: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { optional_cylinder(model) }?;
        // SAFETY: as the header asks, `segments` is NULL or segments that can be read.
        let view = unsafe { read(segments, "segments") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let segments = unsafe { views::segments(&view) }?;
        let needed = segments.len();
        // SAFETY: as the header asks, `out_limbs` is NULL or room for `capacity` bytes.
        let out = unsafe { Room::new(out_limbs, needed, capacity, "out_limbs") }?;
        let found = content.fitter.select_edges(&segments, model.as_ref(), reach)?;
        out.fill(std::iter::repeat(0));
        for (number, indices) in (1..).zip(found) {
            for index in indices {
                out.set(index, number);
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_that_do_not_fit_become_zero() {
        let u16 = |value| stored_depth(Pixels::U16, value);
        assert_eq!([u16(0.4), u16(0.6), u16(65534.4), u16(65534.6)], [0.0, 1.0, 65534.0, 0.0]);
        let f32 = |value| stored_depth(Pixels::F32, value);
        assert_eq!([f32(1e-60), f32(0.5), f32(1e60)], [0.0, 0.5, 0.0]);
    }
}
