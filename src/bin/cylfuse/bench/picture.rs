//! Pictures of fits over the image, as SVG.

use super::page::{data, escaped};
use super::sample::View;
use crate::failure::Failure;
use crate::images::{Image, Pixels};
use cylfuse::camera::Camera;
use cylfuse::geometry::{Cylinder, LimbFrame, any_orthogonal};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Pixels of the image around what is shown.
const MARGIN: usize = 26;

/// The most pixels that are shown: lines on more are too fine for a phone.
const MOST: usize = 200;

/// A finite cylinder as it is drawn.
pub struct Outline {
    /// Axis and radius.
    pub cylinder: Cylinder,
    /// The middles of its ends.
    pub ends: [Vector3<f64>; 2],
    /// Its colour.
    pub color: [u8; 3],
    /// Whether its lines are dashed.
    pub dashed: bool,
}

impl Outline {
    /// Limbs and end circles in pixels.
    fn lines(&self, camera: &Camera) -> Vec<Vec<[f64; 2]>> {
        let project = |point: Vector3<f64>| camera.project(&point).map(|pixel| [pixel.x, pixel.y]);
        let mut lines = Vec::new();
        if let Some(limbs) = LimbFrame::new(&self.cylinder) {
            for limb in limbs.limb_lines() {
                let [from, to] = self.ends.map(|end| limb.nearest_to(&end));
                lines.push((0..=20).filter_map(|k| project(from.lerp(&to, f64::from(k) / 20.0))).collect());
            }
        }
        let (u, v) = any_orthogonal(&self.cylinder.axis.direction);
        for end in self.ends {
            let point = |k: i32| {
                let (sine, cosine) = (TAU * f64::from(k) / 60.0).sin_cos();
                project(end + (u * cosine + v * sine) * self.cylinder.radius)
            };
            lines.push((0..=60).filter_map(point).collect());
        }
        lines
    }
}

/// The part of an image around its mask with cylinders over it, as a figure with a caption.
///
/// # Errors
/// `PLOT` where the image cannot be encoded.
pub fn over_image(view: &View, outlines: &[Outline], caption: &str) -> Result<String, Failure> {
    let (width, height) = view.camera.size();
    let inside: Vec<usize> = match &view.mask {
        Some(mask) => (0..mask.len()).filter(|k| mask[*k] > 0).collect(),
        None => (0..width * height).collect(),
    };
    let range = |of: &dyn Fn(usize) -> usize, most: usize| {
        let (low, high) =
            inside.iter().map(|k| of(*k)).fold((most, 0), |(low, high), x| (low.min(x), high.max(x)));
        let (low, high) = (low.saturating_sub(MARGIN), (high + MARGIN + 1).min(most));
        let beyond = high.saturating_sub(low).saturating_sub(MOST);
        (low + beyond / 2, high - (beyond - beyond / 2))
    };
    let (left, right) = range(&|k| k % width, width);
    let (top, bottom) = range(&|k| k / width, height);
    let size = [right.saturating_sub(left), bottom.saturating_sub(top)];
    let rows = (top..bottom).flat_map(|y| &view.image[y * width + left..y * width + right]);
    let shown = Image::new(size.into(), Pixels::Grey8(rows.copied().collect()));
    let mut png = Vec::new();
    shown.write_png(&mut png).map_err(|error| Failure {
        status: "PLOT",
        message: format!("a picture cannot be encoded: {error}"),
    })?;
    let mut svg = format!(
        "<figure><svg viewBox=\"0 0 {0} {1}\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"><image width=\"{0}\" height=\"{1}\" href=\"{2}\"/>",
        size[0],
        size[1],
        data("image/png", &png)
    );
    for outline in outlines {
        let [red, green, blue] = outline.color;
        let dashes = if outline.dashed { " stroke-dasharray=\"3 2\"" } else { "" };
        for line in outline.lines(&view.camera) {
            let _ = write!(
                svg,
                "<polyline fill=\"none\" stroke=\"rgb({red},{green},{blue})\" stroke-width=\"0.8\"{dashes} points=\""
            );
            for [x, y] in line {
                // The middle of a pixel is its coordinate.
                let _ = write!(svg, "{:.2},{:.2} ", x + 0.5 - left as f64, y + 0.5 - top as f64);
            }
            svg.push_str("\"/>");
        }
    }
    let _ = write!(svg, "</svg><figcaption>{}</figcaption></figure>", escaped(caption));
    Ok(svg)
}
