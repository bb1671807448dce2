//! Tests of the extent on rendered scenes.

use super::scene::{SIZE, Scene};
use super::*;
use crate::fitter::{ExtentRule, Inputs, Method, ObjectiveKind, Options};
use crate::noise::NoiseModel;
use crate::observations::{ImageView, PointsView};
use crate::residuals::{Rim, on_wall};
use nalgebra::Vector2;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The errors of start and end in pixels, outward positive.
fn errors(scene: &Scene, extent: &Extent) -> [f64; 2] {
    let axis = scene.cylinder.axis;
    let [start, end] = [extent.start, extent.end].map(|point| axis.position_of(&point));
    [scene.ends.0 - start, end - scene.ends.1].map(|e| e * Scene::PIXELS)
}

fn extent(scene: &Scene, mask_bias: i64, rule: ExtentRule, with_image: bool) -> Extent {
    let (image, depth, mask) = scene.render(mask_bias);
    let mut fitter = Scene::fitter(&depth, &mask);
    if with_image {
        fitter.push_image(&ImageView::from_f32(&image, SIZE).unwrap()).unwrap();
    }
    fitter.set_options(Options { extent_rule: rule, ..Options::default() }).unwrap();
    fitter.find_extent(Some(&scene.cylinder), None, Some(true)).unwrap().0
}

#[test]
fn ends_come_from_the_image_whatever_the_mask() {
    for tilt in [0.0, 0.05, 0.4, -0.6] {
        let scene = Scene::tilted(tilt);
        for bias in [-3, 0, 3] {
            let found = extent(&scene, bias, ExtentRule::Located, true);
            for error in errors(&scene, &found) {
                assert!(error.abs() < 0.1, "tilt {tilt}, bias {bias}: {error} pixels");
            }
            assert_eq!((found.start_source, found.end_source), (EndSource::Image, EndSource::Image));
            assert_eq!((found.start_state, found.end_state), (EndState::Seen, EndState::Seen));
            assert!(found.start_deviation.unwrap() * Scene::PIXELS < 0.3);
            assert!((found.end - found.start - scene.cylinder.axis.direction * found.length).norm() < 1e-12);
        }
    }
}

#[test]
fn without_an_image_the_bias_of_the_mask_is_taken_off() {
    let scene = Scene::tilted(0.4);
    for bias in [-2, 0, 2] {
        let found = extent(&scene, bias, ExtentRule::Located, false);
        for error in errors(&scene, &found) {
            assert!(error.abs() < 0.5, "bias {bias}: {error} pixels");
        }
        assert_eq!(found.start_source, EndSource::Mask);
    }
    let paper = extent(&scene, 2, ExtentRule::Extremes, true);
    assert!(errors(&scene, &paper).iter().all(|&error| error > 1.5));
    assert_eq!((paper.start_source, paper.start_deviation), (EndSource::Extreme, None));
}

#[test]
fn the_rule_follows_the_method_unless_it_is_chosen() {
    let scene = Scene::tilted(0.4);
    let (_, depth, mask) = scene.render(2);
    let mut fitter = Scene::fitter(&depth, &mask);
    let mut source = |options: Options| {
        fitter.set_options(options).unwrap();
        fitter.extent(Some(&scene.cylinder), None).unwrap().start_source
    };
    let robust = Options::default();
    let paper = Options { objective: ObjectiveKind::Paper, ..robust };
    let ransac = Options { method: Method::Ransac, ..robust };
    assert_eq!(
        [robust, paper, ransac].map(&mut source),
        [EndSource::Mask, EndSource::Extreme, EndSource::Extreme]
    );
    for options in [robust, paper, ransac] {
        assert_eq!(source(Options { extent_rule: ExtentRule::Extremes, ..options }), EndSource::Extreme);
        assert_eq!(source(Options { extent_rule: ExtentRule::Located, ..options }), EndSource::Mask);
    }
}

#[test]
fn an_occluder_over_a_part_of_the_ends_does_not_shorten() {
    let mut scene = Scene::tilted(0.3);
    scene.bar = Some((70.0, 90.0));
    for with_image in [false, true] {
        let found = extent(&scene, 0, ExtentRule::Located, with_image);
        for error in errors(&scene, &found) {
            assert!(error.abs() < 0.8, "{error} pixels");
        }
    }
}

