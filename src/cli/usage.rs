//! What is told of a command line that cannot be understood. It repeats words of it, and a password may be in any.

use std::ffi::{OsStr, OsString};
use std::process::ExitCode;

use clap::Parser;

use super::{Cli, FAILURE, output};
use crate::source::footprints::redacted;

/// Tells what is wrong with these words, or gives the help that they ask for. `message` is what their grammar says of them.
pub(super) fn tell(words: &[OsString], message: &clap::Error) -> ExitCode {
    let shown: Vec<OsString> = words.iter().map(|word| without_passwords(word)).collect();
    // The grammar says the same of the words without their passwords. In the text of the message it could not be seen where
    // a password ends.
    let again = if shown == words { None } else { Some(Cli::try_parse_from(shown)) };
    match again {
        // Nobody is left to tell if the terminal is gone.
        None => drop(message.print()),
        Some(Err(message)) => drop(message.print()),
        Some(Ok(_)) => output::say(&message.to_string()),
    }
    // clap's own code for bad usage is 2, which means something else here.
    ExitCode::from(if message.use_stderr() { FAILURE } else { 0 })
}

/// A word with its passwords hidden. One that is no text stays as it is, unless a password is in what can be read of it.
fn without_passwords(word: &OsStr) -> OsString {
    let text = word.to_string_lossy();
    let shown = redacted(&text);
    if shown == text { word.to_owned() } else { shown.into() }
}
