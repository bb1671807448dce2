//! Drawing on an enlarged image: lines between pixel positions, text, bars.

use crate::images::{Image, Pixels};
use nalgebra::Vector2;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use std::borrow::Cow;
use tiny_skia::{
    ColorU8, FillRule, FilterQuality, LineCap, LineJoin, Paint, Path, PathBuilder, Pattern, Pixmap,
    PremultipliedColorU8, Rect, SpreadMode, Stroke, StrokeDash, Transform,
};

/// Red, green, blue, opacity.
pub type Color = [u8; 4];

/// Colours that neighbours in a list can be told by.
const OF_CYLINDERS: [[u8; 3]; 8] = [
    [230, 60, 60],
    [60, 180, 75],
    [70, 110, 255],
    [255, 200, 30],
    [200, 80, 230],
    [40, 210, 220],
    [245, 130, 48],
    [190, 240, 90],
];

/// The colour of a cylinder of a scene, counted from 0. They come again after the last.
pub fn color_of(index: usize) -> [u8; 3] {
    OF_CYLINDERS[index % OF_CYLINDERS.len()]
}

/// Behind every line, so that it shows on bright ground too.
const HALO: Color = [0, 0, 0, 110];

/// The ground of the caption.
const BAND: Color = [18, 20, 24, 255];

/// Height of the text.
const TEXT: RasterHeight = RasterHeight::Size16;

/// Height of a line of text with its spacing.
pub const LINE_HEIGHT: u32 = 26;

/// How a line looks.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    /// Its colour.
    pub color: Color,
    /// Its width on the canvas.
    pub width: f32,
    /// Lengths of dashes and gaps; none for a full line.
    pub dash: Option<[f32; 2]>,
}

/// The image or a part of it, enlarged so that fractions of its pixels show, above a band for the caption.
pub struct Canvas {
    pixels: Pixmap,
    /// Canvas pixels in a pixel of the image.
    scale: f64,
    /// The upper left corner of what is shown of the image.
    corner: Vector2<f64>,
    image_height: u32,
}

/// A rectangle of pixels of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Column and row of the upper left pixel.
    pub corner: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

/// The window of a picture of one thing is at least so wide, in pixels of the image.
const LEAST_WIDTH: f64 = 48.0;

/// Its margin on each side, as a part of the thing.
const MARGIN: f64 = 0.2;

impl Window {
    /// All of an image.
    pub fn of_image(size: [u32; 2]) -> Self {
        Self { corner: [0, 0], size }
    }

    /// Around some pixels (column, row), four to three where the image has room for that; all of the image around none.
    pub fn around(pixels: impl Iterator<Item = (u32, u32)>, size: [u32; 2]) -> Self {
        let nothing = ([u32::MAX; 2], [0; 2]);
        let (low, high) = pixels.fold(nothing, |(low, high), (x, y)| {
            ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)])
        });
        if low[0] > high[0] {
            return Self::of_image(size);
        }
        let wide = |k: usize| f64::from(high[k] - low[k] + 1) * (1.0 + 2.0 * MARGIN);
        let width = wide(0).max(wide(1) * 4.0 / 3.0).max(LEAST_WIDTH);
        let mut window = Self::of_image(size);
        for (k, wanted) in [width, 0.75 * width].into_iter().enumerate() {
            window.size[k] = (wanted.round() as u32).clamp(1, size[k]);
            let middle = low[k].midpoint(high[k]);
            window.corner[k] = middle.saturating_sub(window.size[k] / 2).min(size[k] - window.size[k]);
        }
        window
    }
}

impl Canvas {
    /// Puts an image, `scale` times enlarged, on a canvas with a band of the given height below. `None` for
    /// sizes that cannot be drawn.
    pub fn new(image: &Pixmap, scale: u32, band: u32) -> Option<Self> {
        let (width, height) = (image.width().checked_mul(scale)?, image.height().checked_mul(scale)?);
        let mut pixels = Pixmap::new(width, height.checked_add(band)?)?;
        put(&mut pixels, height, image, Transform::from_scale(scale as f32, scale as f32));
        Some(Self { pixels, scale: f64::from(scale), corner: Vector2::zeros(), image_height: height })
    }

