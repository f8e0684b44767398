//! Footprints of a `PostGIS` database, read from a server that `scripts/test-postgis.sh` starts; without one these tests say
//! that they are skipped.

mod encryption;
mod reads;
mod refusals;
mod server;
