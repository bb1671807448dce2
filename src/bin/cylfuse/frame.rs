//! Frame files: one or more RGB-D views with their cameras.

use crate::failure::Failure;
use crate::images::{self, Image, Pixels, Role};
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::geometry::RigidMotion;
use cylfuse::observations::{self, DepthCamera, DepthRange, DepthView, EdgeSegment};
use nalgebra::{Matrix3, Vector2, Vector3};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The largest frame file in bytes: a million edges would fit.
const MAX_FRAME_FILE: u64 = 1 << 26;

/// A frame file, checked and decoded.
pub struct Frame {
    /// One or more views of the same cylinder.
    pub views: Vec<View>,
}

/// One RGB-D view.
pub struct View {
    /// The camera of image, mask and edges, and of the depth where there is no depth camera.
    pub camera: Camera,
    /// From the frame of the camera to that of the result.
    pub pose: RigidMotion,
    /// The image, unless it is absent or not wanted.
    pub image: Option<Image>,
    /// Light is the value of the image to this power; 1 where the file does not say.
    pub image_gamma: f64,
    /// The depth z of each pixel, row by row; 0 = not measured.
    pub depth: Vec<u16>,
    /// Metres per unit of depth.
    pub depth_scale: f64,
    /// The camera of the depth, where it is another one.
    pub depth_camera: Option<DepthCamera>,
    /// One byte a pixel, non-zero on the cylinder.
    pub mask: Option<Vec<u8>>,
    /// Pieces of the limbs in pixels of the (distorted) image.
    pub edges: Vec<EdgeSegment>,
}

/// A file of several views.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewsFile {
    views: Vec<ViewFields>,
}

/// A view as it is written; a file of a single one is nothing else.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewFields {
    camera: CameraFields,
    image: Option<PathBuf>,
    image_gamma: Option<f64>,
    depth: PathBuf,
    depth_scale: f64,
    depth_camera: Option<DepthCameraFields>,
    mask: Option<PathBuf>,
    edges: Option<Vec<[[f64; 2]; 2]>>,
    pose: Option<MotionFields>,
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
    #[serde(default)]
    distortion: Vec<f64>,
}

/// [`CameraFields`] and [`MotionFields`]: unknown fields of flattened parts would go unseen.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DepthCameraFields {
    #[serde(default)]
    model: CameraModel,
    width: u32,
    height: u32,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    #[serde(default)]
    distortion: Vec<f64>,
    rotation: [f64; 9],
    translation: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MotionFields {
    /// Row by row.
    rotation: [f64; 9],
    translation: [f64; 3],
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

impl MotionFields {
    fn motion(&self) -> cylfuse::error::Result<RigidMotion> {
        RigidMotion::new(Matrix3::from_row_slice(&self.rotation), Vector3::from(self.translation))
    }
}

impl DepthCameraFields {
    fn depth_camera(self) -> cylfuse::error::Result<DepthCamera> {
        let Self { model, width, height, fx, fy, cx, cy, distortion, rotation, translation } = self;
        let camera = CameraFields { model, width, height, fx, fy, cx, cy, distortion }.camera()?;
        let to_color = MotionFields { rotation, translation }.motion()?;
        Ok(DepthCamera { camera, to_color })
    }
}

impl Frame {
    /// Reads a frame file and the images that it names, relative to itself.
    pub fn read(path: &Path, with_image: bool) -> Result<Self, Failure> {
        let views = match parse(path)? {
            Content::Single(view) => vec![View::read(path, "", *view, with_image)?],
            Content::Several(file) => {
                let views = file.views.into_iter().enumerate();
                let read = |(k, view)| View::read(path, &format!("views[{k}]."), view, with_image);
                views.map(read).collect::<Result<Vec<_>, _>>()?
            }
        };
        if views.is_empty() {
            return Err(Failure::bad_frame(path, "views: the list is empty; give at least one view"));
        }
        Ok(Self { views })
    }
}

impl View {
    /// Reads the images of a view; `location` is where it stands in the file.
    fn read(path: &Path, location: &str, fields: ViewFields, with_image: bool) -> Result<Self, Failure> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let at = |name: &'static str| {
            move |error| Failure::from(error).in_frame(path, &format!("{location}{name}"))
        };
        let camera = fields.camera.camera().map_err(at("camera"))?;
        let pose = fields.pose.map(|pose| pose.motion()).transpose().map_err(at("pose"))?;
        let depth_camera = fields.depth_camera.map(DepthCameraFields::depth_camera).transpose();
        let depth_camera = depth_camera.map_err(at("depth_camera"))?;
        let size = |camera: &Camera| (camera.intrinsics().width, camera.intrinsics().height);
        let depth_size = size(depth_camera.as_ref().map_or(&camera, |own| &own.camera));
        let read = |name: &Path, role| images::read(&folder.join(name), role, size(&camera));
        let depth = folder.join(&fields.depth);
        let Pixels::Grey16(depth) = images::read(&depth, Role::Depth, depth_size)?.pixels else {
            return Err(Failure::bad_image(&depth, "the depth image was not decoded to 16-bit grey"));
        };
        let mask = fields.mask.as_deref().map(|name| read(name, Role::Mask)).transpose()?;
        let image = fields.image.as_deref().filter(|_| with_image);
        let segment = |[a, b]: [[f64; 2]; 2]| EdgeSegment {
            endpoints: [Vector2::from(a), Vector2::from(b)],
            weight: 1.0,
        };
        Ok(Self {
            image: image.map(|name| read(name, Role::Image)).transpose()?,
            image_gamma: fields.image_gamma.unwrap_or(1.0),
            depth,
            depth_scale: fields.depth_scale,
            depth_camera,
            mask: mask.as_ref().map(images::mask_bytes),
            edges: fields.edges.unwrap_or_default().into_iter().map(segment).collect(),
            pose: pose.unwrap_or_default(),
            camera,
        })
    }

    /// Columns and rows of image and mask.
    pub fn size(&self) -> (usize, usize) {
        self.camera.size()
    }

    /// What the library takes of it: cameras, pose, depth and image.
    pub fn observed(&self) -> cylfuse::error::Result<observations::Frame> {
        let mut frame = observations::Frame::new(self.camera.clone());
        frame.set_pose(self.pose);
        frame.set_depth_camera(self.depth_camera.clone())?;
        let size = self.depth_camera.as_ref().map_or(self.size(), |own| own.camera.size());
        frame
            .set_depth(&DepthView::from_u16(&self.depth, size, self.depth_scale)?, &DepthRange::default())?;
        if let Some(image) = &self.image {
            images::give(image, self.image_gamma, &mut frame)?;
        }
        Ok(frame)
    }
}

