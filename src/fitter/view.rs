//! The data of one view, as they were pushed.

use super::few::Neighbours;
use crate::camera::Camera;
use crate::geometry::{Cylinder, RigidMotion};
use crate::noise::NoiseModel;
use crate::observations::{DepthImage, EdgeSegment, Frame, GreyImage, Mask, PointCloud};
use crate::parts::Parts;
use nalgebra::{Matrix3, Vector3};
use std::sync::OnceLock;

/// One view of the cylinder: a frame, and what was pushed of the cylinder in it, in the coordinates of the view.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    pub frame: Frame,
    pub mask: Option<Mask>,
    /// The part of the mask that is the body, where that is not all of it.
    pub body: Option<Mask>,
    /// Whether the mask is known to hold the body alone.
    pub mask_is_body: bool,
    /// Whether the sides of the mask were drawn about the cylinder of a fit.
    sides_drawn: bool,
    pub cloud: PointCloud,
    pub segments: Vec<EdgeSegment>,
    /// The neighbours among the points, as soon as a fit has asked for them; those that an observer sees come second.
    neighbours: [OnceLock<Neighbours>; 2],
    /// The mean and covariance of the points, likewise.
    spread: OnceLock<Option<(Vector3<f64>, Matrix3<f64>)>>,
}

impl View {
    /// The same view with other points, and with that part of its mask.
    pub fn with_points(&self, cloud: PointCloud, body: Option<Mask>) -> Self {
        Self {
            frame: self.frame.clone(),
            mask: self.mask.clone(),
            body,
            mask_is_body: self.mask_is_body,
            sides_drawn: self.sides_drawn,
            cloud,
            segments: self.segments.clone(),
            neighbours: Default::default(),
            spread: OnceLock::new(),
        }
    }

    /// The same view with another mask, whose sides were drawn.
    pub fn with_drawn_sides(&self, mask: Mask) -> Self {
        Self { mask: Some(mask), body: None, sides_drawn: true, ..self.clone() }
    }

    /// Whether the sides of the mask say something of their own: not where they were drawn about the cylinder of a fit, nor
    /// where a detector found the body by the depth, which is smeared at the limbs.
    pub fn sides_tell(&self) -> bool {
        !self.sides_drawn && !self.mask_is_body
    }

    /// Whether a mask, if there is one, was drawn in the image, by a person or a network, and not made of the depth.
    pub fn mask_is_drawn(&self) -> bool {
        self.sides_tell() && !self.mask_ends_with_depth()
    }

    /// The points are about to change.
    pub fn forget_points(&mut self) {
        (self.neighbours, self.spread) = Default::default();
    }

    /// The mean and covariance of the points, found once; `None` for none.
    pub fn mean_and_covariance(&self) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        *self.spread.get_or_init(|| self.cloud.mean_and_covariance())
    }

    /// The neighbours among the points, found once.
    pub(super) fn neighbours(&self, observed: bool) -> &Neighbours {
        self.neighbours[usize::from(observed)].get_or_init(|| Neighbours::new(&self.cloud, observed))
    }

    /// Some of its points alone, evenly spread.
    pub fn thinned(&self, count: usize) -> Self {
        let (frame, cloud) = (self.frame.clone(), self.cloud.thinned(count));
        Self { frame, cloud, mask: None, segments: Vec::new(), ..Self::default() }
    }

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

    /// The mask of the body.
    pub fn body(&self) -> Option<&Mask> {
        self.body.as_ref().or(self.mask.as_ref())
    }

    /// The parts of the mask about a cylinder in the coordinates of the view; `None` without camera, depth and mask, and
    /// where the depth does not show the cylinder.
    pub fn parts(&self, cylinder: &Cylinder, noise: &NoiseModel) -> Option<Parts> {
        let (camera, depth, mask) = (self.camera()?, self.depth()?, self.mask.as_ref()?);
        Parts::new(camera, depth, mask, cylinder, &noise.in_image(camera.size()))
    }

    /// The grey image.
    pub fn image(&self) -> Option<&GreyImage> {
        self.frame.image()
    }
}
