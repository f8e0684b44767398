//! A tile of the terrain, from its ground points and outlines to features.

use serde_json::{Map, Value};

use super::Terrain;
use super::border::Setting;
use super::coverage::Coverage;
use super::grid::{Grid, STEPS_PER_UNIT, TileKey};
use super::ground::Ground;
use super::mesh::Mesh;
use super::outlines::Inside;
use super::pieces::pieces;
use super::refine::{Fit, refine};
use super::surface::Surface;
use super::surroundings::Surroundings;
use crate::error::Result;
use crate::sink::Feature;
use crate::source::cityjson::{CityObject, Face, Geometry, GeometryKind, Shell};

/// The level of detail that a terrain has in the specification of CityJSON.
const LOD: &str = "1";

/// The attributes of a terrain: name, unit and meaning.
pub const ATTRIBUTES: [(&str, &str, &str); 6] = [
    ("gable_terrain_source", "", "what the heights were taken from: ground-points, terrain-model, or both"),
    ("gable_terrain_error", "m", "how far the ground points may lie above or below the terrain"),
    ("gable_terrain_points", "", "ground points of the tile, one of each half metre, outside the collars of buildings"),
    ("gable_terrain_rmse", "m", "root mean square of how far these lie above or below it"),
    ("gable_terrain_largest", "m", "how far the farthest of these lies above or below it"),
    ("gable_terrain_spanned", "m2", "area without ground points that it spans"),
];

/// What a tile came to.
#[derive(Debug, Clone, Default)]
pub struct Made {
    /// Its pieces, the largest first; none where it is empty.
    pub features: Vec<Feature>,
    /// What was counted.
    pub tally: Tally,
}

/// What is counted of the terrain.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tally {
    /// Tiles with terrain.
    pub tiles: usize,
    /// Objects: pieces of tiles that hang together.
    pub objects: usize,
    /// Vertices of all objects.
    pub vertices: usize,
    /// Triangles of all objects.
    pub triangles: usize,
    /// Triangles among them that stand upright, where floors differ.
    pub upright: usize,
    /// Ground points that it was held against, one of each half metre.
    pub points: u64,
    /// Ground points that were left out because all others around are far above or below.
    pub strays: usize,
    /// Sum of squares of how far the points are off, square metres.
    pub squares: f64,
    /// How far the farthest is off, metres.
    pub largest: f64,
    /// Area without ground points that is spanned, square metres.
    pub spanned: f64,
    /// Area without ground points, between those that were scanned, that is left out, square metres.
    pub left_out: f64,
    /// Edges of outlines that the terrain does not have, because they cross others or an upright triangle cannot be.
    pub missed: usize,
}

impl Tally {
    /// Counts another tile.
    pub fn add(&mut self, other: &Self) {
        self.tiles += other.tiles;
        self.objects += other.objects;
        self.vertices += other.vertices;
        self.triangles += other.triangles;
        self.upright += other.upright;
        self.points += other.points;
        self.strays += other.strays;
        self.squares += other.squares;
        self.largest = self.largest.max(other.largest);
        self.spanned += other.spanned;
        self.left_out += other.left_out;
        self.missed += other.missed;
    }

    /// Root mean square of how far the points are off, metres; `None` without any.
    pub fn rmse(&self) -> Option<f64> {
        (self.points > 0).then(|| (self.squares / self.points as f64).sqrt())
    }
}

impl Terrain {
    /// Makes a tile.
    ///
    /// # Errors
    /// The ground points cannot be read back.
    pub fn tile(&self, key: TileKey) -> Result<Made> {
        let mut ground = Ground::read(&self.store, key, self.model.as_ref())?;
        let outlines = Surroundings::of(&self.outlines, &self.grid, key);
        ground.clear_collars(&outlines);
        let coverage = Coverage::of(&ground, &outlines);
        let setting = Setting {
            ground: &ground,
            outlines: &outlines,
            coverage: &coverage,
            tolerance: self.grid.height_steps(self.options.terrain_error),
            reach: Grid::reach(&self.options),
        };
        let Some(mut mesh) = Mesh::coarse(&setting) else { return Ok(Made::default()) };
        let mut states = ground.states.clone();
        let fit = refine(&mut mesh, &setting, &mut states);
        let surface = Surface::of(&mesh, &outlines, self.grid.step[2]);
        if surface.triangles.is_empty() {
            return Ok(Made::default());
        }
        let [spanned, left_out] = self.areas_of(key, &setting);
        let mut tally = Tally {
            tiles: 1,
            upright: surface.upright,
            points: fit.points,
            strays: ground.strays,
            squares: fit.squares,
            largest: fit.largest,
            spanned,
            left_out,
            missed: mesh.crossed + surface.missed,
            ..Tally::default()
        };
        let attributes = self.attributes(&fit, spanned, &ground);
        let mut features = Vec::new();
        for (number, piece) in pieces(&surface.triangles).into_iter().enumerate() {
            let name = self.grid.name(key);
            let id = if number == 0 { name } else { format!("{name}-{number}") };
            let feature = self.feature(id, key, &surface, &piece, &attributes);
            tally.vertices += feature.vertices.len();
            tally.triangles += piece.len();
            features.push(feature);
        }
        tally.objects = features.len();
        Ok(Made { features, tally })
    }

