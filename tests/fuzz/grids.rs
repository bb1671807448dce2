//! Grids of pixels, points and segments that are handed to a call, with every stride, and the structs that describe them.

use crate::inputs::Source;
use cylfuse::ffi::*;
use std::ffi::c_void;

/// A grid of elements in memory.
pub struct Grid {
    pub first: *const c_void,
    pub element_stride: isize,
    pub row_stride: isize,
}

impl Source<'_> {
    /// A grid whose elements are written by `fill`.
    pub fn grid(
        &mut self,
        (width, height): (usize, usize),
        size: usize,
        fill: impl Fn(usize, usize) -> Vec<u8>,
    ) -> Grid {
        if self.strikes() || width * height == 0 {
            return Grid { first: std::ptr::null(), element_stride: 0, row_stride: 0 };
        }
        let dice = &mut self.dice;
        let pad = if dice.one_in(2) { 0 } else { dice.below(5) };
        let row_pad = if dice.one_in(2) { 0 } else { dice.below(9) };
        let (mut across, mut down) = (size + pad, 0);
        if dice.one_in(6) {
            down = size + pad;
            across = down * height + row_pad;
        } else {
            down = down.max(across * width + row_pad);
        }
        let (left, up) = (dice.one_in(6), dice.one_in(6));
        let packed = across == size && down == size * width && !left && !up && dice.one_in(2);
        let length = (width - 1) * across + (height - 1) * down + size;
        let mut bytes = vec![0xff; length];
        let first = if left { (width - 1) * across } else { 0 } + if up { (height - 1) * down } else { 0 };
        let signed = |stride: usize, back: bool| if back { -(stride as isize) } else { stride as isize };
        let (element_stride, row_stride) = (signed(across, left), signed(down, up));
        for row in 0..height {
            for column in 0..width {
                let at = first as isize + column as isize * element_stride + row as isize * row_stride;
                bytes[at as usize..at as usize + size].copy_from_slice(&fill(column, row));
            }
        }
        let placed = self.place(&bytes);
        if self.dice.one_in(8) {
            self.arena.read_only();
        }
        let mut grid =
            Grid { first: unsafe { placed.add(first) }.cast_const().cast(), element_stride, row_stride };
        if packed {
            (grid.element_stride, grid.row_stride) = (0, 0);
        }
        if self.strikes() && down >= across {
            // Strides that overlap or leave the range of addresses: refused before anything is read.
            let bad = [1, -1, isize::MAX, isize::MIN, isize::MAX - 3][self.dice.below(5)];
            if width > 2 && size > 1 {
                grid.element_stride = bad;
            }
            if height > 2 && width > 2 && (size > 1 || self.dice.one_in(2)) {
                grid.row_stride = bad;
            }
        }
        grid
    }

    /// Columns and rows of images: those of the view, now and then others that are there too.
    fn size(&mut self) -> (usize, usize) {
        let (width, height) = self.view.size;
        if self.strikes() {
            [(width, height - 1), (width - 1, height), (0, 0), (0, height), (1, 1)][self.dice.below(5)]
        } else {
            (width, height)
        }
    }

    pub fn mask(&mut self) -> *const cylfuse_mask_view {
        let (width, height) = self.size();
        let label = if self.dice.one_in(8) { self.constant(255) as u32 } else { 0 };
        let (w, mask) = (self.view.size.0, self.view.mask.clone());
        let stored = if label > 0 { label as u8 } else { 1 };
        let grid = self.grid((width, height), 1, |column, row| vec![mask[row * w + column] * stored]);
        let (width, height) = self.claimed((width, height));
        let value = cylfuse_mask_view {
            struct_size: 0,
            width,
            height,
            label,
            data: grid.first.cast(),
            row_stride: grid.row_stride,
            pixel_stride: grid.element_stride,
        };
        self.input(&value)
    }

    /// A mask, NULL more often where it stands for all or the last one.
    pub fn mask_or_none(&mut self) -> *const cylfuse_mask_view {
        if self.dice.one_in(2) { std::ptr::null() } else { self.mask() }
    }

    /// The size, or one that no memory has.
    fn claimed(&mut self, (width, height): (usize, usize)) -> (u32, u32) {
        if width > 0 && height > 0 && self.strikes() && self.strikes() {
            (u32::MAX, u32::MAX)
        } else {
            (width as u32, height as u32)
        }
    }

    pub fn depth(&mut self) -> *const cylfuse_depth_view {
        let size = self.size();
        let (w, depth) = (self.view.size.0, self.view.depth.clone());
        let narrow = self.dice.one_in(2);
        let grid = if narrow {
            self.grid(size, 2, |column, row| {
                ((depth[row * w + column] * 1000.0) as u16).to_ne_bytes().to_vec()
            })
        } else {
            self.grid(size, 4, |column, row| depth[row * w + column].to_ne_bytes().to_vec())
        };
        let format = if self.strikes() { self.constant(3) } else { if narrow { 1 } else { 2 } };
        // A format of more bytes than there are would be a lie that no call can see.
        let format = if narrow && format == 2 { 1 } else { format };
        let (width, height) = self.claimed(size);
        let limits = self.dice.one_in(4);
        let value = cylfuse_depth_view {
            struct_size: 0,
            format: cylfuse_depth_format(format),
            data: grid.first,
            width,
            height,
            row_stride: grid.row_stride,
            pixel_stride: grid.element_stride,
            scale: self.number(if narrow { 0.001 } else { 1.0 }),
            min_depth: if limits { self.number(0.3) } else { 0.0 },
            max_depth: if limits { self.number(3.0) } else { 0.0 },
        };
        self.input(&value)
    }

    pub fn image(&mut self) -> *const cylfuse_image_view {
        let size = self.size();
        let (w, image) = (self.view.size.0, self.view.image.clone());
        let format = 1 + self.dice.below(7) as i32;
        let bytes = [1, 2, 4, 3, 3, 4, 4][format as usize - 1];
        let grid = self.grid(size, bytes, |column, row| {
            let value = image[row * w + column];
            match format {
                2 => ((value * 200.0) as u16).to_ne_bytes().to_vec(),
                3 => value.to_ne_bytes().to_vec(),
                _ => vec![value as u8; bytes],
            }
        });
        let format = if self.strikes() { [0, -1, 8, i32::MAX][self.dice.below(4)] } else { format };
        let (width, height) = self.claimed(size);
        let gamma = [1.0, 2.2][self.dice.below(2)];
        let value = cylfuse_image_view {
            struct_size: 0,
            format: cylfuse_image_format(format),
            data: grid.first,
            width,
            height,
            row_stride: grid.row_stride,
            pixel_stride: grid.element_stride,
            gamma: self.number(gamma),
        };
        self.input(&value)
    }

    /// Points of the depth image, organised or not, with or without weights and normals. Also how many.
    pub fn points(&mut self) -> (*const cylfuse_points_view, usize) {
        let wide = self.dice.one_in(2);
        let organised = self.dice.one_in(3);
        let (w, h) = self.view.size;
        let (width, height) = if organised { (w, h) } else { (self.dice.below(w * h).min(3000), 1) };
        let place = |k: usize| (k % w, k / w);
        let own = &self.view.intrinsics;
        let (fx, fy, cx, cy) = (own.fx, own.fy, own.cx, own.cy);
        let depth = self.view.depth.clone();
        let hostility = self.hostility;
        let mut points: Vec<[f64; 3]> = (0..width * height)
            .map(|k| {
                let (column, row) = place(k);
                let z = f64::from(depth[k]);
                [(column as f64 - cx) / fx * z, (row as f64 - cy) / fy * z, z]
            })
            .collect();
        for _ in 0..self.dice.below(4) {
            if !points.is_empty() {
                let k = self.dice.below(points.len());
                points[k] = hostility.numbers(&mut self.dice, points[k]);
            }
        }
        let scalar = |value: f64| {
            if wide { value.to_ne_bytes().to_vec() } else { (value as f32).to_ne_bytes().to_vec() }
        };
        let size = if wide { 8 } else { 4 };
        let vector = |v: &[f64; 3]| v.iter().flat_map(|x| scalar(*x)).collect::<Vec<u8>>();
        let grid = self.grid((width, height), 3 * size, |column, row| vector(&points[row * width + column]));
        let none = Grid { first: std::ptr::null(), element_stride: 0, row_stride: 0 };
        let weight = self.number(0.5);
        let weights = if self.dice.one_in(3) {
            self.grid((width, height), size, |column, row| {
                scalar(if (column + row) % 5 == 0 { weight } else { 1.0 })
            })
        } else {
            Grid { ..none }
        };
        let normal = [self.number(0.1), self.number(0.2), self.number(-1.0)];
        let normals = if self.dice.one_in(4) {
            self.grid((width, height), 3 * size, |_, _| vector(&normal))
        } else {
            Grid { ..none }
        };
        let (mut claimed_width, mut claimed_height) = (width, height);
        if self.strikes() {
            (claimed_width, claimed_height) =
                [(usize::MAX, 1), (usize::MAX / 2, usize::MAX), (0, 0), (width, 0), (isize::MAX as usize, 3)]
                    [self.dice.below(5)];
        }
        let count = claimed_width.saturating_mul(claimed_height);
        let scalar = if self.strikes() { [0, 3, -1][self.dice.below(3)] } else { if wide { 2 } else { 1 } };
        let value = cylfuse_points_view {
            struct_size: 0,
            scalar: cylfuse_scalar(scalar),
            data: grid.first,
            width: claimed_width,
            height: claimed_height,
            point_stride: grid.element_stride,
            row_stride: grid.row_stride,
            weights: weights.first,
            weight_stride: weights.element_stride,
            weight_row_stride: weights.row_stride,
            normals: normals.first,
            normal_stride: normals.element_stride,
            normal_row_stride: normals.row_stride,
        };
        (self.input(&value), count)
    }

    /// Edge segments; also how many.
    pub fn segments(&mut self) -> (*const cylfuse_segments_view, usize) {
        let count = self.dice.below(6);
        let (w, h) = self.view.size;
        let wide = self.dice.one_in(2);
        let mut all = Vec::new();
        for _ in 0..count {
            let ends = [0, 1, 0, 1].map(|k| self.dice.unit() * [w, h][k] as f64);
            all.push(self.hostility.numbers(&mut self.dice, ends));
        }
        let size = if wide { 8 } else { 4 };
        let mut grid = self.grid((count, 1), 4 * size, |column, _| {
            let number =
                |x: &f64| if wide { x.to_ne_bytes().to_vec() } else { (*x as f32).to_ne_bytes().to_vec() };
            all[column].iter().flat_map(number).collect()
        });
        if count < 2 {
            grid.element_stride = 0;
        }
        let weights: Vec<f64> = (0..count).map(|_| self.number(0.5)).collect();
        let weights = if self.dice.one_in(3) { self.numbers(&weights) } else { std::ptr::null() };
        let claimed =
            if self.strikes() { [usize::MAX, isize::MAX as usize / 8, 0][self.dice.below(3)] } else { count };
        let scalar = if self.strikes() { [0, 3, -1][self.dice.below(3)] } else { if wide { 2 } else { 1 } };
        let value = cylfuse_segments_view {
            struct_size: 0,
            scalar: cylfuse_scalar(scalar),
            data: grid.first,
            count: claimed,
            segment_stride: grid.element_stride,
            weights,
        };
        (self.input(&value), claimed)
    }
}
