//! Where the buildings of several sources stand.

use std::collections::BTreeSet;

use super::super::model::Model;
use super::super::source::Source;
use crate::error::InputError;
use crate::site::Frame;
use crate::source::crs::Crs;

/// Free space between generated buildings, metres.
const STREET: f64 = 40.0;
/// Where generated buildings stand that have nothing beside them: a place of the CRS in whole units.
const NOWHERE: [f64; 3] = [100_000.0, 450_000.0, 0.0];
/// The CRS of generated buildings that have nothing beside them: metres, and known to all programs.
const GENERATED_CRS: &str = "EPSG:7415";

/// The CRS of all sources: the one that is given, or that which they name.
///
/// # Errors
/// They name different systems, or a file names none and none is given; generated buildings and a CRS that is not in metres.
pub fn common_crs(sources: &[Source], given: Option<Crs>) -> Result<Crs, InputError> {
    let mut found: Option<(&str, &Crs)> = None;
    for source in sources.iter().filter(|source| !source.is_generated) {
        match (&source.crs, &given) {
            (Some(crs), _) => match found {
                Some((first, other)) if !crs.is_same_horizontally(other) => {
                    let expected = format!("{other}, that of {first}");
                    return Err(InputError::new(&source.name, format!("the CRS {crs}"), expected)
                        .remedy("Scan models of different systems one by one"));
                }
                _ => found = found.or(Some((&source.name, crs))),
            },
            (None, None) => {
                return Err(InputError::new(&source.name, "no CRS that is known", "one")
                    .remedy("Give it with --crs, such as --crs EPSG:31256"));
            }
            (None, Some(_)) => {}
        }
    }
    let crs = match (given, found) {
        (Some(given), _) => given,
        (None, Some((_, crs))) => crs.clone(),
        (None, None) => Crs::parse(GENERATED_CRS)?,
    };
    let is_metric = !crs.is_geographic && crs.metres_per_unit.iter().all(|m| (m - 1.0).abs() < 1e-9);
    if !is_metric && sources.iter().any(|source| source.is_generated) {
        return Err(InputError::new("--generate", format!("the CRS {crs}"), "one in metres")
            .remedy("Give another one with --crs, or scan generated buildings by themselves"));
    }
    Ok(crs)
}

/// All models where they stand: those of files in their places, generated ones in rows east of them.
pub(super) fn arranged(sources: &[Source]) -> Vec<Model> {
    let mut models: Vec<Model> =
        sources.iter().filter(|source| !source.is_generated).flat_map(|source| source.models.clone()).collect();
    let generated: Vec<&Model> =
        sources.iter().filter(|source| source.is_generated).flat_map(|source| &source.models).collect();
    let start = models
        .iter()
        .filter_map(|model| {
            let aabb = model.mesh.aabb()?;
            let place = model.frame.to_crs(&aabb.max.into());
            Some([place[0], place[1], model.frame.to_crs(&aabb.min.into())[2]])
        })
        .reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1]), a[2].min(b[2])])
        .map_or(NOWHERE, |[x, y, z]| [x + 1000.0, y, z].map(f64::round));
    let widest = generated
        .iter()
        .flat_map(|model| std::iter::once(&model.mesh).chain(&model.neighbours))
        .filter_map(|mesh| mesh.aabb())
        .flat_map(|aabb| [aabb.min[0].abs(), aabb.min[1].abs(), aabb.max[0].abs(), aabb.max[1].abs()])
        .fold(0.0, f64::max);
    let step = (2.0 * widest + STREET).ceil();
    let columns = (generated.len() as f64).sqrt().ceil().max(1.0) as usize;
    for (number, model) in generated.into_iter().enumerate() {
        let [column, row] = [number % columns, number / columns].map(|n| n as f64);
        let [x, y, z] = start;
        let origin = [x + column * step, y + row * step, z];
        models.push(Model { frame: Frame { origin, ..model.frame }, ..model.clone() });
    }
    models
}

/// The ids of the models, numbered where they are not unique.
pub(super) fn unique_ids(models: &[Model]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    models
        .iter()
        .map(|model| {
            let mut id = model.id.clone();
            let mut number = 1;
            while !taken.insert(id.clone()) {
                number += 1;
                id = format!("{}~{number}", model.id);
            }
            id
        })
        .collect()
}

/// A whole place near the lower corner of all.
pub(super) fn corner(models: &[Model]) -> [f64; 3] {
    models
        .iter()
        .filter_map(|model| Some(model.frame.to_crs(&model.mesh.aabb()?.min.into())))
        .reduce(|a, b| std::array::from_fn(|i| a[i].min(b[i])))
        .unwrap_or([0.0; 3])
        .map(f64::floor)
}
