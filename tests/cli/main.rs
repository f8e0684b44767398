//! The `gable` command end to end: what it says, what it writes, and what its exit codes mean.

mod bench;
mod errors;
mod evaluate;
mod info;
mod reconstruct;