#[test]
fn an_occluder_over_an_end_hides_it() {
    let direction = Vector3::x();
    let cylinder = Cylinder::new(Vector3::new(0.0, 0.0, 0.7), direction, 0.03).unwrap();
    let scene = Scene { cylinder, ends: (-0.06, 0.06), bar: Some((120.0, 170.0)) };
    let found = extent(&scene, 0, ExtentRule::Located, true);
    assert_eq!((found.start_state, found.end_state), (EndState::Seen, EndState::Hidden));
    assert_eq!((found.start_source, found.end_source), (EndSource::Image, EndSource::Mask));
    assert!(errors(&scene, &found)[0].abs() < 0.1);
}

#[test]
fn a_cut_end_is_the_last_of_the_surface_in_the_image() {
    let mut scene = Scene::tilted(0.2);
    scene.ends.1 = 0.5;
    let camera = Scene::camera();
    let axis = scene.cylinder.axis;
    let mut last = f64::NEG_INFINITY;
    for (column, row) in (0..SIZE.0).flat_map(|column| (0..SIZE.1).map(move |row| (column, row))) {
        let ray = camera.unproject(&Vector2::new(column as f64, row as f64)).unwrap();
        if let Some(point) = scene.cylinder.first_hit(&ray) {
            last = last.max(axis.position_of(&point));
        }
    }
    scene.ends.1 = last;
    let rendered = Scene { ends: (scene.ends.0, 0.5), ..scene };
    let found = extent(&rendered, 2, ExtentRule::Located, true);
    assert_eq!((found.start_state, found.end_state), (EndState::Seen, EndState::Cut));
    assert_eq!(found.end_source, EndSource::Border);
    assert!((axis.position_of(&found.end) - last).abs() < 1e-12);
}

/// The last of the surface inside the image, which was taken for the end, lies 2.7 to 8.7 pixels beyond it.
#[test]
fn an_end_that_the_border_cuts_off_in_part_is_where_the_rest_of_it_is() {
    for (tilt, end) in [(0.0, 0.112), (0.0, 0.118), (0.2, 0.116), (-0.2, 0.116), (0.4, 0.118)] {
        let scene = Scene { ends: (-0.0613, end), ..Scene::tilted(tilt) };
        for (bias, with_image) in [(0, true), (2, true), (-2, true), (0, false)] {
            let found = extent(&scene, bias, ExtentRule::Located, with_image);
            let error = errors(&scene, &found)[1];
            let most = if found.end_source == EndSource::Image { 0.3 } else { 0.7 };
            assert!(error.abs() < most, "tilt {tilt}, end {end}, bias {bias}: {error} pixels");
            assert_eq!(found.end_state, EndState::Seen, "tilt {tilt}, end {end}, bias {bias}");
        }
    }
}

/// What pixels beside the mask would show of the surface was taken for the end: up to ten stated deviations beyond it.
#[test]
fn what_is_stated_of_a_cut_end_holds_the_end_of_the_body() {
    let mut cut = 0;
    for (tilt, end) in [0.4, 0.5, -0.4, -0.5].into_iter().flat_map(|tilt| (0..12).map(move |k| (tilt, k))) {
        let scene = Scene { ends: (-0.0613, 0.11 + 0.003 * f64::from(end)), ..Scene::tilted(tilt) };
        for with_image in [false, true] {
            let found = extent(&scene, 0, ExtentRule::Located, with_image);
            if found.end_state == EndState::Cut {
                let beyond = errors(&scene, &found)[1] / (found.end_deviation.unwrap() * Scene::PIXELS);
                assert!(beyond < 2.0, "tilt {tilt}, end {end}: {beyond} deviations");
                cut += 1;
            }
        }
    }
    assert!(cut > 8, "{cut}");
}

/// Such masks looked like ends inside the image at first.
#[test]
fn a_mask_that_stops_short_of_the_border_is_cut_off_by_it() {
    for tilt in [0.0, 0.2, -0.2] {
        let scene = Scene { ends: (-0.0613, 0.5), ..Scene::tilted(tilt) };
        let (_, depth, mut mask) = scene.render(0);
        for rows in [4, 5, 6] {
            mask[(SIZE.1 - rows) * SIZE.0..].fill(0);
            let fitter = Scene::fitter(&depth, &mask);
            let found = fitter.find_extent(Some(&scene.cylinder), None, Some(true)).unwrap().0;
            assert_eq!(found.end_state, EndState::Cut, "tilt {tilt}, {rows} rows");
        }
    }
}

