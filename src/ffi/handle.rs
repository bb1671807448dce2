//! What is behind an opaque handle: many readers or one writer at a time, a text for each failure.

use super::access::Access;
use super::callbacks::{Callback, Log, cylfuse_progress_fn};
use super::constants::cylfuse_log_level;
use super::guard::guard;
use super::status::{Failure, cylfuse_status};
use super::texts::{self, Text};
use crate::fitter::Fitter;
use std::cell::UnsafeCell;
use std::ffi::c_char;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Estimates one cylinder: holds options, views with their data, and the last result. Opaque; made by
/// `cylfuse_fitter_create`.
///
/// A fitter may move between threads. Calls that take a `const cylfuse_fitter *` run side by side; a call that may
/// change it runs alone: what would disturb it, from another thread or from a callback, returns
/// `CYLFUSE_STATUS_BUSY`. Different fitters run in parallel.
#[derive(Default)]
pub struct cylfuse_fitter(pub(super) Handle<Content>);

/// What calls on a fitter work on.
#[derive(Default)]
pub(super) struct Content {
    pub fitter: Fitter,
    pub progress: Callback<cylfuse_progress_fn>,
    pub log: Log,
}

impl Opaque for cylfuse_fitter {
    type Content = Content;
    const NAME: &'static str = "fitter";

    fn handle(&self) -> &Handle<Content> {
        &self.0
    }

    fn log(content: &Content) -> Log {
        content.log
    }
}

/// Readers on several threads share the fitter itself. The pointers in callbacks are the caller's business.
const _: () = {
    const fn shared_by_readers<T: Sync>() {}
    shared_by_readers::<Fitter>();
};

/// What a pointer of the interface leads to. It is only ever reached by shared references: all that other threads reach of it is atomic,
/// locked or guarded by `access`.
pub(super) trait Opaque {
    /// What calls work on.
    type Content;

    /// The name of the argument of calls.
    const NAME: &'static str;

    fn handle(&self) -> &Handle<Self::Content>;

    /// Where the log lines of calls go.
    fn log(_content: &Self::Content) -> Log {
        Log::default()
    }
}

const BUSY: &str = "the handle is busy in another call; wait until that has returned, or, in a callback, make the call after it";

/// What the calls on a handle share.
pub(super) struct Handle<C> {
    /// Tells handles apart that had the same address one after the other.
    serial: u64,
    /// Who may touch `content`.
    access: Access,
    poisoned: AtomicBool,
    /// How often it was asked to cancel.
    cancels: AtomicU64,
    /// Text of the last call that finished.
    text: Mutex<Text>,
    /// The thread whose last call on the handle was one of many at once that found it busy on another thread.
    refused: AtomicU64,
    content: UnsafeCell<C>,
}

/// Tells a call whether it was asked to stop since it began.
pub(super) struct Cancel<'a> {
    cancels: &'a AtomicU64,
    before: u64,
}

impl Cancel<'_> {
    pub fn is_asked_for(&self) -> bool {
        self.cancels.load(Ordering::Acquire) != self.before
    }
}

impl<C: Default> Default for Handle<C> {
    fn default() -> Self {
        Self::new(C::default())
    }
}

impl<C> Handle<C> {
    pub fn new(content: C) -> Self {
        static SERIALS: AtomicU64 = AtomicU64::new(1);
        Self {
            serial: SERIALS.fetch_add(1, Ordering::Relaxed),
            access: Access::default(),
            poisoned: AtomicBool::new(false),
            cancels: AtomicU64::new(0),
            text: Mutex::new(Text::EMPTY),
            refused: AtomicU64::new(texts::NO_THREAD),
            content: UnsafeCell::new(content),
        }
    }

    fn cancel(&self) -> cylfuse_status {
        if self.is_poisoned() {
            return cylfuse_status::PANIC;
        }
        self.cancels.fetch_add(1, Ordering::AcqRel);
        self.keep(Text::EMPTY);
        cylfuse_status::OK
    }

