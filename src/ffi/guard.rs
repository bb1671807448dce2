//! Nothing unwinds into the caller, and nothing is printed when a call panics.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    /// Text of the panic of the call that this thread is in; `None` outside of calls.
    static PANIC_TEXT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs the body of a call; a panic becomes its text.
pub(super) fn guard<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    // Compiled for every call: what does not depend on the body is in functions of its own.
    let outer = begin();
    let outcome = catch_unwind(AssertUnwindSafe(body));
    let text = end(outer);
    outcome.map_err(|_| text)
}

/// A callback may call another fitter: the text of the outer call, which comes back afterwards.
#[inline(never)]
fn begin() -> Option<String> {
    silence_panics();
    swap_text(Some(String::new()))
}

/// The text of the call that ends.
#[inline(never)]
fn end(outer: Option<String>) -> String {
    swap_text(outer).unwrap_or_default()
}

/// `None` too when the thread is ending and its variables are gone.
fn swap_text(text: Option<String>) -> Option<String> {
    PANIC_TEXT.try_with(|slot| slot.replace(text)).unwrap_or_default()
}

/// The standard hook prints to stderr, which belongs to the host. This one stores the text instead, with the
/// place in the source, for panics inside a call; all others go to the hook that was there before. A shared
/// library has hooks of its own, so this is not seen by a Rust host. A worker thread is not inside a call: what it
/// would have to say about a defect still goes to the hook from before.
fn silence_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let inside = PANIC_TEXT.try_with(|slot| match slot.try_borrow_mut().as_deref_mut() {
                Ok(Some(text)) => {
                    *text = info.to_string();
                    true
                }
                _ => false,
            });
            if inside != Ok(true) {
                before(info);
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_text_with_its_place() {
        let text = guard(|| panic!("number {}", 7)).unwrap_err();
        assert!(text.contains("number 7") && text.contains("guard.rs"), "{text}");
        assert_eq!(guard(|| 5), Ok(5));
    }

    #[test]
    fn calls_inside_calls_keep_their_texts_apart() {
        let text = guard(|| {
            let inner = guard(|| panic!("inner")).unwrap_err();
            assert!(inner.contains("inner"));
            panic!("outer")
        })
        .unwrap_err();
        assert!(text.contains("outer"), "{text}");
    }
}
