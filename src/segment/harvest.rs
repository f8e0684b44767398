//! What one tile gives to the sites.

use super::counts::PointCounts;
use super::ground::{GROUND_CELL, Lows, OPEN_CELL};
use super::naming::Naming;
use super::neighbourhood::{Neighbourhood, Place, snap, to_local};
use super::options::{BuildingClasses, NEVER_BUILDING, NOISE, SegmentOptions, UseFlagged};
use super::outside::Outside;
use super::thinned::{Choice, Thinned};
use super::unused::Unused;
use crate::error::Result;
use crate::source::points::{Block, Extent, Region, Tile, TileProblem};
use crate::terrain::{Collector, GroundStore};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Classes that say that a point is of the ground, or on a bridge (LAS 1.4 R15, table 17).
const GROUND_LIKE: [u8; 4] = [8, 17, 20, 21];

/// The part a class plays.
#[derive(Debug, Clone, Copy, Default)]
#[expect(clippy::struct_excessive_bools, reason = "a class may play several parts")]
struct Role {
    noise: bool,
    ground: bool,
    building: bool,
    /// It could be of a building, but its class was not asked for.
    candidate: bool,
}

/// The part that each of the 256 classes plays.
pub(super) struct Roles {
    of_class: [Role; 256],
    use_flagged: UseFlagged,
    /// Whether every class can be of a building.
    is_any: bool,
}

impl Roles {
    /// As `options` say.
    pub fn new(options: &SegmentOptions) -> Self {
        let of_class = std::array::from_fn(|class| {
            let class = class as u8;
            let noise = NOISE.contains(&class);
            let ground = options.ground_classes.contains(&class);
            let building = match &options.building_classes {
                BuildingClasses::Listed(classes) => classes.contains(&class),
                BuildingClasses::Keyword(_) => !ground && !NEVER_BUILDING.contains(&class),
            };
            let candidate =
                !noise && !ground && !building && !NEVER_BUILDING.contains(&class) && !GROUND_LIKE.contains(&class);
            Role { noise, ground, building: building && !noise, candidate }
        });
        Self { of_class, use_flagged: options.use_flagged, is_any: options.building_classes.is_any() }
    }

    /// Whether points of `class` can be building points.
    pub fn is_building(&self, class: u8) -> bool {
        self.of_class[usize::from(class)].building
    }
}

/// What one tile gives to the sites.
pub(super) struct Harvest {
    /// Building points per footprint, local metres, in no particular order and with duplicates.
    pub points: BTreeMap<usize, Vec<[f64; 3]>>,
    /// Building points in no footprint, under the roof of one of which the outline is known; as above.
    pub under_eaves: BTreeMap<usize, Vec<[f64; 3]>>,
    /// Ground points, thinned.
    pub ground: Thinned,
    /// Ground points inside each footprint, thinned less; for each apart, so that no neighbour changes what is kept.
    pub inner_ground: BTreeMap<usize, Thinned>,
    /// Lowest points, thinned.
    pub lows: Lows,
    /// Points inside each footprint that could be of a building and are not used, by why.
    pub unused: BTreeMap<(usize, Unused), u64>,
    /// What was counted.
    pub counts: PointCounts,
    /// Extents of the tiles.
    pub extents: Vec<Extent>,
    /// What is wrong with them.
    pub problems: Vec<TileProblem>,
}

impl Harvest {
    /// Nothing.
    pub fn new(metres_per_unit: [f64; 3]) -> Self {
        Self {
            points: BTreeMap::new(),
            under_eaves: BTreeMap::new(),
            ground: Thinned::new(Choice::Central, GROUND_CELL, metres_per_unit),
            inner_ground: BTreeMap::new(),
            lows: Lows::new(metres_per_unit),
            unused: BTreeMap::new(),
            counts: PointCounts::default(),
            extents: Vec::new(),
            problems: Vec::new(),
        }
    }