    /// Keeps all other calls out for good, before the handle is destroyed; false when one is running.
    pub fn close(&self) -> bool {
        let closed = self.access.try_write();
        if !closed {
            self.busy();
        }
        closed
    }

    /// The text of the last call of this thread on the handle, or of any thread when this one has made another call
    /// since.
    fn last_error(&self) -> *const c_char {
        texts::last(self.serial, || {
            if self.refused.load(Ordering::Relaxed) == texts::this_thread() {
                return Text::new(BUSY);
            }
            *self.text()
        })
    }

    /// Notes how a call ended that another thread made for this one: the text that the handle is busy would else be with
    /// the other thread. Of several threads that were refused the last one is told.
    pub fn made_for(&self, thread: u64, status: cylfuse_status) {
        if status == cylfuse_status::BUSY {
            self.refused.store(thread, Ordering::Relaxed);
        } else {
            self.forget_refusal(thread);
        }
    }

    fn forget_refusal(&self, thread: u64) {
        // Failing means that there was none.
        let none = texts::NO_THREAD;
        let _ = self.refused.compare_exchange(thread, none, Ordering::Relaxed, Ordering::Relaxed);
    }

    /// Keeps the text of a call of this thread.
    fn keep(&self, text: Text) {
        self.forget_refusal(texts::this_thread());
        texts::keep(self.serial, text);
    }

    fn text(&self) -> MutexGuard<'_, Text> {
        // A text is copied whole or not at all, so that a panic cannot leave half of one.
        self.text.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_poisoned(&self) -> bool {
        self.poisoned.load(Ordering::Acquire)
    }

    fn busy(&self) -> cylfuse_status {
        self.keep(Text::new(BUSY));
        cylfuse_status::BUSY
    }

    /// Runs a call that has access.
    fn run(&self, call: impl FnOnce(&Cancel<'_>) -> Outcome) -> cylfuse_status {
        // Compiled for every call: what does not depend on it is in functions of its own.
        match self.begin() {
            Some(cancel) => self.end(guard(|| call(&cancel))),
            None => cylfuse_status::PANIC,
        }
    }

    /// `None` after a panic.
    #[inline(never)]
    fn begin(&self) -> Option<Cancel<'_>> {
        if self.is_poisoned() {
            self.keep(*self.text());
            return None;
        }
        Some(Cancel { cancels: &self.cancels, before: self.cancels.load(Ordering::Acquire) })
    }

    /// Keeps the text of a call; after a panic no other call gets in.
    #[inline(never)]
    fn end(&self, outcome: Result<Outcome, String>) -> cylfuse_status {
        let (status, text) = outcome.unwrap_or_else(|panic| {
            self.poisoned.store(true, Ordering::Release);
            let text = format!("defect of the library, destroy the handle: {panic}");
            (cylfuse_status::PANIC, Text::new(&text))
        });
        *self.text() = text;
        self.keep(text);
        status
    }
}

type Outcome = (cylfuse_status, Text);

/// Writes a failure to the log, and makes a status and a text of it.
#[inline(never)]
fn log_outcome(log: Log, result: Result<(), Failure>) -> Outcome {
    let Err(failure) = result else { return (cylfuse_status::OK, Text::EMPTY) };
    let text = failure.to_string();
    // Without any room it was a question how much is needed.
    let asked = matches!(failure, Failure::BufferTooSmall { capacity: 0, .. });
    let level = if asked { cylfuse_log_level::DEBUG } else { cylfuse_log_level::ERROR };
    log.write(level, || text.clone());
    (failure.status(), Text::new(&text))
}

