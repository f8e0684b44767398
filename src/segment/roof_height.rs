//! Heights of roofs that the user states.

use std::collections::BTreeMap;

use super::ground::{Found, number};
use super::neighbourhood::Neighbourhood;
use super::options::{HeightAbove, SegmentOptions};
use crate::source::footprints::Footprint;

/// The heights of roofs that an attribute of the footprints gives, local metres, by the footprint; what is no number gives
/// none. `grounds` are those of the footprints.
pub(super) fn stated(
    footprints: &[Footprint],
    all: &Neighbourhood,
    grounds: &[Found],
    options: &SegmentOptions,
) -> BTreeMap<usize, f64> {
    let Some(name) = &options.roof_height_attribute else { return BTreeMap::new() };
    let places = footprints.iter().zip(&all.frames).zip(grounds).enumerate();
    let heights = places.filter_map(|(index, ((footprint, frame), (ground, _)))| {
        let height = footprint.attribute(name).and_then(number)?;
        let local = match options.roof_height_above {
            HeightAbove::Datum => (height - frame.origin[2]) * frame.metres_per_unit[2],
            HeightAbove::Ground => ground.height + height * frame.metres_per_unit[2],
        };
        Some((index, local))
    });
    heights.collect()
}
