//! The footprints of a run: read where the tiles are, brought into their CRS, and what is odd about them told.

use std::collections::BTreeSet;

use super::job::{FootprintSource, Job};
use super::journal::Journal;
use super::limit::{self, Area};
use super::observer::Observer;
use super::tiles;
use crate::building::{Building, Measures, Outcome, Reason};
use crate::error::{InputError, Result};
use crate::record::Record;
use crate::report::FootprintsReport;
use crate::segment::SegmentOptions;
use crate::sink::AttributeOptions;
use crate::site::Frame;
use crate::solid::Model;
use crate::source::crs::Crs;
use crate::source::footprints::{self, Footprint, FootprintLayer, LARGEST_BUILDING, Rejected, Within};
use crate::source::points::{Extent, Tile};

/// So many names of attributes are shown in one warning.
const SHOWN: usize = 10;
/// Neighbours whose floors count are no farther than this, metres.
const NEIGHBOURS: f64 = 100.0;

/// The footprints of a run.
pub(super) struct Outlines {
    /// Those that are wanted and those beside them, in the order of the file.
    pub(super) footprints: Vec<Footprint>,
    /// Which of them are wanted.
    pub(super) is_wanted: Vec<bool>,
    /// Features without a usable polygon.
    pub(super) rejected: Vec<Rejected>,
    pub(super) report: FootprintsReport,
}

/// Reads the footprints; those far from all tiles and from `area` only where the format cannot tell which they are.
pub(super) fn read(
    job: &Job,
    source: &FootprintSource,
    tiles: &[Tile],
    area: Option<&Area>,
    journal: &Journal<'_>,
) -> Result<FootprintLayer> {
    let mut options = source.options.clone();
    if footprints::is_read_in_part(&source.path) {
        let with_points = tiles.iter().filter(|tile| tile.points > 0);
        let all: Option<Vec<Extent>> =
            with_points.map(|tile| tile.extent.filter(|_| tile.is_true_to_its_extent())).collect();
        let agreed = tiles::agree_on_crs(tiles, job.crs.as_deref(), None).ok();
        if let (Some((crs, ..)), Some(all)) = (agreed, all.filter(|all| !all.is_empty())) {
            let mut whole = Extent::EMPTY;
            for extent in &all {
                whole.join(extent);
            }
            let mut extent = [whole.min[0], whole.min[1], whole.max[0], whole.max[1]];
            if let Some(area) = area {
                let reach = margin(&job.segmentation, &crs).into_iter().fold(0.0, f64::max);
                let [x0, y0, x1, y1] = area.extent(reach + LARGEST_BUILDING / crs.metres_per_unit[0]);
                extent = [extent[0].max(x0), extent[1].max(y0), extent[2].min(x1), extent[3].min(y1)];
            }
            options.within = Some(Within { crs, extent });
        }
    }
    footprints::read_until(&source.path, &options, &|| journal.interrupted())
}

/// How far from a footprint others change what is known of it, CRS units along x and y: their floors, and where the ground
/// around them lies.
pub(super) fn margin(options: &SegmentOptions, crs: &Crs) -> [f64; 2] {
    let metres = NEIGHBOURS + 2.0 * options.ring_limit.max(options.ring_width);
    [metres / crs.metres_per_unit[0], metres / crs.metres_per_unit[1]]
}

/// Brings footprints into the CRS of the tiles and says what is odd about them; those outside `area` are left out.
pub(super) fn bring(
    mut layer: FootprintLayer,
    crs: &Crs,
    area: Option<&Area>,
    job: &Job,
    journal: &Journal<'_>,
) -> Result<Outlines> {
    let attributes = &job.attributes;
    let file = layer.path.display().to_string();
    let own_crs = layer.crs.as_ref().map(tiles::label);
    for warning in &layer.warnings {
        journal.warn(&format!("{file}: {warning}"));
    }
    if layer.footprints.is_empty() && layer.rejected.is_empty() && layer.has_more {
        let fault = InputError::new(&layer.path, "no feature at the tiles", "footprints where the tiles are");
        let remedy = "See whether they are of one place, and whether --crs and --footprint-crs are right";
        return Err(fault.remedy(remedy).into());
    }
    if layer.footprints.is_empty() && layer.rejected.is_empty() {
        let fault = InputError::new(&layer.path, "no feature", "footprints of buildings");
        return Err(fault.remedy("Check --layer and --filter").into());
    }
    refuse_unknown(&layer, job)?;
    if let Some(clashes) = reserved(&layer, attributes) {
        journal.warn(&format!("{file}: {clashes}"));
    }
    for warning in layer.reproject(crs)? {
        journal.warn(&warning);
    }
    layer.reject_giants(crs);
    if let Some(first) = layer.rejected.first() {
        let (count, total) = (layer.rejected.len(), layer.rejected.len() + layer.footprints.len());
        journal.warn(&format!(
            "{file}: {count} of {total} features have no usable polygon and are written without geometry, the first of \
             them {}: {}",
            first.id, first.reason
        ));
    }
    let mut outside = 0;
    let mut is_wanted = vec![true; layer.footprints.len()];
    if let Some(area) = area {
        is_wanted = layer.footprints.iter().map(|footprint| area.has_footprint(footprint)).collect();
        outside = leave_out(&mut layer, &mut is_wanted, area, margin(&job.segmentation, crs), journal)?;
    }
    let report = FootprintsReport {
        file,
        footprints: is_wanted.iter().filter(|is_wanted| **is_wanted).count(),
        rejected: layer.rejected.len(),
        outside,
        missing: layer.missing,
        is_damaged: layer.is_damaged,
        crs: own_crs,
        id_attribute: layer.id_attribute,
    };
    Ok(Outlines { footprints: layer.footprints, is_wanted, rejected: layer.rejected, report })
}

