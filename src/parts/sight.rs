//! What the pixels of a mask see of a cylinder.

use super::{Sight, WIDTH_PART};
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::DepthImage;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// How many pixels are looked at in one go.
const BLOCK: usize = 64;

/// What those of the pixels see that have a depth and meet the middle part of the surface.
pub(super) fn sights(
    camera: &Camera,
    depth: &DepthImage,
    cylinder: &Cylinder,
    pixels: impl Iterator<Item = (usize, usize)>,
) -> List<Sight> {
    let (mut chosen, mut depths) = (List::new(), List::new());
    // A loop over an iterator of iterators is slow to be asked one by one.
    pixels.for_each(|(column, row)| {
        if let Some(z) = depth.depth(column, row) {
            chosen.push([column as u32, row as u32]);
            depths.push(z);
        }
    });
    Arch::new().dispatch(Looks { camera, view: View::new(cylinder), pixels: &chosen, depths: &depths })
}

/// The least and the greatest position along the axis at which the rays of pixels first meet a cylinder; infinite where none does.
pub(crate) fn extremes(
    camera: &Camera,
    cylinder: &Cylinder,
    pixels: impl Iterator<Item = (usize, usize)>,
) -> [f64; 2] {
    let mut chosen = List::new();
    pixels.for_each(|(column, row)| chosen.push([column as u32, row as u32]));
    Arch::new().dispatch(Extremes { camera, view: View::new(cylinder), pixels: &chosen })
}

/// Pixels alone.
struct Extremes<'a> {
    camera: &'a Camera,
    view: View,
    pixels: &'a [[u32; 2]],
}

impl WithSimd for Extremes<'_> {
    type Output = [f64; 2];

    /// Plain loops, as below.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; 2] {
        let Self { camera, view, pixels } = self;
        let mut extremes = [f64::INFINITY, f64::NEG_INFINITY];
        let ([mut x, mut y], mut seen) = ([[0.0; BLOCK]; 2], [0.0; BLOCK]);
        for pixels in pixels.chunks(BLOCK) {
            camera.rays_of_pixels(pixels, &mut x, &mut y);
            for ((x, y), position) in x.iter().zip(&y).zip(&mut seen).take(pixels.len()) {
                let (hit, met) = view.first_hit([*x, *y, 1.0]);
                let found = dot(minus(hit, view.point), view.direction);
                *position = if met { found } else { f64::NAN };
            }
            for position in &seen[..pixels.len()] {
                extremes = [extremes[0].min(*position), extremes[1].max(*position)];
            }
        }
        extremes
    }
}

/// Pixels with their depths.
struct Looks<'a> {
    camera: &'a Camera,
    view: View,
    pixels: &'a [[u32; 2]],
    depths: &'a [f64],
}

impl WithSimd for Looks<'_> {
    type Output = List<Sight>;

    /// Plain loops, which the compiler makes the widest instructions of the machine of; they all round alike.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> List<Sight> {
        let Self { camera, view, pixels, depths } = self;
        let mut sights = List::with_capacity(depths.len());
        let ([mut x, mut y], mut seen) = ([[0.0; BLOCK]; 2], [[0.0; BLOCK]; 4]);
        for (pixels, depths) in pixels.chunks(BLOCK).zip(depths.chunks(BLOCK)) {
            camera.rays_of_pixels(pixels, &mut x, &mut y);
            let [positions, surfaces, distances, turns] = &mut seen;
            let pixels = x.iter().zip(&y).zip(depths);
            let room =
                positions.iter_mut().zip(surfaces.iter_mut()).zip(distances.iter_mut()).zip(turns.iter_mut());
            for (((x, y), depth), (((position, surface), distance), turn)) in pixels.zip(room) {
                [*position, *surface, *distance, *turn] = view.look([*x, *y, 1.0], *depth);
            }
            for (k, depth) in depths.iter().enumerate() {
                let [position, surface, distance, turn] = [0, 1, 2, 3].map(|number| seen[number][k]);
                if !position.is_nan() {
                    sights.push(Sight {
                        position,
                        point: Vector3::new(x[k], y[k], 1.0) * *depth,
                        distance,
                        nearer: *depth < surface,
                        facing: turn < 0.0,
                    });
                }
            }
        }
        sights
    }
}

/// A cylinder that is looked at from outside.
struct View {
    direction: [f64; 3],
    point: [f64; 3],
    radius: f64,
    /// The point of the axis nearest to the camera.
    nearest: [f64; 3],
    /// |c|² − r² for that point c: see [`Cylinder::intersect_ray`].
    product: f64,
}

