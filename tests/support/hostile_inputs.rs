//! Frames of 640 × 480 pixels that show no cylinder, or far too many, and take a fit or a search as long as any that were
//! thought of. The same at every run.
// This is test code wherever it is included.
#![allow(clippy::unwrap_used)]

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::fitter::Fitter;
use cylfuse::observations::{DepthRange, DepthView, EdgeSegment, Frame, ImageView, MaskView};
use nalgebra::{Vector2, Vector3};

pub const SIZE: (usize, usize) = (640, 480);
const FOCAL: f64 = 525.0;

/// A frame.
pub struct Hostile {
    pub name: String,
    pub depth: Vec<f32>,
    pub mask: Vec<u8>,
    pub image: Option<Vec<u8>>,
    pub segments: Vec<EdgeSegment>,
}

/// Numbers that look random.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let z = (self.0 ^ (self.0 >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Depth by column and row.
fn depth(mut at: impl FnMut(f64, f64) -> f64) -> Vec<f32> {
    let (width, height) = SIZE;
    (0..width * height).map(|k| at((k % width) as f64, (k / width) as f64) as f32).collect()
}

fn grey(mut at: impl FnMut(f64, f64) -> f64) -> Vec<u8> {
    depth(&mut at).into_iter().map(|value| value.clamp(0.0, 255.0) as u8).collect()
}

/// A surface of half cylinders side by side, `period` pixels wide and `long` pixels long, turned by an angle.
fn half_cylinders(x: f64, y: f64, period: f64, long: f64, angle: f64) -> f64 {
    let (u, v) = (x * angle.cos() + y * angle.sin(), y * angle.cos() - x * angle.sin());
    let across = 2.0 * (u / period).rem_euclid(1.0) - 1.0;
    let gap = (v / long).rem_euclid(1.0) > 0.9 || across.abs() > 0.9;
    let radius = 0.5 * period / FOCAL;
    if gap { 1.5 } else { 1.0 - radius * (1.0 - (across / 0.9).powi(2)).max(0.0).sqrt() }
}

/// Smooth noise: bumps of several sizes at random places.
fn hills(dice: &mut Dice, count: usize) -> Vec<[f64; 4]> {
    let mut hill =
        || [dice.unit() * 640.0, dice.unit() * 480.0, 5.0 + 60.0 * dice.unit().powi(3), dice.unit() - 0.5];
    (0..count).map(|_| hill()).collect()
}

fn stripes(x: f64, y: f64, period: f64, angle: f64) -> f64 {
    let across = (x * angle.cos() + y * angle.sin()) / period;
    if across.rem_euclid(1.0) < 0.5 { 60.0 } else { 190.0 }
}

