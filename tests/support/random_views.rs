//! Views that are drawn by lot, the same at every run.
// This is test code wherever it is included.
#![allow(clippy::unwrap_used)]

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::geometry::Cylinder;
use nalgebra::{Vector2, Vector3};

/// Numbers that look random, the same at every run.
pub struct Dice(u64);
impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// A shaded cylinder with depth and mask.
pub struct View {
    pub intrinsics: Intrinsics,
    pub size: (usize, usize),
    pub depth: Vec<f32>,
    pub mask: Vec<u8>,
    pub image: Vec<f32>,
}

impl View {
    /// A view of some cylinder, now and then along its axis, from inside, or on an image of a single pixel.
    pub fn new(dice: &mut Dice) -> Self {
        let size = [(64, 48), (96, 64), (160, 120), (1, 64), (64, 1), (1, 1), (7, 5)]
            [dice.below(7).min(if dice.one_in(3) { 6 } else { 2 })];
        Self::of_size(dice, size)
    }

    pub fn of_size(dice: &mut Dice, size: (usize, usize)) -> Self {
        let f = size.0.max(size.1) as f64 * dice.between(0.4, 2.0);
        let distortion = match dice.below(4) {
            0 => Distortion::BrownConrady([
                dice.between(-0.3, 0.3),
                dice.between(-0.1, 0.1),
                0.001,
                -0.001,
                0.,
                0.,
                0.,
                0.,
            ]),
            1 => Distortion::KannalaBrandt([dice.between(-0.1, 0.1), dice.between(-0.02, 0.02), 0., 0.]),
            _ => Distortion::None,
        };
        let intrinsics = Intrinsics {
            width: size.0 as u32,
            height: size.1 as u32,
            fx: f,
            fy: f * dice.between(0.8, 1.2),
            cx: size.0 as f64 / 2.0 - 0.5,
            cy: size.1 as f64 / 2.0 - 0.5,
            distortion,
        };
        let camera = Camera::new(intrinsics).unwrap();
        let direction = match dice.below(5) {
            0 => Vector3::z() + Vector3::new(dice.normal(), dice.normal(), 0.0) * 0.05,
            1 => Vector3::z(),
            _ => Vector3::new(dice.normal(), dice.normal(), dice.normal()),
        };
        let r = 10_f64.powf(dice.between(-2.0, 0.3));
        let point = Vector3::new(dice.normal() * 0.4, dice.normal() * 0.3, dice.between(0.0, 2.0));
        let cylinder = Cylinder::new(point, direction, r).unwrap();
        let half = dice.between(0.02, 2.0);
        let light = Vector3::new(dice.normal(), dice.normal(), dice.normal()).normalize();
        let noise = [0.0, 0.001, 0.01, 0.1][dice.below(4)];
        let (mut depth, mut mask, mut image) =
            (vec![0_f32; size.0 * size.1], vec![0_u8; size.0 * size.1], vec![0_f32; size.0 * size.1]);
        let background = dice.between(0.0, 255.0);
        for k in 0..size.0 * size.1 {
            image[k] = (background + dice.normal()) as f32;
            let Some(ray) = camera.unproject(&Vector2::new((k % size.0) as f64, (k / size.0) as f64)) else {
                continue;
            };
            let Some(hit) = cylinder.first_hit(&ray) else { continue };
            let along = cylinder.axis.position_of(&hit);
            if along.abs() > half || hit.z <= 0.0 {
                continue;
            }
            let normal = (hit - cylinder.axis.nearest_to(&hit)) / r;
            depth[k] = (hit.z * (1.0 + noise * dice.normal())) as f32;
            mask[k] = 1;
            image[k] = (60.0 + 120.0 * normal.dot(&light).max(0.0) + dice.normal()) as f32;
        }
        Self { intrinsics, size, depth, mask, image }
    }

    /// Mask, depth and image as nobody wants them.
    pub fn spoil(&mut self, dice: &mut Dice) {
        let (w, h) = self.size;
        let n = w * h;
        let any = |dice: &mut Dice| dice.below(n);
        match dice.below(8) {
            0 => {
                self.mask.fill(1);
            }
            1 => {
                self.mask.fill(0);
                let k = any(dice);
                self.mask[k] = 1;
            }
            2 => {
                let row = dice.below(h);
                for k in 0..n {
                    if k / w != row {
                        self.mask[k] = 0;
                    }
                }
            }
            3 => {
                let c = dice.below(w);
                for k in 0..n {
                    if (k % w) == c {
                        self.mask[k] ^= 1;
                    }
                }
            }
            4 => {
                for k in 0..n {
                    if dice.one_in(3) {
                        self.mask[k] = 0;
                    }
                }
            }
            5 => {
                for k in 0..n {
                    if dice.one_in(3) {
                        self.mask[k] = 1;
                    }
                }
            }
            _ => {}
        }
        match dice.below(12) {
            0 => {
                for z in &mut self.depth {
                    if *z > 0.0 {
                        *z = 1.0;
                    }
                }
            }
            1 => self.depth.fill(0.7),
            2 => {
                for k in 0..n {
                    self.depth[k] = if k % w < w / 2 { 0.5 } else { 1.0 };
                }
            }
            3 => {
                for k in 0..n {
                    if dice.one_in(2) {
                        self.depth[k] = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30, 1e-30][dice.below(6)];
                    }
                }
            }
            4 => {
                for z in &mut self.depth {
                    *z = (*z * 20.0).round() / 20.0;
                }
            }
            5 => {
                let s = [1e-30, 1e-10, 1e10, 1e30][dice.below(4)];
                for z in &mut self.depth {
                    *z *= s;
                }
            }
            6 => {
                for k in 0..n {
                    self.depth[k] = dice.between(0.1, 3.0) as f32;
                }
            }
            _ => {}
        }
        match dice.below(12) {
            0 => self.image.fill(7.0),
            1 => self.image.fill(0.0),
            2 => {
                for k in 0..n {
                    self.image[k] = dice.between(0.0, 255.0) as f32;
                }
            }
            3 => {
                for v in &mut self.image {
                    *v *= 1e36;
                }
            }
            4 => {
                for v in &mut self.image {
                    *v = if *v > 100.0 { f32::MAX } else { -f32::MAX };
                }
            }
            5 => {
                for v in &mut self.image {
                    *v *= 1e-43;
                }
            }
            6 => {
                for v in &mut self.image {
                    *v = (*v / 100.0).round();
                }
            }
            _ => {}
        }
    }
}
