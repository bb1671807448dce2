//! All cylinders of a scene.

use super::callbacks::{Callback, cylfuse_detection_progress_fn};
use super::frame::{content_of, cylfuse_frame};
use super::handle::{Cancel, Handle, Opaque, borrow, cancel, enter_to_change, enter_to_read, last_error};
use super::library::{create, destroy};
use super::options::saturated;
use super::outcomes::cylfuse_detection_phase;
use super::results::cylfuse_detection_progress;
use super::sized::{Output, read};
use super::status::{Failure, cylfuse_status};
use super::structs::{cylfuse_detector_options, cylfuse_options, cylfuse_points_view};
use super::views;
use crate::error::{Error, Result as LibraryResult};
use crate::scene::{Detector, DetectorOptions, Found, Observer, Progress, Scene};
use std::ffi::{c_char, c_void};
use std::ops::ControlFlow;

/// Finds all cylinders of a frame or a cloud and fits each by the full method: holds options and the last scene. Opaque;
/// made by `cylfuse_detector_create`.
///
/// A detector may move between threads. Calls that take a `const cylfuse_detector *` run side by side; a call that may
/// change it runs alone: what would disturb it, from another thread or from a callback, returns `CYLFUSE_STATUS_BUSY`.
/// Different detectors run in parallel.
#[derive(Default)]
pub struct cylfuse_detector(Handle<DetectorContent>);

/// What calls on a detector work on.
#[derive(Default)]
pub(super) struct DetectorContent {
    detector: Detector,
    scene: Option<Scene>,
    progress: Callback<cylfuse_detection_progress_fn>,
}

impl Opaque for cylfuse_detector {
    type Content = DetectorContent;
    const NAME: &'static str = "detector";

    fn handle(&self) -> &Handle<DetectorContent> {
        &self.0
    }
}

/// Readers on several threads share detector and scene.
const _: () = {
    const fn shared_by_readers<T: Sync>() {}
    shared_by_readers::<(Detector, Scene)>();
};

impl DetectorContent {
    pub fn scene(&self) -> Result<&Scene, Failure> {
        let missing = Error::BadState {
            call: "asking for cylinders",
            missing: "a scene",
            remedy: "search a frame or points first",
        };
        self.scene.as_ref().ok_or(missing.into())
    }

    pub fn cylinder(&self, index: usize) -> Result<&Found, Failure> {
        let cylinders = &self.scene()?.cylinders;
        cylinders.get(index).ok_or_else(|| {
            let requirement = format!("be less than the number of cylinders, {}", cylinders.len());
            Failure::argument("index", index, requirement)
        })
    }

    fn change_options(&mut self, change: impl FnOnce(&mut DetectorOptions)) -> Result<(), Failure> {
        let mut options = *self.detector.options();
        change(&mut options);
        Ok(self.detector.set_options(options)?)
    }

    /// Searches, hands over how far it is, and keeps the scene.
    fn search(
        &mut self,
        cancel: &Cancel<'_>,
        search: impl FnOnce(&Detector, &mut Observer<'_>) -> LibraryResult<Scene>,
    ) -> Result<(), Failure> {
        let Callback { function, user_data } = self.progress;
        let mut progress = |progress: Progress| {
            let Some(function) = function else { return ControlFlow::Continue(()) };
            let (phase, done, count) = match progress {
                Progress::Search => (cylfuse_detection_phase::SEARCH, 0, 0),
                Progress::Fit { done, count } => (cylfuse_detection_phase::FIT, done, count),
            };
            let state = cylfuse_detection_progress {
                struct_size: size_of::<cylfuse_detection_progress>() as u32,
                phase,
                fits_done: saturated(done),
                fits: saturated(count),
            };
            // SAFETY: the caller gave the function for this use; the struct lives until it returns.
            let stop = unsafe { function(&raw const state, user_data) } != 0;
            if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let stopped = || cancel.is_asked_for();
        let scene = search(&self.detector, &mut Observer { progress: &mut progress, stopped: &stopped })?;
        self.scene = Some(scene);
        Ok(())
    }
}

/// Makes a detector with default options. It keeps the memory of its calls for the next ones, 3 to 25 MB after frames of
/// 640 × 480 pixels: use it again.
///
/// @param abi_version `CYLFUSE_ABI_VERSION`
/// @param out_detector where the detector goes, for `cylfuse_detector_destroy` in the end; set to NULL when the call
///   fails
/// @return ABI_MISMATCH when the program was compiled for another version of the interface, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_create(
    abi_version: u32,
    out_detector: *mut *mut cylfuse_detector,
) -> cylfuse_status {
    // SAFETY: as the header asks, `out_detector` is NULL or writable.
    unsafe { create(abi_version, out_detector, "out_detector") }
}

/// Destroys a detector and frees what it holds. Fitters that it made stay. No other call on it may be running or follow.
///
/// @param detector the detector; NULL does nothing
/// @return BUSY when a call on the detector is running, which a call from its callback always finds; nothing is
///   destroyed then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_destroy(detector: *mut cylfuse_detector) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive, and no other call on it runs or follows.
    unsafe { destroy(detector) }
}

