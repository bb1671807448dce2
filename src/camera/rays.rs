//! Rays of the whole pixels of an image, each found once.

use nalgebra::{Vector2, Vector3};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Stands for a coordinate that has not been found yet. It is not a number, as [`NO_RAY`], so that no ray has it.
const UNKNOWN: u64 = u64::MAX;

/// Stands for the coordinates of a pixel without a ray.
const NO_RAY: u64 = f64::NAN.to_bits();

/// The bits of x and y of a ray with z = 1, [`UNKNOWN`] or [`NO_RAY`].
type Entry = [AtomicU64; 2];

/// The rays of the whole pixels of an image through a lens, remembered from when they are first asked for: 16 bytes a
/// pixel when all were asked for.
///
/// There is only memory for blocks of pixels that were asked for. A block has about as many pixels as there are blocks, so
/// that a single ray of a large image takes little. Where memory is missing nothing is remembered.
pub(super) struct Rays {
    width: usize,
    height: usize,
    /// The logarithm of the number of pixels of a block, to the base 2.
    shift: u32,
    /// Row by row. Empty, as a block is, where there was no memory for it.
    blocks: OnceLock<Vec<OnceLock<Vec<Entry>>>>,
}

impl Rays {
    /// None is known yet.
    pub(super) fn new((width, height): (usize, usize)) -> Self {
        let shift = (width * height).max(1).ilog2() / 2;
        Self { width, height, shift, blocks: OnceLock::new() }
    }

    /// The ray of a pixel by `find`, which must give the same bits whenever it is called with this pixel: it is not called
    /// again for whole pixels in the image.
    pub(super) fn ray(
        &self,
        pixel: &Vector2<f64>,
        find: impl Fn() -> Option<Vector3<f64>>,
    ) -> Option<Vector3<f64>> {
        let (column, row) = (pixel.x as usize, pixel.y as usize);
        // By their bits: -0.0 may have another ray than 0.0, in the sign of a zero.
        let whole =
            (column as f64).to_bits() == pixel.x.to_bits() && (row as f64).to_bits() == pixel.y.to_bits();
        if whole { self.of_pixel(column, row, find) } else { find() }
    }

    /// The same for a whole pixel.
    #[inline]
    pub(super) fn of_pixel(
        &self,
        column: usize,
        row: usize,
        find: impl Fn() -> Option<Vector3<f64>>,
    ) -> Option<Vector3<f64>> {
        let Some([x, y]) = self.entry(column, row) else { return find() };
        // No ordering: each number is written with the same bits by all threads, and who misses one finds both again.
        let bits = [x.load(Ordering::Relaxed), y.load(Ordering::Relaxed)];
        if bits.contains(&UNKNOWN) {
            let ray = find();
            let bits = ray.map_or([NO_RAY; 2], |ray| [ray.x.to_bits(), ray.y.to_bits()]);
            x.store(bits[0], Ordering::Relaxed);
            y.store(bits[1], Ordering::Relaxed);
            return ray;
        }
        let [x, y] = bits.map(f64::from_bits);
        (bits[0] != NO_RAY).then(|| Vector3::new(x, y, 1.0))
    }

    /// Takes the rays of some pixels of a row, by their offsets from one at a column and a row on, as their x and y. Says whether all of
    /// them have one that is known; else what was taken is of no use.
    #[inline]
    pub(super) fn take_known(
        &self,
        (column, row): (usize, usize),
        offsets: &[usize],
        x: &mut [f64],
        y: &mut [f64],
    ) -> bool {
        let Some(known) = self.side_by_side((column, row), offsets.last().map_or(0, |last| last + 1)) else {
            return false;
        };
        let mut all = true;
        for ((offset, x), y) in offsets.iter().zip(x).zip(y) {
            let [bits_of_x, bits_of_y] = known[*offset].each_ref().map(|bits| bits.load(Ordering::Relaxed));
            (*x, *y) = (f64::from_bits(bits_of_x), f64::from_bits(bits_of_y));
            // Neither what is unknown nor what stands for no ray is a number.
            all &= !(x.is_nan() | y.is_nan());
        }
        all
    }

