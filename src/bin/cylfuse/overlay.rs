//! The picture of a fit: the image with limb lines, ends, axis, given edges, completed surface, and the samples of limbs
//! and ends that were used and refused.

use crate::canvas::{Canvas, Color, LINE_HEIGHT, Pen, Window, text_width, tint};
use crate::ground;
use crate::images::Image;
use crate::page::{Label, Picture};
use crate::report::Measurement;
use cylfuse::camera::Camera;
use cylfuse::extent::ArcSample;
use cylfuse::fitter::Fitter;
use cylfuse::fitter::LimbSample;
use cylfuse::geometry::{Cylinder, LimbFrame, Line, any_orthogonal};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;
use tiny_skia::Pixmap;

// Colours that people with any colour vision can tell apart, in hue and in brightness.
const LIMBS: Color = [64, 224, 255, 255];
const EDGES: Color = [255, 150, 20, 255];
const ENDS: Color = [255, 240, 80, 255];
const AXIS: Color = [255, 255, 255, 220];
const SURFACE: Color = [40, 150, 255, 70];
const USED: Color = [120, 255, 120, 255];
const REFUSED: Color = [255, 70, 190, 255];
const END_SAMPLES: Color = [255, 255, 255, 255];
const PAPER: [u8; 3] = [235, 238, 242];
const GREY: [u8; 3] = [165, 172, 180];

const LIMB_PEN: Pen = Pen { color: LIMBS, width: 1.8, dash: None };
// Wide and below the limbs, which nearly cover it where the fit is good.
const EDGE_PEN: Pen = Pen { color: EDGES, width: 5.0, dash: None };
// Dashed and above the limbs, which nearly coincide with it where the fit is good.
const LOCATED_PEN: Pen = Pen { color: USED, width: 1.8, dash: Some([5.0, 7.0]) };
const END_PEN: Pen = Pen { color: ENDS, width: 2.0, dash: None };
const HIDDEN_END_PEN: Pen = Pen { color: [255, 240, 80, 150], width: 1.4, dash: Some([6.0, 5.0]) };
const AXIS_PEN: Pen = Pen { color: AXIS, width: 1.2, dash: Some([12.0, 6.0]) };

/// The picture is made about this wide, so that fractions of a pixel show.
const WIDTH: u32 = 1280;

/// Samples of a line of the cylinder: with distortion it is a curve in the image.
const LINE_SAMPLES: usize = 400;

/// Samples of a circle.
const CIRCLE_SAMPLES: usize = 720;

/// Without an extent the limbs are drawn this many times the distance of the axis to either side.
const ENDLESS: f64 = 3.0;

/// Radius of the dot of a sample of a limb.
const LIMB_SAMPLE: f32 = 2.4;

/// The same of an end, where the samples lie close together.
const END_SAMPLE: f32 = 1.4;

/// Distance of the middle of a label from the end that it names, on the canvas.
const LABEL_DISTANCE: f64 = 26.0;

/// What is drawn.
pub struct Overlay<'a> {
    /// The fit, with the view selected.
    pub fitter: &'a Fitter,
    /// The image, if there is one.
    pub image: Option<&'a Image>,
    /// The camera of the view.
    pub camera: &'a Camera,
    /// Extent and numbers of the fit.
    pub measurement: &'a Measurement,
    /// The positions of the ends in the image.
    pub arcs: &'a [Vec<ArcSample>; 2],
    /// The pixels (column, row) with completed points.
    pub completed: &'a [(u32, u32)],
}

