/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/*
 * Between Go and the C interface. Go may hand pointers to its memory to C as arguments, but not inside structs:
 * these functions take the pointers one by one and put them into copies of the structs. Data are pointers to bytes and
 * not to void because cgo refuses a `void *` into memory that has Go pointers anywhere, such as an array that is a
 * field of a Go struct.
 */

#ifndef CYLFUSE_GO_BRIDGE_H
#define CYLFUSE_GO_BRIDGE_H

#include "cylfuse.h"

/* `mask` and what else may be NULL in the C interface may be NULL here. */
cylfuse_status bridge_push_points(cylfuse_fitter *fitter, const cylfuse_points_view *points, const uint8_t *data,
                                  const uint8_t *weights, const uint8_t *normals, const cylfuse_mask_view *mask,
                                  const uint8_t *mask_data);
cylfuse_status bridge_push_depth(cylfuse_fitter *fitter, const cylfuse_depth_view *depth, const uint8_t *data,
                                 const cylfuse_mask_view *mask, const uint8_t *mask_data);
cylfuse_status bridge_push_image(cylfuse_fitter *fitter, const cylfuse_image_view *image, const uint8_t *data);
cylfuse_status bridge_push_edges(cylfuse_fitter *fitter, const cylfuse_segments_view *segments, const uint8_t *data,
                                 const double *weights);
cylfuse_status bridge_complete_bound(cylfuse_fitter *fitter, const cylfuse_mask_view *mask, const uint8_t *mask_data,
                                     cylfuse_layout layout, size_t *out_capacity);
cylfuse_status bridge_complete(cylfuse_fitter *fitter, const cylfuse_cylinder *model, const cylfuse_mask_view *mask,
                               const uint8_t *mask_data, cylfuse_layout layout, const cylfuse_points_out *out,
                               uint8_t *data, cylfuse_completion *out_completion);
cylfuse_status bridge_complete_depth(cylfuse_fitter *fitter, const cylfuse_cylinder *model,
                                     const cylfuse_mask_view *mask, const uint8_t *mask_data,
                                     const cylfuse_depth_out *out, uint8_t *data, cylfuse_completion *out_completion);
cylfuse_status bridge_extent(cylfuse_fitter *fitter, const cylfuse_cylinder *model, const cylfuse_mask_view *mask,
                             const uint8_t *mask_data, cylfuse_extent *out_extent);
cylfuse_status bridge_end_samples(cylfuse_fitter *fitter, const cylfuse_cylinder *model, const cylfuse_mask_view *mask,
                                  const uint8_t *mask_data, cylfuse_end_sample *out, size_t capacity,
                                  size_t *out_count);
cylfuse_status bridge_use_frame(cylfuse_fitter *fitter, const cylfuse_frame *frame, const cylfuse_mask_view *mask,
                                const uint8_t *mask_data);
cylfuse_status bridge_detect_points(cylfuse_detector *detector, const cylfuse_points_view *points, const uint8_t *data,
                                    const uint8_t *weights, const uint8_t *normals);
cylfuse_status bridge_frame_set_depth(cylfuse_frame *frame, const cylfuse_depth_view *depth, const uint8_t *data);
cylfuse_status bridge_frame_set_image(cylfuse_frame *frame, const cylfuse_image_view *image, const uint8_t *data);
cylfuse_status bridge_intrinsics_project(const cylfuse_intrinsics *intrinsics, const cylfuse_points_view *points,
                                         const uint8_t *data, double *out, size_t capacity);
cylfuse_status bridge_distances(const cylfuse_cylinder *model, const cylfuse_points_view *points, const uint8_t *data,
                                double *out, size_t capacity);
cylfuse_status bridge_select_edges(cylfuse_fitter *fitter, const cylfuse_cylinder *model,
                                   const cylfuse_segments_view *segments, const uint8_t *data, double reach,
                                   uint8_t *out_limbs, size_t capacity);

/*
 * Says which call the thread is in, for the callbacks, which the library makes on the thread of the call: a handle of Go
 * (0 for none). Returns the call around it.
 */
uintptr_t bridge_enter(uintptr_t call);

/* Sets or takes away the callbacks that call Go. */
cylfuse_status bridge_set_progress(cylfuse_fitter *fitter, int32_t on);
cylfuse_status bridge_set_log(cylfuse_fitter *fitter, cylfuse_log_level max_level, int32_t on);
cylfuse_status bridge_set_detection_progress(cylfuse_detector *detector, int32_t on);

/* Fits all; with `on` each fit that ended is told to Go, with the handle of Go. */
cylfuse_status bridge_fit_all(cylfuse_fitter **fitters, size_t count, uint32_t threads, int32_t on, uintptr_t call,
                              cylfuse_status *out_statuses);

#endif
