//! Tests of the camera models against reference values and each other.

use super::*;

impl Camera {
    /// Whether the two remember rays together.
    pub(crate) fn shares_rays_with(&self, other: &Self) -> bool {
        self.rays.as_ref().zip(other.rays.as_ref()).is_some_and(|(own, other)| Arc::ptr_eq(own, other))
    }
}

fn pinhole() -> Intrinsics {
    let distortion = Distortion::None;
    Intrinsics { width: 1280, height: 720, fx: 612.25, fy: 611.75, cx: 640.5, cy: 360.25, distortion }
}

/// The camera of the reference values, with this lens.
pub(super) fn camera(distortion: Distortion) -> Camera {
    Camera::new(Intrinsics { distortion, ..pinhole() }).unwrap()
}

/// Checks both round trips on a dense grid of pixels, half an image beyond every border, and the way from
/// rays up to `end` (on the plane z = 1) in all directions. Returns how many pixels of the image itself
/// have no ray.
pub(super) fn check_round_trips(camera: &Camera, end: f64) -> usize {
    let Intrinsics { width, height, fx, .. } = *camera.intrinsics();
    let (width, height) = (width as i32, height as i32);
    let mut lost = 0;
    for y in (-height / 2..height * 3 / 2).step_by(7) {
        for x in (-width / 2..width * 3 / 2).step_by(5) {
            let pixel = Vector2::new(f64::from(x), f64::from(y));
            let Some(ray) = camera.unproject(&pixel) else {
                lost += usize::from(camera.contains(&pixel));
                continue;
            };
            assert_eq!(ray.z, 1.0);
            let again = camera.project(&(ray * 1.7)).unwrap();
            assert!((again - pixel).norm() <= 1e-9, "{pixel} {again}");
        }
    }
    for i in 0..=400 {
        // The last circle is the end of the field itself.
        let radius = end * (1.0 - 1e-15) * f64::from(i) / 400.0;
        for j in 0..90 {
            let (sin, cos) = (f64::from(j) * std::f64::consts::TAU / 90.0).sin_cos();
            let ray = Vector3::new(radius * cos, radius * sin, 1.0);
            let pixel = camera.project(&ray).unwrap();
            let again = camera.unproject(&pixel).unwrap_or_else(|| panic!("{ray} {pixel}"));
            let angle = ray.cross(&again).norm() / ray.norm_squared();
            assert!(angle * fx <= 1e-9, "{ray} {again}");
        }
    }
    lost
}

/// Compares with pixels that `cv2.projectPoints` or `cv2.fisheye.projectPoints` of OpenCV 5.0 gives.
pub(super) fn check_reference(camera: &Camera, reference: &[(f64, f64)]) {
    let points = [
        Vector3::new(0.31, -0.22, 1.7),
        Vector3::new(-0.9, 0.55, 1.4),
        Vector3::new(0.02, 0.015, 0.8),
        Vector3::new(1.1, 0.9, 2.5),
        Vector3::new(0.0, 0.0, 1.0),
        Vector3::new(2.0, -1.5, 0.4),
    ];
    for (p, &(x, y)) in points.iter().zip(reference) {
        let pixel = camera.project(p).unwrap();
        assert!((pixel - Vector2::new(x, y)).norm() <= 1e-9, "{p} {pixel}");
        let ray = camera.unproject(&Vector2::new(x, y)).unwrap();
        let angle = ray.cross(p).norm() / (ray.norm() * p.norm());
        assert!(angle * camera.intrinsics().fx <= 1e-9, "{p} {ray}");
    }
}

#[test]
fn a_pinhole_is_exact() {
    let camera = camera(Distortion::None);
    assert_eq!(check_round_trips(&camera, 50.0), 0);
    let pixel = camera.project(&Vector3::new(0.5, -0.25, 2.0)).unwrap();
    assert_eq!(pixel, Vector2::new(612.25 * 0.25 + 640.5, 611.75 * -0.125 + 360.25));
    assert_eq!(camera.unproject(&Vector2::new(640.5, 360.25)), Some(Vector3::z()));
    assert_eq!(camera.unproject(&Vector2::new(640.5 + 612.25, 360.25)), Some(Vector3::new(1.0, 0.0, 1.0)));
}

#[test]
fn zero_coefficients_are_a_pinhole() {
    let zeros = camera(Distortion::brown_conrady(&[]).unwrap());
    let p = Vector3::new(90.0, -70.0, 0.1);
    assert_eq!(zeros.project(&p), camera(Distortion::None).project(&p));
}

