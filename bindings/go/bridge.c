/* SPDX-License-Identifier: MIT OR Apache-2.0 */
#include "bridge.h"

#include "_cgo_export.h"

/* A copy of a mask view with its pixels; NULL stays NULL. */
static const cylfuse_mask_view *with_pixels(cylfuse_mask_view *copy, const cylfuse_mask_view *mask,
                                            const uint8_t *data)
{
    if (mask == NULL) return NULL;
    *copy = *mask;
    copy->data = data;
    return copy;
}

cylfuse_status bridge_push_points(cylfuse_fitter *fitter, const cylfuse_points_view *points, const uint8_t *data,
                                  const uint8_t *weights, const uint8_t *normals, const cylfuse_mask_view *mask,
                                  const uint8_t *mask_data)
{
    cylfuse_mask_view mask_copy;
    cylfuse_points_view view = *points;
    view.data = data;
    view.weights = weights;
    view.normals = normals;
    return cylfuse_fitter_push_points(fitter, &view, with_pixels(&mask_copy, mask, mask_data));
}

cylfuse_status bridge_detect_points(cylfuse_detector *detector, const cylfuse_points_view *points, const uint8_t *data,
                                    const uint8_t *weights, const uint8_t *normals)
{
    cylfuse_points_view view = *points;
    view.data = data;
    view.weights = weights;
    view.normals = normals;
    return cylfuse_detector_detect_points(detector, &view);
}

cylfuse_status bridge_push_depth(cylfuse_fitter *fitter, const cylfuse_depth_view *depth, const uint8_t *data,
                                 const cylfuse_mask_view *mask, const uint8_t *mask_data)
{
    cylfuse_mask_view mask_copy;
    cylfuse_depth_view view = *depth;
    view.data = data;
    return cylfuse_fitter_push_depth(fitter, &view, with_pixels(&mask_copy, mask, mask_data));
}

cylfuse_status bridge_push_image(cylfuse_fitter *fitter, const cylfuse_image_view *image, const uint8_t *data)
{
    cylfuse_image_view view = *image;
    view.data = data;
    return cylfuse_fitter_push_image(fitter, &view);
}

cylfuse_status bridge_push_edges(cylfuse_fitter *fitter, const cylfuse_segments_view *segments, const uint8_t *data,
                                 const double *weights)
{
    cylfuse_segments_view view = *segments;
    view.data = data;
    view.weights = weights;
    return cylfuse_fitter_push_edges(fitter, &view);
}

cylfuse_status bridge_complete_bound(cylfuse_fitter *fitter, const cylfuse_mask_view *mask, const uint8_t *mask_data,
                                     cylfuse_layout layout, size_t *out_capacity)
{
    cylfuse_mask_view mask_copy;
    return cylfuse_fitter_complete_bound(fitter, with_pixels(&mask_copy, mask, mask_data), layout, out_capacity);
}

cylfuse_status bridge_complete(cylfuse_fitter *fitter, const cylfuse_cylinder *model, const cylfuse_mask_view *mask,
                               const uint8_t *mask_data, cylfuse_layout layout, const cylfuse_points_out *out,
                               uint8_t *data, cylfuse_completion *out_completion)
{
    cylfuse_mask_view mask_copy;
    cylfuse_points_out buffer = *out;
    buffer.data = data;
    return cylfuse_fitter_complete(fitter, model, with_pixels(&mask_copy, mask, mask_data), layout, &buffer,
                                   out_completion);
}

cylfuse_status bridge_complete_depth(cylfuse_fitter *fitter, const cylfuse_cylinder *model,
                                     const cylfuse_mask_view *mask, const uint8_t *mask_data,
                                     const cylfuse_depth_out *out, uint8_t *data, cylfuse_completion *out_completion)
{
    cylfuse_mask_view mask_copy;
    cylfuse_depth_out image = *out;
    image.data = data;
    return cylfuse_fitter_complete_depth(fitter, model, with_pixels(&mask_copy, mask, mask_data), &image,
                                         out_completion);
}

cylfuse_status bridge_extent(cylfuse_fitter *fitter, const cylfuse_cylinder *model, const cylfuse_mask_view *mask,
                             const uint8_t *mask_data, cylfuse_extent *out_extent)
{
    cylfuse_mask_view mask_copy;
    return cylfuse_fitter_extent(fitter, model, with_pixels(&mask_copy, mask, mask_data), out_extent);
}

