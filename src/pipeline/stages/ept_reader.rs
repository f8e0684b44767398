//! `readers.ept`: folders of Entwine Point Tiles, of which only the nodes that are wanted are read.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use crate::error::{InputError, Result};
use crate::pipeline::area::Area;
use crate::pipeline::ept::Ept;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Layout, Points};
use crate::pipeline::source::{named_crs, reader_options};
use crate::pipeline::stage::{Context, Flow, Next, Reader, Role, Stage, StageKind};
use crate::source::crs::Crs;
use crate::source::points::Extent;

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "readers.ept",
    summary: "Reads folders of Entwine Point Tiles, only where and as finely as points are wanted",
    role: Role::Reader,
    options,
    elsewhere: &["addons", "origin", "ogr", "header", "query", "requests", "threads", "option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let mut options = reader_options("`ept.json`, or its folder");
    options.extend([
        OptionSpec::new("bounds", Kind::Text, "Only points in ([xmin, xmax], [ymin, ymax]), perhaps with [zmin, zmax]"),
        OptionSpec::new("polygon", Kind::Texts, "Only points in this polygon, or in any of these, as WKT"),
        OptionSpec::new(
            "resolution",
            Kind::at_least(0.0),
            "Only as many levels as it takes until points are no further apart than this, CRS units; 0 takes all",
        )
        .or(0.0),
        OptionSpec::new(
            "ignore_unreadable",
            Kind::Boolean,
            "Whether nodes that cannot be read are left out; that is told, and the exit code is 2",
        )
        .or(false),
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
    let [override_crs, default_crs] = named_crs(values)?;
    Ok(Stage::Reader(Box::new(EptReader {
        path: values.text("filename").unwrap_or_default().into(),
        count: values.whole("count").unwrap_or(u64::MAX),
        override_crs,
        default_crs,
        no_crs: values.is_on("nosrs"),
        wanted,
        resolution: values.number("resolution").unwrap_or(0.0),
        leaves_out: values.is_on("ignore_unreadable"),
        opened: None,
        read: None,
        is_whole: true,
    })))
}

struct EptReader {
    path: PathBuf,
    count: u64,
    override_crs: Option<Arc<Crs>>,
    default_crs: Option<Arc<Crs>>,
    no_crs: bool,
    /// In one area of each of these lists points must lie.
    wanted: Vec<Vec<Area>>,
    resolution: f64,
    /// Whether nodes that cannot be read are left out.
    leaves_out: bool,
    opened: Option<Opened>,
    /// Number of points that were handed on; `None` before.
    read: Option<u64>,
    is_whole: bool,
}

struct Opened {
    ept: Ept,
    layout: Arc<Layout>,
    crs: Option<Arc<Crs>>,
}

impl EptReader {
    fn wants(&self, position: [f64; 3]) -> bool {
        self.wanted.iter().all(|areas| areas.iter().any(|area| area.has(position)))
    }

    fn touches(&self, node: &Extent) -> bool {
        let flat = |corner: [f64; 3]| [corner[0], corner[1]];
        let height = |area: &Area| {
            let extent = area.extent();
            extent.min[2] <= node.max[2] && extent.max[2] >= node.min[2]
        };
        let near = |area: &Area| area.touches(flat(node.min), flat(node.max)) && height(area);
        self.wanted.iter().all(|areas| areas.iter().any(near))
    }
}

impl Reader for EptReader {
    fn prepare(&mut self, context: &Context<'_>) -> Result<Flow> {
        let ept = Ept::open(&self.path)?;
        let own = match ept.crs.as_deref().filter(|_| !self.no_crs && self.override_crs.is_none()).map(Crs::parse) {
            Some(Ok(crs)) => Some(Arc::new(crs)),
            Some(Err(fault)) => {
                context.warn(&format!("{}: {fault}; override_srs can name the CRS", self.path.display()));
                None
            }
            None => None,
        };
        let crs = self.override_crs.clone().or(own).or_else(|| self.default_crs.clone());
        let layout = ept.layout()?;
        let mut areas = Some(vec![ept.extent]).filter(|_| self.count == u64::MAX);
        for wanted in &self.wanted {
            areas = areas.map(|areas| Area::clip(wanted, &areas));
        }
        let points = Some(self.count.min(ept.points));
        let flow = Flow { layout: layout.clone(), crs: crs.clone(), areas, points, ..Flow::default() };
        self.opened = Some(Opened { ept, layout: Arc::new(layout), crs });
        self.read = None;
        self.is_whole = true;
        Ok(flow)
    }

    fn read(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        let Some(Opened { ept, layout, crs }) = &self.opened else { return Ok(()) };
        let levels = if self.resolution > 0.0 { ept.levels_for(self.resolution) } else { u32::MAX };
        let nodes = ept.nodes(levels, &|node| self.touches(node))?;
        let mut given = 0;
        let mut lost: Option<(String, u64)> = None;
        for (key, count) in nodes {
            if given >= self.count {
                break;
            }
            let mut outcome = Ok(());
            let read = ept.read(key, count, layout, &mut |mut points: Points| {
                context.observer.advanced(points.len() as u64);
                points.crs.clone_from(crs);
                if !self.wanted.is_empty() {
                    let kept: Vec<bool> = (0..points.len()).map(|i| self.wants(points.position(i))).collect();
                    points.retain(&kept);
                }
                let left = self.count - given;
                if points.len() as u64 > left {
                    points = points.gather(&(0..left as usize).collect::<Vec<_>>());
                }
                given += points.len() as u64;
                if !points.is_empty() {
                    outcome = next(points);
                }
                // What is behind is no fault of the node.
                Ok(())
            });
            outcome?;
            let fault = match read {
                Ok(read) if read == count => continue,
                Ok(read) => {
                    let expected = format!("{count} points, as the hierarchy says");
                    InputError::new(ept.path(key), format!("{read} points"), expected).into()
                }
                Err(fault) => fault,
            };
            if !self.leaves_out {
                return Err(fault);
            }
            lost.get_or_insert_with(|| (fault.to_string(), 0)).1 += 1;
        }
        self.read = Some(given);
        if let Some((fault, count)) = lost {
            self.is_whole = false;
            context.warn(&format!("{fault}; {count} nodes could not be read or not wholly"));
        }
        Ok(())
    }

    fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn metadata(&self) -> Map<String, Value> {
        let Some(Opened { ept, layout, crs }) = &self.opened else { return Map::new() };
        let Extent { min, max } = ept.extent;
        Map::from_iter([
            ("filename".to_owned(), json!(self.path.display().to_string())),
            ("count".to_owned(), json!(ept.points)),
            ("read".to_owned(), json!(self.read)),
            ("bounds".to_owned(), json!([min, max].concat())),
            ("dimensions".to_owned(), json!(layout.names())),
            (
                "srs".to_owned(),
                json!({ "wkt": crs.as_ref().map_or("", |crs| &crs.wkt), "code": crs.as_ref().and_then(|crs| crs.code.clone()) }),
            ),
        ])
    }
}