impl View {
    fn new(cylinder: &Cylinder) -> Self {
        let Cylinder { axis, radius } = *cylinder;
        let nearest = axis.nearest_to_origin();
        Self {
            direction: axis.direction.into(),
            point: axis.point.into(),
            radius,
            nearest: nearest.into(),
            product: nearest.norm_squared() - radius * radius,
        }
    }

    /// Where a ray first meets the cylinder, and whether it does: [`Cylinder::first_hit`] to the last bit, without branches.
    #[inline(always)]
    fn first_hit(&self, ray: [f64; 3]) -> ([f64; 3], bool) {
        let Self { direction, radius, nearest, product, .. } = *self;
        // As `intersect_ray` of a cylinder.
        let across = along(ray, direction, -dot(ray, direction));
        let a = dot(across, across);
        let b = dot(across, nearest);
        let moment = cross(across, nearest);
        let discriminant = a * radius * radius - dot(moment, moment);
        let root = discriminant.sqrt();
        let large = if b >= 0.0 { b + root } else { b - root };
        let (first, second) = (large / a, product / large);
        let (near, far) = if first < second { (first, second) } else { (second, first) };
        let t = if near > 0.0 { near } else { far };
        // False for a root that is none.
        (ray.map(|x| x * t), (t > 0.0) & (large != 0.0))
    }

    /// Along a ray of a pixel with a depth: the position along the axis and the depth at which it meets the surface, how far
    /// the measured point is from that, and a number that is negative for a point on the wall that the camera sees. The
    /// position is NaN where the ray passes by or beside the middle part.
    ///
    /// The numbers of [`Cylinder::first_hit`] and [`Cylinder::distance`] to the last bit, without branches.
    #[inline(always)]
    fn look(&self, ray: [f64; 3], depth: f64) -> [f64; 4] {
        let Self { direction, point, radius, .. } = *self;
        let normal = cross(ray, direction);
        let beside = dot(normal, point).abs() > WIDTH_PART.get() * dot(normal, normal).sqrt() * radius;
        let (hit, met) = self.first_hit(ray);
        let from_point = minus(hit, point);
        let position = if met & !beside { dot(from_point, direction) } else { f64::NAN };
        let measured = ray.map(|x| x * depth);
        let from_axis_point = minus(measured, point);
        let lever = cross(from_axis_point, direction);
        let distance = dot(lever, lever).sqrt() - radius;
        let outward = minus(measured, along(point, direction, dot(from_axis_point, direction)));
        [position, hit[2], distance, dot(outward, measured)]
    }
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The point at a length along a direction from another.
#[inline(always)]
fn along(from: [f64; 3], direction: [f64; 3], length: f64) -> [f64; 3] {
    [from[0] + direction[0] * length, from[1] + direction[1] * length, from[2] + direction[2] * length]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What one pixel sees, by the functions of the cylinder.
    fn plain(cylinder: &Cylinder, ray: &Vector3<f64>, depth: f64) -> Option<[f64; 4]> {
        let axis = &cylinder.axis;
        let normal = ray.cross(&axis.direction);
        if normal.dot(&axis.point).abs() > WIDTH_PART.get() * normal.norm() * cylinder.radius {
            return None;
        }
        let hit = cylinder.first_hit(ray)?;
        let point = ray * depth;
        let turn = (point - axis.nearest_to(&point)).dot(&point);
        Some([(hit - axis.point).dot(&axis.direction), hit.z, cylinder.distance(&point), turn])
    }

    #[test]
    fn pixels_see_side_by_side_what_each_sees_alone() {
        let slanted = |scale: f64| {
            let point = Vector3::new(0.1, -0.2, 0.9) * scale;
            Cylinder::new(point, Vector3::new(0.4, 0.8, 0.3), 0.07 * scale).unwrap()
        };
        for scale in [1.0, 1e-120, 1e120] {
            let cylinder = slanted(scale);
            let view = View::new(&cylinder);
            let mut met = 0;
            for k in 0..4000 {
                let (column, row) = (f64::from(k % 80), f64::from(k / 80));
                let ray = Vector3::new(0.01 * column - 0.4, 0.02 * row - 0.6, 1.0);
                for depth in [0.0, 0.8, 0.95, 1e3, f64::MIN_POSITIVE, 1e120].map(|depth| depth * scale) {
                    let found = view.look(ray.into(), depth);
                    match plain(&cylinder, &ray, depth) {
                        Some(expected) => {
                            let same = |(a, b): (&f64, f64)| *a == b || a.is_nan() && b.is_nan();
                            assert!(found.iter().zip(expected).all(same), "{found:?} {expected:?}");
                        }
                        None => assert!(found[0].is_nan()),
                    }
                    met += usize::from(!found[0].is_nan());
                }
            }
            assert!((1000..20_000).contains(&met), "{met}");
        }
    }
}
