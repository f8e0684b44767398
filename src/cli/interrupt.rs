//! Ctrl-C: once to finish the write of what is done, twice to give up.

use std::sync::atomic::{AtomicBool, Ordering};

use super::output::say;

static PRESSED: AtomicBool = AtomicBool::new(false);

/// The exit code that shells give to a program that an interrupt ended: 128 + SIGINT.
const INTERRUPTED: i32 = 130;

/// Listens for Ctrl-C, `SIGTERM` and `SIGHUP` from now on.
pub fn listen() {
    let installed = ctrlc::set_handler(|| {
        if PRESSED.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
        say("\ninterrupted: completing what is under way and writing what is done (again to give up)");
    });
    if installed.is_err() {
        // The system's own way of ending the process stays in force; the run itself is not concerned.
        say("warning: Ctrl-C cannot be caught here and will lose what is done");
    }
}

/// Whether it was pressed.
pub fn pressed() -> bool {
    PRESSED.load(Ordering::Relaxed)
}
