//! Signals. Ctrl-C: once to finish the write of what is done, twice to give up.

use std::sync::atomic::{AtomicBool, Ordering};

use super::FAILURE;
use super::output::say;
use crate::error::Error;

static PRESSED: AtomicBool = AtomicBool::new(false);
static SOMETHING_TO_SAVE: AtomicBool = AtomicBool::new(false);
/// Whether somebody asks again and again whether it was pressed.
#[cfg(feature = "edit")]
static WAITING: AtomicBool = AtomicBool::new(false);

/// The exit code that shells give to a program that an interrupt ended: 128 + SIGINT.
const INTERRUPTED: i32 = 130;

/// Listens for Ctrl-C, `SIGTERM` and `SIGHUP` from now on.
pub fn listen() {
    let installed = ctrlc::set_handler(|| {
        if PRESSED.swap(true, Ordering::SeqCst) {
            say("\ngiven up: the same command with --resume goes on from what is done");
            std::process::exit(INTERRUPTED);
        }
        if !SOMETHING_TO_SAVE.load(Ordering::SeqCst) {
            say(&format!("\nerror: {}", Error::Interrupted));
            std::process::exit(FAILURE.into());
        }
        say("\ninterrupted: completing what is under way and writing what is done (again to give up)");
    });
    if installed.is_err() {
        // The system's own way of ending the process stays in force; the run itself is not concerned.
        say("warning: Ctrl-C cannot be caught here and will lose what is done");
    }
}

/// Listens for the same where everything is saved at any moment: it ends the process without a word.
#[cfg(feature = "edit")]
pub fn listen_quietly() {
    let installed = ctrlc::set_handler(|| {
        if PRESSED.swap(true, Ordering::SeqCst) || !WAITING.load(Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
    });
    // Otherwise the system ends the process, which is as well.
    drop(installed);
}

/// From now on whoever is interrupted quietly ends by itself.
#[cfg(feature = "edit")]
pub fn wait_quietly() {
    WAITING.store(true, Ordering::SeqCst);
}

/// From now on a file that grows beyond the limit of the shell (`ulimit -f`) is an error of the write, which is told, and
/// no end of the process.
pub fn outlive_file_limits() {
    #[cfg(unix)]
    {
        let reached = std::sync::Arc::new(AtomicBool::new(false));
        if signal_hook::flag::register(signal_hook::consts::SIGXFSZ, reached).is_err() {
            say("warning: a limit on the size of files will end this process without a word");
        }
    }
}

/// From now on there is something that an interruption must not lose; before, it ends the process at once.
pub fn something_to_save() {
    SOMETHING_TO_SAVE.store(true, Ordering::SeqCst);
}

/// Whether it was pressed.
pub fn pressed() -> bool {
    PRESSED.load(Ordering::Relaxed)
}
