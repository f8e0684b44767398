//! The sites of a run from one point cloud, or each from the best of several.

use super::choice::{Offer, choose};
use super::clouds::Cloud;
use crate::error::{Error, Result};
use crate::segment::{SegmentOptions, Segmentation};
use crate::source::footprints::Footprint;
use crate::source::points::Tile;

/// The options for the points of the only cloud that all buildings are made from; `None` where each is made from the best of several.
pub(super) fn of_single(clouds: &[Cloud], options: &SegmentOptions) -> Option<SegmentOptions> {
    match (clouds, &options.year_attribute) {
        ([only], None) => Some(only.options(options)),
        _ => None,
    }
}

/// Gives `footprints` their points from the tiles of `clouds`; `of_tiles` does so from some tiles, with these options. A cloud that is of no use is
/// told and left out.
///
/// # Errors
/// What `of_tiles` says of the only cloud, or of the first of several that are all of no use.
pub(super) fn segment(
    clouds: &[Cloud],
    tiles: &[Tile],
    footprints: Vec<Footprint>,
    options: &SegmentOptions,
    of_tiles: impl Fn(&[Tile], Vec<Footprint>, &SegmentOptions) -> Result<Segmentation>,
) -> Result<Segmentation> {
    if let Some(options) = of_single(clouds, options) {
        return of_tiles(tiles, footprints, &options);
    }
    let mut whole = Segmentation::default();
    let mut offers = Vec::with_capacity(clouds.len());
    let mut first_fault = None;
    for cloud in clouds {
        let found = match of_tiles(&cloud.tiles(tiles), footprints.clone(), &cloud.options(options)) {
            Ok(found) => found,
            Err(fault @ Error::Input(_)) => {
                whole.warnings.push(format!("{}: {fault}; this point cloud is left out", cloud.name()));
                first_fault.get_or_insert(fault);
                continue;
            }
            Err(fault) => return Err(fault),
        };
        let Segmentation { sites, notes, counts, problems, warnings } = found;
        offers.push(Offer { cloud, sites, notes });
        whole.counts.add(&counts);
        whole.problems.extend(problems);
        whole.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", cloud.name())));
    }
    match first_fault {
        Some(fault) if offers.is_empty() => return Err(fault),
        _ => {}
    }
    (whole.sites, whole.notes) = choose(offers, options);
    whole.problems.sort();
    Ok(whole)
}
