//! `filters.overlay`: gives points within polygons a value of the polygon.

use std::path::Path;
use std::sync::Arc;

use geo::{BoundingRect, Coord, Intersects, MultiPolygon};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use serde_json::Value;

use crate::error::{InputError, Result};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Column, Dimension, Points};
use crate::pipeline::stage::{Context, Filter, Flow, Role, Stage, StageKind};
use crate::source::crs::Crs;
use crate::source::footprints::{self, FootprintLayer, FootprintOptions};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.overlay",
    summary: "Gives points within the polygons of a file a value of the polygon",
    role: Role::Filter,
    options,
    elsewhere: &["query", "bounds", "option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new("dimension", Kind::Text, "Dimension that gets the value; filters.ferry makes one (`=>Name`)")
            .required(),
        OptionSpec::new("datasource", Kind::File, "File or PostGIS database with the polygons, as of footprints")
            .required(),
        OptionSpec::new(
            "column",
            Kind::Text,
            "Attribute whose value it is: a number, or a text that is one; the first attribute when not given",
        ),
        OptionSpec::new("layer", Kind::Text, "Layer with the polygons; the only one with polygons when not given")
            .aliases(&["lyr_name"]),
        OptionSpec::new("threads", Kind::count(), "Taken for the sake of PDAL's files; points stream anyway"),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    Ok(Stage::Filter(Box::new(Overlay {
        values: values.clone(),
        layer: None,
        place: 0,
        covers: Vec::new(),
        warnings: Vec::new(),
    })))
}

struct Overlay {
    values: Values,
    /// The polygons as they stand in the file, with their values; read once.
    layer: Option<(FootprintLayer, Vec<Option<f64>>)>,
    /// The place of the dimension.
    place: usize,
    /// The polygons in each CRS that points came in.
    covers: Vec<(Option<Arc<Crs>>, Cover)>,
    warnings: Vec<String>,
}

/// Polygons in the CRS of points, and where they are.
struct Cover {
    /// In the order of the file, each with its value.
    polygons: Vec<(MultiPolygon<f64>, f64)>,
    index: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
}

impl Cover {
    fn new(polygons: Vec<(MultiPolygon<f64>, f64)>) -> Self {
        let boxed = polygons.iter().enumerate().filter_map(|(i, (polygon, _))| {
            let rect = polygon.bounding_rect()?;
            Some(GeomWithData::new(Rectangle::from_corners(rect.min().into(), rect.max().into()), i))
        });
        let index = RTree::bulk_load(boxed.collect());
        Self { polygons, index }
    }

    /// The value at a place: that of the first polygon in the file which holds it, its border included.
    fn at(&self, place: [f64; 2]) -> Option<f64> {
        let mut near: Vec<usize> =
            self.index.locate_in_envelope_intersecting(&AABB::from_point(place)).map(|found| found.data).collect();
        near.sort_unstable();
        let place = Coord::from(place);
        near.into_iter().map(|i| &self.polygons[i]).find(|(polygon, _)| polygon.intersects(&place)).map(|found| found.1)
    }
}

/// The number that an attribute is; `None` for one without a value.
///
/// # Errors
/// What was found, when it is no number, or not one that doubles keep.
fn number_of(value: Option<&Value>) -> Result<Option<f64>, String> {
    let number = match value {
        None | Some(Value::Null) => return Ok(None),
        Some(Value::Bool(is_set)) => f64::from(u8::from(*is_set)),
        Some(Value::Number(number)) => number.as_f64().ok_or_else(|| number.to_string())?,
        Some(Value::String(text)) => text.trim().parse().map_err(|_| format!("`{text}`"))?,
        Some(other) => return Err(other.to_string()),
    };
    let exact = value.and_then(Value::as_i64).is_none_or(|whole| number as i64 == whole);
    if exact { Ok(Some(number)) } else { Err(format!("{number}, which has more digits than points can hold")) }
}

