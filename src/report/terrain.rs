//! The terrain around the buildings.

use schemars::JsonSchema;
use serde::Serialize;

use crate::terrain::{Tally, TerrainOptions};

/// The terrain around the buildings.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct TerrainReport {
    /// What it should be like.
    pub options: TerrainOptions,
    /// Ground points that came.
    pub ground_points: u64,
    /// Tiles with terrain.
    pub tiles: usize,
    /// Objects: pieces of tiles that hang together.
    pub objects: usize,
    /// Triangles of all objects.
    pub triangles: usize,
    /// Vertices of all objects.
    pub vertices: usize,
    /// Triangles that stand upright, where the floors of neighbours differ.
    pub upright: usize,
    /// Ground points that it was held against: one of each half metre, outside the collars of buildings.
    pub points: u64,
    /// Root mean square of how far these lie above or below it, metres; absent without any.
    pub rmse: Option<f64>,
    /// How far the farthest of these lies above or below it, metres.
    pub largest: f64,
    /// Ground points of these cells that were left out: all others around lie far above or below.
    pub strays: usize,
    /// Area without ground points that it spans, square metres.
    pub spanned: f64,
    /// Area without ground points that was scanned and is left out, square metres.
    pub left_out: f64,
    /// Edges of outlines that it does not have: they cross others, or its buildings reach too far.
    pub missed: usize,
    /// Tiles that were not reached before the interruption.
    pub not_reached: usize,
}

impl TerrainReport {
    /// What was counted of a terrain.
    pub fn new(options: TerrainOptions, ground_points: u64, tally: &Tally) -> Self {
        let hundredths = |value: f64| (value * 100.0).round() / 100.0;
        let tenths_of_millimetres = |value: f64| (value * 1e4).round() / 1e4;
        Self {
            options,
            ground_points,
            tiles: tally.tiles,
            objects: tally.objects,
            triangles: tally.triangles,
            vertices: tally.vertices,
            upright: tally.upright,
            points: tally.points,
            rmse: tally.rmse().map(tenths_of_millimetres),
            largest: tenths_of_millimetres(tally.largest),
            strays: tally.strays,
            spanned: hundredths(tally.spanned),
            left_out: hundredths(tally.left_out),
            missed: tally.missed,
            not_reached: 0,
        }
    }
}
