//! What goes into a fitter: views, cameras, points, images, edges.

use super::Fitter;
#[cfg(doc)]
use super::options::StartKind;
use super::view::View;
use crate::camera::{Camera, Intrinsics};
use crate::error::{Error, Result, reserve};
use crate::geometry::RigidMotion;
use crate::observations::{
    DepthCamera, DepthImage, DepthRange, DepthView, EdgeSegment, Frame, GreyImage, ImageView, Mask, MaskView,
    PointCloud, PointsView, check_segments,
};
use nalgebra::Vector2;

/// Bytes a point of a copy: the points as they were pushed, and of those in a mask that holds more than the body, or beside
/// what covers it, with their neighbours.
const BYTES_OF_COPY: usize = 160;

bitflags::bitflags! {
    /// Kinds of data of a view.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct Inputs: u32 {
        /// Points, those of depth images too.
        const POINTS = 1;
        /// The depth image and its mask; the points that were made of it stay.
        const DEPTH = 1 << 1;
        /// The edge segments.
        const EDGES = 1 << 2;
        /// The grey image.
        const IMAGE = 1 << 3;
    }
}

impl Fitter {
    /// A copy, as by `clone`, where there is memory for it. Images are shared, points are copied.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn try_clone(&self) -> Result<Self> {
        self.check_memory(BYTES_OF_COPY)?;
        Ok(self.clone())
    }

    /// Selects the view that settings, data and questions of a view are about. An index that is the number of views adds
    /// a view at the identity.
    ///
    /// # Errors
    /// `InvalidArgument` for a larger index.
    pub fn select_view(&mut self, index: usize) -> Result<()> {
        let count = self.views.len();
        if index > count {
            let requirement = format!("be at most {count}, the number of views, which adds one");
            return Err(Error::argument("index of the view", index, requirement));
        }
        if index == count {
            reserve(&mut self.views, 1, "a view")?;
            self.views.push(View::default());
            self.made_with = None;
        }
        self.selected = index;
        Ok(())
    }

    /// The index of the selected view.
    #[must_use]
    pub fn selected_view(&self) -> usize {
        self.selected
    }

    /// The number of views.
    #[must_use]
    pub fn view_count(&self) -> usize {
        self.views.len()
    }

    /// The selected view.
    pub(crate) fn view(&self) -> &View {
        &self.views[self.selected]
    }

    /// All views.
    pub(crate) fn views(&self) -> &[View] {
        &self.views
    }

    /// The selected view, to change it: the constraints of the last fit are another matter then.
    fn view_mut(&mut self) -> &mut View {
        self.made_with = None;
        let view = &mut self.views[self.selected];
        view.is_body = false;
        view.limbs_of_others.clear();
        view.forget_points();
        view
    }

    /// Tells that points and mask of the selected view are those of the body alone, until that view is changed.
    pub(crate) fn know_as_body(&mut self) {
        self.views[self.selected].is_body = true;
    }

    /// Tells pieces of the limbs of other bodies, from end to end in ideal pixels, until the selected view is changed: an edge
    /// there is none of the cylinder.
    pub(crate) fn know_limbs_of_others(&mut self, pieces: &[[Vector2<f64>; 2]]) {
        self.views[self.selected].limbs_of_others = pieces.to_vec();
    }

    /// Sets the camera of the selected view. Points that were pushed before stay as they are.
    ///
    /// # Errors
    /// `InvalidIntrinsics`; `SizeMismatch` with an image of another size ([`Fitter::clear_inputs`]). The old camera stays
    /// then.
    pub fn set_intrinsics(&mut self, intrinsics: Intrinsics) -> Result<()> {
        let camera = Camera::new(intrinsics)?;
        self.view_mut().frame.set_camera(camera)
    }

    /// Sets where the selected view is: the motion from its coordinates, those of its colour camera, to the reference
    /// frame, in the unit of length of the data.
    pub fn set_pose(&mut self, pose: RigidMotion) {
        self.view_mut().frame.set_pose(pose);
    }

    /// Sets or takes away a depth camera of its own for the selected view: depth images that are pushed from then on are
    /// on its grid.
    ///
    /// # Errors
    /// `SizeMismatch` with a depth image of another size, `OutOfMemory`. The old one stays then.
    pub fn set_depth_camera(&mut self, depth_camera: Option<DepthCamera>) -> Result<()> {
        self.view_mut().frame.set_depth_camera(depth_camera)
    }

    /// Takes camera, pose and images of a frame into the selected view, in place of its own, and adds the points of its
    /// depth image, if there is one; a mask selects pixels. The images are shared and not copied.
    ///
    /// # Errors
    /// See [`PointCloud::push_frame`]. Nothing is changed then.
    pub fn use_frame(&mut self, frame: &Frame, mask: Option<&MaskView<'_>>) -> Result<()> {
        let mask = mask.map(Mask::copy).transpose()?;
        if let (Some(mask), Some(camera)) = (&mask, frame.camera()) {
            mask.check_size("the image of the intrinsics", camera.size())?;
        }
        let view = self.view_mut();
        if frame.depth().is_some() {
            view.cloud.push_frame(frame, mask.as_ref())?;
        }
        view.frame = frame.clone();
        view.mask = mask;
        Ok(())
    }

    /// The frame of the selected view: its camera, its pose and its images, to be shared with other fitters.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.view().frame
    }

    /// The pose of the selected view.
    #[must_use]
    pub fn pose(&self) -> &RigidMotion {
        self.view().pose()
    }

    /// The camera of the selected view.
    #[must_use]
    pub fn camera(&self) -> Option<&Camera> {
        self.view().camera()
    }

    /// Adds points in the coordinates of the selected view; a mask selects pixels of an organised cloud.
    ///
    /// # Errors
    /// See [`PointCloud::push_points`]. Nothing is added then.
    pub fn push_points(&mut self, points: &PointsView<'_>, mask: Option<&MaskView<'_>>) -> Result<()> {
        let mask = mask.map(Mask::copy).transpose()?;
        self.view_mut().cloud.push_points(points, mask.as_ref())
    }

    /// The same for points with these numbers in place of a mask: see [`PointCloud::push_numbered`].
    pub(crate) fn push_numbered(
        &mut self,
        points: &PointsView<'_>,
        numbers: impl ExactSizeIterator<Item = usize>,
    ) -> Result<()> {
        self.view_mut().cloud.push_numbered(points, numbers)
    }

    /// Adds the points of a depth image; a mask on the grid of the colour image selects pixels. Image and mask are kept, in
    /// place of earlier ones, for the extent and the completion.
    ///
    /// # Errors
    /// `BadState` without intrinsics, else see [`Frame::set_depth`] and [`PointCloud::push_frame`]. Nothing is added
    /// then.
    pub fn push_depth(
        &mut self,
        depth: &DepthView<'_>,
        mask: Option<&MaskView<'_>>,
        range: &DepthRange,
    ) -> Result<()> {
        let mask = mask.map(Mask::copy).transpose()?;
        let mut frame = self.view().frame.clone();
        frame.set_depth(depth, range)?;
        let view = self.view_mut();
        view.cloud.push_frame(&frame, mask.as_ref())?;
        view.frame = frame;
        view.mask = mask;
        Ok(())
    }

    /// Adds edge segments in pixels of the (distorted) image of the selected view.
    ///
    /// # Errors
    /// `InvalidArgument` for a bad number, `OutOfMemory`. Nothing is added then.
    pub fn push_edges(&mut self, segments: &[EdgeSegment]) -> Result<()> {
        check_segments(segments)?;
        self.reserve_segments(segments.len())?;
        self.view_mut().segments.extend_from_slice(segments);
        Ok(())
    }

    /// Takes a grey or colour image on the grid of the camera of the selected view, in place of an earlier one. The robust
    /// objective locates the limbs in it from the given edges, the sides of the mask, or without both the outline of the points where these
    /// are as dense as the image, and the ends are located in it.
    ///
    /// # Errors
    /// `BadState` without intrinsics, `SizeMismatch` when it has another size than they, else see
    /// [`GreyImage::copy`]. The earlier image stays then.
    pub fn push_image(&mut self, image: &ImageView<'_>) -> Result<()> {
        self.view_mut().frame.set_image(image)
    }

    /// Forgets all data, all views but the first, and the result; keeps options, start model, what [`StartKind::Last`] goes
    /// on from, the camera of the first view, and memory.
    pub fn clear(&mut self) {
        self.views.truncate(1);
        self.selected = 0;
        self.clear_inputs(Inputs::all());
        self.set_pose(RigidMotion::identity());
        self.result = None;
    }

    /// Forgets some of the data of the selected view.
    pub fn clear_inputs(&mut self, inputs: Inputs) {
        let view = self.view_mut();
        if inputs.contains(Inputs::POINTS) {
            view.cloud.clear();
        }
        if inputs.contains(Inputs::DEPTH) {
            view.frame.clear_depth();
            view.mask = None;
        }
        if inputs.contains(Inputs::EDGES) {
            view.segments.clear();
        }
        if inputs.contains(Inputs::IMAGE) {
            view.frame.clear_image();
        }
    }

    /// Makes room for the coordinates of that many more points and for that many more segments of the selected view.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn reserve(&mut self, points: usize, segments: usize) -> Result<()> {
        self.views[self.selected].cloud.reserve(points)?;
        self.reserve_segments(segments)
    }

    fn reserve_segments(&mut self, segments: usize) -> Result<()> {
        reserve(&mut self.views[self.selected].segments, segments, "the edge segments")
    }

    /// The points that were pushed to the selected view.
    #[must_use]
    pub fn cloud(&self) -> &PointCloud {
        &self.view().cloud
    }

    /// The segments that were pushed to the selected view.
    #[must_use]
    pub fn segments(&self) -> &[EdgeSegment] {
        &self.view().segments
    }

    /// The mask of the last depth image of the selected view.
    #[must_use]
    pub fn mask(&self) -> Option<&Mask> {
        self.view().mask.as_ref()
    }

    /// Puts a mask in place of that of the selected view, and gives that back. The constraints of the last fit stay: this is
    /// for taking the same mask away and back.
    pub(crate) fn swap_mask(&mut self, mask: Option<Mask>) -> Option<Mask> {
        std::mem::replace(&mut self.views[self.selected].mask, mask)
    }

    /// The depth of the selected view on the grid of its image.
    #[must_use]
    pub fn depth(&self) -> Option<&DepthImage> {
        self.view().depth()
    }

    /// The grey image of the selected view.
    #[must_use]
    pub fn image(&self) -> Option<&GreyImage> {
        self.view().image()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_is_known_as_the_body_until_its_view_is_changed() {
        let mut fitter = Fitter::new();
        fitter.know_as_body();
        fitter.set_start(None);
        assert!(fitter.view().is_body);
        fitter.clear_inputs(Inputs::DEPTH);
        assert!(!fitter.view().is_body);
    }

    #[test]
    fn what_is_known_of_points_is_forgotten_with_them() {
        let wave = |k: i32| 1e-4 * (f64::from(k) * 12.9898).sin();
        let points = |turn: f64| -> Vec<[f64; 3]> {
            let point = |k: i32| {
                let (angle, radius) = (turn + 0.005 * f64::from(k % 200), 0.05 + wave(k));
                [radius * angle.sin(), 0.002 * f64::from(k / 200), 0.8 - radius * angle.cos()]
            };
            (0..4000).map(point).collect()
        };
        let push = |fitter: &mut Fitter, points: &[[f64; 3]]| {
            fitter.push_points(&PointsView::from_f64(points), None).unwrap();
        };
        let (first, second) = (points(-0.5), points(0.3));
        let mut fitter = Fitter::new();
        push(&mut fitter, &first);
        fitter.fit().unwrap();
        push(&mut fitter, &second);
        let both = fitter.fit().unwrap();
        fitter.clear_inputs(Inputs::POINTS);
        push(&mut fitter, &second);
        let alone = fitter.fit().unwrap();
        for (pushed, result) in [(vec![&first, &second], &both), (vec![&second], &alone)] {
            let mut fresh = Fitter::new();
            pushed.into_iter().for_each(|points| push(&mut fresh, points));
            let fresh = fresh.fit().unwrap();
            assert_eq!(fresh.cylinder, result.cylinder);
            assert_eq!(fresh.independent_points.to_bits(), result.independent_points.to_bits());
        }
    }
}
