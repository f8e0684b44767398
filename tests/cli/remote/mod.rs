//! Tiles, footprints and models in object storage and on web servers: against a web server of our own that fails on demand, and
//! against a server that speaks the protocol of S3, which `scripts/test-remote.sh` starts; without one those tests say that they
//! are skipped.

mod failures;
mod indexes;
mod s3;
mod server;
mod uploads;
mod web;