/// The depth goes on as the surface would: that was taken for the end of it.
#[test]
fn nobody_knows_what_a_mask_that_stops_before_the_end_leaves_out() {
    for tilt in [0.0, 0.2, -0.4] {
        let scene = Scene::tilted(tilt);
        let (_, depth, mut mask) = scene.render(0);
        let last = mask.chunks(SIZE.0).rposition(|row| row.iter().any(|&pixel| pixel != 0)).unwrap();
        for rows in [40, 60] {
            mask[(last - rows) * SIZE.0..].fill(0);
            let fitter = Scene::fitter(&depth, &mask);
            let found = fitter.find_extent(Some(&scene.cylinder), None, Some(true)).unwrap().0;
            let states = (found.start_state, found.end_state);
            assert_eq!(states, (EndState::Seen, EndState::Unknown), "tilt {tilt}, {rows} rows");
        }
    }
}

/// Where each pixel of the border looked at all that the mask may be off by, and generators were followed as far or by steps
/// as small as any number, this never ended.
#[test]
fn ends_take_no_longer_however_far_or_fine_the_mask_may_be_drawn() {
    let scene = Scene { ends: (-0.06, 0.5), ..Scene::tilted(0.2) };
    let (image, depth, mask) = scene.render(0);
    let base = NoiseModel::default();
    for noise in [
        NoiseModel { mask_boundary: 1e9, ..base },
        NoiseModel { drawn_pixel: 1e9, ..base },
        NoiseModel { drawn_pixel: 1e-9, ..base },
        NoiseModel { drawn_pixel: 1e-9, mask_boundary: 1e18, ..base },
    ] {
        for with_image in [false, true] {
            let mut fitter = Scene::fitter(&depth, &mask);
            if with_image {
                fitter.push_image(&ImageView::from_f32(&image, SIZE).unwrap()).unwrap();
            }
            fitter
                .set_options(Options { extent_rule: ExtentRule::Located, noise, ..Options::default() })
                .unwrap();
            let found = fitter.find_extent(Some(&scene.cylinder), None, Some(true)).unwrap().0;
            assert!(found.length.is_finite() && found.length > 0.0, "{noise:?}");
        }
    }
}

/// The image blurred by a Gaussian of a standard deviation of one pixel.
fn blurred(image: &[f32]) -> Vec<f32> {
    let weight = |k: i64| (-0.5 * (k * k) as f64).exp();
    let weights: f64 = (-4..=4).map(weight).sum();
    let pixel = |column: i64, row: i64| {
        let (x, y) = (column.clamp(0, SIZE.0 as i64 - 1), row.clamp(0, SIZE.1 as i64 - 1));
        f64::from(image[y as usize * SIZE.0 + x as usize])
    };
    let along = |x: i64, y: i64| (-4..=4).map(|k| weight(k) * pixel(x + k, y)).sum::<f64>() / weights;
    let both = |x: i64, y: i64| (-4..=4).map(|k| weight(k) * along(x, y + k)).sum::<f64>() / weights;
    let pixels = (0..SIZE.1 as i64).flat_map(|row| (0..SIZE.0 as i64).map(move |column| (column, row)));
    pixels.map(|(x, y)| both(x, y) as f32).collect()
}

