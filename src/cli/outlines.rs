//! The options that say which footprints.

use std::path::PathBuf;

use crate::error::InputError;
use crate::run::{FootprintSource, Limit, bounds};
use crate::source::crs::Crs;
use crate::source::footprints::FootprintOptions;

/// Where the footprints come from, and which of them are taken.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Footprints")]
pub struct OutlineArgs {
    /// Building footprints: GeoPackage, GeoJSON, Shapefile, FlatGeobuf, GeoParquet, SpatiaLite, also in object
    /// storage or on the web, or a PostGIS database ("PG:host=… dbname=…")
    #[arg(short, long, value_name = "FILE", conflicts_with = "no_footprint")]
    footprints: Option<PathBuf>,

    /// Outlines of the roofs, where the footprints are those of the walls: roofs hang over as far as these reach, at LoD 2.3
    #[arg(long, value_name = "FILE", conflicts_with = "no_footprint")]
    roofprint: Option<PathBuf>,

    /// Take what stands apart in the building points for an object each
    #[arg(long)]
    no_footprint: bool,

    /// CRS of the footprints; goes before what the file says
    #[arg(long, value_name = "CRS", conflicts_with = "no_footprint")]
    footprint_crs: Option<String>,

    /// Layer or table of the footprints, if there are several
    #[arg(long, value_name = "NAME", conflicts_with = "no_footprint")]
    layer: Option<String>,

    /// SELECT that gives the footprints of a database, instead of a layer
    #[arg(long, value_name = "SQL", conflicts_with_all = ["no_footprint", "layer"])]
    query: Option<String>,

    /// Only footprints whose attributes satisfy this, such as "status = 'in use' AND height > 3"
    #[arg(long, value_name = "EXPRESSION", conflicts_with = "no_footprint")]
    filter: Option<String>,

    /// Attribute that holds the ids of the buildings [default: guessed]
    #[arg(long, value_name = "NAME", conflicts_with = "no_footprint")]
    id_attribute: Option<String>,

    /// Only buildings in this box, in the CRS of the tiles, which is that of the model. A building is where a point inside
    /// its footprint is; the left and the lower edge belong to the box, the right and the upper one do not
    #[arg(
        id = "box",
        long = "box",
        value_name = "MINX,MINY,MAXX,MAXY",
        value_parser = bounds,
        allow_hyphen_values = true,
        conflicts_with = "no_footprint"
    )]
    bounds: Option<[f64; 4]>,

    /// Only buildings in the polygons of this file, in any format of footprints and any CRS; of two polygons with a common
    /// edge, each building is in one
    #[arg(long, value_name = "FILE", conflicts_with = "no_footprint")]
    limit_area: Option<PathBuf>,
}

impl OutlineArgs {
    /// Whether outlines of roofs are given.
    pub(super) fn has_roofprints(&self) -> bool {
        self.roofprint.is_some()
    }

    /// The footprints, none where every object is to be found in the points; which of them; and the file of the outlines of
    /// roofs.
    ///
    /// # Errors
    /// Neither is said, or a CRS that is none.
    pub(super) fn source(self) -> Result<(Option<FootprintSource>, Limit, Option<PathBuf>), InputError> {
        if self.footprints.is_none() && !self.no_footprint {
            let fault = InputError::new("--footprints", "none", "the file of the outlines of the buildings");
            return Err(fault.remedy("Without outlines --no-footprint takes what stands apart for a building each"));
        }
        let named = |fault: InputError| InputError { file: "--footprint-crs".into(), ..fault };
        let crs = self.footprint_crs.as_deref().map(Crs::parse).transpose().map_err(named)?;
        let (layer, query) = (self.layer, self.query);
        let (filter, id_attribute) = (self.filter, self.id_attribute);
        let options = FootprintOptions { layer, query, filter, id_attribute, crs, within: None };
        let source = self.footprints.map(|path| FootprintSource { path, options });
        Ok((source, Limit { bounds: self.bounds, area: self.limit_area }, self.roofprint))
    }
}
