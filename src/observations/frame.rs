//! What a camera delivers in one go: its depth image and its grey image, with where it stands.

use super::depth::{DepthImage, DepthRange};
use super::image::GreyImage;
use super::registration::Registration;
use super::size::{SCALE_IMAGE, check_same_size};
use super::views::{DepthView, ImageView};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::geometry::RigidMotion;
use std::sync::Arc;

/// A depth sensor with optics of its own, beside the colour camera.
#[derive(Debug, Clone)]
pub struct DepthCamera {
    /// Its intrinsics; the depth image has the size of their image.
    pub camera: Camera,
    /// Where it stands: `x_color = R x_depth + t`.
    pub to_color: RigidMotion,
}

/// One view: the camera, where it stands, and the images that it took. Clones share the images, so that one copy serves
/// any number of fits.
///
/// Masks, edges and the grey image lie on the grid of the colour camera, and points have the coordinates of its frame.
/// The depth image lies on the grid of the depth camera where there is one of its own, else on that of the colour
/// camera.
#[derive(Debug, Clone, Default)]
pub struct Frame {
    camera: Option<Camera>,
    pose: RigidMotion,
    depth_camera: Option<DepthCamera>,
    depth: Option<Arc<DepthImage>>,
    range: DepthRange,
    registration: Option<Arc<Registration>>,
    image: Option<Arc<GreyImage>>,
}

/// The image of the colour camera, in texts about sizes.
const COLOR_GRID: &str = "the image of the intrinsics";

/// The image of the depth camera, in texts about sizes.
const DEPTH_GRID: &str = "the image of the depth camera";

/// What to do about a depth image that does not have the size of the colour image.
const REGISTER_DEPTH: &str = "register the depth to the image, or set the camera of the depth";

impl Frame {
    /// A frame without images. `Frame::default()` has no camera either: the frame of a bare cloud.
    #[must_use]
    pub fn new(camera: Camera) -> Self {
        Self { camera: Some(camera), ..Self::default() }
    }

    /// Replaces the colour camera, unless it has the same parameters. Images stay: they must have its size.
    ///
    /// # Errors
    /// `SizeMismatch` with an image of another size ([`Frame::clear_image`], [`Frame::clear_depth`]), `OutOfMemory`.
    /// The old camera stays then.
    pub fn set_camera(&mut self, camera: Camera) -> Result<()> {
        // The one that is there knows rays already, and nothing else would change.
        if self.camera.as_ref().is_some_and(|known| known.intrinsics() == camera.intrinsics()) {
            return Ok(());
        }
        if let Some(image) = &self.image {
            check_same_size(
                COLOR_GRID,
                camera.size(),
                "image",
                (image.width(), image.height()),
                SCALE_IMAGE,
            )?;
        }
        if let (Some(depth), None) = (&self.depth, &self.depth_camera) {
            check_same_size(COLOR_GRID, camera.size(), "depth image", depth.size(), REGISTER_DEPTH)?;
        }
        self.registration = register(self.depth.as_deref(), self.depth_camera.as_ref(), Some(&camera))?;
        self.camera = Some(camera);
        Ok(())
    }

    /// Sets the motion from the frame of the colour camera to the frame of reference that the result is given in.
    pub fn set_pose(&mut self, pose: RigidMotion) {
        self.pose = pose;
    }

    /// Sets or takes away a depth camera of its own. The depth image stays: it must have the size of the camera that
    /// measured it.
    ///
    /// # Errors
    /// `SizeMismatch` with a depth image of another size ([`Frame::clear_depth`]), `OutOfMemory`. The old depth camera
    /// stays then.
    pub fn set_depth_camera(&mut self, depth_camera: Option<DepthCamera>) -> Result<()> {
        if let Some(depth) = &self.depth {
            if let Some(own) = &depth_camera {
                check_same_size(DEPTH_GRID, own.camera.size(), "depth image", depth.size(), SCALE_IMAGE)?;
            } else if let Some(camera) = &self.camera {
                check_same_size(COLOR_GRID, camera.size(), "depth image", depth.size(), REGISTER_DEPTH)?;
            }
        }
        self.registration = register(self.depth.as_deref(), depth_camera.as_ref(), self.camera.as_ref())?;
        self.depth_camera = depth_camera;
        Ok(())
    }

