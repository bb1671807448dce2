use super::*;
use crate::camera::{Distortion, Intrinsics};
use crate::observations::{DepthView, PointsView};

const SIZE: (usize, usize) = (320, 240);

fn camera() -> Camera {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let (fx, fy, cx, cy) = (300.0, 300.0, 159.5, 119.5);
    Camera::new(Intrinsics { width, height, fx, fy, cx, cy, distortion: Distortion::None }).unwrap()
}

/// What may stand in a scene. A ray gives the depth at which it first meets it.
enum Body {
    /// Normal and distance from the origin.
    Plane(Vector3<f64>, f64),
    Sphere(Vector3<f64>, f64),
    /// A piece of a cylinder from its centre by half its length to each side, with caps.
    Can(Cylinder, f64),
    /// The same with a radius that grows along the axis.
    Frustum(Cylinder, f64, f64),
    /// A can with a keyway towards the camera, of this width and depth.
    Keyed(Cylinder, f64, [f64; 2]),
    /// Centre, three half edges.
    Block(Vector3<f64>, [Vector3<f64>; 3]),
}

impl Body {
    fn depth(&self, ray: &Vector3<f64>) -> Option<f64> {
        match self {
            Self::Plane(normal, distance) => {
                let slope = normal.dot(ray);
                (slope.abs() > 1e-9).then(|| distance / slope).filter(|&t| t > 0.0)
            }
            Self::Sphere(center, radius) => {
                let (a, b) = (ray.norm_squared(), ray.dot(center));
                let root = b * b - a * (center.norm_squared() - radius * radius);
                (root >= 0.0).then(|| (b - root.sqrt()) / a).filter(|&t| t > 0.0)
            }
            Self::Can(cylinder, half) => frustum(cylinder, 0.0, *half, ray),
            Self::Frustum(cylinder, taper, half) => frustum(cylinder, *taper, *half, ray),
            Self::Keyed(cylinder, half, [width, depth]) => {
                let Cylinder { axis, radius } = cylinder;
                let surface = frustum(cylinder, 0.0, *half, ray)?;
                let toward = -axis.nearest_to(&Vector3::zeros()).normalize();
                let point = ray * surface - axis.point;
                let is_cut = point.dot(&toward) > 0.0
                    && point.dot(&axis.direction.cross(&toward)).abs() <= 0.5 * width
                    && point.dot(&axis.direction).abs() <= 0.8 * half;
                let floor = (axis.point.dot(&toward) + radius - depth) / ray.dot(&toward);
                Some(if is_cut { floor } else { surface })
            }
            Self::Block(center, edges) => {
                let (mut near, mut far) = (0.0_f64, f64::INFINITY);
                for edge in edges {
                    let (a, b) = (ray.dot(edge), center.dot(edge));
                    let reach = edge.norm_squared();
                    let (t0, t1) = ((b - reach) / a, (b + reach) / a);
                    near = near.max(t0.min(t1));
                    far = far.min(t0.max(t1));
                }
                (near > 0.0 && near < far).then_some(near)
            }
        }
    }
}

fn frustum(cylinder: &Cylinder, taper: f64, half: f64, ray: &Vector3<f64>) -> Option<f64> {
    let (p, d, r) = (cylinder.axis.point, cylinder.axis.direction, cylinder.radius);
    // |t k − q|² = (r + taper (t a − c))² with everything across the axis in k and q.
    let (along, start) = (ray.dot(&d), p.dot(&d));
    let (k, q) = (ray - d * along, p - d * start);
    let (base, slope) = (r - taper * start, taper * along);
    let a = k.norm_squared() - slope * slope;
    let b = k.dot(&q) + base * slope;
    let root = b * b - a * (q.norm_squared() - base * base);
    let mut hits = Vec::new();
    if root >= 0.0 && a.abs() > 1e-12 {
        hits.extend([(b - root.sqrt()) / a, (b + root.sqrt()) / a]);
        hits.retain(|t| (t * along - start).abs() <= half);
    }
    for end in [-half, half] {
        let t = (start + end) / along;
        if ((t * ray - p) - d * end).norm() <= r + taper * end {
            hits.push(t);
        }
    }
    hits.into_iter().filter(|&t| t > 0.0).min_by(f64::total_cmp)
}