    /// A part of an image, made as wide as is asked for, without a band. `None` for sizes that cannot be drawn.
    pub fn of_part(image: &Pixmap, window: Window, width: u32) -> Option<Self> {
        let [[left, top], [columns, rows]] = [window.corner, window.size];
        let scale = f64::from(width) / f64::from(columns);
        let height = ((f64::from(rows) * scale).round() as u32).max(1);
        // Between four pixels nothing is seen of those that a larger step leaves out: they are put together before.
        let mut image = Cow::Borrowed(image);
        let mut step = 1.0 / scale;
        while step > 2.0 {
            let mut half = Pixmap::new(image.width().div_ceil(2), image.height().div_ceil(2))?;
            let height = half.height();
            put(&mut half, height, &image, Transform::from_scale(0.5, 0.5));
            image = Cow::Owned(half);
            step /= 2.0;
        }
        let mut pixels = Pixmap::new(width, height)?;
        let (x, y) = (-f64::from(left) * scale, -f64::from(top) * scale);
        let enlarge = (1.0 / step) as f32;
        put(&mut pixels, height, &image, Transform::from_row(enlarge, 0.0, 0.0, enlarge, x as f32, y as f32));
        let corner = Vector2::new(f64::from(left), f64::from(top));
        Some(Self { pixels, scale, corner, image_height: height })
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.pixels.width()
    }

    /// Where the band starts.
    pub fn image_height(&self) -> u32 {
        self.image_height
    }

    /// Where a pixel position of the image lies on the canvas: pixel centres are at whole numbers in the
    /// image and at halves here.
    pub fn point(&self, position: &Vector2<f64>) -> (f32, f32) {
        let point = (position - self.corner).add_scalar(0.5) * self.scale;
        (point.x as f32, point.y as f32)
    }

    /// So many pixels of the canvas in pixels of the image.
    pub fn length(&self, pixels: f64) -> f64 {
        pixels / self.scale
    }

    /// Where a position of the image lies, as parts of width and height of the part that is shown.
    pub fn part(&self, position: &Vector2<f64>) -> [f32; 2] {
        let (x, y) = self.point(position);
        [x / self.width() as f32, y / self.image_height as f32]
    }

    /// A line through positions in the image; it breaks where there is none.
    pub fn polyline(&mut self, positions: impl Iterator<Item = Option<Vector2<f64>>>, pen: Pen) {
        let mut path = PathBuilder::new();
        let mut broken = true;
        for position in positions {
            // Far outside there is nothing to see, and single precision runs out.
            let point = position.map(|p| self.point(&p)).filter(|(x, y)| x.abs() < 1e5 && y.abs() < 1e5);
            match point {
                Some((x, y)) if broken => path.move_to(x, y),
                Some((x, y)) => path.line_to(x, y),
                None => {}
            }
            broken = point.is_none();
        }
        if let Some(path) = path.finish() {
            self.stroke(&path, Pen { color: HALO, width: pen.width + 2.0, ..pen });
            self.stroke(&path, pen);
        }
    }

    /// A filled dot at a position in the image.
    pub fn dot(&mut self, position: &Vector2<f64>, radius: f32, color: Color) {
        self.mark(self.point(position), radius, color);
    }

    /// A filled dot at a position of the canvas.
    pub fn mark(&mut self, (x, y): (f32, f32), radius: f32, color: Color) {
        for (radius, color) in [(radius + 1.0, HALO), (radius, color)] {
            if let Some(path) = PathBuilder::from_circle(x, y, radius) {
                self.pixels.fill_path(&path, &paint(color), FillRule::Winding, Transform::identity(), None);
            }
        }
    }

    /// A line between two positions of the canvas.
    pub fn line(&mut self, (x0, y0): (f32, f32), (x1, y1): (f32, f32), pen: Pen) {
        let mut path = PathBuilder::new();
        path.move_to(x0, y0);
        path.line_to(x1, y1);
        if let Some(path) = path.finish() {
            self.stroke(&path, pen);
        }
    }