    /// Takes a depth image, in place of an earlier one. Only depths in the range become points.
    ///
    /// # Errors
    /// `BadState` without a camera, `InvalidArgument` for a bad range, `SizeMismatch` when the image has another size
    /// than the camera that measured it, `OutOfMemory`. The earlier image stays then.
    pub fn set_depth(&mut self, depth: &DepthView<'_>, range: &DepthRange) -> Result<()> {
        let camera = self.camera_for("pushing a depth image")?;
        range.check()?;
        let size = (depth.width(), depth.height());
        match &self.depth_camera {
            Some(own) => check_same_size("depth image", size, DEPTH_GRID, own.camera.size(), SCALE_IMAGE)?,
            None => check_same_size("depth image", size, COLOR_GRID, camera.size(), REGISTER_DEPTH)?,
        }
        let depth = DepthImage::copy(depth)?;
        self.registration = register(Some(&depth), self.depth_camera.as_ref(), Some(camera))?;
        self.depth = Some(Arc::new(depth));
        self.range = *range;
        Ok(())
    }

    /// The frame with its depth image moved by some columns and rows; `None` with a depth camera of its own.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn with_depth_moved(&self, by: [i32; 2]) -> Result<Option<Self>> {
        let depth = self.depth.as_ref().filter(|_| self.depth_camera.is_none());
        let moved = depth.map(|depth| depth.moved(by)).transpose()?;
        Ok(moved.map(|depth| Self { depth: Some(Arc::new(depth)), ..self.clone() }))
    }

    /// Takes a grey or colour image on the grid of the colour camera, in place of an earlier one.
    ///
    /// # Errors
    /// `BadState` without a camera, `SizeMismatch` when the image has another size than it, else see
    /// [`GreyImage::copy`]. The earlier image stays then.
    pub fn set_image(&mut self, image: &ImageView<'_>) -> Result<()> {
        let camera = self.camera_for("pushing an image")?;
        check_same_size("image", (image.width(), image.height()), COLOR_GRID, camera.size(), SCALE_IMAGE)?;
        self.image = Some(Arc::new(GreyImage::copy(image)?));
        Ok(())
    }

    /// Forgets the depth image.
    pub fn clear_depth(&mut self) {
        self.depth = None;
        self.registration = None;
    }

    /// Forgets the grey image.
    pub fn clear_image(&mut self) {
        self.image = None;
    }

    /// The colour camera.
    #[must_use]
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// The motion from the frame of the colour camera to the frame of reference.
    #[must_use]
    pub fn pose(&self) -> &RigidMotion {
        &self.pose
    }

    /// The depth camera of its own.
    #[must_use]
    pub fn depth_camera(&self) -> Option<&DepthCamera> {
        self.depth_camera.as_ref()
    }

    /// The depth image as it was measured, on the grid of the camera that measured it.
    #[must_use]
    pub fn depth(&self) -> Option<&DepthImage> {
        self.depth.as_deref()
    }

    /// Which depths become points.
    #[must_use]
    pub fn depth_range(&self) -> &DepthRange {
        &self.range
    }

    /// The depth that the colour camera sees, on its grid: in each pixel the nearest of the surfaces that were measured
    /// there, z along the axis of the colour camera. The measured image where the depth camera is the colour camera.
    #[must_use]
    pub fn depth_on_image(&self) -> Option<&DepthImage> {
        self.registration.as_deref().map(Registration::image).or(self.depth.as_deref())
    }

    /// The grey image.
    #[must_use]
    pub fn image(&self) -> Option<&GreyImage> {
        self.image.as_deref()
    }

    /// Where the measured pixels lie on the colour image; `None` without a depth camera of its own.
    pub(super) fn registration(&self) -> Option<&Registration> {
        self.registration.as_deref()
    }

    fn camera_for(&self, call: &'static str) -> Result<&Camera> {
        self.camera.as_ref().ok_or(Error::BadState {
            call,
            missing: "intrinsics",
            remedy: "set the intrinsics first",
        })
    }
}

/// The registration of what is there; `None` when something is missing or nothing is to be registered.
fn register(
    depth: Option<&DepthImage>,
    depth_camera: Option<&DepthCamera>,
    camera: Option<&Camera>,
) -> Result<Option<Arc<Registration>>> {
    match (depth, depth_camera, camera) {
        (Some(depth), Some(own), Some(camera)) => {
            Registration::new(depth, own, camera).map(|registration| Some(Arc::new(registration)))
        }
        _ => Ok(None),
    }
}
