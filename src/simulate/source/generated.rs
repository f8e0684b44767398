//! Models from the generator.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::super::generator::{self, Generated};
use super::super::mesh::Mesh;
use super::super::model::Model;
use super::Source;

/// Buildings of one generated tile.
pub const TILE: usize = 50;

/// Generates buildings with the seeds from `seed` on. They are tiles of 50 in the order of their seeds.
pub fn generate(count: usize, seed: u64) -> Source {
    let made: Vec<_> = (0..count)
        .into_par_iter()
        .map(|number| generator::building(seed.wrapping_add(number as u64)).map(|made| model(number, made)))
        .collect();
    let mut left_out = BTreeMap::new();
    let mut models = Vec::with_capacity(count);
    for made in made {
        match made {
            Ok(model) => models.push(model),
            Err(error) => *left_out.entry(error.to_string()).or_default() += 1,
        }
    }
    let tiling = format!("tiles of {TILE} in the order of their seeds");
    Source { name: "generator".to_owned(), models, left_out, crs: None, tiling }
}

fn model(number: usize, made: Generated) -> Model {
    Model {
        id: format!("generated-{number:06}"),
        tile: format!("generated/{:05}", number / TILE).into(),
        shape: Some(format!("{:?}", made.shape.roof)),
        frame: made.frame,
        mesh: Arc::new(Mesh::of(&made.solid)),
        footprint: made.footprint,
        ground: made.ground,
        neighbours: made.neighbours.iter().map(|solid| Arc::new(Mesh::of(solid))).collect(),
        solid: Arc::new(made.solid),
    }
}