cylfuse_status bridge_end_samples(cylfuse_fitter *fitter, const cylfuse_cylinder *model, const cylfuse_mask_view *mask,
                                  const uint8_t *mask_data, cylfuse_end_sample *out, size_t capacity,
                                  size_t *out_count)
{
    cylfuse_mask_view mask_copy;
    return cylfuse_fitter_end_samples(fitter, model, with_pixels(&mask_copy, mask, mask_data), out, sizeof *out, capacity,
                                      out_count);
}

cylfuse_status bridge_use_frame(cylfuse_fitter *fitter, const cylfuse_frame *frame, const cylfuse_mask_view *mask,
                                const uint8_t *mask_data)
{
    cylfuse_mask_view mask_copy;
    return cylfuse_fitter_use_frame(fitter, frame, with_pixels(&mask_copy, mask, mask_data));
}

cylfuse_status bridge_frame_set_depth(cylfuse_frame *frame, const cylfuse_depth_view *depth, const uint8_t *data)
{
    cylfuse_depth_view view = *depth;
    view.data = data;
    return cylfuse_frame_set_depth(frame, &view);
}

cylfuse_status bridge_frame_set_image(cylfuse_frame *frame, const cylfuse_image_view *image, const uint8_t *data)
{
    cylfuse_image_view view = *image;
    view.data = data;
    return cylfuse_frame_set_image(frame, &view);
}

cylfuse_status bridge_intrinsics_project(const cylfuse_intrinsics *intrinsics, const cylfuse_points_view *points,
                                         const uint8_t *data, double *out, size_t capacity)
{
    cylfuse_points_view view = *points;
    view.data = data;
    return cylfuse_intrinsics_project(intrinsics, &view, out, capacity);
}

cylfuse_status bridge_distances(const cylfuse_cylinder *model, const cylfuse_points_view *points, const uint8_t *data,
                                double *out, size_t capacity)
{
    cylfuse_points_view view = *points;
    view.data = data;
    return cylfuse_cylinder_distances(model, &view, out, capacity);
}

cylfuse_status bridge_select_edges(cylfuse_fitter *fitter, const cylfuse_cylinder *model,
                                   const cylfuse_segments_view *segments, const uint8_t *data, double reach,
                                   uint8_t *out_limbs, size_t capacity)
{
    cylfuse_segments_view view = *segments;
    view.data = data;
    return cylfuse_fitter_select_edges(fitter, model, &view, reach, out_limbs, capacity);
}

/* The call on a fitter or detector that this thread is in: a handle of Go, 0 for none. */
static _Thread_local uintptr_t current;

uintptr_t bridge_enter(uintptr_t call)
{
    uintptr_t outer = current;
    current = call;
    return outer;
}

static int32_t hear_progress(const cylfuse_progress *progress, void *user_data)
{
    (void)user_data;
    return cylfuseGoProgress((cylfuse_progress *)progress, current);
}

static void hear_log(cylfuse_log_level level, const char *message, void *user_data)
{
    (void)user_data;
    cylfuseGoLog(level, (char *)message, current);
}

static int32_t hear_detection_progress(const cylfuse_detection_progress *progress, void *user_data)
{
    (void)user_data;
    return cylfuseGoDetectionProgress((cylfuse_detection_progress *)progress, current);
}

cylfuse_status bridge_set_progress(cylfuse_fitter *fitter, int32_t on)
{
    return cylfuse_fitter_set_progress(fitter, on ? hear_progress : NULL, NULL);
}

cylfuse_status bridge_set_log(cylfuse_fitter *fitter, cylfuse_log_level max_level, int32_t on)
{
    return cylfuse_fitter_set_log(fitter, max_level, on ? hear_log : NULL, NULL);
}

cylfuse_status bridge_set_detection_progress(cylfuse_detector *detector, int32_t on)
{
    return cylfuse_detector_set_progress(detector, on ? hear_detection_progress : NULL, NULL);
}

static int32_t hear_fit_ended(size_t index, cylfuse_status status, void *call)
{
    return cylfuseGoFitEnded(index, status, (uintptr_t)call);
}

cylfuse_status bridge_fit_all(cylfuse_fitter **fitters, size_t count, uint32_t threads, int32_t on, uintptr_t call,
                              cylfuse_status *out_statuses)
{
    return cylfuse_fit_all(fitters, count, threads, on ? hear_fit_ended : NULL, (void *)call, out_statuses);
}
