//! The ground around a building, and its floor.
//!
//! Ground points are thinned while they stream by ([`super::thinned`]), which gives every part of the ring the same
//! weight whatever the overlap of strips. What is left is taken for a [surface](surface::Surface) with noise: the floor is
//! where this surface meets the outline, not some low point of the ring.
//!
//! The floor comes from the first of these that there is: an attribute of the footprint that the user names
//! ([`stated`]), a terrain model that the user gives, the ground points around ([`around`]), the floors of neighbours that
//! come from one of these, or from their lowest points ([`neighbours`]), the lowest points around the building and on its
//! walls ([`feet`]), and the lower end of its own points. Of neighbours and lowest points the surer one is taken,
//! or the neighbours where the lower part of the walls was not seen, and never a floor above the lowest point of a wall.

mod around;
mod feet;
mod fit;
pub(super) mod neighbours;
mod outline;
mod stated;
mod surface;

pub(super) use around::{Around, look};
use geo::Centroid;
pub(super) use neighbours::Known;
use neighbours::Neighbours;
pub(super) use stated::{Stated, number, read_attributes, read_terrain, refuse_unknown};

use super::neighbourhood::{Place, to_local};
use super::options::SegmentOptions;
use super::thinned::{Choice, Thinned};
use crate::site::{Frame, Ground, GroundSource, Site};

/// Side of the cells of the ground, metres.
pub(super) const GROUND_CELL: f64 = 1.0;
/// Side of the cells of the ground inside footprints, metres; of open ground every part counts, so they are small.
pub(super) const OPEN_CELL: f64 = 0.5;
/// Side of the cells of the lowest points, metres; wide, so that a cell under a tree sees the ground somewhere.
pub(super) const LOWEST_CELL: f64 = 2.0;
/// Side of the cells of the lowest building points, metres; narrow, since on a wall every point tells.
const FEET_CELL: f64 = 1.0;
/// Where the floors of more than this share of the buildings are guessed, it is told for the run as a whole.
const MANY_GUESSES: f64 = 0.1;
/// Floors from lowest points that are less sure than this, metres, are no help to neighbours.
const UNSURE: f64 = 0.5;

/// Where its lowest points are above the floors of its neighbours by so many of their standard deviations, the lower part of
/// its walls was not seen …
const HIDDEN_SPREADS: f64 = 3.0;
/// … if that is more than this, metres.
const LEAST_HIDDEN: f64 = 0.3;

/// The lowest points around footprints, thinned.
pub(super) struct Lows {
    /// Of all that is not of a building, or may be: where every class may be a building's, of all.
    pub others: Thinned,
    /// Of the building classes, where they are listed.
    pub building: Thinned,
}

impl Lows {
    /// None yet.
    pub fn new(metres_per_unit: [f64; 3]) -> Self {
        Self {
            others: Thinned::new(Choice::Lowest, LOWEST_CELL, metres_per_unit),
            building: Thinned::new(Choice::Lowest, FEET_CELL, metres_per_unit),
        }
    }

    /// Takes over what another one kept.
    pub fn merge(&mut self, other: Self) {
        self.others.merge(other.others);
        self.building.merge(other.building);
    }

    /// As [`Thinned::forget`].
    pub fn forget(&mut self, squares: &[[i32; 2]], side: f64) {
        self.others.forget(squares, side);
        self.building.forget(squares, side);
    }
}

/// The ground of a footprint, and the ground along its outline (local metres) where it was seen.
pub(super) type Found = (Ground, Vec<[f64; 3]>);

/// The floors beside buildings of which nothing sure is known.
pub(super) struct Beside {
    /// Floors that are sure.
    sure: Neighbours,
    /// And those of neighbours that come from their lowest points: they help only those that have none better.
    any: Neighbours,
}

