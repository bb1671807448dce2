//! The data of one view, as they were pushed.

use crate::camera::Camera;
use crate::geometry::RigidMotion;
use crate::observations::{DepthImage, EdgeSegment, Frame, GreyImage, Mask, PointCloud};

/// One view of the cylinder: a frame, and what was pushed of the cylinder in it, in the coordinates of the view.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    pub frame: Frame,
    pub mask: Option<Mask>,
    pub cloud: PointCloud,
    pub segments: Vec<EdgeSegment>,
}

impl View {
    /// The camera of image, mask and edges.
    pub fn camera(&self) -> Option<&Camera> {
        self.frame.camera()
    }

    /// From the view to the reference frame.
    pub fn pose(&self) -> &RigidMotion {
        self.frame.pose()
    }

    /// The depth on the grid of the image.
    pub fn depth(&self) -> Option<&DepthImage> {
        self.frame.depth_on_image()
    }

    /// The grey image.
    pub fn image(&self) -> Option<&GreyImage> {
        self.frame.image()
    }
}