/// Normal errors with standard deviation 1, always the same.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// The depth of a scene with errors of 1.5 mm at 1 m that grow with the square of the depth, times a unit of length.
fn render(bodies: &[Body], unit: f64) -> DepthImage {
    let camera = camera();
    let mut random = Random(7);
    let mut depths = Vec::new();
    for row in 0..SIZE.1 {
        for column in 0..SIZE.0 {
            let ray = camera.unproject(&Vector2::new(column as f64, row as f64)).unwrap();
            let depth = bodies.iter().filter_map(|body| body.depth(&ray)).min_by(f64::total_cmp);
            let error = random.normal();
            depths.push(depth.map_or(0.0, |z| (unit * (z + 0.0015 * z * z * error)) as f32));
        }
    }
    DepthImage::copy(&DepthView::from_f32(&depths, SIZE, 1.0).unwrap()).unwrap()
}

/// Five pipes along the rows, side by side on a plane that is aslant by half a radian: the last one is the nearest, and each but
/// that is hidden in part by the next. Their depth by matching windows of so many pixels to each side.
fn row_of_pipes(radius: f64, window: usize) -> (Vec<Cylinder>, DepthImage) {
    let (camera, mut random) = (camera(), Random(7));
    let down = Vector3::new(0.0, 0.5_f64.cos(), -0.5_f64.sin());
    let normal = Vector3::new(0.0, -down.z, down.y);
    let middle = |k: usize| Vector3::new(0.0, 0.0, 0.7) + down * (2.0 * radius * (k as f64 - 2.0));
    let pipes: Vec<_> = (0..5).map(|k| Cylinder::new(middle(k), Vector3::x(), radius).unwrap()).collect();
    let mut bodies = vec![Body::Plane(normal, 0.7 * normal.z + radius)];
    bodies.extend(pipes.iter().map(|pipe| Body::Can(*pipe, 0.15)));
    let point = |column: usize, row: usize| {
        let ray = camera.unproject(&Vector2::new(column as f64, row as f64)).unwrap();
        ray * bodies.iter().filter_map(|body| body.depth(&ray)).min_by(f64::total_cmp).unwrap()
    };
    let [width, height] = [SIZE.0, SIZE.1];
    let points: Vec<_> = (0..width * height).map(|k| point(k % width, k / width)).collect();
    let around = |t: usize, reach: usize, size: usize| t.saturating_sub(reach)..(t + reach + 1).min(size);
    let mut depths = Vec::new();
    for k in 0..width * height {
        let (rows, columns) = (around(k / width, window, height), around(k % width, window, width));
        let seen: Vec<f64> =
            rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).map(|j| points[j].z).collect();
        let depth = seen.len() as f64 / seen.iter().map(|z| 1.0 / z).sum::<f64>();
        depths.push((depth + 0.0015 * depth * depth * random.normal()) as f32);
    }
    (pipes, DepthImage::copy(&DepthView::from_f32(&depths, SIZE, 1.0).unwrap()).unwrap())
}

/// A table 0.2 below the camera that looks down at it.
fn table() -> Body {
    Body::Plane(Vector3::new(0.0, 0.8, 0.6), 0.6)
}

fn can(x: f64, y: f64, z: f64, direction: Vector3<f64>, radius: f64) -> Cylinder {
    Cylinder::new(Vector3::new(x, y, z), direction, radius).unwrap()
}

fn search_for(bodies: &[Body]) -> Detections {
    detect(&camera(), &render(bodies, 1.0), None, &DetectionOptions::default()).unwrap()
}

const UP: Vector3<f64> = Vector3::new(0.0, 0.8, 0.6);

fn matches(found: &Cylinder, truth: &Cylinder) -> bool {
    let change = truth.compare(found);
    change.angle < 0.09 && change.axis_distance < 0.5 * truth.radius && change.radius_relative.abs() < 0.1
}

