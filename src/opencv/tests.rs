//! On a frame of a can, whose radius is 37.8 mm.

use super::*;
use crate::fitter::{Method, Options};
use opencv::core::{Rect, Scalar as Value};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/frames/r40_a20_f0/");

fn read(name: &str) -> image::DynamicImage {
    image::open(format!("{FOLDER}{name}")).unwrap()
}

fn grey_image(name: &str) -> Mat {
    let image = read(name).into_luma8();
    Mat::new_rows_cols_with_data(480, 640, image.as_raw()).unwrap().try_clone().unwrap()
}

fn depth_image() -> Mat {
    let image = read("depth.png").into_luma16();
    Mat::new_rows_cols_with_data(480, 640, image.as_raw()).unwrap().try_clone().unwrap()
}

fn camera_matrix() -> Mat {
    Mat::from_slice_2d(&[[570.0, 0.0, 319.5], [0.0, 570.0, 239.5], [0.0, 0.0, 1.0]]).unwrap()
}

fn fitter() -> Fitter {
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(intrinsics(&camera_matrix(), &Mat::default(), (640, 480)).unwrap()).unwrap();
    let mask = grey_image("mask.png");
    push_depth(&mut fitter, &depth_image(), 1e-4, Some(&mask), &DepthRange::default()).unwrap();
    fitter
}

#[test]
fn detected_edges_bring_the_radius_nearer_to_the_truth() {
    let mut fitter = fitter();
    fitter.set_options(Options { method: Method::Ransac, ..Options::default() }).unwrap();
    let alone = fitter.fit().unwrap().cylinder.radius;
    let edges = propose_edges(&fitter, &grey_image("image.png"), 0.0).unwrap();
    assert!(!edges.is_empty());
    fitter.push_edges(&edges).unwrap();
    fitter.set_options(Options::default()).unwrap();
    let with_edges = fitter.fit().unwrap().cylinder.radius;
    assert!((with_edges - 0.0378).abs() < 0.6 * (alone - 0.0378).abs(), "{alone} {with_edges}");
}

#[test]
fn all_images_pass_in_all_their_types() {
    let mut fitter = fitter();
    let mut float = Mat::default();
    depth_image().convert_to(&mut float, opencv::core::CV_32F, 1e-4, 0.0).unwrap();
    let used = fitter.cloud().len();
    push_depth(&mut fitter, &float, 1.0, None, &DepthRange::default()).unwrap();
    assert!(fitter.cloud().len() > 2 * used);

    let grey = grey_image("image.png");
    let expected = f32::from(*grey.at_2d::<u8>(240, 340).unwrap());
    let (mut colour, mut with_alpha) = (Mat::default(), Mat::default());
    imgproc::cvt_color_def(&grey, &mut colour, imgproc::COLOR_GRAY2BGR).unwrap();
    imgproc::cvt_color_def(&grey, &mut with_alpha, imgproc::COLOR_GRAY2BGRA).unwrap();
    for image in [&grey, &colour, &with_alpha] {
        push_image(&mut fitter, image, 1.0).unwrap();
        assert!((fitter.image().unwrap().value(340, 240) - expected).abs() < 1e-3);
    }
    // Blue comes first: it is the darkest of the three.
    let mut seen = |blue, red| {
        let image =
            Mat::new_rows_cols_with_default(480, 640, CV_8UC3, Value::new(blue, 0.0, red, 0.0)).unwrap();
        push_image(&mut fitter, &image, 1.0).unwrap();
        fitter.image().unwrap().value(340, 240)
    };
    assert!(seen(200.0, 0.0) < seen(0.0, 200.0));
}

