use super::super::views::MaskView;
use super::*;

#[test]
fn what_is_dropped_is_counted_by_reason() {
    let nan = f64::NAN;
    let points = [[1.0, 2.0, 3.0], [nan, 0.0, 0.0], [4.0, 5.0, 6.0], [7.0, 8.0, f64::INFINITY]];
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    assert_eq!((cloud.len(), cloud.given(), cloud.dropped().not_finite), (2, 4, 2));
    assert_eq!(cloud.point(1), Vector3::new(4.0, 5.0, 6.0));
    let mask = Mask::copy(&MaskView::from_u8(&[1, 0, 0, 1], (4, 1)).unwrap()).unwrap();
    cloud.push_points(&PointsView::from_f64(&points), Some(&mask)).unwrap();
    assert_eq!(*cloud.dropped(), Dropped { not_finite: 3, outside_mask: 2, ..Dropped::default() });
    let small = Mask::copy(&MaskView::from_u8(&[1], (1, 1)).unwrap()).unwrap();
    assert!(cloud.push_points(&PointsView::from_f64(&points), Some(&small)).is_err());
    assert_eq!((cloud.len(), cloud.given()), (3, 8));
}

#[test]
fn weights_are_kept_only_when_one_differs_from_1() {
    let points = [[1.0_f32, 2.0, 3.0]; 3];
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f32(&points), None).unwrap();
    assert!(cloud.weights().is_none());
    let memory = [2.0_f32, 0.0, 0.5].map(f32::to_ne_bytes).concat();
    let weights = Strided::new(&memory, 0, (3, 1), 4, (4, 0)).unwrap();
    let view = PointsView { weights: Some(weights), ..PointsView::from_f32(&points) };
    cloud.push_points(&view, None).unwrap();
    assert_eq!(cloud.weights().unwrap(), [1.0, 1.0, 1.0, 2.0, 0.5]);
    assert_eq!(cloud.dropped().zero_weight, 1);
}
use super::super::strided::Strided;

#[test]
fn normals_count_only_when_every_point_has_one() {
    let points = [[1.0, 2.0, 3.0], [f64::NAN; 3], [4.0, 5.0, 6.0]];
    let normals = [[0.0, 0.0, -2.0], [1.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0]];
    let view = PointsView::from_f64(&points);
    let oriented = PointsView { normals: Some(PointsView::from_f64(&normals).points), ..view };
    let mut cloud = PointCloud::default();
    cloud.push_points(&oriented, None).unwrap();
    assert_eq!(cloud.normals().unwrap(), [Vector3::new(0.0, 0.0, -1.0), Vector3::zeros()]);
    cloud.push_points(&view, None).unwrap();
    assert!(cloud.normals().is_none());
    cloud.push_points(&oriented, None).unwrap();
    assert!(cloud.normals().is_none());
    cloud.clear();
    cloud.push_points(&oriented, None).unwrap();
    assert_eq!(cloud.normals().unwrap().len(), 2);
}

#[test]
fn f64_input_keeps_its_digits_whatever_came_before() {
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f32(&[[10_000.0, 0.0, 0.0]]), None).unwrap();
    assert!((cloud.resolution() - 1.19e-3).abs() < 1e-5);
    cloud.push_points(&PointsView::from_f64(&[[10_000.123_456_789, 0.25, 0.5]]), None).unwrap();
    assert!((cloud.point(1).x - 10_000.123_456_789).abs() < 2e-12);
    assert_eq!(cloud.point(0).x, 10_000.0);
}

#[test]
fn the_origin_is_near_the_data_in_spite_of_far_points() {
    let mut points = vec![[10.0, 20.0, 30.0]; 9];
    points.insert(0, [1e6, 0.0, 0.0]);
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    assert_eq!(*cloud.origin(), Vector3::new(10.0, 20.0, 30.0));
}
