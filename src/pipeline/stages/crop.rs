//! `filters.crop`: keeps points inside or outside of boxes, polygons, circles and spheres.

use std::sync::Arc;

use geo::{Coord, LineString, MapCoords, MultiPolygon, Polygon};

use crate::error::{InputError, Result};
use crate::pipeline::area::Area;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::source::crs_of;
use crate::pipeline::stage::{Context, Filter, Flow, Role, Stage, StageKind, Whole};
use crate::source::crs::{Crs, Transformer};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.crop",
    summary: "Keeps points inside or outside of boxes, polygons, circles and spheres",
    role: Role::Filter,
    options,
    elsewhere: &["ogr", "option_file"],
    collects: "with more than one area, because each gives points of its own",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new(
            "bounds",
            Kind::Texts,
            "Box ([xmin, xmax], [ymin, ymax]), perhaps with [zmin, zmax]; or several",
        ),
        OptionSpec::new("polygon", Kind::Texts, "Polygon as WKT, or several"),
        OptionSpec::new("point", Kind::Texts, "Place as WKT, or several; with `distance`"),
        OptionSpec::new("distance", Kind::at_least(0.0), "Radius around `point`; a place with a height makes a sphere"),
        OptionSpec::new("outside", Kind::Boolean, "Whether points outside are kept, not those inside").or(false),
        OptionSpec::new("a_srs", Kind::Text, "CRS of the areas, where it is not that of the points"),
    ]
}

fn build(values: &Values) -> Result<Stage> {
    let mut areas = Vec::new();
    // In this order each area gives its points, as in PDAL.
    for text in values.texts("polygon") {
        areas.push(Area::of_wkt(text).map_err(|m| values.misfit("polygon", m))?);
    }
    for text in values.texts("bounds") {
        areas.push(Area::of_bounds(text).map_err(|m| values.misfit("bounds", m))?);
    }
    for text in values.texts("point") {
        let Some(distance) = values.number("distance") else {
            return Err(values.place().fault("`point` without `distance`", "the radius as `distance`").into());
        };
        areas.push(Area::near_wkt(text, distance).map_err(|m| values.misfit("point", m))?);
    }
    if areas.is_empty() {
        return Err(values.place().fault("no area", "`bounds`, `polygon`, or `point` with `distance`").into());
    }
    let crs = values.text("a_srs").map(|text| crs_of(values, "a_srs", text)).transpose()?;
    let crop = Crop { values: values.clone(), areas, crs: crs.map(Arc::new), outside: values.is_on("outside") };
    Ok(if crop.areas.len() == 1 { Stage::Filter(Box::new(crop)) } else { Stage::Whole(Box::new(crop)) })
}

struct Crop {
    values: Values,
    /// In `crs` until prepared, then in that of the points.
    areas: Vec<Area>,
    crs: Option<Arc<Crs>>,
    outside: bool,
}

impl Crop {
    /// Brings the areas into the CRS of the points, and cuts what was scanned.
    fn fit(&mut self, flow: &mut Flow) -> Result<()> {
        if let Some(from) = self.crs.take() {
            let Some(to) = &flow.crs else {
                let found = "`a_srs` for points whose CRS is not known";
                return Err(self.values.place().fault(found, "points of one CRS that is known").into());
            };
            if *from != **to {
                let areas = self.areas.iter().map(|area| self.reproject(area, &from, to)).collect::<Result<_, _>>()?;
                self.areas = areas;
            }
        }
        if !self.outside {
            flow.areas = flow.areas.take().map(|areas| Area::clip(&self.areas, &areas));
        }
        Ok(())
    }

    /// An area in another CRS: boxes become polygons, because their sides turn.
    fn reproject(&self, area: &Area, from: &Crs, to: &Crs) -> Result<Area, InputError> {
        let polygons = match area {
            Area::Polygons(polygons, _) => polygons.clone(),
            Area::Box(extent) => {
                let ([x0, y0, _], [x1, y1, _]) = (extent.min, extent.max);
                let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
                let ring: LineString<f64> = corners.map(Coord::from).into_iter().collect();
                MultiPolygon::new(vec![Polygon::new(ring, Vec::new())])
            }
            Area::Near { .. } => {
                let found = "`a_srs` with `point`";
                return Err(self.values.place().fault(found, "the place in the CRS of the points, without `a_srs`"));
            }
        };
        let extent = area.extent();
        let extent = [extent.min[0], extent.min[1], extent.max[0], extent.max[1]];
        let fault =
            |reason: String| self.values.place().fault(reason, "a CRS from which areas can be brought to the points");
        let transformer = Transformer::new(from, to, Some(extent)).map_err(fault)?;
        let polygons = polygons.map_coords(|Coord { x, y }| {
            let mut place = [[x, y]];
            transformer.transform(&mut place);
            Coord::from(place[0])
        });
        Area::of_polygons(polygons).ok_or_else(|| fault("an area that is empty in the CRS of the points".to_owned()))
    }

    fn keeps(&self, area: &Area, points: &Points, i: usize) -> bool {
        area.has(points.position(i)) != self.outside
    }
}

impl Filter for Crop {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.fit(flow)
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let Some(area) = self.areas.first() else { return Ok(()) };
        points.retain_of(chosen, |points, i| self.keeps(area, points, i));
        Ok(())
    }
}

impl Whole for Crop {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.fit(flow)
    }

    fn view(&mut self, points: Points, _context: &Context<'_>) -> Result<Vec<Points>> {
        let of = |area: &Area| {
            let places: Vec<usize> = (0..points.len()).filter(|&i| self.keeps(area, &points, i)).collect();
            points.gather(&places)
        };
        Ok(self.areas.iter().map(of).filter(|points| !points.is_empty()).collect())
    }
}
