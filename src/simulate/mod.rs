//! Buildings that are known exactly, to train and to measure with.

pub mod generator;