/// Runs a call that has nobody beside it.
fn alone<C>(handle: &Handle<C>, call: impl FnOnce(&mut C, &Cancel<'_>) -> Outcome) -> cylfuse_status {
    if !handle.access.try_write() {
        return handle.busy();
    }
    let status = handle.run(|cancel| {
        // SAFETY: nobody else has access until it is given back below, so this is the only reference.
        call(unsafe { &mut *handle.content.get() }, cancel)
    });
    handle.access.end_write();
    status
}

/// Runs a call that may change what a handle holds on a thread of the library, where nothing of the caller is called.
pub(super) fn change_quietly<C>(
    handle: &Handle<C>,
    call: impl FnOnce(&mut C, &Cancel<'_>) -> Result<(), Failure>,
) -> cylfuse_status {
    alone(handle, |content, cancel| log_outcome(Log::default(), call(content, cancel)))
}

/// Runs a call that only reads what a handle holds: beside others of its kind.
pub(super) fn read<H: Opaque>(
    owner: &H,
    call: impl FnOnce(&H::Content, &Cancel<'_>) -> Result<(), Failure>,
) -> cylfuse_status {
    let handle = owner.handle();
    if !handle.access.try_read() {
        return handle.busy();
    }
    let status = handle.run(|cancel| {
        // SAFETY: nobody has a mutable reference until access is given back below.
        let content = unsafe { &*handle.content.get() };
        log_outcome(H::log(content), call(content, cancel))
    });
    handle.access.end_read();
    status
}

/// Runs a call that may change what a handle holds: alone.
pub(super) fn enter_to_change<H: Opaque>(
    owner: Option<&H>,
    call: impl FnOnce(&mut H::Content, &Cancel<'_>) -> Result<(), Failure>,
) -> cylfuse_status {
    let Some(owner) = owner else { return no_handle(H::NAME) };
    alone(owner.handle(), |content, cancel| {
        let result = call(content, cancel);
        log_outcome(H::log(content), result)
    })
}

/// Runs a call that only reads what a handle holds.
pub(super) fn enter_to_read<H: Opaque>(
    owner: Option<&H>,
    call: impl FnOnce(&H::Content, &Cancel<'_>) -> Result<(), Failure>,
) -> cylfuse_status {
    match owner {
        Some(owner) => read(owner, call),
        None => no_handle(H::NAME),
    }
}

/// Asks the calls that are running on a handle to stop.
///
/// # Safety
/// `owner` is NULL or was created and not destroyed.
pub(super) unsafe fn cancel<H: Opaque>(owner: *mut H) -> cylfuse_status {
    // SAFETY: the caller promises NULL or a living handle.
    match unsafe { owner.as_ref() } {
        Some(owner) => owner.handle().cancel(),
        None => no_handle(H::NAME),
    }
}

/// The text of the last call on a handle, of this thread where it is NULL.
///
/// # Safety
/// As [`cancel`].
pub(super) unsafe fn last_error<H: Opaque>(owner: *const H) -> *const c_char {
    // SAFETY: the caller promises NULL or a living handle.
    match unsafe { owner.as_ref() } {
        Some(owner) => owner.handle().last_error(),
        None => texts::last_of_thread(),
    }
}

/// A handle that a call on another one is given.
///
/// # Safety
/// As [`cancel`], for as long as the reference lives.
pub(super) unsafe fn borrow<'a, H: Opaque>(owner: *const H) -> Result<&'a H, Failure> {
    // SAFETY: the caller promises NULL or a living handle.
    unsafe { owner.as_ref() }.ok_or(Failure::NullPointer { name: H::NAME })
}

/// A call on a handle that is NULL.
#[inline(never)]
fn no_handle(name: &'static str) -> cylfuse_status {
    stateless(|| Err(Failure::NullPointer { name }))
}

/// Runs a call without a handle.
pub(super) fn stateless(call: impl FnOnce() -> Result<(), Failure>) -> cylfuse_status {
    keep(guard(|| log_outcome(Log::default(), call())))
}

/// Keeps the text of a call without a handle.
#[inline(never)]
fn keep(outcome: Result<Outcome, String>) -> cylfuse_status {
    let (status, text) = outcome.unwrap_or_else(|panic| {
        (cylfuse_status::PANIC, Text::new(&format!("defect of the library: {panic}")))
    });
    texts::keep(texts::NO_HANDLE, text);
    status
}