#[test]
fn cans_and_pipes_are_found_among_other_bodies() {
    let truths = [
        can(-0.15, 0.12, 0.7, UP, 0.04),
        can(0.12, 0.1, 0.72, Vector3::new(1.0, 0.1, -0.1), 0.035),
        can(0.0, -0.14, 0.9, Vector3::new(1.0, 0.0, 0.2), 0.03),
    ];
    let bodies = [
        table(),
        Body::Can(truths[0], 0.08),
        Body::Can(truths[1], 0.06),
        Body::Can(truths[2], 5.0),
        Body::Sphere(Vector3::new(-0.02, 0.1, 0.75), 0.05),
    ];
    let found = search_for(&bodies);
    for truth in &truths {
        let hits = found.cylinders.iter().filter(|d| matches(&d.cylinder, truth)).count();
        assert_eq!(hits, 1, "{truth:?}: {:?}", found.cylinders);
    }
    assert_eq!(found.cylinders.len(), truths.len(), "{:?}", found.cylinders);
    for (index, detection) in found.cylinders.iter().enumerate() {
        let pixels = found.labels.iter().filter(|&&label| usize::from(label) == index + 1).count();
        assert_eq!(pixels, detection.pixels);
        assert!(detection.score > 0.5 && pixels > 500);
    }
}

/// Its floor seemed to be something that is seen through the shaft.
#[test]
fn a_shaft_with_a_keyway_is_found() {
    for (width, depth) in [(0.4, 0.2), (0.5, 0.2), (0.5, 0.24)] {
        let shaft = can(0.0, 0.0, 0.16, Vector3::new(1.0, 0.1, 0.1), 0.04);
        let keyed = Body::Keyed(shaft, 0.06, [width * 0.04, depth * 0.04]);
        let found = search_for(&[Body::Plane(Vector3::z(), 0.4), keyed]).cylinders;
        let [one] = &found[..] else { panic!("{width} {depth}: {found:?}") };
        assert!(matches(&one.cylinder, &shaft), "{width} {depth}: {one:?}");
    }
}

/// Their depth goes on over the line of contact without a step, and the surface of the next seemed to be that of the same body.
#[test]
fn pipes_that_touch_are_found() {
    for radius in [0.025, 0.03] {
        let (pipes, depth) = row_of_pipes(radius, 1);
        let found = detect(&camera(), &depth, None, &DetectionOptions::default()).unwrap().cylinders;
        let hits = pipes.iter().filter(|pipe| found.iter().any(|one| matches(&one.cylinder, pipe))).count();
        assert!(hits >= 4, "{hits} of 5 with {radius}: {found:?}");
    }
}

/// Draws depth out as matching windows do, by so many pixels beyond what is 0.1 nearer, then smooths it along rows and columns, each to
/// and fro and all of it twice, but for steps of 0.02 and more: what a RealSense gives as it is set when it is bought.
fn drawn_out_and_smoothed(depth: &DepthImage, reach: usize) -> DepthImage {
    let [width, height] = [SIZE.0, SIZE.1];
    let z: Vec<f64> = (0..width * height).map(|k| depth.depth(k % width, k / width).unwrap()).collect();
    let around = |t: usize, size: usize| t.saturating_sub(reach)..(t + reach + 1).min(size);
    let drawn_out = |k: usize| {
        let (rows, columns) = (around(k / width, height), around(k % width, width));
        let seen = rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).map(|j| z[j]);
        let nearest = seen.fold(f64::INFINITY, f64::min);
        if nearest < z[k] - 0.1 { nearest } else { z[k] }
    };
    let mut depths: Vec<f64> = (0..width * height).map(drawn_out).collect();
    let mut smooth = |line: &mut dyn Iterator<Item = usize>| {
        let mut before = f64::INFINITY;
        for k in line {
            if (depths[k] - before).abs() < 0.02 {
                depths[k] = 0.5 * (depths[k] + before);
            }
            before = depths[k];
        }
    };
    for _ in 0..2 {
        for row in 0..height {
            smooth(&mut (row * width..(row + 1) * width));
            smooth(&mut (row * width..(row + 1) * width).rev());
        }
        for column in 0..width {
            smooth(&mut (column..width * height).step_by(width));
            smooth(&mut (column..width * height).step_by(width).rev());
        }
    }
    let depths: Vec<f32> = depths.into_iter().map(|z| z as f32).collect();
    DepthImage::copy(&DepthView::from_f32(&depths, SIZE, 1.0).unwrap()).unwrap()
}

