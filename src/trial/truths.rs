//! The buildings of a trial that are not every model of a source.

use rayon::prelude::*;

use super::hash;
use crate::simulate::{Model, generate, generator};

/// Seeds tried for every building that must have an overhang; about one in six has.
const PATIENCE: usize = 60;

/// Keeps this many models, chosen by the seed and their ids alone.
pub fn choose(models: &mut Vec<Model>, count: usize, seed: u64) {
    models.sort_by_cached_key(|model| hash(seed, &model.id));
    models.truncate(count);
}

/// This many generated buildings with overhangs or arcades; fewer when so many seeds have none.
pub fn overhanging(count: usize, seed: u64) -> Vec<Model> {
    let seeds: Vec<u64> = (0..count * PATIENCE).map(|number| hash(seed, &format!("overhang {number}"))).collect();
    let mut models = Vec::with_capacity(count);
    // Some at a time, so that not all seeds are tried where a few will do.
    for seeds in seeds.chunks(8 * count.max(1)) {
        let found: Vec<Model> = seeds
            .par_iter()
            .filter(|&&seed| generator::building(seed).is_ok_and(|drawn| !drawn.shape.is_height_field()))
            .filter_map(|&seed| {
                let model = generate(1, seed).models.pop()?;
                Some(Model { id: format!("overhanging-{seed:016x}"), ..model })
            })
            .collect();
        models.extend(found);
        if models.len() >= count {
            break;
        }
    }
    models.truncate(count);
    models
}
