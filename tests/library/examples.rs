//! The examples run, with the checks that stand in them. (`render` is a tool, and is run by the quick start's picture.)

#[path = "../../examples/occupancy.rs"]
mod occupancy;
#[path = "../../examples/one_building.rs"]
mod one_building;
#[path = "../../examples/sink.rs"]
mod sink;
#[path = "../../examples/tile.rs"]
mod tile;

#[test]
fn one_building() {
    one_building::main().unwrap();
}

#[test]
fn tile() {
    tile::main().unwrap();
}

#[test]
fn occupancy() {
    occupancy::main().unwrap();
}

#[test]
fn sink() {
    sink::main().unwrap();
}
