//! The image of the colour camera, in grey.

use super::random::{Purpose, Stream};
use super::sampling::{Key, Sample, blur, mean_over_pixels};
use super::scene::{Scene, Viewpoint};
use crate::camera::Camera;
use crate::error::{Error, Result, not_negative};
use nalgebra::{Vector2, Vector3};

/// The image side of the colour camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureOptions {
    /// Standard deviation of the point spread function of lens and focus, in pixels.
    pub blur: f64,
    /// Electrons of a pixel at full scale: light of n electrons has the noise √n (EMVA standard 1288).
    pub full_well: f64,
    /// Noise of reading a pixel out, in electrons.
    pub read_noise: f64,
    /// The exposure: the brightest 3 % of the pixels have more than this share of full scale.
    pub exposure: f64,
    /// The value of a pixel is its light to the power of 1 / `gamma`.
    pub gamma: f64,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { blur: 0.7, full_well: 8000.0, read_noise: 12.0, exposure: 0.8, gamma: 1.0 }
    }
}

impl PictureOptions {
    /// Checks the values.
    ///
    /// # Errors
    /// `InvalidArgument`.
    pub fn check(&self) -> Result<()> {
        for (name, value) in [("blur", self.blur), ("read noise", self.read_noise)] {
            not_negative(name, value)?;
        }
        for (name, value) in [("full well", self.full_well), ("exposure", self.exposure)] {
            if !(value > 0.0) {
                return Err(Error::argument(name, value, "be greater than 0"));
            }
        }
        if !(0.1..=10.0).contains(&self.gamma) {
            return Err(Error::argument("gamma", self.gamma, "be from 0.1 to 10"));
        }
        Ok(())
    }

    /// A camera without blur and noise.
    #[must_use]
    pub fn ideal() -> Self {
        Self { blur: 0.0, full_well: f64::INFINITY, read_noise: 0.0, ..Self::default() }
    }
}

/// The image of a scene, row by row, 255 at full scale.
#[must_use]
pub fn picture(scene: &Scene, camera: &Camera, options: &PictureOptions, seed: u64) -> Vec<u8> {
    let eye = Viewpoint::new(scene, Vector3::zeros());
    let lamp = Viewpoint::new(scene, scene.lamp);
    let look = |x: f64, y: f64| {
        let nothing = Sample { key: Key::default(), values: [0.0] };
        let Some(ray) = camera.unproject(&Vector2::new(x, y)) else { return nothing };
        let Some(hit) = eye.look(&ray) else { return nothing };
        let patch = eye.patch(&ray, &hit);
        let lit = patch.normal.dot(&(scene.lamp - patch.point)) > 0.0 && lamp.sees(&patch.point);
        let direct = if lit { patch.reflect(&scene.lamp, eye.origin()) } else { 0.0 };
        let light = scene.ambient * patch.albedo + (1.0 - scene.ambient) * direct;
        let key = Key { surface: Some((hit.body, hit.part)), lit, albedo: patch.albedo as f32 };
        Sample { key, values: [light] }
    };
    let mut image = mean_over_pixels(camera.size(), look);
    blur(&mut image, camera.size(), options.blur);
    let gain = gain(&image, options.exposure);
    let mut stream = Stream::new(seed, Purpose::Image);
    let value = |[light]: [f64; 1]| {
        let light = (gain * light).max(0.0);
        let shot = light / options.full_well;
        let read = options.read_noise / options.full_well;
        let seen = light + (shot + read * read).sqrt() * stream.normal();
        let coded = if options.gamma == 1.0 { seen } else { libm::pow(seen.max(0.0), 1.0 / options.gamma) };
        libm::round(255.0 * coded).clamp(0.0, 255.0) as u8
    };
    image.into_iter().map(value).collect()
}

/// The factor of an automatic exposure.
fn gain(image: &[[f64; 1]], exposure: f64) -> f64 {
    let mut values: Vec<f64> = image.iter().map(|light| light[0]).collect();
    let index = values.len() - 1 - values.len() * 3 / 100;
    let bright = *values.select_nth_unstable_by(index, f64::total_cmp).1;
    if bright > 0.0 { exposure / bright } else { 1.0 }
}