/// The strip of depth beside the limb and the smoothed edge between the two seemed to be a surface that goes on.
#[test]
fn pipes_whose_depth_is_drawn_out_and_smoothed_are_found() {
    let truths = [
        can(-0.15, 0.0, 0.75, Vector3::new(0.1, 1.0, 0.15), 0.05),
        can(0.13, 0.0, 0.7, Vector3::new(-0.15, 1.0, -0.1), 0.03),
    ];
    let mut bodies = vec![Body::Plane(Vector3::z(), 1.2)];
    bodies.extend(truths.map(|pipe| Body::Can(pipe, 5.0)));
    let depth = drawn_out_and_smoothed(&render(&bodies, 1.0), 3);
    let found = detect(&camera(), &depth, None, &DetectionOptions::default()).unwrap().cylinders;
    // The filter bends the depth, so that radii are off by more than they may be elsewhere.
    for truth in &truths {
        let hits = |found: &Cylinder| {
            let change = truth.compare(found);
            change.angle < 0.09 && change.axis_distance < 0.5 * truth.radius
        };
        assert_eq!(found.iter().filter(|one| hits(&one.cylinder)).count(), 1, "{truth:?}: {found:?}");
    }
}

/// The limb of a pipe that hides a part of the next was taken for a limb of that, which then came out too narrow.
#[test]
fn the_edge_of_what_hides_a_body_is_no_limb_of_it() {
    let (pipes, depth) = row_of_pipes(0.03, 1);
    let camera = camera();
    let pixel = 1.0 / camera.intrinsics().fx;
    let read_points = |row: usize, columns: Range<usize>, points: &mut [List<f64>; 3]| {
        row::write(columns, points, |column| {
            let point = depth.depth(column, row).and_then(|z| Some(camera.ray_of_pixel(column, row)? * z));
            point.unwrap_or_default().into()
        });
    };
    let mut grid = Grid::new(SIZE, pixel, side_of_cells(SIZE, pixel), &read_points);
    let noise = noise::Noise::of_scene(&mut grid).unwrap();
    let open = grid.cells.iter().map(grid::Cell::measured).collect();
    let edges = ImageEdges::default();
    let pixel_of = |p: &Vector2<f64>| {
        let pixel = camera.project(&Vector3::new(p.x, p.y, 1.0))?.map(f64::round);
        Some((pixel.x as usize, pixel.y as usize))
    };
    let effort = Effort::new(&|| false);
    let scene = candidate::Scene::new(&grid, noise, open, Some((&edges, &pixel_of)), pixel, &effort);
    for pipe in &pipes[1..] {
        // The upper limb of a pipe hides a part of the one before.
        let center = pipe.axis.point;
        let angle = center.y.atan2(center.z) - (pipe.radius / center.norm()).asin();
        let (limb, along) = (Vector2::new(0.0, angle.tan()), Vector2::new(0.2, 0.0));
        let hides = |outward: Vector2<f64>| scene.hides([limb, along, outward], 0.08, pipe.radius);
        assert!(hides(Vector2::y()) && !hides(-Vector2::y()), "{pipe:?}");
    }
}

#[test]
fn nothing_is_found_where_there_is_no_cylinder() {
    let edge = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
    let block = Body::Block(
        edge(0.0, 0.1, 0.75),
        [edge(0.05, 0.0, 0.0), edge(0.0, 0.04, 0.03), edge(0.0, -0.03, 0.04)],
    );
    let turned = Body::Block(
        edge(0.0, 0.1, 0.75),
        [edge(0.035, -0.021, 0.028), edge(0.0, 0.056, 0.042), edge(-0.035, -0.021, 0.028)],
    );
    let sphere = || Body::Sphere(edge(0.0, 0.1, 0.75), 0.07);
    let cup = Body::Frustum(can(0.0, 0.12, 0.72, UP, 0.04), 0.3, 0.07);
    for (name, body) in [("block", block), ("turned block", turned), ("sphere", sphere()), ("cup", cup)] {
        let found = search_for(&[table(), body]);
        assert!(found.cylinders.is_empty(), "{name}: {:?}", found.cylinders);
        assert!(found.labels.iter().all(|&label| label == 0));
    }
    assert!(search_for(&[]).cylinders.is_empty());
    assert!(search_for(&[table()]).cylinders.is_empty());
    let mut random = Random(3);
    let noise: Vec<f32> = (0..SIZE.0 * SIZE.1).map(|_| random.uniform() as f32 + 0.5).collect();
    let noise = DepthImage::copy(&DepthView::from_f32(&noise, SIZE, 1.0).unwrap()).unwrap();
    let found = detect(&camera(), &noise, None, &DetectionOptions::default()).unwrap();
    assert!(found.cylinders.is_empty(), "{:?}", found.cylinders);
}

