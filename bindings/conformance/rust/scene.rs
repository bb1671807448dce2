//! The data of the golden cases: one cylinder before a wall, seen by a small camera, with noise.

use super::pair;
use super::run::base64;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Map, Value, json};

pub const WIDTH: usize = 100;
pub const HEIGHT: usize = 75;
const FOCAL: [f64; 2] = [125.0, 126.0];
const CENTRE: [f64; 2] = [48.0, 38.5];
pub const RADIUS: f64 = 0.04;
const HALF_LENGTH: f64 = 0.08;

/// The value of the cylinder in the masks.
const LABEL: u8 = 255;

const SECOND_POSITION: [f64; 3] = [-0.13, 0.0, 0.02];
const DEPTH_POSITION: [f64; 3] = [0.03, 0.0, -0.01];

/// Rays by which a pixel of the image is averaged, in each direction.
const RAYS: usize = 8;

fn middle() -> Vector3<f64> {
    Vector3::new(0.01, -0.005, 0.5)
}

/// Of length 1 in decimal digits.
fn direction() -> Vector3<f64> {
    Vector3::new(0.8, 0.36, 0.48)
}

/// The true cylinder.
pub fn truth() -> Value {
    json!({"point": middle().as_slice(), "direction": direction().as_slice(), "radius": RADIUS})
}

/// The unit vector from the axis to the camera and the one to its side.
fn across() -> (Vector3<f64>, Vector3<f64>) {
    let toward = -(middle() - direction() * middle().dot(&direction())).normalize();
    (toward, direction().cross(&toward))
}

/// A pinhole somewhere in the scene.
struct Viewpoint {
    size: [usize; 2],
    focal: [f64; 2],
    centre: [f64; 2],
    /// To the frame of the first camera, which is the reference.
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
}

impl Viewpoint {
    /// The camera of most cases.
    fn first() -> Self {
        let (size, rotation) = ([WIDTH, HEIGHT], Matrix3::identity());
        Self { size, focal: FOCAL, centre: CENTRE, rotation, position: Vector3::zeros() }
    }

    /// The same camera elsewhere, as `second_pose` says.
    fn second() -> Self {
        Self { rotation: about_y(0.28, 0.96), position: SECOND_POSITION.into(), ..Self::first() }
    }

    /// A depth camera beside the first one, as `depth_pose` says.
    fn depth() -> Self {
        Self {
            size: [60, 45],
            focal: [76.0, 75.0],
            centre: [30.0, 21.5],
            rotation: about_y(0.04, 0.9992),
            position: DEPTH_POSITION.into(),
        }
    }

    /// The depth at which the ray of a pixel meets the near wall between the ends.
    fn near_wall(&self, column: f64, row: f64) -> Option<f64> {
        let [cx, cy] = self.centre;
        let ray = Vector3::new((column - cx) / self.focal[0], (row - cy) / self.focal[1], 1.0);
        let (ray, middle) = (self.rotation * ray, middle() - self.position);
        let off = |v: &Vector3<f64>| v - direction() * v.dot(&direction());
        let (k, w) = (off(&ray), off(&middle));
        // |t k - w| = r
        let (a, b, c) = (k.dot(&k), k.dot(&w), w.dot(&w) - RADIUS * RADIUS);
        let root = (b * b - a * c).max(0.0).sqrt();
        let t = (b - root) / a;
        let along = (ray * t - middle).dot(&direction());
        (b * b >= a * c && along.abs() <= HALF_LENGTH).then_some(t)
    }

    fn shape(&self) -> [usize; 2] {
        [self.size[1], self.size[0]]
    }

    fn pixels(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let [width, height] = self.size;
        (0..width * height).map(move |k| ((k % width) as f64, (k / width) as f64))
    }

    /// With noise, and here and there nothing is measured.
    fn measured(&self, seed: u64) -> Vec<f64> {
        let mut noise = Noise(seed);
        let depth = self.pixels().enumerate().map(|(k, (column, row))| {
            let z = self.near_wall(column, row).unwrap_or(0.9) + 5e-4 * noise.normal();
            if k % 37 == 0 { 0.0 } else { z }
        });
        depth.collect()
    }

