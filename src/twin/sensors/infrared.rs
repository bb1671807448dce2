//! What an infrared camera sees of a scene under a projector of dots.

use crate::camera::Camera;
use crate::observations::DepthCamera;
use crate::twin::random::{Purpose, Stream};
use crate::twin::sampling::{Key, Sample, mean_over_pixels};
use crate::twin::scene::{Scene, Viewpoint};
use nalgebra::{Vector2, Vector3};

/// Positions of the pattern in a pixel, along rows and along columns.
const FINENESS: f64 = 2.0;

/// The brightest tenth of the pixels has at least this value: what an automatic exposure sees to.
const BRIGHT: f64 = 170.0;

/// Random dots, on the image plane of a projector with the intrinsics of the infrared camera.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Pixels that it goes on beyond the left border.
    margin: usize,
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

impl Pattern {
    /// One dot for each square of `spacing` pixels, a Gaussian of a standard deviation of `dot` pixels.
    pub fn new((width, height): (usize, usize), margin: usize, spacing: f64, dot: f64, seed: u64) -> Self {
        let columns = ((width + margin) as f64 * FINENESS) as usize;
        let rows = (height as f64 * FINENESS) as usize;
        let mut values = vec![0.0_f32; columns * rows];
        let mut stream = Stream::new(seed, Purpose::Pattern);
        let (cell, sigma) = (spacing * FINENESS, dot * FINENESS);
        let reach = 3.5 * sigma;
        let cells = |count: usize| (count as f64 / cell) as usize + 1;
        for _ in 0..cells(rows) * cells(columns) {
            // Anywhere, so that nothing repeats.
            let (x, y) = (stream.between(0.0, columns as f64), stream.between(0.0, rows as f64));
            let peak = stream.between(0.5, 1.0);
            let range = |at: f64, end: usize| {
                libm::ceil(at - reach).max(0.0) as usize
                    ..(libm::floor(at + reach).max(0.0) as usize + 1).min(end)
            };
            for row in range(y, rows) {
                for column in range(x, columns) {
                    let (dx, dy) = (column as f64 - x, row as f64 - y);
                    let light = peak * libm::exp(-0.5 * (dx * dx + dy * dy) / (sigma * sigma));
                    values[row * columns + column] += light as f32;
                }
            }
        }
        Self { margin, columns, rows, values }
    }

    /// The light at a position in pixels, 0 beyond the pattern.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (x, y) = ((x + self.margin as f64) * FINENESS, y * FINENESS);
        let (left, top) = (libm::floor(x), libm::floor(y));
        if !(left >= 0.0 && top >= 0.0 && left + 1.0 < self.columns as f64 && top + 1.0 < self.rows as f64) {
            return 0.0;
        }
        let (u, v) = (x - left, y - top);
        let k = top as usize * self.columns + left as usize;
        let row = |k: usize| f64::from(self.values[k]) * (1.0 - u) + f64::from(self.values[k + 1]) * u;
        row(k) * (1.0 - v) + row(k + self.columns) * v
    }

    /// What a camera at the projector would see of it, margin included, 255 at the peak of a dot.
    pub fn reference(&self, (width, height): (usize, usize)) -> Vec<u8> {
        let long = width + self.margin;
        let value = |k: usize| self.at((k % long) as f64 - self.margin as f64, (k / long) as f64);
        (0..long * height).map(|k| libm::round(255.0 * value(k)).min(255.0) as u8).collect()
    }
}

/// The infrared side of a depth sensor: a camera and a projector, rectified to each other.
#[derive(Debug)]
pub struct Infrared<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its pattern.
    pub pattern: &'a Pattern,
    /// The camera of the depth image.
    pub own: &'a DepthCamera,
    /// How far to the right of it the eye is.
    pub eye: f64,
    /// How far to the right of it the projector is.
    pub projector: f64,
    /// Light from elsewhere, as a share of the light of a dot at 1 m.
    pub ambient: f64,
    /// Electrons of a pixel at full scale.
    pub full_well: f64,
    /// Noise of reading a pixel out, in electrons.
    pub read_noise: f64,
    /// Contrast of the laser's own speckle on a pixel (Goodman, Speckle Phenomena in Optics, 2007).
    pub speckle: f64,
}

impl Infrared<'_> {
    /// The image, row by row.
    pub fn image(&self, noise: &mut Stream) -> Vec<u8> {
        let camera = &self.own.camera;
        let aside = |shift: f64| self.own.to_color.point(&Vector3::new(shift, 0.0, 0.0));
        let eye = Viewpoint::new(self.scene, aside(self.eye));
        let projector = Viewpoint::new(self.scene, aside(self.projector));
        let back = self.own.to_color.rotation().transpose();
        let look = |x: f64, y: f64| {
            let nothing = Sample { key: Key::default(), values: [0.0] };
            let Some(ray) = camera.unproject(&Vector2::new(x, y)) else { return nothing };
            let ray = self.own.to_color.direction(&ray);
            let Some(hit) = eye.look(&ray) else { return nothing };
            let mut patch = eye.patch(&ray, &hit);
            // Most inks are clearer in the near infrared.
            patch.albedo = 0.25 + 0.65 * patch.albedo;
            let mut light = self.ambient * patch.albedo;
            let ray_of_projector = patch.point - projector.origin();
            let lit = patch.normal.dot(&ray_of_projector) < 0.0 && projector.sees(&patch.point);
            if lit {
                let dots = self.dots(camera, &(back * ray_of_projector));
                let spread = ray_of_projector.norm_squared();
                light += dots * patch.reflect(projector.origin(), eye.origin()) / spread;
            }
            let key = Key { surface: Some((hit.body, hit.part)), lit, albedo: patch.albedo as f32 };
            Sample { key, values: [light] }
        };
        let image = mean_over_pixels(camera.size(), look);
        let mut values: Vec<f64> = image.iter().map(|light| light[0]).collect();
        let tenth = values.len() - 1 - values.len() / 10;
        let bright = *values.select_nth_unstable_by(tenth, f64::total_cmp).1;
        let gain = if bright > 0.0 { BRIGHT / bright } else { 0.0 };
        let electrons = self.full_well / 255.0;
        let value = |[light]: [f64; 1]| {
            let level = gain * light;
            let variance =
                level / electrons + (self.read_noise / electrons).powi(2) + (self.speckle * level).powi(2);
            libm::round(level + variance.sqrt() * noise.normal()).clamp(0.0, 255.0) as u8
        };
        image.into_iter().map(value).collect()
    }

    fn dots(&self, camera: &Camera, ray: &Vector3<f64>) -> f64 {
        camera.project(ray).map_or(0.0, |pixel| self.pattern.at(pixel.x, pixel.y))
    }
}