    /// Where the rays of so many pixels of a row are remembered; `None` unless there is memory for them in a single block.
    #[inline]
    fn side_by_side(&self, (column, row): (usize, usize), count: usize) -> Option<&[Entry]> {
        if column + count > self.width || row >= self.height {
            return None;
        }
        let index = row * self.width + column;
        let (block, within) = (index >> self.shift, index & ((1 << self.shift) - 1));
        self.blocks.get()?.get(block)?.get()?.get(within..within + count)
    }

    /// Where the ray of a pixel is remembered. `None` outside the image, and where memory is missing.
    #[inline]
    fn entry(&self, column: usize, row: usize) -> Option<&Entry> {
        if column >= self.width || row >= self.height {
            return None;
        }
        let index = row * self.width + column;
        let (block, within) = (index >> self.shift, index & ((1 << self.shift) - 1));
        let blocks = self.blocks.get_or_init(|| self.all_blocks());
        blocks.get(block)?.get_or_init(|| self.block()).get(within)
    }

    #[cold]
    fn all_blocks(&self) -> Vec<OnceLock<Vec<Entry>>> {
        filled((self.width * self.height).div_ceil(1 << self.shift), OnceLock::new)
    }

    #[cold]
    fn block(&self) -> Vec<Entry> {
        filled(1 << self.shift, || [UNKNOWN; 2].map(AtomicU64::new))
    }
}

