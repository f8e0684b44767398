//! The terrain that the buildings stand in: a TIN of the ground points, with the outlines of the buildings for edges.
//!
//! ```text
//! ground points ─► samples (one of each half metre, on disk) ─┐
//! buildings ─────► outlines (where they stand, in groups) ────┼─► a tile: noding ─► mesh ─► refine ─► surface ─► pieces
//! terrain model ──────────────────────────────────────────────┘
//! ```
//!
//! - `grid`: tiles, cells and parts, fast in the CRS.
//! - `samples`: ground points while they stream by.
//! - `outlines`: where buildings stand; `noding` makes those that touch meet in vertices and edges;
//!   `surroundings` are those of a tile, cut at its border.
//! - `ground`: the ground points of a tile; `coverage`: which parts of it are terrain at all.
//! - `border`: the vertices that a tile shares with its neighbours.
//! - `mesh`: the coarsest triangulation; `refine`: as fine as the ground needs.
//! - `surface`: its triangles, and upright ones where floors differ; `pieces`: what is valid by itself.
//!
//! Everything is decided on whole steps of the output. A tile depends on the ground points and buildings in and around it
//! alone: neither the order of the tiles nor the number of threads changes a vertex, and tiles that meet share theirs.

mod border;
mod coverage;
mod grid;
mod ground;
mod mesh;
mod noding;
mod options;
mod outlines;
mod pieces;
mod refine;
mod samples;
mod surface;
mod surroundings;
#[cfg(test)]
mod tests;
mod tile;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::error::Result;
use crate::source::crs::Crs;
use crate::source::points::Extent;
use crate::source::raster::Mosaic;

pub use grid::{Grid, TileKey};
pub use options::TerrainOptions;
pub use outlines::{Grouped, Outlines};
pub use samples::{Collector, GroundStore};
pub use tile::{ATTRIBUTES, Made, Tally};

/// All that the terrain of a run is made from.
pub struct Terrain {
    options: TerrainOptions,
    grid: Grid,
    store: Arc<GroundStore>,
    outlines: Grouped,
    /// Heights of the terrain model that the user gave.
    model: Option<GroundStore>,
    /// What was scanned, in CRS units.
    areas: Vec<Extent>,
}

impl Terrain {
    /// The terrain of these ground points and buildings. `areas` are what was scanned.
    pub fn new(options: TerrainOptions, store: Arc<GroundStore>, outlines: Outlines, areas: Vec<Extent>) -> Self {
        let grid = *store.grid();
        let outlines = outlines.close(&grid);
        Self { options, grid, store, outlines, model: None, areas }
    }

    /// The same on a terrain model, which goes before the ground points where it has heights: they are taken each metre, in
    /// tiles of the terrain in which there is any point, and wait in a nameless file in `folder`.
    ///
    /// # Errors
    /// It cannot be read, or the folder cannot be written to.
    pub fn on_model(mut self, path: &Path, crs: &Crs, folder: &Path) -> Result<Self> {
        let store = GroundStore::create(folder, self.grid)?;
        let keys = self.keys(&self.store.seen(), [0, 0]);
        let unit = |place: grid::Place| place.map(|c| c as f64 / grid::STEPS_PER_UNIT as f64);
        let bounds = keys.iter().fold([f64::MAX, f64::MAX, f64::MIN, f64::MIN], |[x0, y0, x1, y1], key| {
            let ([low_x, low_y], [high_x, high_y]) =
                (unit(self.grid.corner(*key)), unit(self.grid.corner(key.map(|k| k + 1))));
            [x0.min(low_x), y0.min(low_y), x1.max(high_x), y1.max(high_y)]
        });
        if !keys.is_empty() {
            let mut model = Mosaic::open(path, crs, bounds)?;
            let mut collector = store.collector();
            for key in keys {
                let places = self.asked_of_model(key);
                let heights = model.heights(&places)?;
                let found = places.iter().zip(heights).filter_map(|(place, z)| Some([place[0], place[1], z?]));
                found.for_each(|position| collector.add(position, true));
            }
            collector.finish()?;
        }
        self.model = Some(store);
        Ok(self)
    }

    /// The places of a tile for which the terrain model is asked, in CRS units: the middles of every second cell along each axis
    /// in what was scanned.
    fn asked_of_model(&self, key: TileKey) -> Vec<[f64; 2]> {
        let grid = &self.grid;
        let corner = grid.corner(key);
        let first = grid.cell(corner);
        let last = grid.cell([corner[0] + grid.tile[0], corner[1] + grid.tile[1]]);
        let even = |axis: usize| (first[axis]..=last[axis]).filter(|cell| cell.rem_euclid(2) == 0);
        let middle = |axis: usize, cell: i64| cell * grid.sample[axis] + grid.sample[axis] / 2;
        let all = even(1).flat_map(|row| even(0).map(move |column| [middle(0, column), middle(1, row)]));
        let unit = grid::STEPS_PER_UNIT as f64;
        let there = all.filter(|place| grid.tile_of(*place) == key).map(|place| place.map(|c| c as f64 / unit));
        let is_scanned = |[x, y]: &[f64; 2]| {
            self.areas.iter().any(|a| (a.min[0]..=a.max[0]).contains(x) && (a.min[1]..=a.max[1]).contains(y))
        };
        there.filter(is_scanned).collect()
    }

    /// The tiles in which there may be terrain, from west to east and from south to north; none where there is neither a ground
    /// point nor a terrain model.
    pub fn tiles(&self) -> Vec<TileKey> {
        let mut extents = self.store.extents();
        extents.extend(self.model.iter().flat_map(GroundStore::extents));
        if extents.is_empty() {
            return Vec::new();
        }
        extents.extend(self.outlines.extents());
        // What lies beside a tile may reach into it.
        self.keys(&extents, self.grid.margin)
    }

    /// The tiles that rectangles touch, or come as near to as the margin.
    fn keys(&self, extents: &[[grid::Place; 2]], margin: [i64; 2]) -> Vec<TileKey> {
        let mut keys = BTreeSet::new();
        for &[low, high] in extents {
            let [from, to] = [(low, -1), (high, 1)]
                .map(|(place, sign)| self.grid.tile_of([0, 1].map(|axis| place[axis] + sign * margin[axis])));
            keys.extend((from[1]..=to[1]).flat_map(|row| (from[0]..=to[0]).map(move |column| [column, row])));
        }
        keys.into_iter().collect()
    }

    /// How many outlines reach too far to be kept.
    pub fn left_out(&self) -> usize {
        self.outlines.left_out()
    }
}