#[test]
fn points_behind_the_camera_and_bad_numbers_have_no_pixel() {
    for distortion in [
        Distortion::None,
        Distortion::BrownConrady([0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Distortion::KannalaBrandt([0.0; 4]),
    ] {
        let camera = camera(distortion);
        for p in [
            Vector3::new(0.1, 0.2, 0.0),
            Vector3::new(0.1, 0.2, -1.0),
            Vector3::zeros(),
            Vector3::new(1.0, 0.0, 1e-320),
            Vector3::new(f64::NAN, 0.0, 1.0),
            Vector3::new(0.0, f64::INFINITY, 1.0),
            Vector3::new(0.0, 0.0, f64::NAN),
        ] {
            assert_eq!(camera.project(&p), None, "{p}");
            assert_eq!(camera.ideal_pixel(&p), None, "{p}");
        }
        assert_eq!(camera.unproject(&Vector2::new(f64::NAN, 1.0)), None);
        assert_eq!(camera.unproject(&Vector2::new(1.0, f64::INFINITY)), None);
    }
}

#[test]
fn ideal_pixels_ignore_the_lens() {
    let distorted = camera(Distortion::KannalaBrandt([0.1, 0.0, 0.0, 0.0]));
    let ray = Vector3::new(0.4, -0.7, 1.3);
    let ideal = distorted.ideal_pixel(&ray).unwrap();
    assert_eq!(Some(ideal), camera(Distortion::None).project(&ray));
    assert!((distorted.ideal_ray(&ideal) - ray / ray.z).norm() < 1e-15);
}

#[test]
fn points_of_a_line_lie_on_its_projection() {
    let camera = camera(Distortion::None);
    for (point, direction) in [
        (Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.3, 0.8, 0.2)),
        (Vector3::new(-0.4, 0.0, 2.0), Vector3::new(1.0, -0.1, 0.6)),
        (Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.0, 1.0, 0.0)),
    ] {
        let line = camera.line_projection() * point.cross(&direction);
        for t in [-0.5, 0.0, 0.3, 1.0] {
            let pixel = camera.ideal_pixel(&(point + direction * t)).unwrap();
            let distance = line.dot(&pixel.push(1.0)) / line.xy().norm();
            assert!(distance.abs() < 1e-12 * pixel.norm().max(1.0), "{distance}");
        }
    }
}

#[test]
fn the_image_ends_half_a_pixel_beyond_the_outer_centres() {
    let camera = camera(Distortion::None);
    for (x, y, inside) in [
        (-0.5, -0.5, true),
        (1279.499, 719.499, true),
        (-0.501, 0.0, false),
        (0.0, -0.501, false),
        (1279.5, 0.0, false),
        (0.0, 719.5, false),
        (f64::NAN, 0.0, false),
    ] {
        assert_eq!(camera.contains(&Vector2::new(x, y)), inside, "{x} {y}");
    }
}

#[test]
fn bad_intrinsics_are_refused_with_the_field_and_its_value() {
    let good = pinhole();
    let bc = |i: usize, value: f64| {
        let mut k = [0.0; 8];
        k[i] = value;
        Intrinsics { distortion: Distortion::BrownConrady(k), ..good }
    };
    let kb = |i: usize, value: f64| {
        let mut k = [0.0; 4];
        k[i] = value;
        Intrinsics { distortion: Distortion::KannalaBrandt(k), ..good }
    };
    let mut cases = vec![
        (Intrinsics { width: 0, ..good }, "width is 0; it must be at least 1 pixel".to_string()),
        (Intrinsics { height: 0, ..good }, "height is 0; it must be at least 1 pixel".to_string()),
        (
            Intrinsics { width: 1 << 20, height: 1 << 20, ..good },
            "width x height is 1048576 x 1048576; it must be at most 268435456 pixels".to_string(),
        ),
    ];
    for (value, text) in [(0.0, "0.0"), (-3.5, "-3.5"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        let requirement = "it must be finite and above 0";
        cases.push((Intrinsics { fx: value, ..good }, format!("fx is {text}; {requirement}")));
        cases.push((Intrinsics { fy: value, ..good }, format!("fy is {text}; {requirement}")));
    }
    for (value, text) in [(f64::NAN, "NaN"), (f64::NEG_INFINITY, "-inf")] {
        cases.push((Intrinsics { cx: value, ..good }, format!("cx is {text}; it must be finite")));
        cases.push((Intrinsics { cy: value, ..good }, format!("cy is {text}; it must be finite")));
        for (i, name) in ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"].iter().enumerate() {
            cases.push((bc(i, value), format!("{name} is {text}; it must be finite")));
        }
        for (i, name) in ["k1", "k2", "k3", "k4"].iter().enumerate() {
            cases.push((kb(i, value), format!("{name} is {text}; it must be finite")));
        }
    }
    for (intrinsics, text) in cases {
        let error = Camera::new(intrinsics).unwrap_err();
        assert!(matches!(error, Error::InvalidIntrinsics { .. }));
        assert_eq!(error.to_string(), format!("intrinsics: {text}"));
    }
    assert!(Camera::new(Intrinsics { width: 1 << 14, height: 1 << 14, ..good }).is_ok());
    assert_eq!(*Camera::new(good).unwrap().intrinsics(), good);
}

