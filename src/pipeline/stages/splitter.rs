//! `filters.splitter`: parts points into square tiles.

use std::collections::HashMap;

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.splitter",
    summary: "Parts points into square tiles",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    let corner = "of a corner of the tiles; that of the first point when it is not given";
    vec![
        OptionSpec::new("length", Kind::number(), "Side of the tiles, in the units of the CRS").or(1000.0),
        OptionSpec::new("origin_x", Kind::number(), format!("X {corner}")),
        OptionSpec::new("origin_y", Kind::number(), format!("Y {corner}")),
        OptionSpec::new("buffer", Kind::at_least(0.0), "How far tiles overlap with those beside them").or(0.0),
    ]
}

fn build(values: &Values) -> Result<Stage> {
    let length = values.number("length").unwrap_or_default();
    let buffer = values.number("buffer").unwrap_or_default();
    if !(length > 0.0 && length.is_finite()) {
        return Err(values.fault("length", &length.to_string(), "a number greater than 0").into());
    }
    if buffer >= length / 2.0 {
        let expected = format!("less than half of the length of {length}");
        return Err(values.fault("buffer", &buffer.to_string(), expected).into());
    }
    let given = ["origin_x", "origin_y"].map(|name| values.number(name));
    Ok(Stage::Whole(Box::new(Splitter {
        length,
        buffer,
        given,
        origin: None,
        tiles: Vec::new(),
        places: HashMap::new(),
    })))
}

struct Splitter {
    length: f64,
    buffer: f64,
    given: [Option<f64>; 2],
    origin: Option<[f64; 2]>,
    /// The tiles, in the order of their first points.
    tiles: Vec<Points>,
    /// Where the tile of a column and a row stands.
    places: HashMap<[i64; 2], usize>,
}

impl Splitter {
    /// The tile that a point lies in.
    fn tile(&self, position: [f64; 2], origin: [f64; 2]) -> [i64; 2] {
        std::array::from_fn(|axis| {
            let from = position[axis] - origin[axis];
            // As PDAL counts: what lies exactly on a border left of the origin belongs to the tile before it.
            ((from / self.length) as i64).saturating_sub(i64::from(from < 0.0))
        })
    }

    /// Whether a point lies in a tile with its buffer, the border left out.
    fn has(&self, tile: [i64; 2], position: [f64; 2], origin: [f64; 2]) -> bool {
        (0..2).all(|axis| {
            let low = origin[axis] + tile[axis] as f64 * self.length - self.buffer;
            low < position[axis] && position[axis] < low + self.length + 2.0 * self.buffer
        })
    }

    /// The tiles that a point goes to: its own, and those whose buffers it lies in.
    fn tiles_of(&self, position: [f64; 2], origin: [f64; 2]) -> Vec<[i64; 2]> {
        let own @ [x, y] = self.tile(position, origin);
        let mut tiles = vec![own];
        if self.buffer > 0.0 {
            let [west, east] = [x.saturating_sub(1), x.saturating_add(1)];
            let [south, north] = [y.saturating_sub(1), y.saturating_add(1)];
            // A buffer is less than half a tile, so of opposite neighbours only one can have the point.
            let sides: [&[[i64; 2]]; 3] = [
                &[[west, y], [east, y]],
                &[[x, south], [x, north]],
                &[[west, south], [west, north], [east, south], [east, north]],
            ];
            tiles.extend(sides.iter().filter_map(|side| side.iter().find(|tile| self.has(**tile, position, origin))));
        }
        tiles
    }
}

impl Whole for Splitter {
    fn prepare(&mut self, _flow: &mut Flow) -> Result<()> {
        self.origin = None;
        self.tiles.clear();
        self.places.clear();
        Ok(())
    }

    fn view(&mut self, points: Points, _context: &Context<'_>) -> Result<Vec<Points>> {
        let first = points.position(0);
        let origin = *self.origin.get_or_insert_with(|| std::array::from_fn(|i| self.given[i].unwrap_or(first[i])));
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.tiles.len()];
        for i in 0..points.len() {
            let [x, y, _] = points.position(i);
            for tile in self.tiles_of([x, y], origin) {
                let place = *self.places.entry(tile).or_insert_with(|| {
                    members.push(Vec::new());
                    members.len() - 1
                });
                members[place].push(i);
            }
        }
        for (place, members) in members.into_iter().enumerate() {
            let part = points.gather(&members);
            match self.tiles.get_mut(place) {
                Some(tile) => tile.append(part),
                None => self.tiles.push(part),
            }
        }
        // Another input may have more points for any tile.
        Ok(Vec::new())
    }

    fn finish(&mut self, _context: &Context<'_>) -> Result<Vec<Points>> {
        self.places.clear();
        Ok(std::mem::take(&mut self.tiles))
    }
}
