//! Frame files: one RGB-D view with its camera.

use crate::failure::Failure;
use crate::images::{self, Role};
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::observations::EdgeSegment;
use image::DynamicImage;
use nalgebra::Vector2;
use serde::Deserialize;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The largest frame file in bytes: a million edges would fit.
const MAX_FRAME_FILE: u64 = 1 << 26;

/// One RGB-D view, checked and decoded.
pub struct Frame {
    /// The camera of image, depth, mask and edges.
    pub camera: Camera,
    /// The image, unless it is absent or not wanted.
    pub image: Option<DynamicImage>,
    /// Light is the value of the image to this power; 1 where the file does not say.
    pub image_gamma: f64,
    /// The depth z of each pixel, row by row; 0 = not measured.
    pub depth: Vec<u16>,
    /// Metres per unit of depth.
    pub depth_scale: f64,
    /// One byte a pixel, non-zero on the cylinder.
    pub mask: Option<Vec<u8>>,
    /// Pieces of the limbs in pixels of the (distorted) image.
    pub edges: Vec<EdgeSegment>,
}

/// The file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameFile {
    camera: CameraFields,
    image: Option<PathBuf>,
    image_gamma: Option<f64>,
    depth: PathBuf,
    depth_scale: f64,
    mask: Option<PathBuf>,
    edges: Option<Vec<[[f64; 2]; 2]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraFields {
    #[serde(default)]
    model: CameraModel,
    width: u32,
    height: u32,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    distortion: Vec<f64>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "snake_case")]
enum CameraModel {
    #[default]
    BrownConrady,
    KannalaBrandt,
}

impl CameraFields {
    fn camera(&self) -> cylfuse::error::Result<Camera> {
        let distortion = match self.model {
            CameraModel::BrownConrady => Distortion::brown_conrady(&self.distortion)?,
            CameraModel::KannalaBrandt => Distortion::kannala_brandt(&self.distortion)?,
        };
        let Self { width, height, fx, fy, cx, cy, .. } = *self;
        Camera::new(Intrinsics { width, height, fx, fy, cx, cy, distortion })
    }
}

impl Frame {
    /// Reads a frame file and the images that it names, relative to itself.
    pub fn read(path: &Path, with_image: bool) -> Result<Self, Failure> {
        let file = parse(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let camera = file.camera.camera()?;
        let size = (camera.intrinsics().width, camera.intrinsics().height);
        let read = |name: &Path, role| images::read(&folder.join(name), role, size);
        let depth = match read(&file.depth, Role::Depth)? {
            DynamicImage::ImageLuma16(grey) => grey.into_raw(),
            other => {
                let reason =
                    format!("the depth image was decoded to {:?}, not to 16-bit grey", other.color());
                return Err(Failure::bad_image(&folder.join(&file.depth), reason));
            }
        };
        let mask = file.mask.as_deref().map(|name| read(name, Role::Mask)).transpose()?;
        let image = file.image.as_deref().filter(|_| with_image);
        let segment = |[a, b]: [[f64; 2]; 2]| EdgeSegment {
            endpoints: [Vector2::from(a), Vector2::from(b)],
            weight: 1.0,
        };
        Ok(Self {
            image: image.map(|name| read(name, Role::Image)).transpose()?,
            image_gamma: file.image_gamma.unwrap_or(1.0),
            depth,
            depth_scale: file.depth_scale,
            mask: mask.map(images::mask_bytes),
            edges: file.edges.unwrap_or_default().into_iter().map(segment).collect(),
            camera,
        })
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        self.camera.size()
    }
}

fn parse(path: &Path) -> Result<FrameFile, Failure> {
    let mut text = Vec::new();
    let file = File::open(path).map_err(|error| Failure::not_readable(path, &error))?;
    let read = file.take(MAX_FRAME_FILE + 1).read_to_end(&mut text);
    read.map_err(|error| Failure::not_readable(path, &error))?;
    if text.len() as u64 > MAX_FRAME_FILE {
        let reason = format!("has more than {MAX_FRAME_FILE} bytes; a frame file is a small JSON file");
        return Err(Failure::bad_frame(path, reason));
    }
    let mut json = serde_json::Deserializer::from_slice(&text);
    let frame = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let place = error.path().to_string();
        let reason = error.into_inner();
        // "." and "?" stand for the whole file.
        if matches!(place.as_str(), "." | "?") {
            Failure::bad_frame(path, reason)
        } else {
            Failure::bad_frame(path, format!("{place}: {reason}"))
        }
    })?;
    json.end().map_err(|error| Failure::bad_frame(path, error))?;
    Ok(frame)
}