impl Overlay<'_> {
    /// The picture; `None` where it would be too large.
    pub fn draw(&self) -> Option<Image> {
        let image = self.ground()?;
        let scale = ((WIDTH + image.width() / 2) / image.width()).clamp(1, 16);
        let caption = self.caption();
        let lines = layout(&caption, image.width() * scale);
        let band = (lines.len() as u32 + 1) * LINE_HEIGHT;
        let mut canvas = Canvas::new(&image, scale, band)?;
        let labels = self.draw_fit(&mut canvas);
        self.draw_samples(&mut canvas);
        for (at, state) in labels {
            label(&mut canvas, &at, state);
        }
        draw_caption(&mut canvas, &lines);
        Some(canvas.into_image())
    }

    /// The cylinder alone in a picture of some width, without any text, for a page that writes the text itself: its size does
    /// not shrink with the picture then. `None` where it cannot be drawn.
    pub fn illustrate(&self, width: u32) -> Option<Picture> {
        let image = self.ground()?;
        let window = Window::around(self.completed.iter().copied(), [image.width(), image.height()]);
        let mut canvas = Canvas::of_part(&image, window, width)?;
        let labels = self.draw_fit(&mut canvas);
        self.draw_samples(&mut canvas);
        let labels = labels.iter().map(|(at, state)| Label::new(&canvas, at, state)).collect();
        Picture::new(&canvas.into_image(), labels)
    }

    /// The image with the surface of the cylinder.
    fn ground(&self) -> Option<Pixmap> {
        let depth = self.fitter.depth();
        let mut image = ground::draw(self.image, self.camera.size(), |x, y| depth?.depth(x, y))?;
        for &pixel in self.completed {
            tint(&mut image, pixel, SURFACE);
        }
        Some(image)
    }

    /// Draws given edges and the fitted cylinder; returns what is to be written beside its ends, and where.
    fn draw_fit(&self, canvas: &mut Canvas) -> Vec<(Vector2<f64>, &'static str)> {
        for edge in self.fitter.segments() {
            canvas.polyline(edge.endpoints.iter().map(|&end| Some(end)), EDGE_PEN);
            for end in &edge.endpoints {
                canvas.dot(end, 4.5, EDGES);
            }
        }
        let Some(result) = self.fitter.result() else { return Vec::new() };
        let cylinder = self.fitter.pose().inverse().cylinder(&result.cylinder);
        self.draw_lines(&cylinder, canvas);
        self.draw_ends(&cylinder, canvas)
    }

    /// Limb lines and axis, between the ends where there are any.
    fn draw_lines(&self, cylinder: &Cylinder, canvas: &mut Canvas) {
        let axis = cylinder.axis;
        let [from, to] = self.ends().map_or_else(
            || [-1.0, 1.0].map(|side| axis.at(side * ENDLESS * axis.point.norm())),
            |ends| ends.map(|(center, _)| center),
        );
        let mut draw = |line: &Line, pen| {
            let (from, to) = (line.nearest_to(&from), line.nearest_to(&to));
            let sample = |k: usize| self.camera.project(&from.lerp(&to, k as f64 / LINE_SAMPLES as f64));
            canvas.polyline((0..=LINE_SAMPLES).map(sample), pen);
        };
        draw(&axis, AXIS_PEN);
        if let Some(limbs) = LimbFrame::new(cylinder) {
            for line in &limbs.limb_lines() {
                draw(line, LIMB_PEN);
            }
        }
    }

    /// The ends in the coordinates of the view, each with its state.
    fn ends(&self) -> Option<[(Vector3<f64>, &'static str); 2]> {
        let into_view = self.fitter.pose().inverse();
        let ends = self.measurement.extent.as_ref()?.ends();
        Some(ends.map(|(center, state)| (into_view.point(&center), state)))
    }

    /// The samples of limbs and ends, and the lines located through them.
    fn draw_samples(&self, canvas: &mut Canvas) {
        let camera = self.camera;
        let pixel = |ideal: &Vector2<f64>| camera.project(&camera.ideal_ray(ideal));
        for limb in self.fitter.limbs().into_iter().flatten() {
            if let (Ok(line), [first, .., last]) = (limb.line, &limb.samples[..]) {
                let along = (line.ends[1] - line.ends[0]).normalize();
                let foot =
                    |sample: &LimbSample| line.ends[0] + along * (sample.position - line.ends[0]).dot(&along);
                let (from, to) = (foot(first), foot(last));
                let sample = |k: usize| pixel(&from.lerp(&to, k as f64 / LINE_SAMPLES as f64));
                canvas.polyline((0..=LINE_SAMPLES).map(sample), LOCATED_PEN);
            }
            for sample in &limb.samples {
                let color = if limb.uses(sample) { USED } else { REFUSED };
                if let Some(at) = pixel(&sample.position) {
                    canvas.dot(&at, LIMB_SAMPLE, color);
                }
            }
        }
        for sample in self.arcs.iter().flatten() {
            canvas.dot(&sample.pixel, END_SAMPLE, END_SAMPLES);
        }
    }

    /// The circles at the ends, full where they are seen and dashed behind the cylinder; returns their states, and where they
    /// are to be written.
    fn draw_ends(&self, cylinder: &Cylinder, canvas: &mut Canvas) -> Vec<(Vector2<f64>, &'static str)> {
        let mut labels = Vec::new();
        let Some(ends) = self.ends() else { return labels };
        let direction = cylinder.axis.direction;
        let inside = cylinder.contains_origin();
        let (u, v) = any_orthogonal(&direction);
        for ((center, state), outward) in ends.into_iter().zip([-direction, direction]) {
            // A cap that faces the camera shows its whole circle, and so does a pipe from inside.
            let whole = inside || outward.dot(&center) < 0.0;
            let sample = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / CIRCLE_SAMPLES as f64).sin_cos();
                let across = u * cos + v * sin;
                let point = center + across * cylinder.radius;
                (self.camera.project(&point), whole || across.dot(&point) < 0.0)
            };
            let circle: Vec<_> = (0..=CIRCLE_SAMPLES).map(sample).collect();
            let part = |seen: bool| circle.iter().map(move |(at, near)| at.filter(|_| *near == seen));
            canvas.polyline(part(false), HIDDEN_END_PEN);
            canvas.polyline(part(true), END_PEN);
            let rim = circle.iter().filter_map(|(at, _)| at.as_ref());
            let pixels = canvas.length(LABEL_DISTANCE);
            let at = self.beside_end(&center, &(outward * cylinder.radius), rim, pixels);
            labels.extend(at.map(|at| (at, state)));
        }
        labels
    }

    /// The position some pixels beyond an end, in the direction of a step outward, where its label covers neither the end nor
    /// the cylinder.
    fn beside_end<'r>(
        &self,
        center: &Vector3<f64>,
        outward: &Vector3<f64>,
        rim: impl Iterator<Item = &'r Vector2<f64>>,
        pixels: f64,
    ) -> Option<Vector2<f64>> {
        let at = self.camera.project(center)?;
        let ahead = self.camera.project(&(center + outward * 0.1))?;
        let away = (ahead - at).try_normalize(1e-9)?;
        let reach = rim.map(|point| (point - at).dot(&away)).fold(0.0, f64::max);
        Some(at + away * (reach + pixels))
    }

    fn caption(&self) -> Vec<Item> {
        let Measurement { cylinder, extent, result, .. } = self.measurement;
        let mut items = Vec::new();
        if let Some(views) = &self.measurement.views {
            items.push(Item::Strong(format!("view {} of {}", self.fitter.selected_view(), views.len())));
        }
        items.push(Item::Strong(format!("radius {:.2} mm", cylinder.radius * 1000.0)));
        items.extend(extent.as_ref().map(|e| Item::Strong(format!("length {:.1} mm", e.length * 1000.0))));
        let points = format!("{} points, noise {:.2} mm", result.points_used, result.point_scale * 1000.0);
        items.push(Item::Plain(points));
        let edges =
            result.edge_rms_pixels.map(|rms| format!("{} edges, rms {rms:.2} px", result.segments_used));
        items.extend(edges.map(Item::Plain));
        items.push(Item::Break);
        items.push(Item::Line("fitted limbs", LIMB_PEN));
        items.push(Item::Line("fitted ends", END_PEN));
        items.push(Item::Line("axis", AXIS_PEN));
        if !self.fitter.segments().is_empty() {
            items.push(Item::Line("given edges", EDGE_PEN));
        }
        if !self.completed.is_empty() {
            items.push(Item::Area("completed surface", SURFACE));
        }
        items.push(Item::Break);
        if self.fitter.limbs().is_some() {
            items.push(Item::Line("located limbs", LOCATED_PEN));
            items.push(Item::Dots("limb samples used", LIMB_SAMPLE, USED));
            items.push(Item::Dots("refused", LIMB_SAMPLE, REFUSED));
        }
        if self.arcs.iter().any(|arc| !arc.is_empty()) {
            items.push(Item::Dots("end samples", END_SAMPLE, END_SAMPLES));
        }
        // A break with nothing behind it would be an empty line.
        if matches!(items.last(), Some(Item::Break)) {
            items.pop();
        }
        items
    }
}

