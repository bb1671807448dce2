//! A frame of a scene: image, depth, labels and truth.

use super::annotation::end_seen;
use super::picture::{PictureOptions, picture};
use super::scene::{Scene, TrueCylinder, Viewpoint};
use super::sensors::DepthSensor;
use super::shape::Part;
use crate::camera::Camera;
use crate::error::Result;
use crate::observations::{DepthCamera, DepthRange, DepthView, Frame, LARGEST_STORED_DEPTH};
use nalgebra::{Vector2, Vector3};

/// Metres per unit of a depth image.
pub const DEPTH_UNIT: f64 = 1e-4;

/// The fewest pixels of a cylinder that counts, on its body and with depth.
const COUNTABLE_PIXELS: [usize; 2] = [900, 540];

/// The least part of its length and of its width that is seen of one that counts, the width in radii.
const COUNTABLE_SEEN: [f64; 2] = [0.4, 1.9];

/// How a frame is taken.
#[derive(Debug, Clone)]
pub struct CaptureOptions {
    /// The colour camera, in the origin.
    pub camera: Camera,
    /// Its image.
    pub picture: PictureOptions,
    /// The depth sensor beside it.
    pub sensor: DepthSensor,
    /// Whether the depth is carried to the grid of the image.
    pub registered: bool,
}

/// A frame. Images are row by row.
#[derive(Debug, Clone)]
pub struct Capture {
    /// The grey image.
    pub image: Vec<u8>,
    /// The depth in units of [`DEPTH_UNIT`], 0 where none was measured.
    pub depth: Vec<u16>,
    /// The camera of the depth where it is not on the grid of the image.
    pub depth_camera: Option<DepthCamera>,
    /// The object of each pixel of the image.
    pub labels: Vec<u16>,
    /// Whether a pixel of the image is on the lateral surface of a cylinder that is to be found.
    pub body: Vec<bool>,
    /// The cylinders that are to be found.
    pub cylinders: Vec<SeenCylinder>,
}

/// A true cylinder, and what is seen of it.
#[derive(Debug, Clone, Copy)]
pub struct SeenCylinder {
    /// The cylinder.
    pub truth: TrueCylinder,
    /// Pixels on its lateral surface.
    pub body_pixels: usize,
    /// Those of them with depth.
    pub measured_pixels: usize,
    /// From where to where it is seen along the axis, from its middle on.
    pub visible_along: [f64; 2],
    /// From where to where it is seen across the line of sight, in radii from the axis.
    pub visible_across: [f64; 2],
    /// Whether each end is in the image with nothing in front of it, that against the direction of the axis first.
    pub ends_seen: [bool; 2],
    /// Whether so much of it is seen that it has to be found.
    pub countable: bool,
}

/// Takes a frame of a scene. The same seed gives the same bits.
///
/// # Errors
/// `OutOfMemory`.
pub fn capture(scene: &Scene, options: &CaptureOptions, seed: u64) -> Result<Capture> {
    let own = options.sensor.camera()?;
    let measuring = own.clone().unwrap_or_else(|| DepthCamera {
        camera: options.camera.clone(),
        to_color: crate::geometry::RigidMotion::identity(),
    });
    let measured = stored(options.sensor.measure(scene, &measuring, seed));
    let on_image = match &own {
        None => measured.clone(),
        Some(own) => registered(&measured, own, &options.camera)?,
    };
    let Seen { labels, body, cylinders } = look(scene, &options.camera, &on_image);
    let image = picture(scene, &options.camera, &options.picture, seed);
    let (depth, depth_camera) = if options.registered { (on_image, None) } else { (measured, own) };
    Ok(Capture { image, depth, depth_camera, labels, body, cylinders })
}

/// Metres in whole units; 0 beyond 16 bits.
fn stored(depth: Vec<f32>) -> Vec<u16> {
    let unit = |z: f32| libm::round(f64::from(z) / DEPTH_UNIT);
    depth
        .into_iter()
        .map(unit)
        .map(|z| if z > 0.0 && z <= f64::from(LARGEST_STORED_DEPTH) { z as u16 } else { 0 })
        .collect()
}