    /// A filled rectangle of the canvas.
    pub fn bar(&mut self, (x, y): (f32, f32), (width, height): (f32, f32), color: Color) {
        if let Some(rect) = Rect::from_xywh(x, y, width, height) {
            self.pixels.fill_rect(rect, &paint(color), Transform::identity(), None);
        }
    }

    /// Makes the band empty.
    pub fn clear_band(&mut self) {
        let top = self.image_height;
        let size = (self.width() as f32, (self.pixels.height() - top) as f32);
        self.bar((0.0, top as f32), size, BAND);
    }

    /// Text with its upper left corner at a position of the canvas; what does not fit is cut off.
    pub fn text(&mut self, (x, y): (u32, u32), text: &str, color: [u8; 3], bold: bool) {
        let weight = if bold { FontWeight::Bold } else { FontWeight::Regular };
        let (width, height) = (self.pixels.width(), self.pixels.height());
        for (index, character) in text.chars().enumerate() {
            let Some(glyph) = get_raster(character, weight, TEXT).or(get_raster('?', weight, TEXT)) else {
                continue;
            };
            let left = x + index as u32 * glyph.width() as u32;
            for (row, line) in (y..height).zip(glyph.rows()) {
                for (column, &ink) in (left..width).zip(line) {
                    tint(&mut self.pixels, (column, row), [color[0], color[1], color[2], ink]);
                }
            }
        }
    }

    /// The picture.
    pub fn into_image(self) -> Image {
        let bytes = self.pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
        Image { size: (self.pixels.width(), self.pixels.height()), pixels: Pixels::Rgb8(bytes) }
    }

    fn stroke(&mut self, path: &Path, pen: Pen) {
        let stroke = Stroke {
            width: pen.width,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash: pen.dash.and_then(|dash| StrokeDash::new(dash.to_vec(), 0.0)),
            ..Stroke::default()
        };
        self.pixels.stroke_path(path, &paint(pen.color), &stroke, Transform::identity(), None);
    }
}

/// Width of a text on the canvas.
pub fn text_width(text: &str) -> u32 {
    (text.chars().count() * get_raster_width(FontWeight::Regular, TEXT)) as u32
}

/// Fills the upper rows of a canvas with an image.
fn put(canvas: &mut Pixmap, rows: u32, image: &Pixmap, to: Transform) {
    let quality = match to.sx {
        1.0 => FilterQuality::Nearest,
        ..1.0 => FilterQuality::Bilinear,
        _ => FilterQuality::Bicubic,
    };
    // Rounded sizes may end outside the image: its border goes on there.
    let shader = Pattern::new(image.as_ref(), SpreadMode::Pad, quality, 1.0, to);
    if let Some(rect) = Rect::from_xywh(0.0, 0.0, canvas.width() as f32, rows as f32) {
        canvas.fill_rect(rect, &Paint { shader, ..Paint::default() }, Transform::identity(), None);
    }
}

fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    let [r, g, b, a] = color;
    paint.set_color_rgba8(r, g, b, a);
    paint
}

/// Mixes a colour into a pixel of an image.
pub fn tint(image: &mut Pixmap, (column, row): (u32, u32), [r, g, b, opacity]: Color) {
    let at = (row * image.width() + column) as usize;
    let pixel = &mut image.pixels_mut()[at];
    let mix = |below: u8, above: u8| {
        let (below, above, part) = (u32::from(below), u32::from(above), u32::from(opacity));
        ((below * (255 - part) + above * part) / 255) as u8
    };
    *pixel = opaque([mix(pixel.red(), r), mix(pixel.green(), g), mix(pixel.blue(), b)]);
}

/// A pixel of an image.
pub fn opaque([r, g, b]: [u8; 3]) -> PremultipliedColorU8 {
    ColorU8::from_rgba(r, g, b, 255).premultiply()
}
