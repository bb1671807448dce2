//! What the cases found, each as a test that failed first.

use crate::cloud::CloudFile;
use cylfuse::ffi::*;
use std::ptr::{null, null_mut};

fn points(points: &[[f64; 3]]) -> cylfuse_points_view {
    let mut view = std::mem::MaybeUninit::<cylfuse_points_view>::zeroed();
    // SAFETY: room for the struct, of its size.
    let mut view = unsafe {
        cylfuse_points_view_init(view.as_mut_ptr(), size_of::<cylfuse_points_view>());
        view.assume_init()
    };
    view.scalar = cylfuse_scalar::F64;
    view.data = points.as_ptr().cast();
    view.width = points.len();
    view
}

fn cylinder(x: f64, radius: f64) -> cylfuse_cylinder {
    cylfuse_cylinder { point: [x, 0.0, 1.0], direction: [0.0, 1.0, 0.0], radius }
}

#[test]
fn residuals_that_no_number_holds_are_an_error() {
    let pushed = [[0.1, 0.2, 1.0]; 10];
    let (view, far) = (points(&pushed), cylinder(1e200, 1e-3));
    let (mut fitter, mut count, mut out) = (null_mut(), 0, [0.0; 10]);
    unsafe {
        cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &raw mut fitter);
        cylfuse_fitter_push_points(fitter, &raw const view, null());
        let kind = cylfuse_residual_kind::POINTS;
        let status =
            cylfuse_fitter_residuals(fitter, &raw const far, kind, out.as_mut_ptr(), 10, &raw mut count);
        assert_eq!(status.0, -27, "{out:?}");
        cylfuse_fitter_destroy(fitter);
    }
}

#[test]
fn distances_that_no_number_holds_are_not_numbers() {
    let (model, mut out) = (cylinder(0.0, 0.5), [0.0; 2]);
    let pair = [[1e300, 0.0, 1e300], [0.0, 0.0, 1.0]];
    let given = points(&pair);
    let status =
        unsafe { cylfuse_cylinder_distances(&raw const model, &raw const given, out.as_mut_ptr(), 2) };
    assert_eq!(status, cylfuse_status::OK);
    assert!(!out[0].is_infinite() && (out[1] + 0.5).abs() < 1e-12, "{out:?}");
}

#[test]
fn differences_that_no_number_holds_are_an_error() {
    let (a, b) = (cylinder(0.0, 1e-300), cylinder(0.0, 1e300));
    let mut out = [5.0; 3];
    let [angle, distance, relative] = &mut out;
    let status = unsafe { cylfuse_cylinder_compare(&raw const a, &raw const b, angle, distance, relative) };
    assert_eq!((status.0, out), (-27, [5.0; 3]));
}

#[test]
fn models_whose_gradient_no_number_holds_are_an_error() {
    let (mut dice, hostile) = (crate::random_views::Dice::new(3), [1e120, 1e150, 1e153, 1e154]);
    let pushed: Vec<[f64; 3]> = (0..50).map(|_| [dice.unit(), dice.unit(), 1.0 + dice.unit()]).collect();
    let view = points(&pushed);
    let mut fitter = null_mut();
    unsafe {
        cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &raw mut fitter);
        cylfuse_fitter_push_points(fitter, &raw const view, null());
        for far in hostile {
            let mut result = std::mem::MaybeUninit::<cylfuse_result>::zeroed();
            cylfuse_result_init(result.as_mut_ptr(), size_of::<cylfuse_result>());
            let model = cylinder(far, 0.1);
            let status = cylfuse_fitter_evaluate(fitter, &raw const model, result.as_mut_ptr(), null_mut());
            if status == cylfuse_status::OK {
                crate::checks::result(&result.assume_init());
            }
        }
        cylfuse_fitter_destroy(fitter);
    }
}

#[test]
fn messages_about_files_are_one_line() {
    let path = std::env::temp_dir().join(format!("cylfuse-line-{}.ply", std::process::id()));
    std::fs::write(&path, "ply\nformat ascii 1.0\nelement vertex x\nproperty float x\nend_header\n").unwrap();
    let failure = CloudFile::read(&path).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    assert!(!failure.message.contains('\n'), "{failure:?}");
}
