//! Sequences of calls: the handles of a case, what is checked after every call, and the run over all cases.

use crate::inputs::{Source, draw_view, may_use_threads};
use crate::memory::{Arena, held};
use crate::statuses::Statuses;
use crate::{setting, watch};
use cylfuse::ffi::*;
use std::ffi::CStr;
use std::ptr::null_mut;

/// Calls by default.
const CALLS: u64 = 101_000;

/// A test ends after so many cases that failed.
const MOST_FAILURES: u64 = 20;

/// Calls of a case.
const STEPS: usize = 60;

/// A case, with the handles that it uses.
pub struct Case<'a> {
    pub source: Source<'a>,
    pub statuses: &'a Statuses,
    pub calls: u64,
    pub fits: u64,
    pub fitters: [*mut cylfuse_fitter; 2],
    frame: *mut cylfuse_frame,
    pub detector: *mut cylfuse_detector,
}

/// Makes a call and returns its status after all checks that need no look at the outputs.
#[macro_export]
macro_rules! call {
    ($case:expr, $handle:expr, $function:ident($($argument:expr),* $(,)?)) => {{
        let status = unsafe { $function($($argument),*) };
        $case.after(stringify!($function), $handle, status)
    }};
}

/// Whose text tells about a call.
#[derive(Clone, Copy)]
pub enum Teller {
    Fitter(*const cylfuse_fitter),
    Frame(*const cylfuse_frame),
    Detector(*const cylfuse_detector),
    None,
}

impl<'a> Case<'a> {
    pub fn new(seed: u64, arena: &'a mut Arena, statuses: &'a Statuses) -> Self {
        let source = Source::new(seed, arena);
        let mut case = Self {
            source,
            statuses,
            calls: 0,
            fits: 0,
            fitters: [null_mut(); 2],
            frame: null_mut(),
            detector: null_mut(),
        };
        for k in 0..2 {
            let mut fitter = null_mut();
            call!(case, Teller::None, cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &raw mut fitter));
            case.fitters[k] = fitter;
        }
        let mut frame = null_mut();
        call!(case, Teller::None, cylfuse_frame_create(CYLFUSE_ABI_VERSION, &raw mut frame));
        let mut detector = null_mut();
        call!(case, Teller::None, cylfuse_detector_create(CYLFUSE_ABI_VERSION, &raw mut detector));
        (case.frame, case.detector) = (frame, detector);
        case
    }

    pub fn end(mut self) -> (u64, u64) {
        for fitter in self.fitters {
            call!(self, Teller::None, cylfuse_fitter_destroy(fitter));
        }
        let (frame, detector) = (self.frame, self.detector);
        call!(self, Teller::None, cylfuse_frame_destroy(frame));
        call!(self, Teller::None, cylfuse_detector_destroy(detector));
        (self.calls, self.fits)
    }

    /// The checks after every call; whether it succeeded.
    pub fn after(&mut self, function: &str, teller: Teller, status: cylfuse_status) -> bool {
        self.calls += 1;
        let text = unsafe {
            CStr::from_ptr(match teller {
                Teller::Fitter(fitter) => cylfuse_fitter_last_error(fitter),
                Teller::Frame(frame) => cylfuse_frame_last_error(frame),
                Teller::Detector(detector) => cylfuse_detector_last_error(detector),
                Teller::None => cylfuse_fitter_last_error(std::ptr::null()),
            })
        };
        let text = text.to_str().unwrap_or_else(|error| panic!("{function}: a text is not UTF-8: {error}"));
        self.statuses.check(function, status.0, text);
        let succeeded = status == cylfuse_status::OK;
        assert_eq!(text.is_empty(), succeeded, "{function} returned {} and says: {text}", status.0);
        assert!(text.is_ascii() && !text.contains('\n'), "{function} says: {text}");
        succeeded
    }

    pub fn fitter(&mut self) -> *mut cylfuse_fitter {
        if self.source.strikes() && self.source.strikes() {
            return null_mut();
        }
        self.fitters[usize::from(self.source.dice.one_in(5))]
    }

    pub fn frame(&mut self) -> *mut cylfuse_frame {
        if self.source.strikes() && self.source.strikes() { null_mut() } else { self.frame }
    }

    /// What most programs do first, so that there is something to go wrong later.
    pub fn prepare(&mut self) {
        for _ in 0..2 {
            let frame = self.frame();
            let (teller, intrinsics) = (Teller::Frame(frame), self.source.intrinsics());
            call!(self, teller, cylfuse_frame_set_intrinsics(frame, intrinsics));
            let depth = self.source.depth();
            call!(self, teller, cylfuse_frame_set_depth(frame, depth));
            let image = self.source.image();
            call!(self, teller, cylfuse_frame_set_image(frame, image));
            self.source.arena.release(false);
            let fitter = self.fitter();
            let mask = self.source.mask();
            call!(self, Teller::Fitter(fitter), cylfuse_fitter_use_frame(fitter, frame, mask));
            self.source.arena.release(false);
        }
    }

    pub fn step(&mut self) {
        match self.source.dice.below(26) {
            0..4 => self.set_up(),
            4..8 => self.push(),
            8..10 => self.fill_frame(),
            10..13 => self.solve(),
            13..17 => self.list(),
            17..20 => self.apply(),
            20..24 => self.without_handle(),
            24 => self.initialise(),
            _ => self.new_view(),
        }
        let take_away = self.source.dice.one_in(4);
        self.source.arena.release(take_away);
    }

    fn new_view(&mut self) {
        self.source.view = draw_view(&mut self.source.dice);
        self.source.view.spoil(&mut self.source.dice);
    }

    pub fn fill_frame(&mut self) {
        let frame = self.frame();
        let t = Teller::Frame(frame);
        match self.source.dice.below(6) {
            0 => {
                let intrinsics = self.source.intrinsics();
                call!(self, t, cylfuse_frame_set_intrinsics(frame, intrinsics));
            }
            1 => {
                let (rotation, translation) = self.source.motion();
                call!(self, t, cylfuse_frame_set_pose(frame, rotation, translation));
            }
            2 => {
                let intrinsics = self.source.intrinsics();
                let (rotation, translation) = self.source.motion();
                call!(self, t, cylfuse_frame_set_depth_camera(frame, intrinsics, rotation, translation));
            }
            3 => {
                let depth = self.source.depth();
                call!(self, t, cylfuse_frame_set_depth(frame, depth));
            }
            4 => {
                let image = self.source.image();
                call!(self, t, cylfuse_frame_set_image(frame, image));
            }
            _ => {
                let mut other = null_mut();
                let version = if self.source.strikes() { 2 } else { CYLFUSE_ABI_VERSION };
                if call!(self, Teller::None, cylfuse_frame_create(version, &raw mut other)) {
                    call!(self, Teller::None, cylfuse_frame_destroy(self.frame));
                    self.frame = other;
                }
            }
        }
    }

    /// The frame of the case.
    pub fn own_frame(&self) -> *mut cylfuse_frame {
        self.frame
    }
}