impl Beside {
    /// From the floors that are sure and what is known around the other buildings, both in the order of the footprints.
    pub(super) fn new<'a>(mut known: Vec<Known>, unsure: impl Iterator<Item = (&'a Around, Option<[f64; 2]>)>) -> Self {
        let sure = Neighbours::new(known.clone());
        known.extend(unsure.filter_map(|(look, middle)| {
            let level = look.lowest.as_ref().filter(|level| level.unsure <= UNSURE)?;
            Some((middle?, level.height))
        }));
        Self { sure, any: Neighbours::new(known) }
    }

    /// The floor of a building that nothing sure is known of.
    pub(super) fn floor(&self, look: Around, middle: Option<[f64; 2]>) -> Ground {
        let Around { lowest, ceiling, bottom, .. } = look;
        let beside = |neighbours: &Neighbours| {
            let (height, spread) = neighbours.at(middle?)?;
            let is_better = lowest.as_ref().is_none_or(|own| {
                spread < own.unsure || own.height > height + (HIDDEN_SPREADS * spread).max(LEAST_HIDDEN)
            });
            (is_better && ceiling.is_none_or(|ceiling| height <= ceiling)).then_some((height, spread))
        };
        let sources = [
            (beside(&self.sure), GroundSource::Neighbours),
            (beside(&self.any), GroundSource::Neighbours),
            (lowest.as_ref().map(|own| (own.height, own.spread)), GroundSource::LowestPoints),
            (bottom.map(|height| (height, 0.0)), GroundSource::BoundingBox),
        ];
        let first = sources.into_iter().find_map(|(level, source)| Some((level?, source)));
        let ((height, spread), source) = first.unwrap_or(((0.0, 0.0), GroundSource::BoundingBox));
        Ground { height, spread, source }
    }
}

/// The middle of a footprint, metres of the CRS; `None` of an empty one.
pub(super) fn middle(place: &Place) -> Option<[f64; 2]> {
    let (frame, centre) = (&place.frame, place.polygon.centroid()?);
    let local = [centre.x(), centre.y()];
    Some([0, 1].map(|axis| frame.origin[axis] * frame.metres_per_unit[axis] + local[axis]))
}

/// What is said of a building whose floor was guessed; `None` for others.
pub(super) fn guess(site: &Site) -> Option<String> {
    let from = match site.ground.source {
        _ if site.points.is_empty() => return None,
        GroundSource::Attribute
        | GroundSource::TerrainModel
        | GroundSource::GroundPoints
        | GroundSource::ScannedFloor
        | GroundSource::Edit => return None,
        GroundSource::Neighbours => "the floors of its neighbours",
        GroundSource::LowestPoints => "the lowest points around it and on its walls",
        GroundSource::BoundingBox => "the lower end of its points",
    };
    Some(format!("no ground points around it: the height of its floor was guessed from {from}"))
}

/// What is said of many such buildings, of which so many were `guessed` of those `with_points`; `None` where they are few.
pub(super) fn guesses(with_points: usize, guessed: usize, options: &SegmentOptions) -> Option<String> {
    if guessed as f64 <= MANY_GUESSES * with_points as f64 {
        return None;
    }
    let classes: Vec<String> = options.ground_classes.iter().map(u8::to_string).collect();
    Some(format!(
        "the floors of {guessed} of {with_points} buildings were guessed from their neighbours or their lowest points, for \
         want of points of ground class {} around them: they may be too high, and heights and volumes too small; \
         --ground-class says which classes are ground, --ground-attribute which attribute of the footprints has the \
         heights of their floors, --dtm where a terrain model lies",
        classes.join(",")
    ))
}

/// The ground points inside a footprint, in its local frame, sorted by x, y, z.
pub(super) fn inside(frame: &Frame, ground: Option<&Thinned>) -> Vec<[f64; 3]> {
    let kept = ground.map_or_else(Vec::new, |ground| ground.points().collect());
    let mut points: Vec<_> = kept.into_iter().map(|position| to_local(frame, position)).collect();
    points.sort_unstable_by(super::lexicographic);
    points
}

/// The percentile of sorted values, interpolated between neighbours; 0 of none.
fn percentile(sorted: &[f64], percent: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = percent.clamp(0.0, 100.0) / 100.0 * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::percentile;

    #[test]
    fn percentiles_are_interpolated() {
        let heights = [1.0, 2.0, 3.0, 7.0];
        assert_eq!(percentile(&heights, 0.0), 1.0);
        assert_eq!(percentile(&heights, 50.0), 2.5);
        assert_eq!(percentile(&heights, 100.0), 7.0);
        assert_eq!(percentile(&[], 50.0), 0.0);
    }
}
