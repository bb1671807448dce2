//! Plots as SVG, each small enough for the width of a phone; what the colours mean stands beside them in the page.

use crate::failure::Failure;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use std::fmt::Display;

/// Width and height in pixels.
const SIZE: (u32, u32) = (400, 300);

/// Sizes of letters; the backend makes them smaller by a quarter.
const TEXT: u32 = 18;
const SMALL: u32 = 16;

/// Values of one kind.
pub struct Series {
    /// In the legend.
    pub name: String,
    /// Its colour.
    pub color: [u8; 3],
    /// Its values.
    pub marks: Vec<Mark>,
    /// Whether a line joins them.
    pub joined: bool,
}

/// A value with its spread; one that is not finite is left out.
#[derive(Debug, Clone, Copy)]
pub struct Mark {
    /// Along the horizontal axis.
    pub x: f64,
    /// Along the vertical axis.
    pub y: f64,
    /// Half the length of its bar, 0 for none.
    pub spread: f64,
}

/// What an axis shows.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The quantity with its unit.
    pub label: String,
    /// The range; found from the data where it is `None`.
    pub range: Option<[f64; 2]>,
    /// Whether steps are factors.
    pub logarithmic: bool,
    /// The most labels.
    pub labels: usize,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), range: None, logarithmic: false, labels: 7 }
    }

    /// An axis in factors.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { logarithmic: true, ..Self::linear(label) }
    }

    /// With a range.
    pub fn with_range(self, from: f64, to: f64) -> Self {
        Self { range: Some([from, to]), ..self }
    }
}

/// A plot.
pub struct Panel {
    /// Above it.
    pub title: String,
    /// Horizontal; always linear.
    pub x: Axis,
    /// Vertical.
    pub y: Axis,
    /// A dashed line across it, with its name in the legend of the page.
    pub level: Option<f64>,
    /// How far apart the marks of different series at one position are drawn.
    pub aside: f64,
}

impl Panel {
    /// The picture.
    ///
    /// # Errors
    /// `PLOT` with what went wrong.
    pub fn draw(&self, series: &[Series]) -> Result<String, Failure> {
        let [left, right] = self.x.range.unwrap_or_else(|| around(series, |mark| [mark.x, mark.x]));
        let [low, high] = self.y.range.unwrap_or_else(|| self.vertical_range(series));
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            root.fill(&WHITE).map_err(failed)?;
            if self.y.logarithmic {
                // A little below its decade, which would not be labelled otherwise.
                let low = 0.97 * low;
                self.fill(&root, left..right, (low..high).log_scale(), [low, high], series)?;
            } else {
                self.fill(&root, left..right, low..high, [low, high], series)?;
            }
            root.present().map_err(failed)?;
        }
        Ok(text)
    }

    fn fill<Y>(
        &self,
        root: &DrawingArea<SVGBackend<'_>, Shift>,
        x: std::ops::Range<f64>,
        y: impl plotters::coord::ranged1d::AsRangedCoord<CoordDescType = Y, Value = f64>,
        [low, high]: [f64; 2],
        series: &[Series],
    ) -> Result<(), Failure>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let (left, right) = (x.start, x.end);
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, ("sans-serif", TEXT))
            .margin(6)
            .margin_right(16)
            .x_label_area_size(46)
            .y_label_area_size(62)
            .build_cartesian_2d(x, y)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(222, 226, 230))
            .x_labels(self.x.labels)
            .y_labels(self.y.labels)
            .x_label_formatter(&|value| number(*value))
            .y_label_formatter(&|value| number(*value))
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .axis_desc_style(("sans-serif", TEXT))
            .label_style(("sans-serif", SMALL))
            .draw()
            .map_err(failed)?;
        if let Some(level) = self.level.filter(|level| (low..=high).contains(level)) {
            let line = [(left, level), (right, level)];
            chart.draw_series(DashedLineSeries::new(line, 6, 4, BLACK.into())).map_err(failed)?;
        }
        let middle = 0.5 * (series.len() as f64 - 1.0);
        for (index, series) in series.iter().enumerate() {
            let [red, green, blue] = series.color;
            let color = RGBColor(red, green, blue);
            let shift = (index as f64 - middle) * self.aside;
            let marks: Vec<Mark> = series
                .marks
                .iter()
                .filter(|mark| mark.y.is_finite())
                .map(|mark| Mark { x: mark.x + shift, ..*mark })
                .collect();
            let inside = |y: f64| y.clamp(low, high);
            let bars = marks.iter().filter(|mark| mark.spread > 0.0).map(|mark| {
                let [from, to] = [-1.0, 1.0].map(|side| inside(mark.y + side * mark.spread));
                ErrorBar::new_vertical(mark.x, from, inside(mark.y), to, color.stroke_width(1), 5)
            });
            chart.draw_series(bars).map_err(failed)?;
            if series.joined {
                let line = marks.iter().map(|mark| (mark.x, inside(mark.y)));
                chart
                    .draw_series(std::iter::once(PathElement::new(
                        line.collect::<Vec<_>>(),
                        color.stroke_width(2),
                    )))
                    .map_err(failed)?;
            }
            let dots = marks.iter().map(|mark| Circle::new((mark.x, inside(mark.y)), 3, color.filled()));
            chart.draw_series(dots).map_err(failed)?;
        }
        Ok(())
    }

    fn vertical_range(&self, series: &[Series]) -> [f64; 2] {
        let marks = || {
            let all = series.iter().flat_map(|series| &series.marks);
            all.filter(|mark| mark.y.is_finite() && (!self.y.logarithmic || mark.y > 0.0))
        };
        let highest = marks().map(|mark| mark.y + mark.spread).chain(self.level).fold(0.0, f64::max);
        if !self.y.logarithmic {
            return [0.0, if highest > 0.0 { 1.08 * highest } else { 1.0 }];
        }
        let lowest = marks().map(|mark| mark.y).chain(self.level).fold(f64::INFINITY, f64::min);
        if !(lowest > 0.0 && lowest.is_finite() && highest > 0.0) {
            return [0.1, 10.0];
        }
        [10_f64.powf(lowest.log10().floor()), 10_f64.powf(highest.log10().ceil())]
    }
}