/// The depth on the grid of the image.
fn registered(depth: &[u16], own: &DepthCamera, camera: &Camera) -> Result<Vec<u16>> {
    let mut frame = Frame::new(camera.clone());
    frame.set_depth_camera(Some(own.clone()))?;
    let view = DepthView::from_u16(depth, own.camera.size(), DEPTH_UNIT)?;
    frame.set_depth(&view, &DepthRange::default())?;
    let (width, height) = camera.size();
    let at = |k: usize| frame.depth_on_image()?.depth(k % width, k / width);
    Ok(stored((0..width * height).map(|k| at(k).unwrap_or(0.0) as f32).collect()))
}

/// What the colour camera sees at the centres of its pixels.
struct Seen {
    labels: Vec<u16>,
    body: Vec<bool>,
    cylinders: Vec<SeenCylinder>,
}

fn look(scene: &Scene, camera: &Camera, depth: &[u16]) -> Seen {
    let (width, height) = camera.size();
    let eye = Viewpoint::new(scene, Vector3::zeros());
    let nothing = |truth: &TrueCylinder| SeenCylinder {
        truth: *truth,
        body_pixels: 0,
        measured_pixels: 0,
        visible_along: [f64::INFINITY, f64::NEG_INFINITY],
        visible_across: [f64::INFINITY, f64::NEG_INFINITY],
        ends_seen: [-1.0, 1.0].map(|side| end_seen(truth, camera, side, |point| eye.sees(point))),
        countable: false,
    };
    let mut cylinders: Vec<SeenCylinder> = scene.cylinders.iter().map(nothing).collect();
    let (mut labels, mut body) = (vec![0; width * height], vec![false; width * height]);
    for k in 0..width * height {
        let pixel = Vector2::new((k % width) as f64, (k / width) as f64);
        let Some(ray) = camera.unproject(&pixel) else { continue };
        let Some(hit) = eye.look(&ray) else { continue };
        let met = &scene.bodies[hit.body];
        labels[k] = met.object;
        if !met.measured || hit.part == Part::Cap {
            continue;
        }
        body[k] = true;
        let Some(seen) = cylinders.iter_mut().find(|seen| seen.truth.object == met.object) else { continue };
        seen.add(&(ray * hit.t), depth[k] > 0);
    }
    cylinders.iter_mut().for_each(SeenCylinder::judge);
    Seen { labels, body, cylinders }
}

impl SeenCylinder {
    fn add(&mut self, point: &Vector3<f64>, measured: bool) {
        self.body_pixels += 1;
        self.measured_pixels += usize::from(measured);
        let axis = &self.truth.cylinder.axis;
        let from_middle = point - self.truth.center;
        let aside = axis.direction.cross(&axis.nearest_to_origin()).normalize();
        let widen = |range: &mut [f64; 2], value: f64| *range = [range[0].min(value), range[1].max(value)];
        widen(&mut self.visible_along, from_middle.dot(&axis.direction));
        widen(&mut self.visible_across, from_middle.dot(&aside) / self.truth.cylinder.radius);
    }

    fn judge(&mut self) {
        if self.body_pixels == 0 {
            (self.visible_along, self.visible_across) = ([0.0; 2], [0.0; 2]);
        }
        let span = |range: [f64; 2]| range[1] - range[0];
        self.countable = self.body_pixels >= COUNTABLE_PIXELS[0]
            && self.measured_pixels >= COUNTABLE_PIXELS[1]
            && span(self.visible_along) >= 1.6 * self.truth.cylinder.radius
            && (span(self.visible_along) >= COUNTABLE_SEEN[0] * self.truth.length || self.is_cut())
            && span(self.visible_across) >= COUNTABLE_SEEN[1];
    }

    /// Whether it goes on beyond what is seen: a long pipe cut by the border counts by what is in the image.
    fn is_cut(&self) -> bool {
        self.visible_along[1] - self.visible_along[0] > 6.0 * self.truth.cylinder.radius
    }
}
