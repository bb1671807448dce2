//! The picture of a scene: every cylinder in its colour, with its number.

use crate::canvas::{Canvas, LINE_HEIGHT, Window, color_of, tint};
use crate::detect::Found;
use crate::failure::Failure;
use crate::fit::write_file;
use crate::frame::View;
use crate::ground;
use crate::images::Image;
use crate::page::{Label, Picture};
use cylfuse::observations::DepthImage;
use nalgebra::Vector2;
use std::path::Path;
use tiny_skia::Pixmap;

/// How much of the image a cylinder covers, of 255.
const OPACITY: u8 = 130;

/// What is drawn.
pub struct ScenePicture<'a> {
    /// The view.
    pub view: &'a View,
    /// The depth on the grid of the image.
    pub depth: &'a DepthImage,
    /// The number of the cylinder of each pixel, 0 for none.
    pub labels: &'a [u16],
    /// The cylinders.
    pub cylinders: &'a [Found],
}

impl ScenePicture<'_> {
    /// Draws the picture into a PNG file.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let picture = self.draw().ok_or_else(|| Failure::not_writable(path, "the picture is too large"))?;
        write_file(path, |to| picture.write_png(to))
    }

    /// The image with the regions of the cylinders, and the middle of each region, for its number.
    fn ground(&self) -> Option<(Pixmap, Vec<Option<Vector2<f64>>>)> {
        let depth = |x, y| self.depth.depth(x, y);
        let mut image = ground::draw(self.view.image.as_ref(), self.view.size(), depth)?;
        let width = image.width();
        let mut sums = vec![[0.0; 3]; self.cylinders.len()];
        for (k, &label) in self.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
            let (x, y) = (k as u32 % width, k as u32 / width);
            let index = usize::from(label) - 1;
            let [r, g, b] = color_of(index);
            tint(&mut image, (x, y), [r, g, b, OPACITY]);
            let sum = &mut sums[index];
            *sum = [sum[0] + f64::from(x), sum[1] + f64::from(y), sum[2] + 1.0];
        }
        let middle = |[x, y, n]: [f64; 3]| (n > 0.0).then(|| Vector2::new(x / n, y / n));
        Some((image, sums.into_iter().map(middle).collect()))
    }

    /// The picture in some width without any text, for a page that writes the numbers itself. `None` where it cannot be drawn.
    pub fn illustrate(&self, width: u32) -> Option<Picture> {
        let (image, middles) = self.ground()?;
        let window = Window::of_image([image.width(), image.height()]);
        let canvas = Canvas::of_part(&image, window, width)?;
        let label = |(index, middle): (usize, Option<Vector2<f64>>)| {
            Some(Label::new(&canvas, &middle?, &(index + 1).to_string()))
        };
        let labels = middles.into_iter().enumerate().filter_map(label).collect();
        Picture::new(&canvas.into_image(), labels)
    }

    /// The picture; `None` where it would be too large.
    pub fn draw(&self) -> Option<Image> {
        let (image, middles) = self.ground()?;
        let width = image.width();
        let scale = ((1280 + width / 2) / width).clamp(1, 16);
        let mut canvas = Canvas::new(&image, scale, (self.cylinders.len() as u32 + 1) * LINE_HEIGHT)?;
        let top = canvas.image_height() + LINE_HEIGHT / 2;
        for (index, (found, middle)) in self.cylinders.iter().zip(middles).enumerate() {
            let number = (index + 1).to_string();
            if let Some(middle) = middle {
                let (x, y) = canvas.point(&middle);
                canvas.bar((x - 2.0, y - 10.0), (12.0 * number.len() as f32, 20.0), [0, 0, 0, 170]);
                canvas.text((x as u32, (y - 9.0).max(0.0) as u32), &number, [255; 3], true);
            }
            let text = format!(
                "{number}  radius {:.2} mm, score {:.2}, {} pixels",
                1e3 * found.measurement.cylinder.radius,
                found.score,
                found.pixels
            );
            canvas.text((16, top + index as u32 * LINE_HEIGHT), &text, color_of(index), false);
        }
        Some(canvas.into_image())
    }
}
