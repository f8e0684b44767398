//! A panic in one building, or in a decoder that is given damaged data, must not take the run down with it: it becomes a
//! reason in a report.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

thread_local! {
    /// How many guards this thread is inside of.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// Message and place of the last panic under a guard on this thread.
    static CAUGHT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Locks a mutex, also one whose holder panicked.
pub fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `work` and returns the message and the place of its panic, should it panic.
///
/// The first call chains a panic hook in front of the one that is there: it keeps panics under a guard off the
/// terminal and passes all others on.
///
/// # Errors
/// Message and source position of the panic.
pub fn guarded<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if DEPTH.get() == 0 {
                return previous(info);
            }
            let payload = info.payload();
            let message = payload
                .downcast_ref::<&str>()
                .copied()
                .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
                .unwrap_or("panic without a message");
            let place = info.location().map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
            CAUGHT.set(Some(format!("{message}{place}")));
        }));
    });
    DEPTH.set(DEPTH.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    DEPTH.set(DEPTH.get() - 1);
    result.map_err(|_| CAUGHT.take().unwrap_or_else(|| "panic without a message".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_becomes_its_message_and_place() {
        let detail = guarded(|| -> u32 { panic!("seven {}", 7) }).unwrap_err();
        assert!(detail.starts_with("seven 7 at "), "{detail}");
        assert!(detail.contains("guard.rs:"), "{detail}");
    }

    #[test]
    fn guards_nest_and_leave_the_thread_usable() {
        let outer = guarded(|| {
            let inner = guarded(|| -> u32 { panic!("inner") });
            assert!(inner.unwrap_err().starts_with("inner at"));
            5
        });
        assert_eq!(outer, Ok(5));
    }
}
