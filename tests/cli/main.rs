//! The `gable` command end to end: what it says, what it writes, and what its exit codes mean.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

mod bench;
mod errors;
mod evaluate;
mod info;
mod reconstruct;
mod validate;
