//! Frames: registration, and what belongs together.

use super::*;
use std::sync::Arc;

#[test]
fn the_registered_depth_is_that_of_the_scene_without_holes_and_ghosts() {
    let (frame, own, camera) = (frame(), depth_camera(), color_camera());
    let registered = frame.depth_on_image().unwrap();
    assert_eq!(registered.size(), COLOR_SIZE);
    let (mut compared, mut unseen) = (0, 0);
    for row in 0..COLOR_SIZE.1 {
        for column in 0..COLOR_SIZE.0 {
            let pixel = Vector2::new(column as f64, row as f64);
            let point = seen(&camera, &RigidMotion::identity(), &pixel);
            // What lies around the point in the depth image, a pixel to each side and diagonally.
            let Some(at) = own.camera.project(&own.to_color.inverse().point(&point)) else { continue };
            let around = [-1.0, 0.0, 1.0].map(|dx| [-1.0, 0.0, 1.0].map(|dy| at + Vector2::new(dx, dy)));
            if !around.iter().flatten().all(|pixel| own.camera.contains(pixel)) {
                continue;
            }
            let depths = around.map(|side| side.map(|pixel| seen(&own.camera, &own.to_color, &pixel).z));
            let near = |z: f64| (z - point.z).abs() < 0.05;
            // Outlines are as coarse as the depth: half a depth pixel is up to two colour pixels.
            let about = [-2.0, 0.0, 2.0].map(|dx| [-2.0, 0.0, 2.0].map(|dy| pixel + Vector2::new(dx, dy)));
            let about = about.map(|side| side.map(|pixel| seen(&camera, &RigidMotion::identity(), &pixel).z));
            if !about.iter().flatten().all(|&z| near(z)) {
                continue;
            }
            if depths.iter().flatten().all(|&z| near(z)) {
                let z = registered.depth(column, row).unwrap_or_else(|| panic!("a hole at {pixel}"));
                // The wall rises by 0.3 × 1.2 / 65 from one depth pixel to the next.
                assert!((z - point.z).abs() < 0.007, "{pixel}: {z}, not {}", point.z);
                compared += 1;
            } else if !depths.iter().flatten().any(|&z| near(z)) {
                // In the shadow of the box for the depth camera: nothing may be there but the box's own side.
                assert!(registered.depth(column, row).is_none_or(near), "{pixel}");
                unseen += 1;
            }
        }
    }
    assert!(compared > 20_000 && unseen > 20, "{compared} {unseen}");
}

#[test]
fn a_depth_camera_at_the_position_of_the_colour_camera_changes_nothing() {
    let camera = color_camera();
    let values = depths(&camera, &RigidMotion::identity());
    let view = DepthView::from_f32(&values, COLOR_SIZE, 1.0).unwrap();
    let mut plain = Frame::new(camera.clone());
    plain.set_depth(&view, &DepthRange::default()).unwrap();
    let mut own = plain.clone();
    own.set_depth_camera(Some(DepthCamera { camera, to_color: RigidMotion::identity() })).unwrap();
    let mask = box_mask(0);
    let clouds = [&plain, &own].map(|frame| {
        let mut cloud = PointCloud::default();
        cloud.push_frame(frame, Some(&mask)).unwrap();
        cloud
    });
    assert!(clouds[0].points().eq(clouds[1].points()));
    assert_eq!(clouds[0].pixels(), clouds[1].pixels());
    for row in 0..COLOR_SIZE.1 {
        for column in 0..COLOR_SIZE.0 {
            let [first, second] =
                [&plain, &own].map(|frame| frame.depth_on_image().unwrap().depth(column, row).unwrap());
            assert_eq!(first, second, "{column} {row}");
        }
    }
}

#[test]
fn depth_far_finer_than_the_image_leaves_no_holes_either() {
    let fine = camera((400, 300), 360.0, Distortion::None);
    let mut frame = Frame::new(camera((50, 40), 40.0, Distortion::None));
    let to_color = RigidMotion::new(exp_so3(&Vector3::zeros()), Vector3::new(0.03, 0.0, 0.0)).unwrap();
    frame.set_depth_camera(Some(DepthCamera { camera: fine, to_color })).unwrap();
    let view = vec![1.0_f32; 400 * 300];
    frame.set_depth(&DepthView::from_f32(&view, (400, 300), 1.0).unwrap(), &DepthRange::default()).unwrap();
    let registered = frame.depth_on_image().unwrap();
    for (column, row) in (5..43).flat_map(|column| (5..35).map(move |row| (column, row))) {
        assert_eq!(registered.depth(column, row), Some(1.0), "{column} {row}");
    }
}

#[test]
fn what_lies_behind_or_against_the_colour_camera_is_bounded_work() {
    let mut frame = Frame::new(color_camera());
    let mut own = depth_camera();
    let depth = vec![1.0_f32; 80 * 60];
    let view = DepthView::from_f32(&depth, (80, 60), 1.0).unwrap();
    for z in [-0.5, -0.999_999, -1.0, 1e300, -1e300, -2.0] {
        own.to_color = RigidMotion::new(*own.to_color.rotation(), Vector3::new(0.0, 0.0, z)).unwrap();
        frame.set_depth_camera(Some(own.clone())).unwrap();
        frame.set_depth(&view, &DepthRange::default()).unwrap();
        assert!(frame.depth_on_image().is_some());
    }
    let mut cloud = PointCloud::default();
    let error = cloud.push_frame(&frame, Some(&box_mask(0))).unwrap_err().to_string();
    assert!(error.starts_with("none of the 0 pixels in the region has a usable depth"), "{error}");
}