/// Leaves out what is not in `area` nor beside it; how many features that are not in it.
///
/// # Errors
/// None is in it.
fn leave_out(
    layer: &mut FootprintLayer,
    is_wanted: &mut Vec<bool>,
    area: &Area,
    margin: [f64; 2],
    journal: &Journal<'_>,
) -> Result<usize> {
    let total = layer.footprints.len();
    let inside = is_wanted.iter().filter(|is_wanted| **is_wanted).count();
    if inside == 0 {
        let fault =
            InputError::new(&layer.path, format!("none of {total} footprints in {}", area.name()), "one at least");
        let remedy = "A footprint is where a point inside it is; the box is in the CRS of the tiles: see `gable info`";
        return Err(fault.remedy(remedy).into());
    }
    let nowhere = std::mem::take(&mut layer.rejected).len();
    if nowhere > 0 {
        journal.warn(&format!(
            "{}: {nowhere} features without a usable polygon are left out: they are in no area",
            layer.path.display()
        ));
    }
    let beside = limit::beside(&layer.footprints, is_wanted, margin);
    let mut keep =
        is_wanted.iter().zip(&beside).map(|(wanted, beside)| *wanted || *beside).collect::<Vec<_>>().into_iter();
    layer.footprints.retain(|_| keep.next().unwrap_or(false));
    let mut beside = beside.into_iter();
    is_wanted.retain(|wanted| {
        let is_beside = beside.next().unwrap_or(false);
        *wanted || is_beside
    });
    Ok(total - inside + nowhere)
}

/// Refuses options that name an attribute of the footprints that none has.
fn refuse_unknown(layer: &FootprintLayer, job: &Job) -> Result<()> {
    let columns: Vec<&str> = layer.columns.iter().map(String::as_str).collect();
    let is_unknown = |name: &&str| !columns.iter().any(|column| column.eq_ignore_ascii_case(name));
    let kept = job.attributes.source.unknown(&columns).map(ToString::to_string);
    let named = [
        ("--footprint-attributes", kept.as_deref()),
        ("--block-attribute", job.parameters.block_attribute.as_deref()),
        ("--glass-attribute", job.parameters.glass_attribute.as_deref()),
        ("--year-attribute", job.segmentation.year_attribute.as_deref()),
        ("--roof-height-attribute", job.segmentation.roof_height_attribute.as_deref()),
    ];
    let mut unknown = named.into_iter().filter_map(|(option, name)| Some((option, name.filter(is_unknown)?)));
    match unknown.next().filter(|_| !layer.columns.is_empty()) {
        None => Ok(()),
        Some((option, name)) => {
            Err(InputError::new(&layer.path, format!("no attribute `{name}`"), "attributes that features have")
                .at(option)
                .remedy(layer.attributes_like(name))
                .into())
        }
    }
}

/// What is to be told of attributes whose names are gable's own, such as those of a model that it made before.
fn reserved(layer: &FootprintLayer, attributes: &AttributeOptions) -> Option<String> {
    let names: BTreeSet<&str> = layer.columns.iter().map(String::as_str).collect();
    let is_renamed = |name: &&str| attributes.source.have(name) && attributes.reserves(name);
    let names: Vec<&str> = names.into_iter().filter(is_renamed).collect();
    let rest = names.len().saturating_sub(SHOWN);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    (!names.is_empty()).then(|| {
        format!(
            "the attributes {}{more} have names that are gable's or those of an Extension: they are written as `source_…`, \
             and the notes of each building say so",
            names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
        )
    })
}

/// What is written of a feature without a usable polygon: its attributes and what is wrong with it.
pub(super) fn rejected(feature: Rejected, crs: &Crs) -> Building {
    let Rejected { id, attributes, reason, .. } = feature;
    Building {
        id,
        frame: Frame { origin: [0.0; 3], metres_per_unit: crs.metres_per_unit },
        attributes: attributes.to_map(),
        model: Model::default(),
        outcome: Outcome::Rejected { reason: Reason::NoPolygon, detail: reason },
        record: Record::default(),
        measures: Measures::default(),
        notes: Vec::new(),
    }
}