    fn mask(&self) -> Vec<f64> {
        let value =
            |(column, row)| if self.near_wall(column, row).is_some() { f64::from(LABEL) } else { 0.0 };
        self.pixels().map(value).collect()
    }

    /// The part of each pixel that shows the surface.
    fn parts(&self) -> Vec<f64> {
        let offset = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
        let part = |(column, row): (f64, f64)| {
            let meets =
                |k: usize| self.near_wall(column + offset(k % RAYS), row + offset(k / RAYS)).is_some();
            (0..RAYS * RAYS).filter(|&k| meets(k)).count() as f64 / (RAYS * RAYS) as f64
        };
        self.pixels().map(part).collect()
    }

    /// The grey image, with noise.
    fn image(&self, seed: u64) -> Vec<f64> {
        let mut noise = Noise(seed);
        self.parts().iter().map(|part| 40.0 + 160.0 * part + 2.0 * noise.normal()).collect()
    }
}

/// A turn about y by the sine and the cosine of an angle.
fn about_y(sine: f64, cosine: f64) -> Matrix3<f64> {
    Matrix3::new(cosine, 0.0, sine, 0.0, 1.0, 0.0, -sine, 0.0, cosine)
}

fn pose(viewpoint: &Viewpoint) -> Value {
    json!({
        "rotation": viewpoint.rotation.transpose().as_slice(), "translation": viewpoint.position.as_slice(),
    })
}

/// The pose of the second view.
pub fn second_pose() -> Value {
    pose(&Viewpoint::second())
}

/// The motion from the depth camera to the first one. The rotation is rounded.
pub fn depth_pose() -> Value {
    pose(&Viewpoint::depth())
}

/// Noise of unit variance, the same at every run.
pub struct Noise(pub u64);

impl Noise {
    /// SplitMix64.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The sum of twelve uniform numbers is normal enough.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn array(element: &str, shape: &[usize], bytes: &[u8]) -> Value {
    json!({"type": element, "shape": shape, "data": base64::encode(bytes)})
}

fn f64_array(shape: &[usize], values: impl IntoIterator<Item = f64>) -> Value {
    array("f64", shape, &values.into_iter().flat_map(f64::to_le_bytes).collect::<Vec<_>>())
}

fn f32_array(shape: &[usize], values: impl IntoIterator<Item = f64>) -> Value {
    array("f32", shape, &values.into_iter().flat_map(|x| (x as f32).to_le_bytes()).collect::<Vec<_>>())
}

fn u16_array(shape: &[usize], values: impl IntoIterator<Item = f64>) -> Value {
    array(
        "u16",
        shape,
        &values.into_iter().flat_map(|x| (x.round() as u16).to_le_bytes()).collect::<Vec<_>>(),
    )
}

fn u8_array(shape: &[usize], values: impl IntoIterator<Item = f64>) -> Value {
    array("u8", shape, &values.into_iter().map(|x| x.round() as u8).collect::<Vec<_>>())
}

/// A point of the near wall and the normal there; both arguments from -1 to 1.
fn wall(around: f64, along: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (toward, sideways) = across();
    let normal = toward * around.cos() + sideways * around.sin();
    (middle() + direction() * (along * HALF_LENGTH) + normal * RADIUS, normal)
}

/// Points that cover the near wall evenly and without order, with noise along the normals.
fn cloud(count: usize, seed: u64) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut noise = Noise(seed);
    let place = |k: usize| {
        // Two irrational steps.
        let (a, b) = ((k as f64 * 0.618_033_988_75).fract(), (k as f64 * 0.414_213_562_37).fract());
        wall(2.0 * a - 1.0, 2.0 * b - 1.0)
    };
    (0..count).map(place).map(|(p, normal)| (p + normal * (2e-4 * noise.normal()), normal)).collect()
}

