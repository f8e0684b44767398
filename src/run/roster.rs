//! What is to come out, in its order, before anything is known but the footprints.

use super::corners::Corners;
use super::layer;
use super::template::Files;
use crate::building::Building;
use crate::segment::frame_of;
use crate::sink::Ids;
use crate::source::crs::Crs;
use crate::source::footprints::{Footprint, Rejected};

/// Stands for no place.
const NONE: u32 = u32::MAX;

/// The buildings of a model in their order: those of the footprints that are wanted, and of the features without a usable polygon.
pub(super) struct Roster {
    /// The footprint of each place; [`NONE`] for a feature without one. Behind the buildings come the footprints that are not wanted.
    footprints: Vec<u32>,
    /// The place of each footprint.
    places: Vec<u32>,
    /// The features without a usable polygon, by their places, ascending.
    rejected: Vec<(u32, Building)>,
    /// How many buildings there are.
    buildings: usize,
    /// The ids of all buildings.
    pub(super) ids: Ids,
    /// The corners of the frames of the buildings in each file.
    pub(super) corners: Corners,
}

impl Roster {
    /// The buildings of these footprints, of which those `is_wanted` are to come out, in the order of `files` where there are several.
    pub(super) fn new(
        footprints: &[Footprint],
        is_wanted: &[bool],
        rejected: Vec<Rejected>,
        files: Option<&Files>,
        crs: &Crs,
    ) -> Self {
        let wanted =
            footprints.iter().zip(is_wanted).filter(|(_, is_wanted)| **is_wanted).map(|(footprint, _)| footprint);
        let ids =
            wanted.map(|footprint| footprint.id.as_str()).chain(rejected.iter().map(|feature| feature.id.as_str()));
        let ids: Ids = ids.collect();
        let mut corners = Corners::new(files.map_or(1, |files| files.paths.len()));
        let file_of = |id: &str| files.and_then(|files| files.of_building.get(id).copied()).unwrap_or_default();
        // What is to be written, with its file; the footprints first.
        let mut order: Vec<(u32, usize)> = Vec::with_capacity(footprints.len() + rejected.len());
        let mut beside = Vec::new();
        for (index, (footprint, is_wanted)) in (0..).zip(footprints.iter().zip(is_wanted)) {
            if !is_wanted {
                beside.push(index);
                continue;
            }
            let file = file_of(&footprint.id);
            order.push((index, file));
            corners.see(file, frame_of(&footprint.polygon, crs.metres_per_unit).origin);
        }
        let first_rejected = footprints.len() as u32;
        order.extend((first_rejected..).zip(&rejected).map(|(index, feature)| (index, file_of(&feature.id))));
        // One file is written after the other.
        order.sort_by_key(|(_, file)| *file);
        let mut rejected: Vec<Option<Building>> =
            rejected.into_iter().map(|feature| Some(layer::rejected(feature, crs))).collect();
        let mut roster = Self {
            footprints: Vec::with_capacity(order.len() + beside.len()),
            places: vec![NONE; footprints.len()],
            rejected: Vec::new(),
            buildings: order.len(),
            ids,
            corners,
        };
        for index in order.into_iter().map(|(index, _)| index).chain(beside) {
            let place = roster.footprints.len() as u32;
            if let Some(own) = roster.places.get_mut(index as usize) {
                *own = place;
                roster.footprints.push(index);
            } else {
                let feature = rejected.get_mut((index - first_rejected) as usize).and_then(Option::take);
                roster.rejected.extend(feature.map(|feature| (place, feature)));
                roster.footprints.push(NONE);
            }
        }
        roster
    }

    /// How many buildings are to come out.
    pub(super) fn len(&self) -> usize {
        self.buildings
    }

    /// The place of a footprint; not below [`Self::len`] where it is not wanted.
    pub(super) fn place(&self, footprint: usize) -> usize {
        self.places.get(footprint).map_or(usize::MAX, |place| *place as usize)
    }

    /// The footprint of a place; `None` where there is none.
    pub(super) fn footprint(&self, place: usize) -> Option<usize> {
        self.footprints.get(place).filter(|index| **index != NONE).map(|index| *index as usize)
    }

    /// The places of the features without a usable polygon.
    pub(super) fn places_of_rejected(&self) -> impl Iterator<Item = usize> + '_ {
        self.rejected.iter().map(|(place, _)| *place as usize)
    }

    /// What is written of the feature without a usable polygon at a place.
    pub(super) fn rejected(&self, place: usize) -> Option<&Building> {
        let at = self.rejected.binary_search_by_key(&place, |(place, _)| *place as usize).ok()?;
        self.rejected.get(at).map(|(_, building)| building)
    }
}