#[test]
fn images_of_one_frame_have_the_sizes_of_their_cameras() {
    let small = || camera((4, 3), 4.0, Distortion::None);
    let own = |camera: Camera| Some(DepthCamera { camera, to_color: RigidMotion::identity() });
    let large = || camera((8, 6), 8.0, Distortion::None);
    let depth = [1.0_f32; 48];
    let of_size = |size| DepthView::from_f32(&depth, size, 1.0).unwrap();
    let all = DepthRange::default();
    let grey = [7; 48];
    let image = |size| ImageView::from_u8(&grey, size).unwrap();
    let text = |outcome: Result<()>| outcome.unwrap_err().to_string();
    use crate::error::Result;

    let mut frame = Frame::default();
    assert!(frame.camera().is_none() && frame.depth().is_none() && *frame.pose() == RigidMotion::identity());
    assert_eq!(
        text(frame.set_depth(&of_size((4, 3)), &all)),
        "pushing a depth image needs intrinsics; set the intrinsics first"
    );
    assert_eq!(
        text(frame.set_image(&image((4, 3)))),
        "pushing an image needs intrinsics; set the intrinsics first"
    );
    let mask = Mask::copy(&MaskView::from_u8(&[1; 12], (4, 3)).unwrap()).unwrap();
    assert_eq!(
        text(PointCloud::default().push_frame(&frame, Some(&mask))),
        "making points of a frame needs intrinsics and a depth image; set both first"
    );

    frame.set_camera(small()).unwrap();
    let both = "both must have the same size";
    let register = "register the depth to the image, or set the camera of the depth";
    let scale = "scale the image, or set the intrinsics for its size";
    assert_eq!(
        text(frame.set_depth(&of_size((8, 6)), &all)),
        format!("depth image is 8 x 6 but the image of the intrinsics is 4 x 3; {both}: {register}")
    );
    assert_eq!(
        text(frame.set_image(&image((8, 6)))),
        format!("image is 8 x 6 but the image of the intrinsics is 4 x 3; {both}: {scale}")
    );
    frame.set_depth(&of_size((4, 3)), &all).unwrap();
    frame.set_image(&image((4, 3))).unwrap();
    assert_eq!(
        text(frame.set_camera(large())),
        format!("the image of the intrinsics is 8 x 6 but image is 4 x 3; {both}: {scale}")
    );
    frame.clear_image();
    assert_eq!(
        text(frame.set_camera(large())),
        format!("the image of the intrinsics is 8 x 6 but depth image is 4 x 3; {both}: {register}")
    );
    assert_eq!(
        text(frame.set_depth_camera(own(large()))),
        format!("the image of the depth camera is 8 x 6 but depth image is 4 x 3; {both}: {scale}")
    );
    assert!(frame.depth_camera().is_none() && frame.camera().unwrap().size() == (4, 3));
    frame.set_depth_camera(own(small())).unwrap();
    // The colour camera may be another one now: the depth image is that of the depth camera.
    frame.set_camera(large()).unwrap();
    assert_eq!(frame.depth_on_image().unwrap().size(), (8, 6));
    assert_eq!(frame.depth().unwrap().size(), (4, 3));
    assert_eq!(
        text(frame.set_depth_camera(None)),
        format!("the image of the intrinsics is 8 x 6 but depth image is 4 x 3; {both}: {register}")
    );
    assert_eq!(
        text(PointCloud::default().push_frame(&frame, Some(&mask))),
        format!("mask is 4 x 3 but the image of the intrinsics is 8 x 6; {both}: scale the mask")
    );
    assert_eq!(
        text(frame.set_depth(&of_size((8, 6)), &all)),
        format!("depth image is 8 x 6 but the image of the depth camera is 4 x 3; {both}: {scale}")
    );
    let bad = DepthRange { min: 2.0, max: 1.0 };
    assert!(text(frame.set_depth(&of_size((4, 3)), &bad)).starts_with("maximal depth is 1"));
    assert!(frame.depth().is_some());
    frame.clear_depth();
    assert!(frame.depth().is_none() && frame.depth_on_image().is_none());
    frame.set_depth_camera(None).unwrap();
}

#[test]
fn frames_are_shared_between_threads() {
    let frame = Arc::new(frame());
    let others = [0, 1].map(|_| {
        let frame = Arc::clone(&frame);
        std::thread::spawn(move || {
            let mut cloud = PointCloud::default();
            cloud.push_frame(&frame, None).unwrap();
            cloud.len()
        })
    });
    assert_eq!(others.map(|thread| thread.join().unwrap()), [80 * 60; 2]);
}

#[test]
fn the_same_camera_again_keeps_the_rays_that_are_known() {
    let mut frame = frame();
    let first = frame.camera().unwrap().clone();
    let again = Camera::new(*first.intrinsics()).unwrap();
    assert!(!again.shares_rays_with(&first));
    frame.set_camera(again).unwrap();
    assert!(frame.camera().unwrap().shares_rays_with(&first));
    let other = Camera::new(Intrinsics { fx: 181.0, ..*first.intrinsics() }).unwrap();
    frame.set_camera(other).unwrap();
    assert!(!frame.camera().unwrap().shares_rays_with(&first));
    assert_eq!(frame.camera().unwrap().intrinsics().fx, 181.0);
}