fn clouds(arrays: &mut Map<String, Value>) {
    let points = cloud(100, 1);
    let flat = |points: &[(Vector3<f64>, Vector3<f64>)]| {
        points.iter().flat_map(|(p, _)| [p.x, p.y, p.z]).collect::<Vec<_>>()
    };
    arrays.insert("cloud_f64".into(), f64_array(&[100, 3], flat(&points)));
    arrays.insert("cloud_f32".into(), f32_array(&[100, 3], flat(&points)));
    let weights = (0..100).map(|k| f64::from(k % 5) * 0.5);
    arrays.insert("weights_f64".into(), f64_array(&[100, 1], weights));
    // Like a structure of x y z, weight, normal, padding; the normals are the directions of the radii.
    let rows = points
        .iter()
        .enumerate()
        .flat_map(|(k, (p, n))| [p.x, p.y, p.z, 1.0 + (k % 3) as f64, n.x, n.y, n.z, -1.0]);
    arrays.insert("records_f32".into(), f32_array(&[100, 8], rows));
    let organised = (0..8 * 12).flat_map(|k| {
        let (row, column) = (k / 12, k % 12);
        let (p, _) = wall(f64::from(row) / 4.0 - 0.9, f64::from(column) / 6.0 - 0.9);
        let z = if k % 17 == 3 { f64::NAN } else { p.z };
        [p.x, p.y, z, 1.0]
    });
    arrays.insert("organised_f32".into(), f32_array(&[8, 12, 4], organised));
    let mask = (0..8 * 12).map(|k| f64::from(u8::from(k % 12 != 0)));
    arrays.insert("organised_mask".into(), u8_array(&[8, 12], mask));
    let grid = |k: i32| [f64::from(k % 8) * 0.01, f64::from(k / 8) * 0.01];
    arrays.insert("plane".into(), f64_array(&[40, 3], (0..40).flat_map(|k| [grid(k)[0], grid(k)[1], 0.5])));
    arrays.insert("line".into(), f64_array(&[40, 3], (0..40).flat_map(|k| [f64::from(k) * 0.01, 0.0, 0.5])));
    arrays.insert("few".into(), f64_array(&[4, 3], flat(&points[..4])));
    arrays.insert("not_finite".into(), f64_array(&[6, 3], [f64::NAN; 18]));
    arrays.insert("none".into(), f64_array(&[0, 3], []));
    // In the image, beyond its border, far beyond, behind the camera, not finite.
    let beside =
        [[0.1, -0.05, 0.5], [0.3, 0.2, 0.4], [9.0, 0.0, 0.1], [0.1, 0.1, -0.5], [f64::NAN, 0.0, 1.0]];
    arrays.insert("beside_f64".into(), f64_array(&[5, 3], beside.concat()));
    let negative = (0..100).map(|k| if k == 7 { -1.0 } else { 1.0 });
    arrays.insert("negative_weight".into(), f64_array(&[100, 1], negative));
}

fn images(arrays: &mut Map<String, Value>) {
    let (first, second, apart) = (Viewpoint::first(), Viewpoint::second(), Viewpoint::depth());
    let shape = first.shape();
    let stored = |depth: &[f64]| depth.iter().map(|z| z * 1e4).collect::<Vec<_>>();
    let depth = first.measured(2);
    arrays.insert("depth_u16".into(), u16_array(&shape, stored(&depth)));
    arrays.insert("depth_f32".into(), f32_array(&shape, depth));
    arrays.insert("mask".into(), u8_array(&shape, first.mask()));
    let image = first.image(3);
    arrays.insert("image_u8".into(), u8_array(&shape, image.iter().copied()));
    arrays.insert("image_u16".into(), u16_array(&shape, image.iter().map(|x| x * 250.0)));
    arrays.insert("image_f32".into(), f32_array(&shape, image));
    arrays.insert("second_depth".into(), u16_array(&shape, stored(&second.measured(4))));
    arrays.insert("second_mask".into(), u8_array(&shape, second.mask()));
    arrays.insert("second_image".into(), u8_array(&shape, second.image(5)));
    arrays.insert("own_depth".into(), u16_array(&apart.shape(), stored(&apart.measured(6))));
    // A red cylinder on blue, of about the same red and green: grey by the wrong weights it is another image.
    let mut noise = Noise(7);
    let colors = first.parts().into_iter().flat_map(|part| {
        [60.0 + 150.0 * part, 80.0 + 20.0 * part, 150.0 - 110.0 * part]
            .map(|value| value + 2.0 * noise.normal())
    });
    let colors: Vec<f64> = colors.collect();
    let with_alpha = colors.chunks(3).enumerate().flat_map(|(k, c)| [c[2], c[1], c[0], (k % 256) as f64]);
    arrays.insert("image_bgra".into(), u8_array(&[HEIGHT, WIDTH, 4], with_alpha));
    arrays.insert("image_rgb".into(), u8_array(&[HEIGHT, WIDTH, 3], colors));
    arrays.insert("empty_mask".into(), u8_array(&shape, [0.0; WIDTH * HEIGHT]));
    arrays.insert("no_depth".into(), u16_array(&[12, 16], [0.0; 192]));
    arrays
        .insert("small_mask".into(), u8_array(&[12, 16], (0..192).map(|k| f64::from(u8::from(k % 16 > 1)))));
    arrays.insert(
        "small_image_not_finite".into(),
        f32_array(&[12, 16], (0..192).map(|k| if k == 20 { f64::INFINITY } else { 1.0 })),
    );
}