/// How far the positions on the near rims of both ends lie outside the end circles, in pixels, and those on the far rims.
fn offsets_of_rims(tilt: f64, blur: bool) -> [[Vec<f64>; 2]; 2] {
    let scene = Scene::tilted(tilt);
    let (image, depth, mask) = scene.render(0);
    let image = if blur { blurred(&image) } else { image };
    let mut fitter = Scene::fitter(&depth, &mask);
    fitter.push_image(&ImageView::from_f32(&image, SIZE).unwrap()).unwrap();
    let camera = Scene::camera();
    let search = EndSearch {
        camera: &camera,
        mask: fitter.mask().unwrap(),
        content: MaskContent::Anything,
        drawn: true,
        depth: fitter.depth(),
        image: fitter.image(),
        tolerance: depth_tolerance(fitter.cloud(), &scene.cylinder),
        limbs_known: true,
        noise: NoiseModel::default().in_image(camera.size()),
        blur: None,
        last: [None; 2],
    };
    let axis = scene.cylinder.axis;
    let [start, end] = locate_ends(&search, &scene.cylinder, &mut || ControlFlow::Continue(()))
        .continue_value()
        .flatten()
        .unwrap();
    [Rim::Near, Rim::Far].map(|rim| {
        [(&start, scene.ends.0), (&end, scene.ends.1)].map(|(found, end)| {
            let offset = |sample: &ArcSample| {
                let ray = camera.unproject(&sample.pixel).unwrap();
                let (position, normal) = on_wall(&scene.cylinder, &ray, rim).unwrap();
                let point = axis.at(position) + normal * scene.cylinder.radius;
                let on_circle = camera.project(&(point + axis.direction * (end - position))).unwrap();
                (sample.pixel - on_circle).dot(&sample.normal)
            };
            let samples = if rim == Rim::Near { &found.samples } else { &found.far_rim };
            samples.iter().map(offset).collect()
        })
    })
}