    fn attributes(&self, fit: &Fit, spanned: f64, ground: &Ground) -> Map<String, Value> {
        let millimetres = |value: f64| Value::from((value * 1e3).round() / 1e3);
        let has_points = fit.points > 0;
        let rmse = has_points.then(|| millimetres((fit.squares / fit.points as f64).sqrt()));
        let source = match (ground.has_model, ground.has_points) {
            (true, true) => "both",
            (true, false) => "terrain-model",
            (false, _) => "ground-points",
        };
        let values = [
            Some(source.into()),
            Some(self.options.terrain_error.into()),
            Some(fit.points.into()),
            rmse,
            has_points.then(|| millimetres(fit.largest)),
            Some(Value::from(spanned.round())),
        ];
        let named = ATTRIBUTES.iter().zip(values);
        named.filter_map(|((name, ..), value)| Some(((*name).to_owned(), value?))).collect()
    }

    fn feature(
        &self,
        id: String,
        key: TileKey,
        surface: &Surface,
        piece: &[usize],
        attributes: &Map<String, Value>,
    ) -> Feature {
        let mut used: Vec<u32> = piece.iter().flat_map(|&triangle| surface.triangles[triangle]).collect();
        used.sort_unstable();
        used.dedup();
        let corner = self.grid.corner(key);
        let vertex = |&index: &u32| {
            let [x, y, z] = surface.vertices[index as usize];
            // Dividing gives the decimal number itself.
            [corner[0] + x, corner[1] + y, z].map(|steps| steps as f64 / STEPS_PER_UNIT as f64)
        };
        let vertices = used.iter().map(vertex).collect();
        let index = |vertex: u32| used.binary_search(&vertex).unwrap_or_default() as u32;
        let face =
            |&triangle: &usize| Face { rings: vec![surface.triangles[triangle].map(index).to_vec()], surface: None };
        let geometry = Geometry {
            lod: LOD.to_owned(),
            kind: GeometryKind::CompositeSurface,
            shells: vec![Shell { solid: 0, faces: piece.iter().map(face).collect() }],
            surfaces: Vec::new(),
            instance: None,
        };
        let object = CityObject {
            id: id.clone(),
            kind: "TINRelief".to_owned(),
            attributes: attributes.clone(),
            geometries: vec![geometry],
            ..CityObject::default()
        };
        Feature { id, objects: vec![object], vertices }
    }

    /// The areas that are spanned and that are left out, square metres: of what was scanned, and where no building stands.
    fn areas_of(&self, key: TileKey, setting: &Setting<'_>) -> [f64; 2] {
        let grid: &Grid = &self.grid;
        let corner = grid.corner(key);
        let mut areas = [0.0; 2];
        for part in setting.coverage.of_tile() {
            let is_spanned = setting.coverage.is_spanned(part);
            if setting.coverage.is_covered(part) && !is_spanned {
                continue;
            }
            let start = [0, 1].map(|axis| grid.part_start(axis, part[axis]));
            let end = [0, 1].map(|axis| grid.part_start(axis, part[axis] + 1));
            let middle = [0, 1].map(|axis| i64::midpoint(start[axis], end[axis]));
            let there = [0, 1].map(|axis| (corner[axis] + middle[axis]) as f64 / STEPS_PER_UNIT as f64);
            let is_scanned = self
                .areas
                .iter()
                .any(|area| (0..2).all(|axis| (area.min[axis]..=area.max[axis]).contains(&there[axis])));
            if is_scanned && setting.outlines.inside(middle, 1) != Some(Inside::Hole) {
                let [width, height] = grid.metres([end[0] - start[0], end[1] - start[1]]);
                areas[usize::from(!is_spanned)] += width * height;
            }
        }
        areas
    }
}
