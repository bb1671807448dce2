//! The data of one view, as they were pushed.

use super::subsample::Neighbours;
use crate::camera::Camera;
use crate::geometry::{Cylinder, RigidMotion};
use crate::memory::List;
use crate::noise::{ImageNoise, NoiseModel};
use crate::observations::{DepthImage, EdgeSegment, Frame, GreyImage, Mask, PointCloud};
use crate::parts::Parts;
use crate::statistics::{median_absolute, median_point};
use nalgebra::{Matrix3, Vector2, Vector3};
use std::sync::OnceLock;

/// Points that tell where a view has most of its points.
const SAMPLE: usize = 64;

/// A root mean square distance of so many median ones is that of a few points that are no part of the body. Of a pipe that leads
/// from 1 m to 100 m away from a scanner it is 10.
const FAR: f64 = 100.0;

/// They are this part of the points at most: more may be the body, and those near each other a spot on it.
const FEW: f64 = 0.1;

/// One view of the cylinder: a frame, and what was pushed of the cylinder in it, in the coordinates of the view.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    pub frame: Frame,
    pub mask: Option<Mask>,
    /// The part of the mask that is the body, where that is not all of it.
    pub body: Option<Mask>,
    /// Whether points and mask are known to be those of the body alone: a detector found them.
    pub is_body: bool,
    /// Whether the mask was made of the points, as none was pushed.
    pub mask_of_points: bool,
    /// Pieces of the limbs of other bodies in the image, from end to end in ideal pixels.
    pub limbs_of_others: Vec<[Vector2<f64>; 2]>,
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
            is_body: self.is_body,
            mask_of_points: self.mask_of_points,
            limbs_of_others: self.limbs_of_others.clone(),
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

    /// The same view with a frame and a mask that were made of its points.
    pub fn with_points_as_mask(&self, frame: Frame, mask: Mask) -> Self {
        Self { frame, mask: Some(mask), mask_of_points: true, ..self.clone() }
    }

    /// Whether a mask or a detector has told the background.
    pub fn tells_background(&self) -> bool {
        self.mask.is_some() || self.is_body
    }

    /// Whether the sides of the mask say something of their own: not where they were drawn about the cylinder of a fit, nor
    /// where a detector found the body by the depth, which is smeared at the limbs.
    pub fn sides_tell(&self) -> bool {
        !self.sides_drawn && !self.is_body
    }

    /// Whether a mask, if there is one, was drawn in the image, by a person or a network, and not made of the depth.
    pub fn mask_is_drawn(&self) -> bool {
        self.sides_tell() && !self.mask_ends_with_depth()
    }

    /// A mask of this view as ends are looked for in it: a drawn one without its specks, as a generator ends where it leaves the mask for
    /// the last time. Where depth is missing a mask that was made of it is in pieces.
    pub fn for_ends<'a>(&self, mask: &'a Mask) -> &'a Mask {
        let without = self.sides_tell().then(|| mask.without_specks()).flatten();
        without.filter(|_| !self.mask_ends_with_depth()).unwrap_or(mask)
    }

    /// How far each limb of a cylinder, in the coordinates of the view, may be from where it is expected without being that of
    /// another body, in pixels.
    pub fn reach_beside_others(&self, camera: &Camera, cylinder: &Cylinder, noise: &ImageNoise) -> [f64; 2] {
        let pieces = self.limbs_of_others.iter();
        let distances = pieces.filter_map(|piece| camera.distances_from_limbs(cylinder, piece));
        distances.fold([f64::INFINITY; 2], |reach, of_piece| {
            let free = of_piece.map(|distance| (distance.amin() - noise.same_limb()).max(0.0));
            [reach[0].min(free[0]), reach[1].min(free[1])]
        })
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

    /// The same view without points that are so far from the others that they hide how these spread, such as invalid ones that a
    /// program moved to other coordinates; `None` where there are none.
    pub fn without_far_points(&self) -> Option<Self> {
        let (_, covariance) = self.mean_and_covariance()?;
        let sample: List<_> = self.cloud.sampled(SAMPLE).collect();
        let middle = median_point(&sample);
        let reach = FAR * median_absolute(sample.iter().map(|p| (p - middle).norm()));
        if reach == 0.0 || covariance.trace() <= reach * reach {
            return None;
        }
        let cloud = self.cloud.chosen(|index| (self.cloud.point(index) - middle).norm() <= reach);
        let are_few = (self.cloud.len() - cloud.len()) as f64 <= FEW * self.cloud.len() as f64;
        are_few.then(|| self.with_points(cloud, self.body.clone()))
    }

    /// The camera of image, mask and edges.
    pub fn camera(&self) -> Option<&Camera> {
        self.frame.camera()
    }

    /// From the view to the reference frame.
    pub fn pose(&self) -> &RigidMotion {
        self.frame.pose()
    }

    /// A cylinder in the coordinates of the view.
    pub fn seen(&self, cylinder: &Cylinder) -> Cylinder {
        self.pose().inverse().cylinder(cylinder)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};

    #[test]
    fn limbs_of_others_limit_where_a_limb_may_be() {
        let distortion = Distortion::None;
        let intrinsics =
            Intrinsics { width: 640, height: 480, fx: 600.0, fy: 600.0, cx: 320.0, cy: 240.0, distortion };
        let camera = Camera::new(intrinsics).unwrap();
        let noise = NoiseModel::default().in_image(camera.size());
        // Its limbs are the columns 320 ± 60.
        let radius = 0.1_f64.atan().sin();
        let cylinder = Cylinder::new(Vector3::z(), Vector3::y(), radius).unwrap();
        let mut view = View::default();
        assert_eq!(view.reach_beside_others(&camera, &cylinder, &noise), [f64::INFINITY; 2]);
        let piece = |u: f64| [100.0, 200.0].map(|v| Vector2::new(u, v));
        view.limbs_of_others = vec![piece(385.0), piece(255.5), piece(245.0)];
        let mut reach = view.reach_beside_others(&camera, &cylinder, &noise);
        reach.sort_by(f64::total_cmp);
        assert!((reach[0] - 3.5).abs() < 1e-9 && (reach[1] - 4.0).abs() < 1e-9, "{reach:?}");
        view.limbs_of_others.push(piece(380.5));
        let reach = view.reach_beside_others(&camera, &cylinder, &noise);
        assert_eq!(reach.iter().filter(|&&reach| reach == 0.0).count(), 1, "{reach:?}");
    }
}