fn pairs(arrays: &mut Map<String, Value>) {
    let [width, height] = pair::SIZE;
    let shape = [height, width];
    arrays.insert("pair_depth".into(), u16_array(&shape, pair::depth().iter().map(|z| z * 1e4)));
    arrays.insert("pair_image".into(), u8_array(&shape, pair::image()));
    arrays.insert("pair_cloud".into(), f32_array(&[height / 2, width / 2, 3], pair::cloud()));
}

/// All arrays by their names.
pub fn arrays() -> Map<String, Value> {
    let mut arrays = Map::new();
    clouds(&mut arrays);
    images(&mut arrays);
    pairs(&mut arrays);
    arrays
}

fn camera(model: &str, distortion: [f64; 8]) -> Value {
    let [fx, fy] = FOCAL;
    let [cx, cy] = CENTRE;
    json!({
        "width": WIDTH, "height": HEIGHT, "fx": fx, "fy": fy, "cx": cx, "cy": cy,
        "distortion_model": model, "distortion": distortion,
    })
}

/// All cameras by their names.
pub fn cameras() -> Value {
    let apart = Viewpoint::depth();
    let mut nan = camera("NONE", [0.0; 8]);
    nan["fx"] = Value::Null;
    let mut negative = camera("NONE", [0.0; 8]);
    negative["fy"] = json!(-126.0);
    json!({
        "pinhole": camera("NONE", [0.0; 8]),
        "brown_conrady": camera("BROWN_CONRADY", [0.02, -0.01, 0.001, -0.0005, 0.002, 0.0, 0.0, 0.0]),
        "kannala_brandt": camera("KANNALA_BRANDT", [0.01, -0.002, 0.001, -0.0005, 0.0, 0.0, 0.0, 0.0]),
        "own_depth": {
            "width": apart.size[0], "height": apart.size[1], "fx": apart.focal[0], "fy": apart.focal[1],
            "cx": apart.centre[0], "cy": apart.centre[1], "distortion_model": "NONE", "distortion": vec![0.0; 8],
        },
        "pair": pair::camera(),
        "focal_length_nan": nan,
        "focal_length_negative": negative,
        "small": {
            "width": 16, "height": 12, "fx": 20.0, "fy": 20.0, "cx": 7.5, "cy": 5.5,
            "distortion_model": "NONE", "distortion": vec![0.0; 8],
        },
    })
}

/// Pieces of both limbs in the pixels of the pinhole, rounded as a detector may give them: to 1/16.
pub fn edges() -> Vec<[f64; 4]> {
    let (toward, sideways) = across();
    let distance = middle().dot(&toward).abs();
    let sine = RADIUS / distance;
    let cosine = (1.0 - sine * sine).sqrt();
    let along = middle().dot(&direction());
    [1.0, -1.0]
        .iter()
        .map(|side| {
            let limb = -toward * (distance * cosine * cosine) + sideways * (side * distance * cosine * sine);
            let pixel = |s: f64| {
                let p = limb + direction() * (along + s * HALF_LENGTH);
                [FOCAL[0] * p.x / p.z + CENTRE[0], FOCAL[1] * p.y / p.z + CENTRE[1]]
                    .map(|x| (x * 16.0).round() / 16.0)
            };
            let ([x1, y1], [x2, y2]) = (pixel(-0.8), pixel(0.8));
            [x1, y1, x2, y2]
        })
        .collect()
}