/// What a frame file may be.
enum Content {
    Single(Box<ViewFields>),
    Several(ViewsFile),
}

/// Enough of a file to tell which.
#[derive(Deserialize)]
struct Probe {
    views: Option<IgnoredAny>,
}

fn parse(path: &Path) -> Result<Content, Failure> {
    let mut text = Vec::new();
    let file = File::open(path).map_err(|error| Failure::not_readable(path, &error))?;
    let read = file.take(MAX_FRAME_FILE + 1).read_to_end(&mut text);
    read.map_err(|error| Failure::not_readable(path, &error))?;
    if text.len() as u64 > MAX_FRAME_FILE {
        let reason = format!("has more than {MAX_FRAME_FILE} bytes; a frame file is a small JSON file");
        return Err(Failure::bad_frame(path, reason));
    }
    // An image or a cloud was named.
    if text.iter().find(|byte| !byte.is_ascii_whitespace()) != Some(&b'{') {
        let reason = "is no frame file, which is a JSON object in {}; name a frame.json or a folder that has one, or a cloud \
                      after --points";
        return Err(Failure::bad_frame(path, reason));
    }
    let several = serde_json::from_slice(&text).is_ok_and(|probe: Probe| probe.views.is_some());
    if several {
        deserialize(path, &text).map(Content::Several)
    } else {
        deserialize(path, &text).map(|view| Content::Single(Box::new(view)))
    }
}

/// Reads JSON; what is wrong is named by its location.
fn deserialize<'a, T: Deserialize<'a>>(path: &Path, text: &'a [u8]) -> Result<T, Failure> {
    let mut json = serde_json::Deserializer::from_slice(text);
    let content = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let location = error.path().to_string();
        let reason = error.into_inner();
        // "." and "?" stand for the whole file, or for what ends within a field.
        let location = location.trim_end_matches(['.', '?']);
        let colon = if location.is_empty() { "" } else { ": " };
        // A field that is missing, misspelt or of another type.
        if reason.is_data() {
            let remedy = "cylfuse fit --help lists the fields";
            return Failure::bad_frame(path, format!("{location}{colon}{reason}; {remedy}"));
        }
        Failure::bad_frame(path, format!("{location}{colon}{}", no_json(&reason)))
    })?;
    json.end().map_err(|error| Failure::bad_frame(path, no_json(&error)))?;
    Ok(content)
}

/// A comma too many, a value that JSON does not know, or the end of the file too early.
fn no_json(error: &serde_json::Error) -> String {
    format!(
        "is not valid JSON: {error}; correct it there (JSON has no NaN, no comments and no comma before a bracket that closes)"
    )
}
