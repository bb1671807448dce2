//! Many fits at once.

use super::callbacks::cylfuse_fit_all_fn;
use super::handle::{change_quietly, cylfuse_fitter, stateless};
use super::lists::{Room, list};
use super::status::{Failure, cylfuse_status};
use super::texts::{self, Text};
use crate::error::{cancelled_if, with_room};
use crate::fitter::each;
use std::ffi::c_void;
use std::ops::ControlFlow;

/// A fitter on any thread.
struct Shared<'a>(Option<&'a cylfuse_fitter>);

// SAFETY: what threads reach of a fitter is atomic, locked or guarded by its access, as where the caller's own threads
// make calls. The callbacks in it, whose pointers are the caller's, are not called here.
unsafe impl Send for Shared<'_> {}

/// Fits many fitters, several at once, each as `cylfuse_fitter_fit` does. The results stay in the fitters, for
/// `cylfuse_fitter_get_result` and all else that can be asked of a fit; a fit that fails has its status in the list, and
/// its text in `cylfuse_fitter_last_error` of its fitter until the next call on that, and the others go on. For the next
/// frames: `cylfuse_fitter_clear`, push, and this again on the same fitters, which keep the room of their data; the memory
/// of the calls is shared by all on a thread.
///
/// The callbacks of the fitters are not called.
///
/// @param fitters the fitters, each once. One that is busy has the status BUSY. One that is NULL has NULL_POINTER and no
///   text, as there is no fitter to ask.
/// @param count how many there are
/// @param threads how many fits run at the same time, 0 for as many as the machine has processors; 1 starts no thread.
///   More than 256 are 256, and there are fewer where the system does not start that many. The results have the same bits
///   for any number. Each fit takes `max_threads` of its options beside that, of which the default, 1, is right here.
/// @param callback is called after each fit, and may stop the rest; NULL for none
/// @param user_data handed to the callback; may be NULL
/// @param out_statuses where the statuses of the `count` fits go, in the order of the fitters
/// @return OK when all fits ended, whatever their statuses; CANCELLED when the callback stopped them, where those that had
///   not ended have the status CANCELLED, too; INVALID_ARGUMENT for a fitter that is there twice, OUT_OF_MEMORY, and then
///   nothing was done
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fit_all(
    fitters: *const *mut cylfuse_fitter,
    count: usize,
    threads: u32,
    callback: cylfuse_fit_all_fn,
    user_data: *mut c_void,
    out_statuses: *mut cylfuse_status,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `fitters` is NULL or points to `count` pointers, each NULL or to a living fitter.
        let mut fitters = unsafe { read(fitters, count) }?;
        // SAFETY: as the header asks, `out_statuses` is NULL or has room for `count` statuses.
        let out = unsafe { Room::new(out_statuses, count, count, "out_statuses") }?;
        // The callback asks fitters for their texts, not this thread for that of an earlier call.
        texts::keep(texts::NO_HANDLE, Text::EMPTY);
        let caller = texts::this_thread();
        let mut stopped = false;
        let mut ended = |index: usize, status: &cylfuse_status| {
            // SAFETY: the caller gave the function for this use, with its `user_data`.
            stopped = callback.is_some_and(|function| unsafe { function(index, *status, user_data) } != 0);
            if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let statuses =
            each(&mut fitters, threads as usize, |fitter, stopped| fit(fitter, stopped, caller), &mut ended);
        out.fill(statuses.into_iter());
        Ok(cancelled_if(stopped)?)
    })
}

fn fit(fitter: &Shared<'_>, stopped: &dyn Fn() -> bool, caller: u64) -> cylfuse_status {
    let Some(fitter) = fitter.0 else { return cylfuse_status::NULL_POINTER };
    let status = change_quietly(&fitter.0, |content, cancel| {
        content.fitter.fit_until(&|| stopped() || cancel.is_asked_for())?;
        Ok(())
    });
    fitter.0.made_for(caller, status);
    status
}

/// The fitters of a list, none of them twice.
///
/// # Safety
/// `fitters` is NULL or points to `count` pointers, which are NULL or point to fitters that outlive the list.
unsafe fn read<'a>(fitters: *const *mut cylfuse_fitter, count: usize) -> Result<Vec<Shared<'a>>, Failure> {
    // SAFETY: the caller promises NULL or `count` pointers.
    let pointers = unsafe { list(fitters, count, "fitters") }?;
    let mut shared = with_room(count, "the list of fitters")?;
    // SAFETY: the caller promises that each is NULL or a fitter that outlives the list.
    shared.extend(pointers.map(|pointer| Shared(unsafe { pointer.as_ref() })));
    let address = |index: usize| shared[index].0.map(std::ptr::from_ref);
    let mut sorted: Vec<usize> = (0..count).filter(|&index| address(index).is_some()).collect();
    sorted.sort_by_key(|&index| (address(index), index));
    match sorted.windows(2).find(|pair| address(pair[0]) == address(pair[1])) {
        Some(&[first, second]) => {
            let value = format!("the same as fitters[{first}]");
            Err(Failure::argument(format!("fitters[{second}]"), value, "be another fitter"))
        }
        _ => Ok(shared),
    }
}