/// Runs cases until that many calls were made.
pub fn run(
    watch: &'static watch::Watch,
    calls: u64,
    body: impl Fn(u64, &mut Arena, &Statuses) -> (u64, u64),
) -> (u64, u64, u64) {
    let statuses = Statuses::read();
    let mut arena = Arena::new();
    let mut done = (0, 0, 0);
    let mut failed = Vec::new();
    let one = setting("CYLFUSE_FUZZ_CASE");
    let first = one.or(setting("CYLFUSE_FUZZ_FIRST")).unwrap_or(0);
    for case in first.. {
        let before = held();
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            watch.run(case, || body(case, &mut arena, &statuses))
        }));
        if let Ok((made, fits)) = outcome {
            done = (done.0 + made, done.1 + fits, done.2 + 1);
            // What one thread takes another gives back. What a thread keeps for its next calls, such as the memory of
            // products of matrices, is not taken a second time.
            if held() > before && !may_use_threads(case) {
                let again = held();
                watch.run(case, || body(case, &mut arena, &statuses));
                let kept = held() - again;
                if kept > 0 {
                    eprintln!("case {case} keeps {kept} bytes");
                    failed.push(case);
                }
            }
        } else {
            eprintln!("^ in case {case}");
            failed.push(case);
            arena = Arena::new();
        }
        if done.0 >= calls
            || one.is_some()
            || failed.len() as u64 >= setting("CYLFUSE_FUZZ_FAILURES").unwrap_or(MOST_FAILURES)
        {
            break;
        }
    }
    assert!(failed.is_empty(), "in cases {failed:?}");
    done
}

#[test]
fn calls() {
    let calls = setting("CYLFUSE_FUZZ_CALLS").unwrap_or(CALLS);
    let (made, fits, cases) = run(&watch::CALLS, calls, |seed, arena, statuses| {
        let mut case = Case::new(seed, arena, statuses);
        case.prepare();
        for _ in 0..STEPS {
            case.step();
        }
        case.end()
    });
    println!("fuzz: {made} calls in {cases} cases, {fits} fits succeeded");
    assert!(
        fits > made / 500 || made < 10_000,
        "the cases have become too hostile: {fits} fits in {made} calls"
    );
}
