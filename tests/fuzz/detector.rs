//! Calls on detectors, and on the fitters that they make.

use crate::calls::{Case, Teller, run};
use crate::inputs::Room;
use crate::{call, checks, setting, watch};
use cylfuse::ffi::*;
use std::ffi::c_void;
use std::ptr::null_mut;

/// Calls by default.
const CALLS: u64 = 6_000;

impl Case<'_> {
    fn detector_options(&mut self) -> cylfuse_detector_options {
        let mut options = std::mem::MaybeUninit::<cylfuse_detector_options>::zeroed();
        // SAFETY: room for the struct, of its size.
        let mut options = unsafe {
            cylfuse_detector_options_init(options.as_mut_ptr(), size_of::<cylfuse_detector_options>());
            options.assume_init()
        };
        let (h, dice) = (self.source.hostility, &mut self.source.dice);
        options.image_use = cylfuse_image_use(h.constant(dice, 1));
        options.max_threads = if self.source.threads { 2 } else { dice.below(2) as u32 };
        options.max_count = h.count(dice, 4).min(1000) as u32;
        options.min_pixels = h.count(dice, 30) as u64;
        options.min_score = h.number(dice, options.min_score);
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

    fn detector_step(&mut self) {
        let detector = self.detector;
        let t = Teller::Detector(detector);
        match self.source.dice.below(12) {
            0 => {
                let options = self.detector_options();
                let options = self.source.input(&options);
                call!(self, t, cylfuse_detector_set_options(detector, options));
                let out = self.source.output();
                if call!(self, t, cylfuse_detector_get_options(detector, out.pointer)) && out.is_whole() {
                    assert!(call!(self, t, cylfuse_detector_set_options(detector, out.pointer)));
                }
            }
            1 => {
                let options = self.source.options();
                let options = self.source.input(&options);
                call!(self, t, cylfuse_detector_set_fit_options(detector, options));
                let out = self.source.output();
                call!(self, t, cylfuse_detector_get_fit_options(detector, out.pointer));
            }
            2 => {
                let callback: cylfuse_detection_progress_fn =
                    if self.source.dice.one_in(3) { None } else { Some(meddle) };
                call!(self, t, cylfuse_detector_set_progress(detector, callback, detector.cast()));
            }
            3..5 => {
                let frame = if self.source.strikes() { null_mut() } else { self.own_frame() };
                if call!(self, t, cylfuse_detector_detect(detector, frame)) {
                    self.fits += 1;
                }
            }
            5 => {
                let (points, _) = self.source.points();
                if call!(self, t, cylfuse_detector_detect_points(detector, points)) {
                    self.fits += 1;
                }
            }
            6 => {
                let size = size_of::<cylfuse_detection>();
                let size =
                    if self.source.strikes() { [0, size - 1, 4097][self.source.dice.below(3)] } else { size };
                let found: Vec<cylfuse_detection> = self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_detector_detections(detector, out, size, capacity, count))
                });
                for detection in found {
                    checks::finite(&[detection.score]);
                    checks::model(&detection.model);
                }
            }
            7 => self.describe_detection(),
            8 => {
                self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_detector_labels(detector, out, capacity, count))
                });
            }
            9 => {
                let index = self.source.dice.below(2);
                self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_detector_indices(detector, index, out, capacity, count))
                });
            }
            10 => {
                let mut fitter = null_mut();
                if call!(self, t, cylfuse_detector_make_fitter(detector, 0, &raw mut fitter)) {
                    let (result, estimate) = (self.source.output(), self.source.output());
                    let own = Teller::Fitter(fitter);
                    if call!(self, own, cylfuse_fitter_fit(fitter, result.pointer, estimate.pointer)) {
                        Self::check_whole(&result, checks::result);
                        Self::check_whole(&estimate, checks::estimate);
                    }
                    call!(self, Teller::None, cylfuse_fitter_destroy(fitter));
                }
            }
            _ => {
                let count = self.source.room::<usize>(1);
                call!(self, t, cylfuse_detector_count(detector, count.pointer));
                let complete = self.source.room::<i32>(1);
                call!(self, t, cylfuse_detector_is_complete(detector, complete.pointer));
                let moved = [self.source.room::<i32>(1), self.source.room::<i32>(1)];
                call!(self, t, cylfuse_detector_depth_moved(detector, moved[0].pointer, moved[1].pointer));
                call!(self, t, cylfuse_detector_cancel(detector));
            }
        }
        self.source.arena.release(false);
    }

    pub fn check_whole<T: Copy>(room: &Room<T>, check: impl Fn(&T)) {
        if let Some(value) = room.is_whole().then(|| room.read()).flatten() {
            check(&value);
        }
    }

    fn describe_detection(&mut self) {
        let detector = self.detector;
        let t = Teller::Detector(detector);
        let index = self.source.dice.below(2);
        let index = self.source.hostility.count(&mut self.source.dice, index);
        let result = self.source.output();
        if call!(self, t, cylfuse_detector_get_result(detector, index, result.pointer)) {
            Self::check_whole(&result, checks::result);
        }
        let estimate = self.source.output();
        if call!(self, t, cylfuse_detector_get_cylinder(detector, index, estimate.pointer)) {
            Self::check_whole(&estimate, checks::estimate);
        }
        let extent = self.source.output();
        if call!(self, t, cylfuse_detector_get_extent(detector, index, extent.pointer)) {
            Self::check_whole(&extent, checks::extent);
        }
    }
}

/// A callback that does what none should do.
unsafe extern "C" fn meddle(progress: *const cylfuse_detection_progress, user_data: *mut c_void) -> i32 {
    let detector: *mut cylfuse_detector = user_data.cast();
    // SAFETY: the library gives a struct, and the detector lives as long as its calls.
    unsafe {
        assert!((*progress).fits_done <= (*progress).fits);
        assert!(cylfuse_detector_destroy(detector) == cylfuse_status::BUSY);
        assert!(cylfuse_detector_detect_points(detector, std::ptr::null()) == cylfuse_status::BUSY);
        i32::from((*progress).fits_done == 3)
    }
}

#[test]
fn detector() {
    let calls = setting("CYLFUSE_FUZZ_CALLS").map_or(CALLS, |calls| calls / 10);
    let (made, scenes, cases) = run(&watch::DETECTOR, calls, |seed, arena, statuses| {
        let mut case = Case::new(seed, arena, statuses);
        case.prepare();
        for _ in 0..20 {
            case.detector_step();
            if case.source.dice.one_in(6) {
                case.fill_frame();
                case.source.arena.release(false);
            }
        }
        case.end()
    });
    println!("fuzz: {made} calls on detectors in {cases} cases, {scenes} scenes searched");
    assert!(scenes > made / 100 || made < 10_000, "too hostile: {scenes} scenes in {made} calls");
}