    /// Streams `tile` and takes what is wanted of it.
    ///
    /// # Errors
    /// The tile cannot be opened.
    pub fn of(
        tile: &Tile,
        all: &Neighbourhood,
        roles: &Roles,
        naming: &Naming,
        metres_per_unit: [f64; 3],
        (progress, terrain): (&(dyn Fn(u64) + Sync), Option<&GroundStore>),
    ) -> Result<Self> {
        let mut harvest = Self::new(metres_per_unit);
        let is_far = |extent: Extent| !all.is_wanted([extent.min[0], extent.min[1]], [extent.max[0], extent.max[1]]);
        let named: Vec<Option<(usize, Arc<Place>)>> =
            naming.table(tile).into_iter().map(|index| index.map(|index| (index, all.place(index)))).collect();
        // A point that names its building may lie anywhere.
        let is_far = || tile.extent.is_some_and(is_far) && tile.is_true_to_its_extent();
        let is_passed_over = tile.is_elsewhere() || named.is_empty() && is_far();
        if is_passed_over && terrain.is_none() {
            harvest.counts.passed_over = tile.points;
            harvest.extents.extend(tile.areas());
            progress(tile.points);
            return Ok(harvest);
        }
        let inner = || Thinned::new(Choice::Central, OPEN_CELL, metres_per_unit);
        let mut told = 0;
        let mut seen = Extent::EMPTY;
        let mut outside = Outside::of(tile.stated_extent, metres_per_unit);
        let mut by_class = [0_u64; 256];
        let mut lookup = all.lookup();
        let wanted = |low: [f64; 2], high: [f64; 2]| all.is_wanted(low, high);
        let region: Option<&Region> = if terrain.is_some() { None } else { Some(&wanted) };
        let mut collector = terrain.map(GroundStore::collector);
        let reading = tile.stream(region, &mut |block: &Block| {
            for point in block.points() {
                seen.grow(point.position);
                outside.see(point.position);
                by_class[usize::from(point.class)] += 1;
                let role = roles.of_class[usize::from(point.class)];
                let dropped = &mut harvest.counts.dropped;
                let is_flagged = !roles.use_flagged.takes(point.withheld, point.synthetic);
                if is_flagged && point.withheld {
                    dropped.withheld += 1;
                } else if is_flagged {
                    dropped.synthetic += 1;
                } else if role.noise {
                    dropped.noise += 1;
                }
                let position = point.position.map(snap);
                if naming.by_place && (role.candidate || is_flagged && role.building) {
                    let kind = Unused::of(&point, is_flagged);
                    for (index, place) in lookup.near(position).unwrap_or_default() {
                        if place.contains(position) {
                            *harvest.unused.entry((*index, kind)).or_default() += 1;
                        }
                    }
                }
                if !is_flagged && !role.noise {
                    if let Some(collector) = &mut collector {
                        collector.add(position, role.ground);
                    }
                    let building = point.building.map(|of| named.get(of as usize).and_then(Option::as_ref));
                    if let Some(building) = building.filter(|_| role.building) {
                        match building {
                            Some((index, place)) => {
                                let local = to_local(&place.frame, position);
                                harvest.points.entry(*index).or_default().push(local);
                            }
                            None => dropped.unknown_building += 1,
                        }
                    }
                    let Some(footprints) = lookup.near(position) else { continue };
                    if role.building && !roles.is_any {
                        harvest.lows.building.add(position);
                    } else {
                        harvest.lows.others.add(position);
                    }
                    if role.ground {
                        harvest.ground.add(position);
                        for (index, place) in footprints.iter().filter(|_| naming.by_place) {
                            if place.contains(position) {
                                harvest.inner_ground.entry(*index).or_insert_with(inner).add(position);
                            }
                        }
                    }
                    if role.building && building.is_none() && naming.by_place {
                        let mut is_inside = false;
                        for (index, place) in footprints {
                            let local = to_local(&place.frame, position);
                            if place.prepared().contains([local[0], local[1]]) {
                                harvest.points.entry(*index).or_default().push(local);
                                is_inside = true;
                            }
                        }
                        for (index, place) in footprints.iter().filter(|_| !is_inside) {
                            let local = to_local(&place.frame, position);
                            if place.is_under_roof(local) {
                                harvest.under_eaves.entry(*index).or_default().push(local);
                            }
                        }
                    }
                }
            }
            told += block.len() as u64;
            progress(block.len() as u64);
        })?;
        collector.map_or(Ok(()), Collector::finish)?;
        progress(tile.points.saturating_sub(told));
        harvest.counts.read = reading.read;
        harvest.counts.passed_over = reading.passed_over;
        harvest.counts.dropped.absurd = reading.absurd;
        harvest.counts.classes = (0..=255).zip(by_class).filter(|(_, n)| *n > 0).collect();
        harvest.problems = reading.problems(tile);
        harvest.problems.extend(tile.wrong_claims(outside.count, reading.read));
        // A file that is cut off covers only what could be read of it, and one whose points lie outside its box covers
        // what they cover, too.
        let is_whole = reading.read >= reading.expected;
        if is_whole && (tile.extent.is_some() || tile.covered.is_some()) {
            harvest.extents.extend(tile.areas());
            harvest.extents.extend(outside.covered());
        } else if !seen.is_empty() {
            harvest.extents.push(seen);
        }
        Ok(harvest)
    }
}