#[test]
fn coefficients_are_counted() {
    let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0];
    for n in 0..=values.len() {
        let result = Distortion::brown_conrady(&values[..n]);
        if [0, 4, 5, 8].contains(&n) {
            let mut expected = [0.0; 8];
            expected[..n].copy_from_slice(&values[..n]);
            assert_eq!(result, Ok(Distortion::BrownConrady(expected)));
        } else {
            let text = result.unwrap_err().to_string();
            assert!(text.contains(&format!("is {n}; it must be 0, 4, 5 or 8")), "{text}");
        }
        let result = Distortion::kannala_brandt(&values[..n]);
        match n {
            0 => assert_eq!(result, Ok(Distortion::KannalaBrandt([0.0; 4]))),
            4 => assert_eq!(result, Ok(Distortion::KannalaBrandt([1.0, 2.0, 3.0, 4.0]))),
            _ => {
                let text = result.unwrap_err().to_string();
                assert!(text.contains(&format!("is {n}; it must be 0 or 4")), "{text}");
            }
        }
    }
}

#[test]
fn limb_lines_pass_through_the_pixels_of_the_limbs() {
    let camera = Camera::new(pinhole()).unwrap();
    let cylinder = Cylinder::new(Vector3::new(0.05, -0.02, 0.8), Vector3::new(0.3, 0.9, 0.2), 0.04).unwrap();
    let limbs = LimbFrame::new(&cylinder).unwrap().limb_lines();
    for (line, limb) in camera.limb_lines(&cylinder).unwrap().iter().zip(limbs) {
        assert!((line.x.hypot(line.y) - 1.0).abs() < 1e-15);
        for along in [-0.1, 0.0, 0.1] {
            let pixel = camera.project(&limb.at(along)).unwrap();
            assert!(line.dot(&Vector3::new(pixel.x, pixel.y, 1.0)).abs() < 1e-9);
        }
    }
    let around = Cylinder::new(Vector3::new(0.0, 0.1, 0.0), Vector3::new(0.1, 0.0, 1.0), 0.5).unwrap();
    assert!(matches!(camera.limb_lines(&around), Err(Error::EdgeGeometry { .. })));
}

#[test]
fn what_is_not_in_pixels_of_the_image_is_refused() {
    let good = pinhole();
    let cases = [
        (
            Intrinsics { fx: 1e12, ..good },
            "fx is 1000000000000.0; it must lie in [1.28, 128000000.0], 0.001 to 100000",
        ),
        (
            Intrinsics { fy: 0.0036, ..good },
            "fy is 0.0036; it must lie in [1.28, 128000000.0], 0.001 to 100000",
        ),
        (
            Intrinsics { cx: -1e300, ..good },
            "cx is -1e300; it must lie in [-12800000.0, 12800000.0], 10000 times",
        ),
        (
            Intrinsics { cy: 2e7, ..good },
            "cy is 20000000.0; it must lie in [-12800000.0, 12800000.0], 10000 times",
        ),
    ];
    for (intrinsics, text) in cases {
        let error = Camera::new(intrinsics).unwrap_err().to_string();
        assert!(error.starts_with(&format!("intrinsics: {text}")), "{error}");
        assert!(error.ends_with("the longer side of the image; give it in pixels of this image"), "{error}");
    }
    // A line camera, a piece of 16 pixels from the corner of a long-focus image, a fisheye.
    for (width, height, f, c) in [(8192, 1, 2e4, 4096.0), (16, 16, 3e5, -9000.0), (1000, 1000, 300.0, 500.0)]
    {
        let intrinsics = Intrinsics { width, height, fx: f, fy: f, cx: c, cy: c, ..good };
        assert!(Camera::new(intrinsics).is_ok(), "{intrinsics:?}");
    }
}

#[test]
fn rays_by_column_and_row_are_those_of_the_pixels() {
    let pinhole = camera(Distortion::None);
    let (x, y) = pinhole.rays_by_column_and_row().unwrap();
    assert_eq!((x.len(), y.len()), pinhole.size());
    for (column, row) in [(0, 0), (1279, 0), (0, 719), (313, 577)] {
        let ray = pinhole.unproject(&Vector2::new(column as f64, row as f64)).unwrap();
        assert_eq!([x[column], y[row], 1.0].map(f64::to_bits), [ray.x, ray.y, ray.z].map(f64::to_bits));
    }
    let distorted = camera(Distortion::KannalaBrandt([0.1, 0.0, 0.0, 0.0]));
    assert!(distorted.rays_by_column_and_row().is_none());
}
