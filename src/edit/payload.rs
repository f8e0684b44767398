//! What the page is given of one building: a head in JSON and columns of numbers, packed as those of [`view`](crate::view).

use geo::{Coord, MapCoords, MultiPolygon};
use nalgebra::Point3;
use serde::Serialize;

use super::drawn::{Made, Scanned};
use super::planes::{Addressed, Told};
use super::roll::Row;
use super::words::words;
use super::{Figures, Session};
use crate::building::Building;
use crate::edits::{Action, State};
use crate::error::Result;
use crate::explain::polygons::{PLANES, SURFACES};
use crate::reconstruct::{Parameters, as_edited};
use crate::site::Frame;
use crate::source::footprints::{Rings, rings};
use crate::view::packed::{STEPS_PER_METRE, packed_quickly};

/// What the page is told in JSON.
#[derive(Debug, Serialize)]
struct Head<'a> {
    id: &'a str,
    gable: &'static str,
    revision: u64,
    state: State,
    /// Its row of the list.
    row: &'a Row,
    crs: &'a str,
    origin: [f64; 3],
    metres_per_unit: [f64; 3],
    steps_per_metre: f64,
    /// How long the last solve took.
    took_ms: f64,
    edits: Vec<Done<'a>>,
    /// How many edits can be done again.
    undone: usize,
    before: Figures,
    now: Figures,
    /// Whether LoD 2.2 was reached: each of its solids is valid.
    valid: bool,
    failure: Option<&'a str>,
    notes: &'a [String],
    /// The height of the floor, in the CRS.
    floor: f64,
    lambda: f64,
    minimum_feature: f64,
    /// Those of all buildings.
    defaults: Defaults,
    footprint: Rings,
    footprint_before: Rings,
    planes: Vec<Told>,
    plane_kinds: [&'static str; PLANES.len()],
    surfaces: [&'static str; SURFACES.len()],
    columns: Vec<(&'static str, usize)>,
}

/// An edit that was done.
#[derive(Debug, Serialize)]
struct Done<'a> {
    name: &'static str,
    action: &'a Action,
    text: String,
    time: Option<&'a str>,
    author: Option<&'a str>,
    applied: bool,
    /// Why it does not apply.
    note: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct Defaults {
    lambda: f64,
    minimum_feature: f64,
}

/// A building as the page is given it.
///
/// # Errors
/// Never in practice: memory takes every byte.
pub(super) fn payload(session: &Session, scanned: &Scanned, (revision, row, crs): (u64, &Row, &str)) -> Result<String> {
    let (site, now) = (session.site(), session.now());
    let (edited, parameters) = as_edited(site, session.parameters());
    let (building, steps) = (&now.building, &now.steps);
    let addressed = Addressed::all(steps.detected.as_ref());
    let made = Made::new(scanned, (site, &edited), (building, session.before()), steps, &addressed);
    let Frame { origin, metres_per_unit } = site.frame;
    let figures = Figures::of(building);
    let of_all: &Parameters = session.parameters();
    let head = Head {
        id: &site.id,
        gable: env!("CARGO_PKG_VERSION"),
        revision,
        state: row.state,
        row,
        crs,
        origin,
        metres_per_unit,
        steps_per_metre: STEPS_PER_METRE,
        took_ms: (now.took.as_secs_f64() * 1e4).round() / 10.0,
        edits: done(session),
        undone: session.undone().len(),
        before: Figures::of(session.before()),
        valid: figures.lod == "2.2",
        failure: building.outcome.reason().map(|(_, detail)| detail),
        notes: &building.notes,
        floor: figures.floor.unwrap_or(origin[2] + edited.ground.height / metres_per_unit[2]),
        lambda: parameters.labelling.lambda,
        minimum_feature: parameters.surface.minimum_feature,
        defaults: Defaults { lambda: of_all.labelling.lambda, minimum_feature: of_all.surface.minimum_feature },
        footprint: in_crs(&site.frame, edited.footprint.as_ref()),
        footprint_before: in_crs(&site.frame, site.footprint.as_ref()),
        planes: addressed.iter().map(|plane| plane.told(&site.frame)).collect(),
        plane_kinds: PLANES,
        surfaces: SURFACES,
        columns: made.in_order(scanned).map(|(name, column)| (name, column.len())).collect(),
        now: figures,
    };
    packed_quickly(&head, made.in_order(scanned).map(|(_, column)| column))
}

/// The edits that are done, and what became of each.
fn done(session: &Session) -> Vec<Done<'_>> {
    let refused = session.now().building.measures.edits.as_ref().map_or(&[][..], |tally| tally.refused.as_slice());
    let why = |number: usize| refused.iter().find(|refused| refused.number == number).map(|refused| &*refused.why);
    let told = session.edits().iter().zip(1..).map(|(edit, number)| Done {
        name: edit.action.name(),
        action: &edit.action,
        text: words(&edit.action),
        time: edit.time.as_deref(),
        author: edit.author.as_deref(),
        applied: why(number).is_none(),
        note: why(number),
    });
    told.collect()
}

/// How many edits of a building do not apply.
pub(super) fn refused(building: &Building) -> usize {
    building.measures.edits.as_ref().map_or(0, |tally| tally.refused.len())
}

/// The polygons of a footprint in the CRS, as edits take them.
fn in_crs(frame: &Frame, footprint: Option<&MultiPolygon<f64>>) -> Rings {
    let place = |c: Coord<f64>| {
        let [x, y, _] = frame.to_crs(&Point3::new(c.x, c.y, 0.0));
        Coord { x, y }
    };
    footprint.map(|footprint| rings(&footprint.map_coords(place))).unwrap_or_default()
}