/// Why the last call on a detector failed; see `cylfuse_fitter_last_error`, whose rules hold here too.
///
/// @param detector the detector, which may be busy; NULL asks for the last call of this thread, whatever it was on
/// @return a text that is valid until the next call of this thread that returns a status or asks for such a text; never
///   NULL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_last_error(detector: *const cylfuse_detector) -> *const c_char {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    unsafe { last_error(detector) }
}

/// Asks the calls that are running on a detector to stop: they return CANCELLED, during the search or before the next
/// iteration of a fit. When no call is running it does nothing. May be called from any thread and from callbacks.
///
/// @param detector the detector
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_cancel(detector: *mut cylfuse_detector) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    unsafe { cancel(detector) }
}

/// Replaces the options of a detector: of the search, and of the scene as a whole.
///
/// @param detector the detector
/// @param options copied
/// @return INVALID_ARGUMENT for a value out of range, STRUCT_SIZE; the old options stay then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_set_options(
    detector: *mut cylfuse_detector,
    options: *const cylfuse_detector_options,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_change(detector, |content, _| {
        // SAFETY: as the header asks, `options` is NULL or a struct of its `struct_size`.
        let options = unsafe { read(options, "options") }?;
        let given = options.read(&content.detector.options().fit)?;
        content.change_options(|options| *options = given)
    })
}

/// Reads the options of a detector.
///
/// @param detector the detector
/// @param out_options where they go; `cylfuse_detector_options_init` comes before
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_get_options(
    detector: *const cylfuse_detector,
    out_options: *mut cylfuse_detector_options,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_options` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_options, "out_options") }?;
        out.write(&content.detector.options().into());
        Ok(())
    })
}

/// Replaces the options of the fits of a detector. Limits, threads and the start are those of the detector: here
/// `radius_min`, `radius_max`, `axis`, `axis_max_angle`, `max_threads` and `start` must have their defaults.
///
/// @param detector the detector
/// @param options copied
/// @return INVALID_ARGUMENT for a value out of range and for one that the detector sets, STRUCT_SIZE; the old options
///   stay then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_set_fit_options(
    detector: *mut cylfuse_detector,
    options: *const cylfuse_options,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_change(detector, |content, _| {
        // SAFETY: as the header asks, `options` is NULL or a struct of its `struct_size`.
        let options = unsafe { read(options, "options") }?;
        let fit = options.read()?;
        content.change_options(|options| options.fit = fit)
    })
}

/// Reads the options of the fits of a detector.
///
/// @param detector the detector
/// @param out_options where they go; `cylfuse_options_init` comes before
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_get_fit_options(
    detector: *const cylfuse_detector,
    out_options: *mut cylfuse_options,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_options` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_options, "out_options") }?;
        out.write(&(&content.detector.options().fit).into());
        Ok(())
    })
}

/// Sets or takes away the progress callback of a detector.
///
/// @param detector the detector
/// @param callback NULL for none
/// @param user_data handed to the callback, kept until the callback is replaced; may be NULL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_set_progress(
    detector: *mut cylfuse_detector,
    callback: cylfuse_detection_progress_fn,
    user_data: *mut c_void,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_change(detector, |content, _| {
        content.progress = Callback { function: callback, user_data };
        Ok(())
    })
}

/// Finds all cylinders in the depth image of a frame, and fits each to its region by depth and image. Results are in the
/// reference frame, to which the pose of the frame leads. The scene takes the place of the last one.
///
/// @param detector the detector
/// @param frame the frame, with intrinsics and a depth image; shared and not copied. It may be changed or destroyed
///   afterwards, of which the scene sees nothing.
/// @return BAD_STATE without intrinsics or depth, UNSUPPORTED for options of the fits that need edges, BUSY when the frame
///   is being filled, OUT_OF_MEMORY, CANCELLED; the last scene stays then. A scene without any cylinder is none of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_detect(
    detector: *mut cylfuse_detector,
    frame: *const cylfuse_frame,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_change(detector, |content, cancel| {
        // SAFETY: as the header asks, `frame` is NULL or alive.
        let frame = content_of(unsafe { borrow(frame) }?)?;
        content.search(cancel, |detector, observer| detector.detect_with(&frame, observer))
    })
}

/// Finds all cylinders in a cloud, organised or not, and fits each to its points. It is looked at from where
/// one sensor has seen it, in its origin or where the densities of the points tell; other clouds are looked at from all
/// sides, which takes about ten times as long. Points with a coordinate that is not finite or a weight of 0 are left
/// out. The scene takes the place of the last one.
///
/// @param detector the detector
/// @param points read during the call only
/// @return INVALID_ARGUMENT for a negative weight or a bad stride, UNSUPPORTED for options of the fits that need edges,
///   OUT_OF_MEMORY, CANCELLED; the last scene stays then. A scene without any cylinder is none of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_detect_points(
    detector: *mut cylfuse_detector,
    points: *const cylfuse_points_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_change(detector, |content, cancel| {
        // SAFETY: as the header asks, `points` is NULL or points that can be read.
        let view = unsafe { read(points, "points") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let points = unsafe { views::points_view(&view) }?;
        content.search(cancel, |detector, observer| detector.detect_points_with(&points, observer))
    })
}