impl Overlay {
    /// Reads the polygons and their values, and holds these against the dimension.
    fn read(&mut self, dimension: &Dimension) -> Result<()> {
        let path = Path::new(self.values.text("datasource").unwrap_or_default());
        let options = FootprintOptions { layer: self.values.text("layer").map(str::to_owned), ..Default::default() };
        let layer = footprints::read(path, &options)?;
        self.warnings.extend(layer.warnings.iter().cloned());
        let fault = |found: String, expected: String| InputError::new(&layer.path, found, expected);
        let mut all = layer.footprints.iter().map(|footprint| &footprint.attributes);
        let column = match self.values.text("column") {
            Some(column) => {
                let is_there = layer.footprints.is_empty() || all.any(|attributes| attributes.get(column).is_some());
                if !is_there {
                    let known = layer.columns.join(", ");
                    return Err(self
                        .values
                        .fault("column", &format!("`{column}`, which no polygon has"), known)
                        .into());
                }
                column.to_owned()
            }
            None => all.find_map(|attributes| attributes.to_map().into_iter().next()).unwrap_or_default().0,
        };
        let mut values = Vec::with_capacity(layer.footprints.len());
        for footprint in &layer.footprints {
            let value = number_of(footprint.attributes.get(&column).as_ref()).map_err(|found| {
                fault(format!("{found} as `{column}`"), "a number".to_owned())
                    .at(format!("feature {}", footprint.id))
                    .remedy("Name the attribute with the value as `column`")
            })?;
            if let Some(value) = value
                && !Column::zeros(dimension.kind, 1).set(0, value)
            {
                let expected = format!("a value of the type {}, which {} has", dimension.kind, dimension.name);
                let fault = fault(format!("{value} as `{column}`"), expected);
                return Err(fault.at(format!("feature {}", footprint.id)).into());
            }
            values.push(value);
        }
        let without = values.iter().filter(|value| value.is_none()).count();
        let file = layer.path.display();
        if without > 0 {
            self.warnings.push(format!(
                "{file}: {without} of {} polygons have no `{column}`; points within them stay as they are",
                values.len()
            ));
        }
        if let Some(rejected) = layer.rejected.first() {
            self.warnings.push(format!(
                "{file}: {} features have no usable geometry and count for nothing, such as {}: {}",
                layer.rejected.len(),
                rejected.id,
                rejected.reason
            ));
        }
        self.layer = Some((layer, values));
        Ok(())
    }

    /// The place among the covers of the one in a CRS.
    fn cover(&mut self, crs: Option<&Arc<Crs>>) -> Result<usize> {
        if let Some(place) = self.covers.iter().position(|(own, _)| own.as_ref() == crs) {
            return Ok(place);
        }
        let Some((layer, values)) = &self.layer else { return Ok(0) };
        // Reprojection may reject polygons, so values go by id.
        let mut moved = layer.clone();
        if let Some(crs) = crs.filter(|_| layer.crs.is_some()) {
            self.warnings.extend(moved.reproject(crs)?);
            if let Some(lost) = moved.rejected.get(layer.rejected.len()) {
                self.warnings.push(format!("{}: polygon {}: {}", layer.path.display(), lost.id, lost.reason));
            }
        }
        let by_id: std::collections::HashMap<&str, f64> = (layer.footprints.iter().zip(values))
            .filter_map(|(footprint, value)| Some((footprint.id.as_str(), (*value)?)))
            .collect();
        let polygons = moved.footprints.into_iter().filter_map(|footprint| {
            let value = by_id.get(footprint.id.as_str())?;
            Some((footprint.polygon, *value))
        });
        let cover = Cover::new(polygons.collect());
        self.covers.push((crs.cloned(), cover));
        Ok(self.covers.len() - 1)
    }
}

impl Filter for Overlay {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let name = self.values.text("dimension").unwrap_or_default();
        let missing = |known: String| {
            let fault =
                self.values.fault("dimension", &format!("the dimension `{name}`, which the points lack"), known);
            fault.remedy(format!("`filters.ferry` with `\"dimensions\": \"=>{name}\"` makes it"))
        };
        self.place = flow.layout.require(name).map_err(missing)?;
        let dimension = flow.layout.dimensions()[self.place].clone();
        if self.layer.is_none() {
            self.read(&dimension)?;
        }
        if !flow.is_mixed {
            self.cover(flow.crs.clone().as_ref())?;
        }
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let crs = points.crs.clone();
        let cover = self.cover(crs.as_ref())?;
        let Some((_, cover)) = self.covers.get(cover) else { return Ok(()) };
        for i in (0..points.len()).filter(|&i| chosen.has(i)) {
            if let Some(value) = cover.at([points.get(0, i), points.get(1, i)]) {
                // Held against the type of the dimension before.
                let _ = points.column_mut(self.place).set(i, value);
            }
        }
        Ok(())
    }

    fn finish(&mut self, context: &Context<'_>) {
        for warning in self.warnings.drain(..) {
            context.warn(&format!("filters.overlay: {warning}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn values_are_numbers_or_texts_that_are() {
        let of = |value: Value| number_of(Some(&value));
        assert_eq!(of(json!(7)), Ok(Some(7.0)));
        assert_eq!(of(json!(" 2.5 ")), Ok(Some(2.5)));
        assert_eq!(of(json!(true)), Ok(Some(1.0)));
        assert_eq!(of(Value::Null), Ok(None));
        assert_eq!(number_of(None), Ok(None));
        assert_eq!(of(json!(503_100_000_022_871_i64)), Ok(Some(503_100_000_022_871.0)));
        assert!(of(json!(9_007_199_254_740_993_i64)).unwrap_err().contains("digits"));
        assert!(of(json!("NL.1")).is_err());
    }
}
