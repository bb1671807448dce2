//! Says which case it was when the process crashes or a case does not end.

use std::sync::Once;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// No case takes longer, on the busiest machine either: a case has at most 60 calls on images of at most 160 x 120 pixels,
/// which take seconds.
pub const LIMIT: Duration = Duration::from_secs(900);

/// One for each kind of case.
pub struct Watch {
    name: &'static str,
    case: AtomicU64,
}

pub static CALLS: Watch = Watch::new("calls");
pub static DETECTOR: Watch = Watch::new("detector");
pub static FILES: Watch = Watch::new("files");

const NONE: u64 = u64::MAX;

impl Watch {
    const fn new(name: &'static str) -> Self {
        Self { name, case: AtomicU64::new(NONE) }
    }

    /// Runs a case, which is known by its number from now on.
    pub fn run<T>(&'static self, case: u64, body: impl FnOnce() -> T) -> T {
        static ONCE: Once = Once::new();
        ONCE.call_once(|| {
            for signal in [libc::SIGSEGV, libc::SIGBUS, libc::SIGABRT, libc::SIGILL, libc::SIGFPE] {
                // SAFETY: the handler calls nothing but write and functions on atomics.
                unsafe { libc::signal(signal, on_crash as extern "C" fn(i32) as libc::sighandler_t) };
            }
            std::thread::spawn(watch);
        });
        self.case.store(case, Ordering::Relaxed);
        let outcome = body();
        self.case.store(NONE, Ordering::Relaxed);
        outcome
    }

    fn say(&self) {
        let case = self.case.load(Ordering::Relaxed);
        if case == NONE {
            return;
        }
        let mut digits = [0_u8; 20];
        let mut rest = case;
        let mut at = digits.len();
        loop {
            at -= 1;
            digits[at] = b'0' + (rest % 10) as u8;
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        for text in [b"fuzz: in case ".as_slice(), &digits[at..], b" of ", self.name.as_bytes(), b"\n"] {
            // SAFETY: the memory is that of the text. There is nobody to tell when it fails.
            let _ = unsafe { libc::write(2, text.as_ptr().cast(), text.len()) };
        }
    }
}

extern "C" fn on_crash(signal: i32) {
    for watch in [&CALLS, &DETECTOR, &FILES] {
        watch.say();
    }
    // SAFETY: the way to end as without a handler.
    unsafe {
        libc::signal(signal, libc::SIG_DFL);
        libc::raise(signal);
    }
}

fn watch() {
    let mut since = [(NONE, Instant::now()); 3];
    loop {
        std::thread::sleep(Duration::from_millis(500));
        for (watch, (case, start)) in [&CALLS, &DETECTOR, &FILES].into_iter().zip(&mut since) {
            let now = watch.case.load(Ordering::Relaxed);
            if now != *case {
                (*case, *start) = (now, Instant::now());
            } else if now != NONE && start.elapsed() > LIMIT {
                eprintln!("fuzz: a case takes more than {LIMIT:?}");
                std::process::abort();
            }
        }
    }
}