#[test]
fn samples_of_the_arcs_lie_on_the_end_circles() {
    for offsets in offsets_of_rims(0.5, false)[0].clone() {
        assert!(offsets.len() > 20);
        let mut sizes: Vec<f64> = offsets.iter().map(|offset| offset.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        assert!(sizes[sizes.len() / 2] < 0.1, "{offsets:?}");
    }
}

#[test]
fn the_far_rim_of_a_cap_does_not_bend_the_arc() {
    // The cap, 4 to 9 pixels wide in the middle, narrows to nothing at the limbs, and where its far rim lies just
    // outside the window of a profile it still shines in.
    for tilt in [0.15, 0.17, 0.19, 0.21] {
        let [[offsets, _], _] = offsets_of_rims(tilt, true);
        assert!(offsets.len() > 40, "tilt {tilt}: {offsets:.2?}");
        assert!(offsets.iter().all(|offset| offset.abs() < 0.3), "tilt {tilt}: {offsets:.2?}");
    }
}

#[test]
fn an_end_that_faces_the_camera_is_told_by_its_far_rim_too() {
    for tilt in [0.3, 0.5] {
        let [near, far] = offsets_of_rims(tilt, true);
        assert!(near.iter().all(|offsets| offsets.len() > 20), "{near:?}");
        assert!(far[0].len() > 20 && far[1].is_empty(), "{far:?}");
        let mut sizes: Vec<f64> = far[0].iter().map(|offset| offset.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        assert!(sizes[sizes.len() / 2] < 0.1, "{far:.2?}");
    }
}

#[test]
fn a_plain_image_leaves_the_mask() {
    let scene = Scene::tilted(0.3);
    let (_, depth, mask) = scene.render(0);
    let mut fitter = Scene::fitter(&depth, &mask);
    fitter.push_image(&ImageView::from_u8(&vec![90; SIZE.0 * SIZE.1], SIZE).unwrap()).unwrap();
    let found = fitter.extent(Some(&scene.cylinder), None).unwrap();
    assert_eq!((found.start_source, found.end_source), (EndSource::Mask, EndSource::Mask));
}

#[test]
fn from_inside_a_pipe_the_points_tell_the_ends() {
    // A camera that looks along the pipe about itself, whose wall was measured from 0.5 to 2 away.
    let pipe = Cylinder::new(Vector3::new(0.02, 0.01, 0.0), Vector3::new(0.01, -0.02, 1.0), 0.2).unwrap();
    let camera = Scene::camera();
    let mut depth = vec![0.0_f32; SIZE.0 * SIZE.1];
    for (k, depth) in depth.iter_mut().enumerate() {
        let ray = camera.unproject(&Vector2::new((k % SIZE.0) as f64, (k / SIZE.0) as f64)).unwrap();
        let z = pipe.first_hit(&ray).unwrap().z;
        *depth = if z < 2.0 { z as f32 } else { 0.0 };
    }
    let mut fitter = Scene::fitter(&depth, &vec![1; SIZE.0 * SIZE.1]);
    let found = fitter.extent(Some(&pipe), None).unwrap();
    assert_eq!((found.start_source, found.end_source), (EndSource::Points, EndSource::Points));
    // The wall leaves the image at the height of its corners and beside its edges, and few pixels reach far.
    assert!(found.end.z > 1.8 && found.end.z < 2.1, "{found:?}");
    assert!(found.start.z > 0.7 && found.start.z < 1.3, "{found:?}");
    // Without points on it the mask is all that there is.
    fitter.clear_inputs(Inputs::POINTS);
    assert_eq!(fitter.extent(Some(&pipe), None).unwrap().end_source, EndSource::Extreme);
}

/// The points of the cylinder of a scene, and its image.
fn points_and_image(scene: &Scene) -> (Vec<[f64; 3]>, Vec<f32>) {
    let (image, depth, mask) = scene.render(0);
    let camera = Scene::camera();
    let point = |k: usize| {
        let pixel = Vector2::new((k % SIZE.0) as f64, (k / SIZE.0) as f64);
        (camera.unproject(&pixel).unwrap() * f64::from(depth[k])).into()
    };
    ((0..mask.len()).filter(|&k| mask[k] != 0).map(point).collect(), image)
}

fn fitted_to_points_and_image(scene: &Scene) -> Fitter {
    let (points, image) = points_and_image(scene);
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(Scene::intrinsics()).unwrap();
    fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
    fitter.push_image(&ImageView::from_f32(&image, SIZE).unwrap()).unwrap();
    fitter.fit().unwrap();
    fitter
}

#[test]
fn points_alone_have_ends() {
    for tilt in [0.0, 0.3, -0.6] {
        let scene = Scene::tilted(tilt);
        let mut fitter = Fitter::new();
        fitter.push_points(&PointsView::from_f64(&points_and_image(&scene).0), None).unwrap();
        fitter.set_start(Some(scene.cylinder));
        fitter.fit().unwrap();
        let found = fitter.extent(None, None).unwrap();
        for error in errors(&scene, &found) {
            assert!(error.abs() < 1.0, "tilt {tilt}: {error} pixels");
        }
        assert_eq!((found.start_source, found.end_source), (EndSource::Points, EndSource::Points));
        assert_eq!((found.start_state, found.end_state), (EndState::Unknown, EndState::Unknown));
        let [of_length, of_end] = [found.uncertainty.unwrap().length, found.end_deviation.unwrap()];
        assert!(of_length > of_end && of_length < 2.1 * of_end, "{found:?}");
        // Of a given model the ends are known, and not how uncertain it is.
        let given = fitter.extent(Some(&scene.cylinder), None).unwrap();
        assert!(given.uncertainty.is_none() && (given.length - found.length).abs() < 1e-3);
    }
}

/// The length of a pipe and its deviation by rows and columns of points, of which so many along either share an error.
fn length_with_errors_alike(window: u32) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let errors: Vec<f64> =
        (0..60 * 100).map(|_| f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5).collect();
    let point = |row: u32, column: u32| {
        let (sin, cos) = (0.035 * (f64::from(column) - 29.5)).sin_cos();
        let radius = 0.2 + 2e-3 * errors[(row / window * 60 + column / window) as usize];
        [radius * sin, 0.006 * (f64::from(row) - 49.5), 1.0 - radius * cos]
    };
    let points: Vec<_> = (0..100).flat_map(|row| (0..60).map(move |column| point(row, column))).collect();
    let mut fitter = Fitter::new();
    fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
    fitter.fit().unwrap();
    let found = fitter.extent(None, None).unwrap();
    (found.length, found.uncertainty.unwrap().length)
}

#[test]
fn ends_of_points_are_as_uncertain_as_errors_are_alike() {
    let (length, alone) = length_with_errors_alike(1);
    assert!((length - 0.6).abs() < alone && alone < 0.006, "{length} {alone}");
    let (length, alike) = length_with_errors_alike(5);
    assert!((length - 0.6).abs() < alike && alike > 2.5 * alone, "{length} {alike} {alone}");
}

#[test]
fn points_with_an_image_have_their_ends_in_it() {
    let scene = Scene::tilted(0.3);
    let fitter = fitted_to_points_and_image(&scene);
    let found = fitter.extent(None, None).unwrap();
    for error in errors(&scene, &found) {
        assert!(error.abs() < 0.2, "{error} pixels");
    }
    assert_eq!((found.start_source, found.end_source), (EndSource::Image, EndSource::Image));
}

/// It was taken for one of the pixels that have depth, in which specks stay.
#[test]
fn a_mask_that_is_given_after_a_fit_without_one_is_a_drawn_one() {
    let scene = Scene::tilted(0.3);
    let fitter = fitted_to_points_and_image(&scene);
    let mut mask = scene.render(0).2;
    let length =
        |mask: &[u8]| fitter.extent(None, Some(&MaskView::from_u8(mask, SIZE).unwrap())).unwrap().length;
    let clean = length(&mask);
    // Beside one another beyond the end, each of them a small part of the mask.
    let beyond = Scene::camera().project(&scene.cylinder.axis.at(scene.ends.1 + 0.04)).unwrap();
    let (column, row) = (beyond.x as usize, beyond.y as usize);
    (column - 20..column + 20).step_by(2).for_each(|column| mask[row * SIZE.0 + column] = 1);
    assert_eq!(length(&mask).to_bits(), clean.to_bits());
}

/// Few points lie beyond an end by chance, and a mask knows it to a pixel.
#[test]
fn a_view_of_points_does_not_move_the_ends_of_a_mask() {
    let scene = Scene::tilted(0.3);
    let (_, depth, mask) = scene.render(0);
    let mut fitter = Scene::fitter(&depth, &mask);
    let of_mask = fitter.extent(Some(&scene.cylinder), None).unwrap();
    let (points, _) = points_and_image(&scene);
    fitter.select_view(1).unwrap();
    let farther = scene.cylinder.axis.direction * 0.01;
    let moved = points.iter().map(|point| (Vector3::from(*point) + farther).into());
    fitter.push_points(&PointsView::from_f64(&moved.collect::<Vec<_>>()), None).unwrap();
    assert_eq!(fitter.extent(Some(&scene.cylinder), None).unwrap(), of_mask);
    // Nor where nothing tells what lies beyond it.
    fitter.select_view(0).unwrap();
    let bare: Vec<f32> = depth.iter().zip(&mask).map(|(&z, &set)| if set == 0 { 0.0 } else { z }).collect();
    let range = crate::observations::DepthRange::default();
    let depth = crate::observations::DepthView::from_f32(&bare, SIZE, 1.0).unwrap();
    fitter.push_depth(&depth, Some(&MaskView::from_u8(&mask, SIZE).unwrap()), &range).unwrap();
    let both = fitter.extent(Some(&scene.cylinder), None).unwrap();
    assert_eq!((both.end_state, both.end_source, both.end_view), (EndState::Unknown, EndSource::Mask, 0));
}

/// The tolerance is a multiple of the median distance of all points.
#[test]
fn points_of_a_whole_scene_do_not_move_the_ends_of_a_model() {
    let scene = Scene::tilted(0.3);
    let (mut points, _) = points_and_image(&scene);
    let count = 2 * points.len();
    let wall = |k: usize| [-1.0 + 2.0 * (k % 97) as f64 / 97.0, -1.0 + 2.0 * k as f64 / count as f64, 1.5];
    points.extend((0..count).map(wall));
    let mut fitter = Fitter::new();
    fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
    for error in errors(&scene, &fitter.extent(Some(&scene.cylinder), None).unwrap()) {
        assert!(error.abs() < 1.0, "{error} pixels");
    }
}

#[test]
fn without_points_or_a_mask_there_are_no_ends() {
    let cylinder = Scene::tilted(0.3).cylinder;
    let mut fitter = Fitter::new();
    let error = fitter.extent(Some(&cylinder), None).unwrap_err();
    assert!(matches!(error, crate::error::Error::BadState { missing: "points or a mask", .. }), "{error}");
    // Points elsewhere.
    fitter.push_points(&PointsView::from_f64(&[[0.0, 0.0, 9.0]; 50]), None).unwrap();
    let error = fitter.extent(Some(&cylinder), None).unwrap_err();
    assert!(matches!(error, crate::error::Error::EdgeGeometry { .. }), "{error}");
}
