//! A frame with its truth, ready for any number of fits.

use crate::failure::Failure;
use crate::frame::Frame;
use crate::ground;
use cylfuse::camera::Camera;
use cylfuse::fitter::Fitter;
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{self, DepthRange, DepthView, EdgeSegment, ImageView, MaskView};
use cylfuse::twin::{
    self, Capture, CaptureOptions, DEPTH_UNIT, Purpose, Scene, SeenCylinder, Stream, capture,
};
use nalgebra::{Vector2, Vector3};
use serde::Deserialize;
use std::path::Path;

/// The part of a limb that must be seen for a person to set an edge there.
const SEEN_OF_EDGE: f64 = 1.0 / 3.0;

/// One cylinder in one or more views.
pub struct Sample {
    /// What it is called in lists.
    pub name: String,
    /// The views.
    pub views: Vec<View>,
    /// What is true.
    pub truth: Truth,
}

/// A view of it.
pub struct View {
    /// Camera, depth and image.
    pub frame: observations::Frame,
    /// The camera of the image.
    pub camera: Camera,
    /// Its pixels, 0 elsewhere; none where all depth counts.
    pub mask: Option<Vec<u8>>,
    /// Pieces of its limbs.
    pub edges: Vec<EdgeSegment>,
    /// The image in grey, for pictures.
    pub image: Vec<u8>,
}

/// The true cylinder; centre and length only where both ends are seen.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    /// Axis and radius.
    pub cylinder: Cylinder,
    /// Whether the radius was measured by other means.
    pub radius_known: bool,
    /// The middle of the axis.
    pub center: Option<Vector3<f64>>,
    /// The length.
    pub length: Option<f64>,
}

/// The files of a truth, of which kinds differ in what they say.
#[derive(Deserialize)]
struct TruthFile {
    center: [f64; 3],
    axis: [f64; 3],
    radius: f64,
    radius_in_sensor_scale: Option<f64>,
    radius_known_independently: Option<bool>,
    length: Option<f64>,
    ends_seen: Option<EndsSeen>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum EndsSeen {
    Both(bool),
    Each([bool; 2]),
}

impl Sample {
    /// A cylinder of a frame of the twin, with mask and edges as a person draws them.
    ///
    /// # Errors
    /// Those of the library for images of a wrong size.
    pub fn of_capture(
        name: String,
        taken: &Capture,
        options: &CaptureOptions,
        index: usize,
        annotation: u64,
    ) -> Result<Self, Failure> {
        let seen = &taken.cylinders[index];
        let size = options.camera.size();
        let body = own_body(taken, seen);
        let mask = twin::drawn_mask(&body, size, annotation);
        let mut frame = observations::Frame::new(options.camera.clone());
        frame.set_depth_camera(taken.depth_camera.clone())?;
        let depth_size = taken.depth_camera.as_ref().map_or(size, |own| own.camera.size());
        frame
            .set_depth(&DepthView::from_u16(&taken.depth, depth_size, DEPTH_UNIT)?, &DepthRange::default())?;
        frame.set_image(&ImageView::from_u8(&taken.image, size)?.with_gamma(options.picture.gamma)?)?;
        let limbs = twin::true_edges(&seen.truth, &options.camera);
        let limbs: Vec<_> = limbs.iter().flatten().copied().collect();
        let drawn = match <[_; 2]>::try_from(limbs) {
            Ok(limbs) => {
                let visible = limbs.map(|limb| is_seen(&limb, &body, size));
                // A hand sets both, so that one that is hidden moves no other.
                let set = twin::hand_set(&limbs, size, annotation);
                if set.len() == 2 {
                    set.into_iter().zip(visible).filter(|(_, seen)| *seen).map(|(edge, _)| edge).collect()
                } else {
                    set
                }
            }
            Err(_) => Vec::new(),
        };
        let edges = drawn.into_iter().map(|endpoints| EdgeSegment { endpoints, weight: 1.0 }).collect();
        let both = seen.ends_seen == [true; 2];
        Ok(Self {
            name,
            truth: Truth {
                cylinder: seen.truth.cylinder,
                radius_known: true,
                center: both.then_some(seen.truth.center),
                length: both.then_some(seen.truth.length),
            },
            views: vec![View {
                frame,
                camera: options.camera.clone(),
                mask: Some(mask),
                edges,
                image: taken.image.clone(),
            }],
        })
    }