#[test]
fn a_part_of_a_matrix_is_read_where_it_lies() {
    // Six rows of eight points whose coordinates count up.
    let numbers: Vec<f64> = (0..6 * 8 * 3_u8).map(f64::from).collect();
    let numbers = Mat::new_rows_cols_with_data(6, 24, &numbers).unwrap();
    let points = numbers.reshape(3, 6).unwrap();
    let part = Mat::roi(&points, Rect::new(2, 1, 3, 4)).unwrap();
    assert!(!part.is_continuous());
    let mut fitter = Fitter::new();
    push_points(&mut fitter, &part, None).unwrap();
    let starts: Vec<f64> = fitter.cloud().points().map(|p| p.x).collect();
    assert_eq!(starts, [30.0, 33.0, 36.0, 54.0, 57.0, 60.0, 78.0, 81.0, 84.0, 102.0, 105.0, 108.0]);
}

#[test]
fn completed_depth_has_the_size_of_the_camera() {
    let mut fitter = fitter();
    let cylinder = fitter.fit().unwrap().cylinder;
    let completed = complete_depth(&fitter, None, None).unwrap();
    assert_eq!((completed.rows(), completed.cols(), completed.typ()), (480, 640, CV_32FC1));
    let z = f64::from(*completed.at_2d::<f32>(240, 340).unwrap());
    let point = fitter.camera().unwrap().unproject(&Vector2::new(340.0, 240.0)).unwrap();
    assert!(cylinder.distance(&(point * (z / point.z))).abs() < 1e-6);
    assert_eq!(*completed.at_2d::<f32>(0, 0).unwrap(), 0.0);
}

#[test]
fn labels_have_the_pixels_of_the_image() {
    let scene = crate::scene::Detector::new().detect(fitter().frame()).unwrap();
    assert_eq!(scene.cylinders.len(), 1);
    let labels = labels(&scene).unwrap();
    assert_eq!((labels.rows(), labels.cols(), labels.typ()), (480, 640, CV_16UC1));
    for k in scene.indices(0) {
        assert_eq!(*labels.at_2d::<u16>((k / 640) as i32, (k % 640) as i32).unwrap(), 1);
    }
    assert_eq!(opencv::core::count_non_zero(&labels).unwrap() as usize, scene.cylinders[0].pixels);
}

#[test]
fn what_is_wrong_is_named() {
    let mut fitter = fitter();
    let range = DepthRange::default();
    let text = |error: Error| error.to_string();
    let empty = Mat::default();
    let error = text(push_depth(&mut fitter, &empty, 1.0, None, &range).unwrap_err());
    assert_eq!(
        error,
        "the depth image is empty; it must hold an image: was the file read, the camera ready?"
    );
    let grey = grey_image("image.png");
    let error = text(push_depth(&mut fitter, &grey, 1.0, None, &range).unwrap_err());
    assert_eq!(error, "the depth image is of type CV_8UC1; it must be of type CV_16UC1 or CV_32FC1");
    let small = Mat::new_rows_cols_with_default(10, 20, CV_8UC1, Value::all(255.0)).unwrap();
    let error = text(push_depth(&mut fitter, &depth_image(), 1e-4, Some(&small), &range).unwrap_err());
    assert!(error.contains("20 x 10") && error.contains("640 x 480"), "{error}");
    let error = text(push_image(&mut fitter, &small, 1.0).unwrap_err());
    assert!(error.contains("20 x 10") && error.contains("640 x 480"), "{error}");
    let error = text(intrinsics(&small, &empty, (640, 480)).unwrap_err());
    assert!(error.contains("the camera matrix is 10 x 20 of type CV_8UC1"), "{error}");
    let skewed = Mat::from_slice_2d(&[[570.0, 0.1, 319.5], [0.0, 570.0, 239.5], [0.0, 0.0, 1.0]]).unwrap();
    let error = text(intrinsics(&skewed, &empty, (640, 480)).unwrap_err());
    assert!(error.contains("element (0, 1) of the camera matrix is 0.1"), "{error}");
    let six = Mat::from_slice_2d(&[[0.0; 6]]).unwrap();
    assert!(intrinsics(&camera_matrix(), &six, (640, 480)).is_err());
}
