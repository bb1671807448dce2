//! The structs have one layout in Rust, in C and in the committed list, without padding.

#![allow(clippy::unwrap_used, reason = "a test program")]

mod common;

use common::{assert_committed, c_compiler, root, run, scratch};
use cylfuse::ffi::*;
use std::process::Command;

/// A struct with its size and the name, offset and size of each field.
type Layout = (&'static str, usize, Vec<(&'static str, usize, usize)>);

/// Size of the field that a function picks.
fn size_of_field<S, F>(_: fn(&S) -> &F) -> usize {
    size_of::<F>()
}

// offset_of! wants the names as they are, hence a macro.
macro_rules! layouts {
    ($($name:ident { $($field:ident),* $(,)? })*) => {
        vec![$((
            stringify!($name),
            size_of::<$name>(),
            vec![$((
                stringify!($field),
                std::mem::offset_of!($name, $field),
                size_of_field(|s: &$name| &s.$field),
            )),*],
        )),*]
    };
}

fn layouts() -> Vec<Layout> {
    layouts! {
        cylfuse_cylinder { point, direction, radius }
        cylfuse_intrinsics { struct_size, distortion_model, width, height, fx, fy, cx, cy, distortion }
        cylfuse_points_view {
            struct_size, scalar, data, width, height, point_stride, row_stride, weights, weight_stride,
            weight_row_stride, normals, normal_stride, normal_row_stride,
        }
        cylfuse_points_out { struct_size, scalar, data, capacity, point_stride, row_stride }
        cylfuse_depth_view {
            struct_size, format, data, width, height, row_stride, pixel_stride, scale, min_depth, max_depth,
        }
        cylfuse_depth_out { struct_size, format, data, width, height, row_stride, pixel_stride, scale }
        cylfuse_mask_view { struct_size, width, height, label, data, row_stride, pixel_stride }
        cylfuse_image_view { struct_size, format, data, width, height, row_stride, pixel_stride, gamma }
        cylfuse_segments_view { struct_size, scalar, data, count, segment_stride, weights }
        cylfuse_options {
            struct_size, method, objective, start, near_wall, chart, edge_use, extent_rule, max_threads,
            max_iterations, cost_tolerance, gradient_tolerance, step_tolerance, initial_lambda, lambda_factor,
            max_lambda, edge_weight, seed, ransac_max_iterations, ransac_threshold, independent_points,
            depth_noise, image_noise, edge_noise, mask_noise, image_blur, drawn_pixel, radius_min, radius_max,
            axis, axis_max_angle, depth_shared,
        }
        cylfuse_counts {
            struct_size, view, points_given, points_used, dropped_not_finite, dropped_zero_weight,
            dropped_outside_mask, dropped_no_depth, dropped_out_of_range, dropped_outside_camera,
            dropped_hidden, segments_given,
        }
        cylfuse_result {
            struct_size, flags, termination, iterations, rejected_steps, limbs_located, segments_given,
            segments_used, points_given, points_used, independent_points, point_deviation, point_rms,
            edge_rms_pixels, near_wall_fraction, initial_cost, cost, energy_points, energy_edges, edge_weight,
            condition, gradient_norm, step_norm, lambda, seconds_start, seconds_solve, seconds_total,
        }
        cylfuse_cylinder_estimate {
            struct_size, start_kind, model, start_model, radius_deviation, direction_deviation,
            position_deviation, radius_from_points, radius_from_points_deviation, radius_from_limbs,
            radius_from_limbs_deviation, radius_z_score, covariance,
        }
        cylfuse_cylinder_diagnosis {
            struct_size, rank, singular_values, condition, weakest_shift, weakest_tilt, weakest_radius,
        }
        cylfuse_completion { struct_size, view, count, hits, misses, outside_camera, out_of_range }
        cylfuse_extent {
            struct_size, start_state, end_state, start_source, end_source, start_view, end_view, limbs_known,
            start, end, center, length, start_deviation, end_deviation, length_deviation, start_covariance,
            end_covariance, center_covariance,
        }
        cylfuse_progress { struct_size, phase, iteration, max_iterations, cost, lambda, cylinder }
        cylfuse_limb { view, limb, status, samples, line, deviation }
        cylfuse_limb_sample { view, limb, pixel, deviation, weight }
        cylfuse_end_sample { view, end, pixel, normal, deviation }
        cylfuse_detector_options {
            struct_size, image_use, max_threads, max_count, min_pixels, min_score, radius_min, radius_max, axis,
            axis_max_angle,
        }
        cylfuse_detection_progress { struct_size, phase, fits_done, fits }
        cylfuse_detection { score, pixels, model }
    }
}

fn list() -> String {
    let mut list = String::new();
    for (name, size, fields) in layouts() {
        list += &format!("{name} {size}\n");
        for (field, offset, _) in fields {
            list += &format!("    {field} {offset}\n");
        }
    }
    list
}

/// Together the fields fill their struct: none is missing in the list above, and nothing lies between them.
#[test]
fn structs_have_no_padding() {
    for (name, size, fields) in layouts() {
        let mut end = 0;
        for (field, offset, field_size) in fields {
            assert_eq!(offset, end, "padding or a missing field before {name}.{field}");
            end = offset + field_size;
        }
        assert_eq!(end, size, "padding or a missing field at the end of {name}");
    }
}

#[test]
#[cfg(target_pointer_width = "64")]
fn layouts_are_the_committed_ones() {
    assert_committed("abi_layout.txt", &list());
}

#[test]
fn layouts_are_the_same_in_c() {
    let mut text = "#include <cylfuse/cylfuse.h>\n#include <stdio.h>\nint main(void)\n{\n".to_string();
    for (name, _, fields) in layouts() {
        text += &format!("    printf(\"{name} %zu\\n\", sizeof({name}));\n");
        for (field, ..) in fields {
            text += &format!("    printf(\"    {field} %zu\\n\", offsetof({name}, {field}));\n");
        }
    }
    text += "    return 0;\n}\n";
    let folder = scratch("abi_layout");
    let (source, program) = (folder.join("layout.c"), folder.join("layout"));
    std::fs::write(&source, text).unwrap();
    run(c_compiler()
        .arg("-std=c99")
        .arg("-I")
        .arg(root().join("include"))
        .arg(source)
        .arg("-o")
        .arg(&program));
    assert_eq!(run(&mut Command::new(program)), list());
}
