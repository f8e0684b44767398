//! `readers.copc`: cloud-optimised point clouds, of which only the octree nodes that are wanted are read.

use crate::error::Result;
use crate::pipeline::area::Area;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::source::{TileReader, reader_options};
use crate::pipeline::stage::{Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "readers.copc",
    summary: "Reads COPC files, only where points are wanted",
    role: Role::Reader,
    options,
    elsewhere: &[
        "ogr",
        "requests",
        "threads",
        "resolution",
        "header",
        "query",
        "vlr",
        "keep_alive",
        "fix_dims",
        "srs_vlr_order",
        "option_file",
    ],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let mut options = reader_options("COPC file; a pattern such as tiles/*.copc.laz stands for one reader per file");
    options.extend([
        OptionSpec::new("bounds", Kind::Text, "Only points in ([xmin, xmax], [ymin, ymax]), perhaps with [zmin, zmax]"),
        OptionSpec::new("polygon", Kind::Texts, "Only points in this polygon, or in any of these, as WKT"),
    ]);
    options
}

fn build(values: &Values) -> Result<Stage> {
    let bounds = values.text("bounds").map(|text| Area::of_bounds(text).map_err(|m| values.misfit("bounds", m)));
    let polygons = values.texts("polygon");
    let polygons = polygons.iter().map(|text| Area::of_wkt(text).map_err(|m| values.misfit("polygon", m)));
    let mut wanted = vec![bounds.transpose()?.into_iter().collect::<Vec<_>>()];
    wanted.push(polygons.collect::<Result<_, _>>()?);
    wanted.retain(|areas: &Vec<Area>| !areas.is_empty());
    Ok(Stage::Reader(Box::new(TileReader::new(values, wanted)?)))
}