/// So many values, or none where memory is missing.
fn filled<T>(count: usize, value: impl FnMut() -> T) -> Vec<T> {
    let mut values = Vec::new();
    if values.try_reserve_exact(count).is_ok() {
        values.resize_with(count, value);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use std::sync::atomic::AtomicUsize;

    /// A lens that folds over within the image.
    fn camera(distortion: Distortion) -> Camera {
        let (width, height) = (131, 77);
        Camera::new(Intrinsics { width, height, fx: 60.0, fy: 61.0, cx: 65.0, cy: 38.5, distortion }).unwrap()
    }

    fn folding() -> Camera {
        camera(Distortion::brown_conrady(&[-0.3, 0.02, 0.001, -0.002]).unwrap())
    }

    fn bits(ray: Option<Vector3<f64>>) -> Option<[u64; 3]> {
        ray.map(|ray| [ray.x, ray.y, ray.z].map(f64::to_bits))
    }

    /// All pixels of the image and some beyond its border.
    fn pixels() -> impl Iterator<Item = Vector2<f64>> {
        (-3..80).flat_map(|y| (-3..135).map(move |x| Vector2::new(f64::from(x), f64::from(y))))
    }

    #[test]
    fn remembered_rays_have_the_bits_of_those_found_anew_in_all_threads() {
        for camera in [folding(), camera(Distortion::KannalaBrandt([0.1, -0.02, 0.0, 0.0]))] {
            let check = |pixel: Vector2<f64>| {
                assert_eq!(bits(camera.unproject(&pixel)), bits(camera.find_ray(&pixel)), "{pixel}");
            };
            std::thread::scope(|scope| {
                for thread in 0..4 {
                    let clone = camera.clone();
                    scope.spawn(move || {
                        let all: Vec<_> = pixels().collect();
                        for k in 0..all.len() {
                            // 7919 is a prime: some ask for the same pixels at once, some for others.
                            let pixel = all[(k + thread / 2 * 7919) % all.len()];
                            assert_eq!(
                                bits(clone.unproject(&pixel)),
                                bits(clone.find_ray(&pixel)),
                                "{pixel}"
                            );
                        }
                    });
                }
            });
            pixels().for_each(check);
            pixels().map(|pixel| pixel.add_scalar(0.25)).for_each(check);
            for x in [-0.0, 0.0, f64::NAN, f64::INFINITY, -1.0, 1e300] {
                check(Vector2::new(x, 3.0));
                check(Vector2::new(3.0, x));
            }
            for (column, row) in (0..80).flat_map(|row| (0..135).map(move |column| (column, row))) {
                let pixel = Vector2::new(column as f64, row as f64);
                assert_eq!(bits(camera.ray_of_pixel(column, row)), bits(camera.find_ray(&pixel)), "{pixel}");
            }
        }
        let camera = folding();
        let without = pixels().filter(|pixel| camera.contains(pixel) && camera.unproject(pixel).is_none());
        assert!(without.count() > 100);
    }

    #[test]
    fn clones_share_rays_and_a_reduced_camera_has_its_own() {
        let camera = folding();
        let clone = camera.clone();
        let ray = camera.unproject(&Vector2::new(40.0, 30.0)).unwrap();
        let known = |camera: &Camera, column, row| {
            let rays = camera.rays.as_ref().unwrap();
            rays.entry(column, row).unwrap()[0].load(Ordering::Relaxed)
        };
        assert_eq!(known(&clone, 40, 30), ray.x.to_bits());
        assert_eq!(known(&clone, 41, 30), UNKNOWN);
        assert_eq!(known(&camera.reduced(2), 40, 30), UNKNOWN);
        assert!(self::camera(Distortion::None).rays.is_none());
    }

    #[test]
    fn rays_of_a_row_are_taken_where_all_are_known() {
        let camera = folding();
        let rays = camera.rays.as_ref().unwrap();
        let take = |column, row, offsets: &[usize]| {
            let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
            rays.take_known((column, row), offsets, &mut x, &mut y).then_some((x, y))
        };
        assert_eq!(take(50, 30, &[0, 2, 5]), None);
        for column in [50, 52, 55] {
            assert!(camera.ray_of_pixel(column, 30).is_some());
        }
        let (x, y) = take(50, 30, &[0, 2, 5]).unwrap();
        for (k, column) in [50, 52, 55].into_iter().enumerate() {
            let ray = camera.ray_of_pixel(column, 30).unwrap();
            assert_eq!([x[k], y[k]], [ray.x, ray.y]);
        }
        assert_eq!(take(50, 30, &[0, 2, 3, 5]), None);
        assert!(take(50, 30, &[]).is_some());
        // Beyond the image, and where there is no ray.
        assert_eq!(take(128, 30, &[0, 3]), None);
        assert_eq!(take(50, 77, &[0]), None);
        assert!(camera.ray_of_pixel(0, 0).is_none());
        assert_eq!(take(0, 0, &[0]), None);
    }

    #[test]
    fn a_ray_is_found_once() {
        let rays = Rays::new((20, 10));
        let calls = AtomicUsize::new(0);
        let ask = |x: f64, ray: Option<Vector3<f64>>| {
            let find = || {
                calls.fetch_add(1, Ordering::Relaxed);
                ray
            };
            assert_eq!(rays.ray(&Vector2::new(x, 9.0), find), ray);
            calls.load(Ordering::Relaxed)
        };
        let ray = Some(Vector3::new(0.5, -0.25, 1.0));
        assert_eq!([ask(3.0, ray), ask(3.0, ray), ask(3.0, ray)], [1, 1, 1]);
        assert_eq!([ask(19.0, None), ask(19.0, None)], [2, 2]);
        assert_eq!([ask(3.5, ray), ask(3.5, ray)], [3, 4]);
        assert_eq!([ask(20.0, ray), ask(20.0, ray)], [5, 6]);
    }

    #[test]
    fn a_single_ray_of_the_largest_image_takes_little_memory() {
        for (width, height) in [(1 << 14, 1 << 14), (1 << 28, 1), (1, 1 << 28), (1, 1)] {
            let rays = Rays::new((width, height));
            assert!(rays.blocks.get().is_none());
            assert_eq!(rays.of_pixel(width - 1, height - 1, || Some(Vector3::z())), Some(Vector3::z()));
            let blocks = rays.blocks.get().unwrap();
            let entries: usize = blocks.iter().filter_map(OnceLock::get).map(Vec::len).sum();
            assert!((1..=1 << 14).contains(&entries) && (1..=1 << 15).contains(&blocks.len()));
        }
    }

    #[test]
    fn without_memory_rays_are_found_anew() {
        assert!(filled(usize::MAX, || 0_u64).is_empty());
        let rays = Rays::new((20, 10));
        rays.blocks.set(vec![OnceLock::from(Vec::new())]).unwrap();
        for (column, row) in [(0, 0), (19, 9)] {
            assert_eq!(rays.of_pixel(column, row, || Some(Vector3::z())), Some(Vector3::z()));
        }
    }
}
