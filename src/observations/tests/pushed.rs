//! What becomes points.

use super::*;

#[test]
fn a_mask_on_the_colour_image_selects_what_the_colour_camera_sees() {
    let frame = frame();
    let mut cloud = PointCloud::default();
    cloud.push_frame(&frame, Some(&box_mask(2))).unwrap();
    assert!(cloud.len() > 300, "{}", cloud.len());
    for point in cloud.points() {
        assert!(on_box(&point), "{point}");
    }
    // The wall behind the box, which the depth camera sees past it.
    assert!(cloud.dropped().hidden > 10, "{:?}", cloud.dropped());
    assert_eq!(cloud.dropped().total() + cloud.len(), cloud.given());
    assert_eq!(cloud.given(), 80 * 60);
    // Every pixel of the box that both see is there.
    let (own, camera, mask) = (depth_camera(), color_camera(), box_mask(2));
    let expected = (0..80 * 60).filter(|k| {
        let point = seen(&own.camera, &own.to_color, &Vector2::new(f64::from(k % 80), f64::from(k / 80)));
        let pixel = camera.project(&point).unwrap();
        let front = (seen(&camera, &RigidMotion::identity(), &pixel) - point).norm() < 1e-9;
        // As far from the border of the mask as the interpolated rays may be off.
        let sure = |d: f64| mask.contains((pixel.x + d).round() as usize, (pixel.y + d).round() as usize);
        front && sure(0.02) && sure(-0.02)
    });
    assert!(cloud.len() >= expected.count());
}

#[test]
fn without_a_mask_every_measured_pixel_counts() {
    let (frame, own) = (frame(), depth_camera());
    let mut cloud = PointCloud::default();
    cloud.push_frame(&frame, None).unwrap();
    assert_eq!((cloud.len(), cloud.dropped().total()), (80 * 60, 0));
    for (point, &[column, row]) in cloud.points().zip(cloud.pixels().unwrap()) {
        let exact = seen(&own.camera, &own.to_color, &Vector2::new(f64::from(column), f64::from(row)));
        assert!((point - exact).norm() < 1e-6, "{column} {row}");
    }
}

#[test]
fn pixels_that_the_lens_does_not_see_are_counted_and_the_next_push_has_the_same_bits() {
    // It folds over within the image.
    let folding = Distortion::BrownConrady([-0.3, 0.02, 1e-3, -2e-3, 0.0, 0.0, 0.0, 0.0]);
    let camera = camera((131, 77), 60.0, folding);
    let depths: Vec<f32> = (0..131 * 77_u16).map(|k| f32::from(k % 7)).collect();
    let set: Vec<u8> = (0..131 * 77_u16).map(|k| u8::from(k % 5 < 3)).collect();
    let mask = Mask::copy(&MaskView::from_u8(&set, (131, 77)).unwrap()).unwrap();
    let mut frame = Frame::new(camera.clone());
    let view = DepthView::from_f32(&depths, (131, 77), 1.0).unwrap();
    frame.set_depth(&view, &DepthRange { min: 1.5, max: 5.0 }).unwrap();
    let (mut pixels, mut expected) = (Vec::new(), Dropped::default());
    for (k, (depth, set)) in depths.iter().zip(&set).enumerate() {
        let pixel = [(k % 131) as u32, (k / 131) as u32];
        let ray = camera.unproject(&Vector2::from(pixel.map(f64::from)));
        match () {
            () if *set == 0 => expected.outside_mask += 1,
            () if *depth == 0.0 => expected.no_depth += 1,
            () if !(1.5..=5.0).contains(depth) => expected.out_of_range += 1,
            () if ray.is_none() => expected.outside_camera += 1,
            () => pixels.push(pixel),
        }
    }
    assert!(expected.outside_camera > 100 && pixels.len() > 100);
    let pushed = || {
        let mut cloud = PointCloud::default();
        cloud.push_frame(&frame, Some(&mask)).unwrap();
        assert_eq!(*cloud.dropped(), expected);
        assert_eq!(cloud.pixels().unwrap(), pixels);
        cloud.points().collect::<Vec<_>>()
    };
    assert_eq!(pushed(), pushed());
}

#[test]
fn points_know_their_pixels_while_they_come_from_one_grid() {
    let organised: Vec<f32> = (0..18_u8).map(f32::from).collect();
    let bytes = organised.iter().flat_map(|x| x.to_ne_bytes()).collect::<Vec<_>>();
    let grid = |size| Strided::new(&bytes, 0, size, 12, (12, 36)).unwrap();
    let view =
        |size| PointsView { points: VectorsView::new(grid(size), Scalar::F32), weights: None, normals: None };
    let mask = Mask::copy(&MaskView::from_u8(&[0, 1, 1, 1, 0, 0], (3, 2)).unwrap()).unwrap();
    let mut cloud = PointCloud::default();
    assert!(cloud.pixels().is_none());
    cloud.push_points(&view((3, 2)), Some(&mask)).unwrap();
    assert_eq!(cloud.pixels().unwrap(), [[1, 0], [2, 0], [0, 1]]);
    // Another grid.
    cloud.push_points(&view((3, 2)), None).unwrap();
    assert!(cloud.pixels().is_none());
    cloud.clear();
    // No grid.
    cloud.push_points(&view((3, 1)), None).unwrap();
    assert!(cloud.pixels().is_none());
    cloud.push_points(&view((3, 2)), None).unwrap();
    assert!(cloud.pixels().is_none());
}

