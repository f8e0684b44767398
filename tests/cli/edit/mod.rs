//! `gable edit`: the server, by a client that speaks as a browser would, and as one would not.

mod bench;
mod decisions;
mod guards;
mod hostile;
mod options;