/// All frames.
pub fn hostile() -> Vec<Hostile> {
    let mut all = Vec::new();
    let mut add = |name: &str, depth: Vec<f32>, image: Option<Vec<u8>>| {
        let mask = vec![1; SIZE.0 * SIZE.1];
        all.push(Hostile { name: name.to_string(), depth, mask, image, segments: Vec::new() });
    };
    for period in [12.0, 25.0, 50.0, 100.0, 200.0] {
        let angle = |x: f64| x * std::f64::consts::TAU / period;
        let bumps = depth(|x, y| 1.0 + 0.1 * period / FOCAL * angle(x).sin() * angle(y).sin());
        add(&format!("bumps every {period} pixels"), bumps, None);
    }
    let noise = |seed: u64, part: f64| {
        let mut dice = Dice(seed);
        depth(|_, _| 1.0 + part * (dice.unit() - 0.5))
    };
    for (seed, part) in [(1, 1.8), (2, 0.1), (3, 0.01), (4, 0.001)] {
        add(&format!("noise of {part}"), noise(seed, part), None);
    }
    for (seed, count) in [(5, 100), (6, 1000)] {
        let hills = hills(&mut Dice(seed), count);
        let height = |x: f64, y: f64| {
            let of = |[u, v, size, height]: &[f64; 4]| {
                let square = ((x - u).powi(2) + (y - v).powi(2)) / size.powi(2);
                if square < 9.0 { height * size / FOCAL * (-square).exp() } else { 0.0 }
            };
            hills.iter().map(of).sum::<f64>()
        };
        add(&format!("{count} hills"), depth(|x, y| 1.0 + height(x, y)), None);
    }
    let mut dice = Dice(7);
    let blocks: Vec<f64> = (0..40 * 30).map(|_| 0.8 + dice.unit()).collect();
    add("blocks", depth(|x, y| blocks[(y as usize / 16) * 40 + x as usize / 16]), None);
    let waves = |period: f64, height: f64| {
        depth(move |x, _| 1.0 + height * (x * std::f64::consts::TAU / period).sin())
    };
    add("waves of 60 pixels", waves(60.0, 0.02), None);
    add("saddle", depth(|x, y| 1.0 + 0.3 * ((x / 320.0 - 1.0).powi(2) - (y / 240.0 - 1.0).powi(2))), None);
    let huge = || depth(|x, _| 3.0 - (2.25 - ((x - 320.0) / FOCAL).powi(2)).sqrt());
    add("huge cylinder", huge(), None);
    let mut dice = Dice(8);
    let random = grey(|_, _| 255.0 * dice.unit());
    let squares = |period: f64| {
        let half_turn = std::f64::consts::FRAC_PI_2;
        grey(|x, y| (stripes(x, y, period, 0.0) - stripes(x, y, period, half_turn)).abs() + 60.0)
    };
    let pictures: [(&str, Vec<u8>); 6] = [
        ("stripes of 20 pixels", grey(|x, y| stripes(x, y, 20.0, 0.0))),
        ("stripes of 36 pixels aslant", grey(|x, y| stripes(x, y, 36.0, 0.3))),
        ("squares of 12 pixels", squares(24.0)),
        ("squares of 16 pixels", squares(32.0)),
        ("rays", grey(|x, y| 127.0 + 120.0 * (60.0 * (y - 240.0).atan2(x - 320.0)).sin().signum())),
        ("noise", random),
    ];
    for (name, picture) in pictures {
        add(&format!("huge cylinder, image of {name}"), huge(), Some(picture.clone()));
        let bumps = depth(|x, y| 1.0 + 0.01 * (x / 8.0).sin() * (y / 8.0).sin());
        add(&format!("bumps every 50 pixels, image of {name}"), bumps, Some(picture));
    }
    for (period, long, angle) in
        [(24.0, 60.0, 0.0), (40.0, 120.0, 0.5), (40.0, 1e9, 0.0), (80.0, 200.0, 1.0), (16.0, 1e9, 0.2)]
    {
        let surface = depth(|x, y| half_cylinders(x, y, period, long, angle));
        let picture: Vec<u8> = surface.iter().map(|z| ((1.6 - z) * 300.0) as u8).collect();
        let name = format!("half cylinders {period} wide and {long} long");
        add(&name, surface.clone(), None);
        add(&format!("{name}, with an image"), surface, Some(picture));
    }
    // The same noise below masks and segments that are hostile themselves.
    let mut dice = Dice(9);
    let surface = depth(|x, y| half_cylinders(x, y, 200.0, 1e9, 0.2));
    let picture: Vec<u8> = surface.iter().map(|z| ((1.6 - z) * 300.0) as u8).collect();
    let mut with_mask = |name: &str, mask: Vec<u8>, segments: Vec<EdgeSegment>| {
        let (depth, image) = (surface.clone(), Some(picture.clone()));
        all.push(Hostile { name: name.to_string(), depth, mask, image, segments });
    };
    with_mask("mask of noise", (0..SIZE.0 * SIZE.1).map(|_| u8::from(dice.unit() < 0.5)).collect(), vec![]);
    with_mask("mask of stripes", grey(|x, y| stripes(x, y, 4.0, 0.4) - 60.0), vec![]);
    let mut segment = || {
        let mut end = || Vector2::new(dice.unit() * 639.0, dice.unit() * 479.0);
        EdgeSegment { endpoints: [end(), end()], weight: 1.0 }
    };
    let segments = (0..1000).map(|_| segment()).collect();
    with_mask("1000 segments", vec![1; SIZE.0 * SIZE.1], segments);
    all
}

impl Hostile {
    fn intrinsics() -> Intrinsics {
        Intrinsics {
            width: SIZE.0 as u32,
            height: SIZE.1 as u32,
            fx: FOCAL,
            fy: FOCAL,
            cx: 319.5,
            cy: 239.5,
            distortion: Distortion::None,
        }
    }

    /// A fitter with all of it.
    pub fn fitter(&self) -> Fitter {
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(Self::intrinsics()).unwrap();
        let mask = MaskView::from_u8(&self.mask, SIZE).unwrap();
        let depth = DepthView::from_f32(&self.depth, SIZE, 1.0).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        if let Some(image) = &self.image {
            fitter.push_image(&ImageView::from_u8(image, SIZE).unwrap()).unwrap();
        }
        if !self.segments.is_empty() {
            fitter.push_edges(&self.segments).unwrap();
        }
        fitter
    }

    /// A frame with depth and image.
    pub fn frame(&self) -> Frame {
        let mut frame = Frame::new(Camera::new(Self::intrinsics()).unwrap());
        frame
            .set_depth(&DepthView::from_f32(&self.depth, SIZE, 1.0).unwrap(), &DepthRange::default())
            .unwrap();
        if let Some(image) = &self.image {
            frame.set_image(&ImageView::from_u8(image, SIZE).unwrap()).unwrap();
        }
        frame
    }

    /// The depth as a cloud.
    #[allow(dead_code, reason = "the example asks for it")]
    pub fn points(&self) -> Vec<[f64; 3]> {
        let camera = Camera::new(Self::intrinsics()).unwrap();
        let point = |k: usize| {
            let ray = camera.unproject(&Vector2::new((k % SIZE.0) as f64, (k / SIZE.0) as f64));
            (ray.unwrap_or_else(Vector3::zeros) * f64::from(self.depth[k])).into()
        };
        (0..self.depth.len()).map(point).collect()
    }
}