#[test]
fn numbers_that_no_sum_can_hold_are_refused_with_the_point() {
    let points = [[0.0_f32, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, 3e38, 1.0], [0.0, -3e38, 1.0]];
    let mut cloud = PointCloud::default();
    let error = cloud.push_points(&PointsView::from_f32(&points[2..]), None).unwrap_err().to_string();
    assert!(error.starts_with("point "), "{error}");
    assert!(error.contains("must lie within 3.4e38 of the points around"), "{error}");
    cloud.push_points(&PointsView::from_f32(&points[..2]), None).unwrap();
    let wide = [[0.0, 0.0, 1.0], [0.0, f64::MAX, 1.0], [0.0, -f64::MAX, 1.0]];
    let error =
        PointCloud::default().push_points(&PointsView::from_f64(&wide[1..]), None).unwrap_err().to_string();
    assert!(error.contains("must lie within 1.8e308 of"), "{error}");
    assert_eq!((cloud.len(), cloud.given()), (2, 2));

    for (weight, text) in [
        (
            1e39,
            "the weight of point 1 is 1e39; it must be at most 3.4e38; only the ratios of the weights count",
        ),
        (-1.0, "the weight of point 1 is -1.0; it must be at least 0"),
    ] {
        let memory = [1.0, weight, 1.0].map(f64::to_ne_bytes).concat();
        let weights = Some(Strided::new(&memory, 0, (3, 1), 8, (8, 0)).unwrap());
        let view = PointsView { weights, ..PointsView::from_f64(&[[1.0, 2.0, 3.0]; 3]) };
        let error = cloud.push_points(&view, None).unwrap_err().to_string();
        assert!(error.starts_with(text), "{error}");
    }
    // Nothing is left of it as an f32.
    let memory = [1.0, 1e-60, f64::from(f32::MAX)].map(f64::to_ne_bytes).concat();
    let weights = Some(Strided::new(&memory, 0, (3, 1), 8, (8, 0)).unwrap());
    cloud.push_points(&PointsView { weights, ..PointsView::from_f64(&[[1.0, 2.0, 3.0]; 3]) }, None).unwrap();
    assert_eq!((cloud.len(), cloud.dropped().zero_weight), (4, 1));
}

#[test]
fn rows_of_nothing_take_no_time() {
    let nothing = Strided::new(&[], 0, (0, usize::MAX), 4, (4, 0)).unwrap();
    let points = PointsView { points: VectorsView::new(nothing, Scalar::F32), weights: None, normals: None };
    let mut cloud = PointCloud::default();
    cloud.push_points(&points, None).unwrap();
    assert!(cloud.is_empty());
    assert!(DepthImage::copy(&DepthView::new(nothing, Pixels::F32, 1.0).unwrap()).is_ok());
    assert!(GreyImage::copy(&ImageView::new(nothing, ImageFormat::F32)).is_ok());
    assert!(GreyImage::copy(&ImageView::new(nothing, ImageFormat::Rgba8)).is_ok());
}

#[test]
fn colours_become_their_luminance() {
    let bytes = [0, 51, 102, 9, 255, 0, 0, 9, 90, 90, 90, 9, 1, 255, 254, 255];
    let image = |format: ImageFormat, bytes: &[u8], gamma: f64| {
        let view = ImageView::from_bytes(bytes, (4, 1), format).unwrap();
        GreyImage::copy(&view.with_gamma(gamma).unwrap()).unwrap()
    };
    let luminance = |[red, green, blue]: [f64; 3]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let without_alpha: Vec<u8> = bytes.chunks(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    let turned: Vec<u8> = bytes.chunks(4).flat_map(|p| [p[2], p[1], p[0], p[3]]).collect();
    let turned_without: Vec<u8> = turned.chunks(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    for gamma in [1.0, 2.2] {
        for (format, bytes) in [
            (ImageFormat::Rgba8, &bytes[..]),
            (ImageFormat::Rgb8, &without_alpha),
            (ImageFormat::Bgra8, &turned),
            (ImageFormat::Bgr8, &turned_without),
        ] {
            let image = image(format, bytes, gamma);
            for (column, pixel) in [[0.0, 51.0, 102.0], [255.0, 0.0, 0.0], [90.0; 3]].into_iter().enumerate()
            {
                let light = luminance(pixel.map(|value: f64| 255.0 * (value / 255.0).powf(gamma)));
                assert!((f64::from(image.value(column, 0)) - light).abs() < 1e-4, "{format:?} {column}");
            }
            // Green is most of the luminance; 255 in the fourth byte is no light.
            assert_eq!([0, 1, 2, 3].map(|column| image.is_saturated(column, 0)), [false, false, false, true]);
        }
    }
    // Grey as colours is grey.
    assert_eq!(image(ImageFormat::Rgb8, &without_alpha, 1.0).value(2, 0), 90.0);
    let short = ImageView::from_bytes(&bytes[..11], (4, 1), ImageFormat::Rgb8).unwrap_err().to_string();
    assert!(short.starts_with("buffer length is 11 bytes"), "{short}");
}