/// Points across an axis: what was measured, what the fit completes, and the true circle, all in millimetres from the
/// true axis.
///
/// # Errors
/// `PLOT` with what went wrong.
pub fn cross_section(
    title: &str,
    reach: f64,
    truth: f64,
    layers: &[([u8; 3], Vec<[f64; 2]>)],
) -> Result<String, Failure> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (360, 373)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(title, ("sans-serif", TEXT))
            .margin(6)
            .margin_right(14)
            .x_label_area_size(44)
            .y_label_area_size(56)
            .build_cartesian_2d(-reach..reach, -reach..reach)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(222, 226, 230))
            .x_labels(5)
            .y_labels(5)
            .x_label_formatter(&|value| number(*value))
            .y_label_formatter(&|value| number(*value))
            .x_desc("across the line of sight (mm)")
            .y_desc("away from the camera (mm)")
            .axis_desc_style(("sans-serif", SMALL))
            .label_style(("sans-serif", SMALL))
            .draw()
            .map_err(failed)?;
        for ([red, green, blue], points) in layers {
            let color = RGBColor(*red, *green, *blue).filled();
            let inside = points.iter().filter(|point| point.iter().all(|x| x.abs() <= reach));
            chart.draw_series(inside.map(|[x, y]| Circle::new((*x, *y), 1, color))).map_err(failed)?;
        }
        let circle = (0..=90).map(|k| f64::from(k) * 4.0_f64.to_radians());
        let circle = circle.map(|angle| (truth * angle.cos(), truth * angle.sin()));
        chart.draw_series(DashedLineSeries::new(circle, 5, 3, BLACK.into())).map_err(failed)?;
        root.present().map_err(failed)?;
    }
    Ok(text)
}

/// The range of values, a little widened.
fn around(series: &[Series], of: impl Fn(&Mark) -> [f64; 2]) -> [f64; 2] {
    let values = || series.iter().flat_map(|series| &series.marks).flat_map(&of);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    if !(low.is_finite() && high.is_finite()) {
        return [0.0, 1.0];
    }
    let margin = if high > low { 0.06 * (high - low) } else { 1.0 };
    [low - margin, high + margin]
}

/// A label without digits that say nothing.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

fn failed(error: impl Display) -> Failure {
    Failure { status: "PLOT", message: format!("a plot cannot be drawn: {error}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short() {
        assert_eq!([0.5, 10.0, 0.001, -0.0001, 100.0].map(number), ["0.5", "10", "0.001", "0", "100"]);
    }

    #[test]
    fn both_ends_of_an_axis_in_factors_are_labelled() {
        let marks = vec![Mark { x: 1.0, y: 0.2, spread: 0.0 }, Mark { x: 2.0, y: 0.9, spread: 0.0 }];
        let series = [Series { name: "a".into(), color: [1, 2, 3], marks, joined: false }];
        let y = Axis::logarithmic("y");
        let panel = Panel {
            title: "t".into(),
            x: Axis::linear("x").with_range(3.0, 9.0),
            y,
            level: None,
            aside: 0.0,
        };
        let text = panel.draw(&series).unwrap();
        let words: Vec<&str> = text.lines().map(str::trim).collect();
        assert!(words.contains(&"0.1") && words.contains(&"1"), "{text}");
    }

    #[test]
    fn marks_without_a_value_are_left_out() {
        let marks = [1.0, f64::NAN, 3.0].map(|y| Mark { x: y, y, spread: 0.0 });
        let marks = vec![marks[0], Mark { x: 2.0, ..marks[1] }, marks[2]];
        let series = [Series { name: "a".into(), color: [1, 2, 3], marks, joined: false }];
        for y in [Axis::linear("y"), Axis::logarithmic("y")] {
            let panel = Panel { title: "t".into(), x: Axis::linear("x"), y, level: None, aside: 0.0 };
            let text = panel.draw(&series).unwrap();
            assert_eq!(text.matches("<circle").count(), 2, "{text}");
            assert!(!text.contains("NaN"));
        }
    }
}
