//! What is handed to a call: structs of every size, grids with every stride, NULL.

use crate::memory::Arena;
use crate::random_views::{Dice, View};
use crate::values::Hostility;
use cylfuse::camera::Distortion;
use cylfuse::ffi::*;
use std::ffi::c_void;

/// What a case draws from.
pub struct Source<'a> {
    pub dice: Dice,
    pub arena: &'a mut Arena,
    pub hostility: Hostility,
    pub view: View,
    pub threads: bool,
}

/// Whether a case sets options with more than one thread.
pub fn may_use_threads(case: u64) -> bool {
    case.is_multiple_of(4)
}

/// A grid of elements in memory.
pub struct Grid {
    pub first: *const c_void,
    pub element_stride: isize,
    pub row_stride: isize,
}

/// Room for a struct or numbers that a call writes.
pub struct Room<T> {
    pub pointer: *mut T,
    size: usize,
}

impl<T: Copy> Room<T> {
    /// What was written, zeros where there was no room.
    pub fn read(&self) -> Option<T> {
        if self.pointer.is_null() {
            return None;
        }
        let mut value = std::mem::MaybeUninit::<T>::zeroed();
        let known = self.size.min(size_of::<T>());
        // SAFETY: the room is still there, and the structs of the interface take any bits.
        unsafe {
            self.pointer.cast::<u8>().copy_to_nonoverlapping(value.as_mut_ptr().cast(), known);
            Some(value.assume_init())
        }
    }

    /// Whether all of the struct was in it.
    pub fn is_whole(&self) -> bool {
        self.size >= size_of::<T>()
    }
}

impl<'a> Source<'a> {
    pub fn new(seed: u64, arena: &'a mut Arena) -> Self {
        let mut dice = Dice::new(seed);
        let hostility = Hostility::drawn(&mut dice);
        let mut view = View::new(&mut dice);
        if dice.one_in(2) {
            view.spoil(&mut dice);
        }
        Self { dice, arena, hostility, view, threads: may_use_threads(seed) }
    }

    pub fn strikes(&mut self) -> bool {
        self.hostility.strikes(&mut self.dice)
    }

    pub fn number(&mut self, number: f64) -> f64 {
        self.hostility.number(&mut self.dice, number)
    }

    pub fn constant(&mut self, last: i32) -> i32 {
        self.hostility.constant(&mut self.dice, last)
    }

    pub fn place(&mut self, bytes: &[u8]) -> *mut u8 {
        let at_end = !self.dice.one_in(4);
        self.arena.place(bytes, at_end)
    }

    /// Numbers to be read, or NULL.
    pub fn numbers(&mut self, numbers: &[f64]) -> *const f64 {
        if self.strikes() {
            return std::ptr::null();
        }
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
        self.place(&bytes).cast()
    }

    /// Room for `count` values, or NULL.
    pub fn room<T>(&mut self, count: usize) -> Room<T> {
        if self.strikes() {
            return Room { pointer: std::ptr::null_mut(), size: 0 };
        }
        let size = count * size_of::<T>();
        Room { pointer: self.place(&vec![0xa5; size]).cast(), size }
    }

    /// A `struct_size` and the bytes that are there: those that the caller promises, as far as a call may look.
    fn struct_size(&mut self, known: usize) -> (u32, usize) {
        if !self.strikes() {
            return (known as u32, known);
        }
        let size = [0, 4, 3, known - 1, known - 8, known + 1, known + 8, 4096, 4097, u32::MAX as usize]
            [self.dice.below(10)];
        // A size beyond the largest is refused by itself.
        (size as u32, if size > 4096 { 4 } else { size.max(4) })
    }

    /// A struct to be read, in any version, or NULL.
    pub fn input<T: Copy>(&mut self, value: &T) -> *const T {
        if self.strikes() {
            return std::ptr::null();
        }
        let known = size_of::<T>();
        let (given, there) = self.struct_size(known);
        let rest = if self.dice.one_in(3) { 0x80 } else { 0 };
        let mut bytes = vec![rest; there];
        // SAFETY: the structs of the interface have no padding.
        let whole = unsafe { std::slice::from_raw_parts(std::ptr::from_ref(value).cast::<u8>(), known) };
        bytes[..there.min(known)].copy_from_slice(&whole[..there.min(known)]);
        bytes[..4].copy_from_slice(&given.to_ne_bytes());
        let placed = self.place(&bytes);
        if self.dice.one_in(8) {
            self.arena.read_only();
        }
        placed.cast_const().cast()
    }

    /// Room for a struct with a size, or NULL.
    pub fn output<T: Copy>(&mut self) -> Room<T> {
        if self.strikes() {
            return Room { pointer: std::ptr::null_mut(), size: 0 };
        }
        let (given, there) = self.struct_size(size_of::<T>());
        let mut bytes = vec![0xa5; there];
        bytes[..4].copy_from_slice(&given.to_ne_bytes());
        Room { pointer: self.place(&bytes).cast(), size: there }
    }