    /// A frame of a scene with one cylinder.
    ///
    /// # Errors
    /// Those of [`capture`] and [`Sample::of_capture`].
    pub fn take(
        name: String,
        scene: &Scene,
        options: &CaptureOptions,
        [seed, annotation]: [u64; 2],
    ) -> Result<Self, Failure> {
        Self::of_capture(name, &capture(scene, options, seed)?, options, 0, annotation)
    }

    /// A frame file with the truth.json beside it.
    ///
    /// # Errors
    /// Those of reading them.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let truth_path = folder.join("truth.json");
        let text = std::fs::read(&truth_path).map_err(|error| Failure::not_readable(&truth_path, &error))?;
        let truth: TruthFile =
            serde_json::from_slice(&text).map_err(|error| Failure::bad_frame(&truth_path, error))?;
        let radius = truth.radius_in_sensor_scale.unwrap_or(truth.radius);
        let center = Vector3::from(truth.center);
        let cylinder = Cylinder::new(center, truth.axis.into(), radius);
        let both = match truth.ends_seen {
            None | Some(EndsSeen::Both(true) | EndsSeen::Each([true, true])) => true,
            Some(_) => false,
        };
        let views = Frame::read(path, true)?.views.into_iter().map(|view| {
            let image = view.image.as_ref().map(ground::grey).unwrap_or_default();
            Ok(View {
                frame: view.observed()?,
                camera: view.camera,
                mask: view.mask,
                edges: view.edges,
                image,
            })
        });
        Ok(Self {
            name: folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            views: views.collect::<Result<_, Failure>>()?,
            truth: Truth {
                cylinder: cylinder
                    .map_err(|error| Failure::from(error).in_frame(&truth_path, "radius and axis"))?,
                radius_known: truth.radius_known_independently.unwrap_or(true),
                center: both.then_some(center),
                length: truth.length.filter(|_| both),
            },
        })
    }

    /// A fitter with all views, with the edges of the first view replaced where others are given.
    ///
    /// # Errors
    /// Those of the library.
    pub fn fitter(&self, edges: Option<&[EdgeSegment]>) -> cylfuse::error::Result<Fitter> {
        let mut fitter = Fitter::new();
        for (index, view) in self.views.iter().enumerate() {
            fitter.select_view(index)?;
            let mask = view.mask.as_deref().map(|mask| MaskView::from_u8(mask, view.camera.size()));
            fitter.use_frame(&view.frame, mask.transpose()?.as_ref())?;
            let own = edges.filter(|_| index == 0).unwrap_or(&view.edges);
            if !own.is_empty() {
                fitter.push_edges(own)?;
            }
        }
        fitter.select_view(0)?;
        Ok(fitter)
    }

    /// The edges of the first view with normal noise on both coordinates of every endpoint, in pixels.
    pub fn disturbed_edges(&self, deviation: f64, seed: u64) -> Vec<EdgeSegment> {
        let mut stream = Stream::new(seed, Purpose::Trial);
        let mut edges = self.views[0].edges.clone();
        for end in edges.iter_mut().flat_map(|edge| &mut edge.endpoints) {
            *end += Vector2::new(stream.normal(), stream.normal()) * deviation;
        }
        edges
    }
}

/// The pixels on the lateral surface of a cylinder.
fn own_body(taken: &Capture, seen: &SeenCylinder) -> Vec<bool> {
    let own = |(label, body): (&u16, &bool)| *body && *label == seen.truth.object;
    taken.labels.iter().zip(&taken.body).map(own).collect()
}

/// Whether enough of a limb lies along pixels of the body.
fn is_seen(limb: &[Vector2<f64>; 2], body: &[bool], (width, height): (usize, usize)) -> bool {
    const SAMPLES: usize = 50;
    let near = |sample: &usize| {
        let at = limb[0].lerp(&limb[1], (*sample as f64 + 0.5) / SAMPLES as f64);
        let (x, y) = (at.x.round() as i64, at.y.round() as i64);
        (-2..=2).any(|dy| {
            (-2..=2).any(|dx| {
                let (x, y) = (x + dx, y + dy);
                let inside = x >= 0 && y >= 0 && x < width as i64 && y < height as i64;
                inside && body[y as usize * width + x as usize]
            })
        })
    };
    // What the border of the image cuts off counts for neither.
    let inside = |sample: &usize| {
        let at = limb[0].lerp(&limb[1], (*sample as f64 + 0.5) / SAMPLES as f64);
        at.x >= 0.0 && at.y >= 0.0 && at.x < width as f64 && at.y < height as f64
    };
    let samples: Vec<usize> = (0..SAMPLES).filter(inside).collect();
    samples.iter().filter(|sample| near(sample)).count() as f64 >= SEEN_OF_EDGE * samples.len() as f64
}
