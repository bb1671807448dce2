//! What a page shows of a frame or cylinder beside its numbers: pictures without text, what is to be written on them, points.

use crate::canvas::Canvas;
use crate::images::Image;
use nalgebra::Vector2;
use serde::{Serialize, Serializer};

/// Width of a picture in pixels, and its quality: some 20 kB each.
pub const PICTURE_WIDTH: u32 = 480;
const PICTURE_QUALITY: u8 = 75;

/// Most points of a cylinder and of a scene: enough to see where they lie.
pub const POINTS_OF_CYLINDER: usize = 1500;
pub const POINTS_OF_SCENE: usize = 8000;

/// A picture, and the words on it.
#[derive(Debug, Clone, Serialize)]
pub struct Picture {
    /// In base 64.
    #[serde(serialize_with = "in_base_64")]
    jpeg: Vec<u8>,
    labels: Vec<Label>,
}

/// A word on a picture. The page writes it, so that it has the size of other text however small the picture is shown.
#[derive(Debug, Clone, Serialize)]
pub struct Label {
    /// The position of its middle, as parts of width and height.
    at: [f32; 2],
    text: String,
}

impl Label {
    /// A word at a position of the image that is on a canvas.
    pub fn new(canvas: &Canvas, position: &Vector2<f64>, text: &str) -> Self {
        // Inside the picture; there is no telling how wide the word will be.
        let at = canvas.part(position).map(|part| part.clamp(0.05, 0.95));
        Self { at, text: text.into() }
    }
}

impl Picture {
    /// From its pixels; none where they cannot be encoded.
    pub fn new(pixels: &Image, labels: Vec<Label>) -> Option<Self> {
        let mut jpeg = Vec::new();
        pixels.write_jpeg(&mut jpeg, PICTURE_QUALITY).ok()?;
        Some(Self { jpeg, labels })
    }
}

/// What a page shows of a frame or cylinder beside its numbers.
#[derive(Debug, Clone, Default)]
pub struct Illustration {
    /// The picture, if there is one.
    pub picture: Option<Picture>,
    /// Where the points count from: they may lie far off.
    pub origin: [f64; 3],
    /// Points in the frame of reference, less the origin.
    pub points: Vec<[f32; 3]>,
}

impl Illustration {
    /// From a picture and points, of which about `most` are shown.
    pub fn new(picture: Option<Picture>, points: &[[f64; 3]], most: usize) -> Self {
        let finite = || points.iter().filter(|point| point.iter().all(|x| x.is_finite()));
        let origin = finite().next().copied().unwrap_or_default();
        let step = finite().count().div_ceil(most.max(1)).max(1);
        let near = |point: &[f64; 3]| std::array::from_fn(|k| (point[k] - origin[k]) as f32);
        let points = finite().step_by(step).map(near).collect();
        Self { picture, origin, points }
    }
}

fn in_base_64<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&super::base_64(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;
    use tiny_skia::Pixmap;

    #[test]
    fn points_are_few() {
        let points = vec![[1.0, 2.0, 3.0]; 5000];
        let most = POINTS_OF_CYLINDER;
        let shown = Illustration::new(None, &points, most).points;
        assert!(shown.len() <= most && shown.len() > most / 2);
    }

    #[test]
    fn a_picture_of_a_part_has_its_labels_where_they_belong() {
        let size = [640, 480];
        let image = Pixmap::new(640, 480).unwrap();
        // A small thing at the right border: the window is four to three and inside the image.
        let pixels = (0..100).map(|k| (620 + k % 20, 200 + k / 20));
        let window = Window::around(pixels, size);
        assert_eq!(window, Window { corner: [592, 184], size: [48, 36] });
        let canvas = Canvas::of_part(&image, window, PICTURE_WIDTH).unwrap();
        // The middle of the window; the middle of a pixel is its coordinate.
        let middle = Label::new(&canvas, &Vector2::new(615.5, 201.5), "seen");
        assert!(middle.at.iter().all(|part| (part - 0.5).abs() < 1e-5), "{middle:?}");
        assert_eq!(Label::new(&canvas, &Vector2::new(0.0, 0.0), "cut").at, [0.05, 0.05]);
        let picture = Picture::new(&canvas.into_image(), vec![middle]).unwrap();
        let shown = image::load_from_memory(&picture.jpeg).unwrap();
        assert_eq!((shown.width(), shown.height()), (480, 360));
        // All of the image around nothing; around more than it holds, too.
        assert_eq!(Window::around(std::iter::empty(), size), Window::of_image(size));
        assert_eq!(Window::around([(0, 0), (639, 479)].into_iter(), size), Window::of_image(size));
    }
}
