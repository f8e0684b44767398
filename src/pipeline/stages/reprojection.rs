//! `filters.reprojection`: takes points to another CRS.

use std::sync::Arc;

use crate::error::{InputError, Result};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::source::crs_of;
use crate::pipeline::stage::{Context, Filter, Flow, Role, Stage, StageKind};
use crate::source::crs::{Crs, SpatialTransformer};
use crate::source::points::Extent;

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.reprojection",
    summary: "Takes points to another CRS, with their heights where both have a vertical part",
    role: Role::Filter,
    options,
    elsewhere: &["in_axis_ordering", "out_axis_ordering", "in_coord_epoch", "out_coord_epoch", "option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new("in_srs", Kind::Text, "CRS of the points, whatever they say"),
        OptionSpec::new("out_srs", Kind::Text, "CRS that they are taken to, such as EPSG:7415 or EPSG:2154+5720")
            .required(),
        OptionSpec::new(
            "error_on_failure",
            Kind::Boolean,
            "Whether a point that cannot be taken there is an error, not dropped",
        )
        .or(false),
    ]
}

fn build(values: &Values) -> Result<Stage> {
    let crs = |option: &str| values.text(option).map(|text| crs_of(values, option, text)).transpose();
    let Some(to) = crs("out_srs")? else {
        return Err(values.place().fault("no `out_srs`", "the CRS that the points are taken to").into());
    };
    Ok(Stage::Filter(Box::new(Reprojection {
        from: crs("in_srs")?.map(Arc::new),
        to: Arc::new(to),
        is_strict: values.is_on("error_on_failure"),
        values: values.clone(),
        area: None,
        ways: Vec::new(),
        lost: 0,
    })))
}

struct Reprojection {
    values: Values,
    from: Option<Arc<Crs>>,
    to: Arc<Crs>,
    is_strict: bool,
    /// West, south, east, north of the points, in their CRS.
    area: Option<[f64; 4]>,
    /// From each CRS that points came in.
    ways: Vec<(Arc<Crs>, SpatialTransformer)>,
    lost: u64,
}

impl Reprojection {
    /// The place of the way from a CRS.
    fn way(&mut self, from: &Arc<Crs>) -> Result<usize, InputError> {
        if let Some(place) = self.ways.iter().position(|(own, _)| own == from) {
            return Ok(place);
        }
        let way = SpatialTransformer::new(from, &self.to, self.area)
            .map_err(|reason| self.values.fault("out_srs", &self.to.to_string(), reason))?;
        self.ways.push((Arc::clone(from), way));
        Ok(self.ways.len() - 1)
    }
}

impl Filter for Reprojection {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.ways.clear();
        self.lost = 0;
        let around = flow.areas.iter().flatten().fold(Extent::EMPTY, |mut all, area| {
            all.join(area);
            all
        });
        let is_one = !flow.is_mixed && !around.is_empty();
        self.area = is_one.then_some([around.min[0], around.min[1], around.max[0], around.max[1]]);
        match self.from.clone().or_else(|| flow.crs.clone()) {
            Some(from) => {
                let way = self.way(&from)?;
                let move_all = |areas: Vec<Extent>| areas.iter().map(|area| moved(area, &self.ways[way].1)).collect();
                flow.areas = flow.areas.take().and_then(move_all);
            }
            None if flow.is_mixed => flow.areas = None,
            None => {
                let fault = self.values.place().fault("points whose CRS is not known", "`in_srs`, which names it");
                return Err(fault.into());
            }
        }
        flow.crs = Some(Arc::clone(&self.to));
        flow.is_mixed = false;
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let Some(from) = self.from.clone().or_else(|| points.crs.clone()) else {
            let fault = self.values.place().fault("points whose CRS is not known", "`in_srs`, which names it");
            return Err(fault.into());
        };
        let way = self.way(&from)?;
        let mut positions: Vec<[f64; 3]> = (0..points.len()).map(|i| points.position(i)).collect();
        self.ways[way].1.transform(&mut positions);
        let mut kept = vec![true; points.len()];
        for (i, position) in positions.into_iter().enumerate().filter(|(i, _)| chosen.has(*i)) {
            if position.iter().all(|value| value.is_finite()) {
                for (axis, value) in position.into_iter().enumerate() {
                    // X, Y and Z are doubles, into which everything fits.
                    let _ = points.column_mut(axis).set(i, value);
                }
            } else if self.is_strict {
                let [x, y, z] = points.position(i);
                let found = format!("the point {x} {y} {z}, which cannot be taken to {}", self.to);
                return Err(self.values.place().fault(found, "points within the area of both CRSs").into());
            } else {
                kept[i] = false;
                self.lost += 1;
            }
        }
        points.retain(&kept);
        points.crs = Some(Arc::clone(&self.to));
        Ok(())
    }

    fn finish(&mut self, context: &Context<'_>) {
        for (_, way) in &self.ways {
            if let Some(warning) = way.warning() {
                context.warn(&format!("filters.reprojection: {warning}"));
            }
        }
        if self.lost > 0 {
            context.warn(&format!(
                "filters.reprojection: {} points cannot be taken to {} and are dropped",
                self.lost, self.to
            ));
        }
    }
}

/// The box around an area in the other CRS; `None` where it cannot be taken there.
fn moved(area: &Extent, way: &SpatialTransformer) -> Option<Extent> {
    let ([x0, y0, z], [x1, y1, _]) = (area.min, area.max);
    let z = if z.is_finite() { z } else { 0.0 };
    let mut corners = [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]];
    way.transform(&mut corners);
    if !corners.iter().flatten().all(|value| value.is_finite()) {
        return None;
    }
    // Sides that turn must not make footprints at the border seem covered: the box within the four corners.
    let mut xs = corners.map(|corner| corner[0]);
    let mut ys = corners.map(|corner| corner[1]);
    xs.sort_by(f64::total_cmp);
    ys.sort_by(f64::total_cmp);
    (xs[1] <= xs[2] && ys[1] <= ys[2])
        .then_some(Extent { min: [xs[1], ys[1], f64::NEG_INFINITY], max: [xs[2], ys[2], f64::INFINITY] })
}
