//! One fitter called by several threads, small enough for Miri and ThreadSanitizer: they see every access to the memory
//! behind the handle. `tests/c` has the same at full size.

use super::*;
use std::ffi::CStr;
use std::ptr::{null, null_mut};
use std::thread;

/// Miri takes some thousand times as long.
const CALLS: usize = if cfg!(miri) { 6 } else { 2000 };

const POINTS: usize = if cfg!(miri) { 20 } else { 60 };

/// Points on half of a pipe of radius 50 mm, with an error of 1 mm that is not the same at each.
fn half_a_pipe() -> Vec<[f64; 3]> {
    let point = |k: usize| {
        let (sine, cosine) = libm::sincos(3.0 * k as f64 / POINTS as f64);
        let radius = 0.05 + 1e-3 * ((k * 7 % 11) as f64 / 5.0 - 1.0);
        [radius * cosine, 0.01 * (k % 10) as f64, 0.6 - radius * sine]
    };
    (0..POINTS).map(point).collect()
}

struct Shared(*mut cylfuse_fitter);

// SAFETY: the interface lets threads share a fitter.
unsafe impl Sync for Shared {}

impl Shared {
    fn new() -> Self {
        let mut fitter = null_mut();
        // SAFETY: room for a pointer.
        let made = unsafe { cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &raw mut fitter) };
        assert_eq!(made, cylfuse_status::OK);
        Self(fitter)
    }

    /// With a start close by, so that a fit takes few steps.
    fn with_a_start() -> Self {
        let fitter = Self::new();
        let mut options = std::mem::MaybeUninit::<cylfuse_options>::uninit();
        let start = cylfuse_cylinder { point: [0.0, 0.0, 0.6], direction: [0.0, 1.0, 0.0], radius: 0.05 };
        // SAFETY: room for the struct, which `init` fills.
        let set = unsafe {
            let made = cylfuse_options_init(options.as_mut_ptr(), size_of::<cylfuse_options>());
            assert_eq!(made, cylfuse_status::OK);
            let mut options = options.assume_init();
            options.method = cylfuse_method::POINTS;
            options.start = cylfuse_start::MODEL;
            let set = cylfuse_fitter_set_options(fitter.0, &raw const options);
            assert_eq!(set, cylfuse_status::OK, "{}", fitter.said());
            cylfuse_fitter_set_start_model(fitter.0, &raw const start)
        };
        assert_eq!(set, cylfuse_status::OK, "{}", fitter.said());
        fitter
    }

    fn push(&self, points: &[[f64; 3]]) -> cylfuse_status {
        let mut view = std::mem::MaybeUninit::<cylfuse_points_view>::uninit();
        // SAFETY: room for the struct, which `init` fills; the points live until the call is over.
        unsafe {
            let made = cylfuse_points_view_init(view.as_mut_ptr(), size_of::<cylfuse_points_view>());
            assert_eq!(made, cylfuse_status::OK);
            let mut view = view.assume_init();
            view.scalar = cylfuse_scalar::F64;
            view.data = points.as_ptr().cast();
            view.width = points.len();
            cylfuse_fitter_push_points(self.0, &raw const view, null())
        }
    }

    fn fit(&self) -> cylfuse_status {
        // SAFETY: nothing is asked for.
        unsafe { cylfuse_fitter_fit(self.0, null_mut(), null_mut()) }
    }

    fn points_given(&self) -> Result<u64, cylfuse_status> {
        let mut counts = std::mem::MaybeUninit::<cylfuse_counts>::uninit();
        // SAFETY: room for the struct, which `init` fills.
        unsafe {
            let made = cylfuse_counts_init(counts.as_mut_ptr(), size_of::<cylfuse_counts>());
            assert_eq!(made, cylfuse_status::OK);
            match cylfuse_fitter_counts(self.0, counts.as_mut_ptr()) {
                cylfuse_status::OK => Ok(counts.assume_init().points_given),
                status => Err(status),
            }
        }
    }

    /// How many residuals there are: written into a buffer that has room for just these.
    fn residuals(&self) -> Result<usize, cylfuse_status> {
        let model = cylfuse_cylinder { point: [0.0, 0.0, 0.6], direction: [0.0, 1.0, 0.0], radius: 0.05 };
        let (kind, mut count, mut residuals) = (cylfuse_residual_kind::POINTS, 0, Vec::<f64>::new());
        // SAFETY: the buffer has the capacity that it says.
        unsafe {
            let asked =
                cylfuse_fitter_residuals(self.0, &raw const model, kind, null_mut(), 0, &raw mut count);
            assert_eq!(asked, cylfuse_status::BUFFER_TOO_SMALL);
            residuals.resize(count, f64::NAN);
            let out = residuals.as_mut_ptr();
            match cylfuse_fitter_residuals(self.0, &raw const model, kind, out, count, &raw mut count) {
                cylfuse_status::OK if residuals.iter().all(|residual| residual.is_finite()) => Ok(count),
                status => Err(status),
            }
        }
    }

    fn said(&self) -> String {
        // SAFETY: a text of this thread, which lives until its next call.
        unsafe { CStr::from_ptr(cylfuse_fitter_last_error(self.0)) }.to_str().unwrap().to_owned()
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: no thread has it any more.
        assert_eq!(unsafe { cylfuse_fitter_destroy(self.0) }, cylfuse_status::OK);
    }
}

#[test]
fn calls_of_several_threads_on_a_fitter_run_one_by_one_or_are_refused() {
    let (fitter, points) = (Shared::new(), half_a_pipe());
    let write = || {
        for _ in 0..CALLS {
            // A thread that the machine puts aside within a call keeps the others out for as long.
            while fitter.push(&points[..3]) != cylfuse_status::OK {
                assert!(fitter.said().contains("another call"), "{}", fitter.said());
                thread::yield_now();
            }
        }
    };
    let read = || {
        for _ in 0..CALLS {
            match fitter.points_given() {
                Ok(count) => assert_eq!(count % 3, 0),
                Err(status) => assert_eq!(status, cylfuse_status::BUSY),
            }
            // SAFETY: any thread may cancel.
            assert_eq!(unsafe { cylfuse_fitter_cancel(fitter.0) }, cylfuse_status::OK);
        }
    };
    thread::scope(|scope| {
        scope.spawn(write);
        scope.spawn(read);
        write();
    });
    let pushed = 2 * CALLS * 3;
    assert_eq!(fitter.points_given(), Ok(pushed as u64));
    assert_eq!(fitter.residuals(), Ok(pushed));
}

#[test]
#[cfg_attr(miri, ignore = "a fit takes minutes")]
fn fits_side_by_side_stay_in_their_fitters() {
    let fitters: Vec<Shared> = (0..3).map(|_| Shared::with_a_start()).collect();
    let points = half_a_pipe();
    // The last has nothing to fit.
    for fitter in &fitters[..2] {
        assert_eq!(fitter.push(&points), cylfuse_status::OK);
    }
    let pointers: Vec<_> = fitters.iter().map(|fitter| fitter.0).collect();
    let mut statuses = [cylfuse_status::OK; 3];
    // SAFETY: as many fitters and statuses as it says.
    unsafe {
        cylfuse_fit_all(pointers.as_ptr(), 3, 2, None, null_mut(), statuses.as_mut_ptr());
    }
    assert_eq!(statuses[..2], [cylfuse_status::OK; 2]);
    assert!(statuses[2] != cylfuse_status::OK);
    assert_eq!(fitters[0].fit(), cylfuse_status::OK, "{}", fitters[0].said());
}
