//! A rendered cylinder with flat caps in front of a tiled wall, for the tests of the extent.

use crate::camera::{Camera, Distortion, Intrinsics};
use crate::fitter::Fitter;
use crate::geometry::Cylinder;
use crate::observations::{DepthRange, DepthView, MaskView};
use nalgebra::{Vector2, Vector3};

pub(super) const SIZE: (usize, usize) = (200, 160);

/// Rays by which a pixel of the image is averaged, in each direction.
const RAYS: usize = 4;

pub(super) struct Scene {
    pub cylinder: Cylinder,
    /// The ends along the axis.
    pub ends: (f64, f64),
    /// An upright bar in front of the cylinder, by its columns.
    pub bar: Option<(f64, f64)>,
}

enum Thing {
    Bar,
    Side,
    Cap,
    Wall,
}

impl Scene {
    /// A cylinder of radius 0.05 about 0.7 away whose `start` faces the camera by `tilt` radians.
    pub fn tilted(tilt: f64) -> Self {
        let upright = Vector3::new(0.3, 0.95, 0.0).normalize();
        let direction = upright * tilt.cos() + Vector3::z() * tilt.sin();
        let cylinder = Cylinder::new(Vector3::new(0.01, -0.005, 0.7), direction, 0.05).unwrap();
        Self { cylinder, ends: (-0.0613, 0.0592), bar: None }
    }

    pub fn intrinsics() -> Intrinsics {
        let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
        Intrinsics { width, height, fx: 500.0, fy: 500.0, cx: 99.5, cy: 79.5, distortion: Distortion::None }
    }

    pub fn camera() -> Camera {
        Camera::new(Self::intrinsics()).unwrap()
    }

    /// Pixels per unit of length at the cylinder.
    pub const PIXELS: f64 = 500.0 / 0.7;

    /// What is seen at a pixel: the thing, its depth, and its brightness.
    fn look(&self, pixel: &Vector2<f64>) -> (Thing, f64, f64) {
        let ray = Self::camera().unproject(pixel).unwrap();
        if self.bar.is_some_and(|(first, last)| first <= pixel.x && pixel.x <= last) {
            return (Thing::Bar, 0.5, 20.0);
        }
        let Cylinder { axis, radius } = self.cylinder;
        if let Some(point) = self.cylinder.first_hit(&ray) {
            let position = axis.position_of(&point);
            if self.ends.0 <= position && position <= self.ends.1 {
                let outward = (point - axis.point - axis.direction * position) / radius;
                return (
                    Thing::Side,
                    point.z,
                    60.0 + 150.0 * outward.dot(&Vector3::new(-0.5, 0.0, -0.8)).max(0.0),
                );
            }
        }
        for end in [self.ends.0, self.ends.1] {
            let middle = axis.at(end);
            let point = ray * (middle.dot(&axis.direction) / ray.dot(&axis.direction));
            if (point - middle).norm() <= radius {
                return (Thing::Cap, point.z, 100.0);
            }
        }
        let tile = (pixel.x / 9.0).floor() as i64 + (pixel.y / 9.0).floor() as i64;
        (Thing::Wall, 1.0, if tile % 3 == 0 { 60.0 } else { 35.0 })
    }

    /// Image, depth image and mask, the mask moved outward by a number of pixels.
    pub fn render(&self, mask_bias: i64) -> (Vec<f32>, Vec<f32>, Vec<u8>) {
        let (width, height) = SIZE;
        let (mut grey, mut depth, mut side) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..height {
            for column in 0..width {
                let at = |x: f64, y: f64| Vector2::new(column as f64 + x, row as f64 + y);
                let (thing, z, _) = self.look(&at(0.0, 0.0));
                depth.push(z as f32);
                side.push(matches!(thing, Thing::Side));
                let offset = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
                let rays = (0..RAYS * RAYS).map(|k| self.look(&at(offset(k % RAYS), offset(k / RAYS))).2);
                grey.push((rays.sum::<f64>() / (RAYS * RAYS) as f64) as f32);
            }
        }
        let reach = mask_bias.abs();
        let near = |column: i64, row: i64, wanted: bool| {
            (-reach..=reach).any(|down| {
                (-reach..=reach).filter(|right| right * right + down * down <= reach * reach).any(|right| {
                    let x = (column + right).clamp(0, width as i64 - 1) as usize;
                    let y = (row + down).clamp(0, height as i64 - 1) as usize;
                    side[y * width + x] == wanted
                })
            })
        };
        let pixels = (0..height as i64).flat_map(|row| (0..width as i64).map(move |column| (column, row)));
        let mask =
            pixels.map(|(x, y)| u8::from(if mask_bias < 0 { !near(x, y, false) } else { near(x, y, true) }));
        let mask = mask.collect();
        (grey, depth, mask)
    }

    /// A fitter that holds depth and mask.
    pub fn fitter(depth: &[f32], mask: &[u8]) -> Fitter {
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(Self::intrinsics()).unwrap();
        let depth = DepthView::from_f32(depth, SIZE, 1.0).unwrap();
        let mask = MaskView::from_u8(mask, SIZE).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        fitter
    }
}