#[test]
fn the_answer_has_the_same_bits_again_and_goes_with_the_unit() {
    let truth = can(0.0, 0.1, 0.7, UP, 0.04);
    let bodies = [table(), Body::Can(truth, 0.08)];
    let once = search_for(&bodies);
    let again = search_for(&bodies);
    assert_eq!(once.cylinders, again.cylinders);
    assert_eq!(once.labels, again.labels);
    let depth = render(&bodies, 1000.0);
    let millimetres = detect(&camera(), &depth, None, &DetectionOptions::default()).unwrap();
    assert_eq!(millimetres.cylinders.len(), 1);
    let ratio = millimetres.cylinders[0].cylinder.radius / once.cylinders[0].cylinder.radius;
    assert!((ratio / 1000.0 - 1.0).abs() < 1e-2, "{ratio}");
}

#[test]
fn options_limit_what_is_found() {
    let bodies = [
        table(),
        Body::Can(can(-0.12, 0.1, 0.7, UP, 0.04), 0.08),
        Body::Can(can(0.12, 0.1, 0.7, Vector3::x(), 0.025), 0.06),
    ];
    let depth = render(&bodies, 1.0);
    let count =
        |options: DetectionOptions| detect(&camera(), &depth, None, &options).unwrap().cylinders.len();
    let defaults = DetectionOptions::default();
    let limits = CylinderLimits::default();
    assert_eq!(count(defaults), 2);
    assert_eq!(count(DetectionOptions { max_count: 1, ..defaults }), 1);
    let wide = CylinderLimits { radius_min: 0.033, ..limits };
    assert_eq!(count(DetectionOptions { limits: wide, ..defaults }), 1);
    let cone = Some(crate::geometry::AxisCone { direction: UP, max_angle: 0.3 });
    assert_eq!(count(DetectionOptions { limits: CylinderLimits { axis: cone, ..limits }, ..defaults }), 1);
    assert_eq!(count(DetectionOptions { min_pixels: 100_000, ..defaults }), 0);
    for min_score in [-0.1, 1.1, f64::NAN] {
        let error = detect(&camera(), &depth, None, &DetectionOptions { min_score, ..defaults }).unwrap_err();
        assert!(error.to_string().contains("options.min_score"), "{error}");
    }
}

#[test]
fn clouds_are_searched_like_images() {
    let truth = can(0.0, 0.1, 0.7, UP, 0.04);
    let depth = render(&[table(), Body::Can(truth, 0.08)], 1.0);
    let camera = camera();
    let mut points = Vec::new();
    for k in 0..SIZE.0 * SIZE.1 {
        let (column, row) = (k % SIZE.0, k / SIZE.0);
        let ray = camera.unproject(&Vector2::new(column as f64, row as f64)).unwrap();
        points.push(depth.depth(column, row).map_or([f64::NAN; 3], |z| (ray * z).into()));
    }
    let detect = |points: &[[f64; 3]]| {
        let (view, options) = (PointsView::from_f64(points), DetectionOptions::default());
        detect_points_until(&view, &mut Looks::default(), &options, &|| false).unwrap()
    };
    let found = detect(&points).unwrap();
    assert_eq!(found.cylinders.len(), 1, "{:?}", found.cylinders);
    assert!(matches(&found.cylinders[0].cylinder, &truth), "{:?}", found.cylinders);
    assert_eq!(found.labels.len(), points.len());
    assert_eq!(found.labels.iter().filter(|&&label| label == 1).count(), found.cylinders[0].pixels);
    for bad in [&[][..], &[[f64::NAN; 3]; 100], &[[1.0, 2.0, 3.0]; 100], &[[1e300, -1e300, 1e-300]; 60]] {
        assert!(detect(bad).is_none_or(|found| found.cylinders.is_empty() && found.labels.is_empty()));
    }
}