/// Names the state of an end beside it, inside the image.
fn label(canvas: &mut Canvas, at: &Vector2<f64>, state: &str) {
    const PADDING: f32 = 4.0;
    let (width, height) = (text_width(state) as f32, 16.0);
    let (x, y) = canvas.point(at);
    let fit = |center: f32, size: f32, most: u32| {
        (center - 0.5 * size).min(most as f32 - size - 2.0 * PADDING).max(2.0 * PADDING).floor()
    };
    let (left, top) = (fit(x, width, canvas.width()), fit(y, height, canvas.image_height()));
    let size = (width + 2.0 * PADDING, height + PADDING);
    canvas.bar((left - PADDING, top - 0.5 * PADDING), size, [18, 20, 24, 190]);
    canvas.text((left as u32, top as u32), state, [ENDS[0], ENDS[1], ENDS[2]], false);
}

/// A part of the caption.
enum Item {
    Strong(String),
    Plain(String),
    Line(&'static str, Pen),
    Area(&'static str, Color),
    Dots(&'static str, f32, Color),
    Break,
}

/// Length of the sample beside a word of the legend.
const SAMPLE: u32 = 34;

/// Space between two parts of the caption, and at its borders.
const SPACE: u32 = 24;

impl Item {
    fn width(&self) -> u32 {
        match self {
            Item::Strong(text) | Item::Plain(text) => text_width(text),
            Item::Line(text, _) | Item::Area(text, _) | Item::Dots(text, ..) => SAMPLE + text_width(text),
            Item::Break => 0,
        }
    }
}

/// Breaks the caption into lines that fit the width.
fn layout(items: &[Item], width: u32) -> Vec<Vec<&Item>> {
    let mut lines: Vec<Vec<&Item>> = vec![Vec::new()];
    let mut x = SPACE;
    for item in items {
        let full = x > SPACE && x + item.width() + SPACE > width;
        if full || matches!(item, Item::Break) {
            lines.push(Vec::new());
            x = SPACE;
        }
        if let (Some(line), false) = (lines.last_mut(), matches!(item, Item::Break)) {
            line.push(item);
            x += item.width() + SPACE;
        }
    }
    lines
}

/// Draws the caption on its band, from which it removes what ran over the border of the image.
fn draw_caption(canvas: &mut Canvas, lines: &[Vec<&Item>]) {
    canvas.clear_band();
    for (index, line) in lines.iter().enumerate() {
        let y = canvas.image_height() + LINE_HEIGHT / 2 + index as u32 * LINE_HEIGHT + 5;
        let middle = y as f32 + 8.0;
        let mut x = SPACE;
        for item in line {
            let (left, right) = (x as f32, (x + SAMPLE - 10) as f32);
            match item {
                Item::Strong(text) => canvas.text((x, y), text, PAPER, true),
                Item::Plain(text) => canvas.text((x, y), text, GREY, false),
                Item::Line(text, pen) => {
                    canvas.line((left, middle), (right, middle), *pen);
                    canvas.text((x + SAMPLE, y), text, PAPER, false);
                }
                Item::Area(text, [r, g, b, _]) => {
                    canvas.bar((left, middle - 6.0), (right - left, 12.0), [*r, *g, *b, 200]);
                    canvas.text((x + SAMPLE, y), text, PAPER, false);
                }
                Item::Dots(text, radius, color) => {
                    for k in 0..3 {
                        canvas.mark((left + 4.0 + 8.0 * k as f32, middle), *radius, *color);
                    }
                    canvas.text((x + SAMPLE, y), text, PAPER, false);
                }
                Item::Break => {}
            }
            x += item.width() + SPACE;
        }
    }
}