    pub fn cylinder(&mut self) -> cylfuse_cylinder {
        let radius = 10_f64.powf(self.dice.between(-2.0, 0.3));
        let near = [self.dice.normal() * 0.4, self.dice.normal() * 0.3, self.dice.between(0.3, 2.0)];
        let direction = [self.dice.normal(), self.dice.normal(), self.dice.normal()];
        cylfuse_cylinder {
            point: self.hostility.numbers(&mut self.dice, near),
            direction: self.hostility.numbers(&mut self.dice, direction),
            radius: self.number(radius),
        }
    }

    /// A cylinder in memory, or NULL.
    pub fn model(&mut self) -> *const cylfuse_cylinder {
        let cylfuse_cylinder { point, direction, radius } = self.cylinder();
        let numbers: Vec<f64> = point.into_iter().chain(direction).chain([radius]).collect();
        self.numbers(&numbers).cast()
    }

    /// The same, NULL more often where it stands for the last result.
    pub fn model_or_last(&mut self) -> *const cylfuse_cylinder {
        if self.dice.one_in(2) { std::ptr::null() } else { self.model() }
    }

    pub fn intrinsics(&mut self) -> *const cylfuse_intrinsics {
        let value = self.intrinsics_value();
        self.input(&value)
    }

    pub fn intrinsics_value(&mut self) -> cylfuse_intrinsics {
        let own = &self.view.intrinsics;
        let (fx, fy, cx, cy) = (own.fx, own.fy, own.cx, own.cy);
        let (width, height) = (own.width, own.height);
        let (model, coefficients) = match own.distortion {
            Distortion::BrownConrady(all) => (1, all),
            Distortion::KannalaBrandt([a, b, c, d]) => (2, [a, b, c, d, 0.0, 0.0, 0.0, 0.0]),
            Distortion::None => (0, [0.0; 8]),
        };
        let model = if self.strikes() { self.constant(2) } else { model };
        let (width, height) = if self.strikes() {
            [
                (0, height),
                (width, 0),
                (1, 1),
                (u32::MAX, u32::MAX),
                (1 << 28, 1),
                (1, 1 << 28),
                (height, width),
            ][self.dice.below(7)]
        } else {
            (width, height)
        };
        cylfuse_intrinsics {
            struct_size: 0,
            distortion_model: cylfuse_distortion(model),
            width,
            height,
            fx: self.number(fx),
            fy: self.number(fy),
            cx: self.number(cx),
            cy: self.number(cy),
            distortion: self.hostility.numbers(&mut self.dice, coefficients),
        }
    }

    /// Rotation and translation, each perhaps NULL.
    pub fn motion(&mut self) -> (*const f64, *const f64) {
        let (sin, cos) = (self.dice.normal() * 0.2).sin_cos();
        let rotation = [cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0];
        let translation = [self.dice.normal() * 0.1, self.dice.normal() * 0.1, self.dice.normal() * 0.1];
        let rotation = self.hostility.numbers(&mut self.dice, rotation);
        let translation = self.hostility.numbers(&mut self.dice, translation);
        (self.numbers(&rotation), self.numbers(&translation))
    }

    pub fn options(&mut self) -> cylfuse_options {
        let mut options = std::mem::MaybeUninit::<cylfuse_options>::zeroed();
        // SAFETY: room for the struct, of its size.
        let mut options = unsafe {
            cylfuse_options_init(options.as_mut_ptr(), size_of::<cylfuse_options>());
            options.assume_init()
        };
        let (h, dice) = (self.hostility, &mut self.dice);
        if dice.one_in(2) {
            options.method = cylfuse_method(h.constant(dice, 3));
            options.objective = cylfuse_objective(h.constant(dice, 1));
            options.start = cylfuse_start(h.constant(dice, 4));
            options.near_wall = cylfuse_near_wall(h.constant(dice, 2));
            options.chart = cylfuse_chart(h.constant(dice, 2));
            options.edge_use = cylfuse_edge_use(h.constant(dice, 1));
            options.extent_rule = cylfuse_extent_rule(h.constant(dice, 2));
            options.edge_weight = [0.0, 0.6, 1.0][dice.below(3)];
        }
        options.max_threads = if self.threads { 2 } else { dice.below(2) as u32 };
        options.max_iterations = h.count(dice, 400).min(100_000) as u32;
        options.seed = dice.below(1000) as u64;
        options.ransac_max_iterations = h.count(dice, 100).min(2000) as u64;
        for field in [
            &mut options.cost_tolerance,
            &mut options.gradient_tolerance,
            &mut options.step_tolerance,
            &mut options.initial_lambda,
            &mut options.lambda_factor,
            &mut options.max_lambda,
            &mut options.edge_weight,
            &mut options.ransac_threshold,
            &mut options.independent_points,
            &mut options.depth_noise,
            &mut options.image_noise,
            &mut options.edge_noise,
            &mut options.mask_noise,
            &mut options.image_blur,
            &mut options.drawn_pixel,
        ] {
            *field = h.number(dice, *field);
        }
        if dice.one_in(4) {
            options.radius_min = h.number(dice, 0.01);
            options.radius_max = h.number(dice, 0.5);
        }
        if dice.one_in(4) {
            options.axis = [dice.normal(), dice.normal(), dice.normal()].map(|x| h.number(dice, x));
            options.axis_max_angle = h.number(dice, 0.3);
        }
        options
    }

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
