//! What is handed to a call: structs of every size, numbers, NULL.

use crate::memory::Arena;
use crate::random_views::{Dice, View};
use crate::values::Hostility;
use cylfuse::camera::Distortion;
use cylfuse::ffi::*;

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

/// A view, but for one in eight on a small image: the time of a call goes with the pixels, what it does hardly.
pub fn draw_view(dice: &mut Dice) -> View {
    if dice.one_in(8) {
        return View::new(dice);
    }
    let size = [(32, 24), (48, 36), (24, 40), (64, 48), (64, 17)][dice.below(5)];
    View::of_size(dice, size)
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
        let mut view = draw_view(&mut dice);
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
}
