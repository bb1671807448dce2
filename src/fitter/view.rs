//! The data of one view, as they were pushed.

use crate::camera::Camera;
use crate::geometry::RigidMotion;
use crate::observations::{DepthImage, EdgeSegment, GreyImage, Mask, PointCloud};

/// One view of the cylinder: a camera, where it stands, and what was pushed of it. Everything but the pose is in its own
/// coordinates.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    pub camera: Option<Camera>,
    pub pose: RigidMotion,
    pub depth: Option<DepthImage>,
    pub image: Option<GreyImage>,
    pub mask: Option<Mask>,
    pub cloud: PointCloud,
    pub segments: Vec<EdgeSegment>,
}

impl View {
    /// The camera of image, mask and edges.
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// From the view to the reference frame.
    pub fn pose(&self) -> &RigidMotion {
        &self.pose
    }

    /// The depth on the grid of the image.
    pub fn depth(&self) -> Option<&DepthImage> {
        self.depth.as_ref()
    }

    /// The grey image.
    pub fn image(&self) -> Option<&GreyImage> {
        self.image.as_ref()
    }
}
