//! The `gable` command end to end: what it says, what it writes, and what its exit codes mean.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

mod agreement;
mod areas;
mod attributes;
mod bad_input_footprints;
mod bad_input_noise;
mod bad_input_options;
mod bad_input_output;
mod bad_input_points;
mod bench;
mod clashes;
mod clouds;
mod convert;
mod crop;
mod crossings;
mod damage;
mod damaged_times;
mod edited;
mod errors;
mod evaluate;
mod explain;
mod field;
mod folders;
mod info;
mod jagged;
mod many_files;
mod neighbourhoods;
mod pipeline;
mod postgis;
mod reconstruct;
mod reported;
mod resume;
mod roofprint;
mod secrets;
mod several_clouds;
mod simulate;
mod standing;
mod streams;
mod terrain;
mod thresholds;
mod told;
mod trial;
mod validate;
mod view;
