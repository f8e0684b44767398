//! A front that sweeps over the area: tiles come in an order in which those beside each other follow each other, and a
//! footprint is done as soon as all tiles that may hold points of it, or of the ground around it, have been read.
//!
//! What is kept is then a matter of the front, not of the area: the points of footprints at its edge, in memory up to a
//! budget and beyond it in a file ([`Waiting`]), and the ground around them. What comes out is the same, bit for bit, as if
//! all tiles had been read first, whatever the budget and the number of threads: tiles are taken in their order, and what
//! is asked about a footprint has been read when it is done. Only the floor of a building without ground around it hangs on those of
//! its neighbours, and so waits for the end.

use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock, PoisonError, RwLock};

use nalgebra::Point3;

use super::boxes::Rectangle;
use super::coverage::Covered;
use super::dense;
use super::front::{Front, SQUARE};
use super::ground::{self, Around, Beside, Found, LOWEST_CELL, Lows};
use super::harvest::{Harvest, Roles};
use super::naming::Naming;
use super::neighbourhood::Neighbourhood;
use super::order;
use super::thinned::Thinned;
use super::totals::{Swept, Totals};
use super::waiting::Waiting;
use super::{Finished, Meaning, SegmentOptions, finish, lexicographic, refuse, roof_height};
use crate::error::Result;
use crate::guard::lock;
use crate::record::Record;
use crate::site::{Eaves, Site};
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use crate::source::points::Tile;
use crate::terrain::GroundStore;

/// What lies this far beyond the reach of a footprint may change which point stands for a cell within it, metres.
const MARGIN: f64 = LOWEST_CELL + 0.001;

/// Tiles and footprints on their way to sites.
pub struct Sweep<'a> {
    /// In the order in which they are read.
    tiles: Vec<Reach<'a>>,
    crs: &'a Crs,
    options: &'a SegmentOptions,
    meaning: Meaning,
    terrain: Option<&'a GroundStore>,
    all: Neighbourhood,
    roles: Roles,
    naming: Naming,
    stated: ground::Stated,
    /// How far around a footprint tiles matter, CRS units.
    margin: [f64; 2],
    front: Mutex<Front>,
    around: RwLock<Surroundings>,
    waiting: Mutex<Waiting>,
    floors: Mutex<Floors>,
    /// The floors of neighbours, once all are known.
    neighbours: OnceLock<Beside>,
    totals: Mutex<Totals>,
}

/// A tile and the rectangle in which its points lie, CRS units; `None` where that is not known.
pub(super) struct Reach<'a> {
    pub(super) tile: &'a Tile,
    pub(super) within: Option<Rectangle>,
}

/// What was seen around footprints.
struct Surroundings {
    ground: Thinned,
    lows: Lows,
    covered: Covered,
    under_eaves: BTreeMap<usize, Vec<[f64; 3]>>,
    inner_ground: BTreeMap<usize, Thinned>,
}

/// The floors of buildings.
#[derive(Default)]
struct Floors {
    /// The middle of each building whose floor is sure, metres of the CRS, with the height.
    sure: BTreeMap<usize, ground::Known>,
    /// What is known around the others.
    unsure: BTreeMap<usize, Unsure>,
}

/// A building that waits for the floors of its neighbours.
struct Unsure {
    around: Around,
    middle: Option<[f64; 2]>,
    /// Its points before those that stand in the tiles more than once were left out.
    used: u64,
}

/// What a tile gives; made by [`Sweep::read`].
pub struct Part(Harvest);

impl<'a> Sweep<'a> {
    /// Prepares `tiles` and `footprints`, both in `crs`. Waiting points take up no more than `budget` bytes of memory.
    /// All ground points go to `terrain` as well, if there is one; then no part of a tile is passed over.
    ///
    /// # Errors
    /// As [`segment`](super::segment), as far as it can be told before the points are read.
    pub fn new(
        tiles: &'a [Tile],
        footprints: Vec<Footprint>,
        crs: &'a Crs,
        options: &'a SegmentOptions,
        meaning: Meaning,
        terrain: Option<&'a GroundStore>,
        budget: usize,
    ) -> Result<Self> {
        refuse::options(options)?;
        refuse::geographic(crs)?;
        let is_share = meaning == Meaning::OutlinesOfShare;
        if !is_share {
            refuse::without_points(tiles)?;
        }
        let naming = Naming::new(tiles, &footprints, meaning != Meaning::PlacesOfNamed);
        let mut stated = ground::read_attributes(&footprints, crs, options, is_share)?;
        let reach = options.ring_limit.max(options.ring_width);
        let all = Neighbourhood::new(footprints, crs, reach)?;
        if !is_share {
            refuse::apart(tiles, &all.boxes, crs)?;
        }
        let units = |metres: f64| [0, 1].map(|axis| metres / crs.metres_per_unit[axis]);
        let margin = units(reach.max(super::coverage::REACH) + MARGIN);
        let tiles = order::of(tiles);
        let mut left = vec![0; all.len()];
        for within in tiles.iter().filter_map(|reach| reach.within) {
            all.boxes.near(within, margin).for_each(|index| left[index] += 1);
        }
        let everywhere = tiles.iter().filter(|reach| reach.within.is_none()).count();
        ground::read_terrain(&all, crs, |index| everywhere > 0 || left[index] > 0, options, is_share, &mut stated)?;
        let metres = crs.metres_per_unit;
        let Harvest { ground, lows, .. } = Harvest::new(metres);
        let covered = Covered::new(metres);
        let surroundings =
            Surroundings { ground, lows, covered, under_eaves: BTreeMap::new(), inner_ground: BTreeMap::new() };
        Ok(Self {
            tiles,
            crs,
            options,
            meaning,
            terrain,
            roles: Roles::new(options),
            naming,
            stated,
            margin,
            front: Mutex::new(Front::new(everywhere, left, &all, margin, metres)),
            around: RwLock::new(surroundings),
            waiting: Mutex::new(Waiting::new(budget)),
            floors: Mutex::default(),
            neighbours: OnceLock::new(),
            totals: Mutex::default(),
            all,
        })
    }

    /// How many tiles there are to be read.
    pub fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// How many footprints there are.
    pub fn footprints(&self) -> usize {
        self.all.len()
    }

    /// Reads a tile, by its place in the order; on any thread. `progress` is told the number of points done since it was
    /// last told.
    ///
    /// # Errors
    /// It can no longer be opened, or what is kept for the terrain cannot be written.
    pub fn read(&self, tile: usize, progress: &(dyn Fn(u64) + Sync)) -> Result<Part> {
        let Some(Reach { tile, .. }) = self.tiles.get(tile) else { return Ok(Part(Harvest::new([1.0; 3]))) };
        let metres = self.crs.metres_per_unit;
        Harvest::of(tile, &self.all, &self.roles, &self.naming, metres, (progress, self.terrain)).map(Part)
    }

    /// Takes what a tile has given, one after the other in their order, and gives the footprints that are done with it, each with the number of its
    /// points. Those around which there is no tile come with the first.
    ///
    /// # Errors
    /// The temporary file cannot be written.
    pub fn take(&self, tile: usize, Part(harvest): Part) -> Result<Vec<(usize, usize)>> {
        let Harvest { points, under_eaves, ground, inner_ground, lows, unused, counts, extents, problems } = harvest;
        let mut front = lock(&self.front);
        let mut totals = lock(&self.totals);
        totals.counts.add(&counts);
        totals.problems.extend(problems);
        for ((index, kind), n) in unused {
            if !front.is_handed_out[index] {
                totals.unused(index, kind, n);
            }
        }
        let mut waiting = lock(&self.waiting);
        for (index, points) in points {
            if front.is_handed_out[index] {
                totals.late(index, points.len() as u64);
            } else {
                waiting.add(index, points);
            }
        }
        drop(totals);
        waiting.settle()?;
        {
            let mut around = self.around.write().unwrap_or_else(PoisonError::into_inner);
            around.ground.merge(ground);
            around.lows.merge(lows);
            around.covered.extend(extents);
            for (index, points) in under_eaves.into_iter().filter(|(index, _)| !front.is_handed_out[*index]) {
                around.under_eaves.entry(index).or_default().extend(points);
            }
            for (index, ground) in inner_ground.into_iter().filter(|(index, _)| !front.is_handed_out[*index]) {
                match around.inner_ground.entry(index) {
                    std::collections::btree_map::Entry::Vacant(slot) => drop(slot.insert(ground)),
                    std::collections::btree_map::Entry::Occupied(mut slot) => slot.get_mut().merge(ground),
                }
            }
            let forgotten = std::mem::take(&mut front.forgotten);
            around.ground.forget(&forgotten, SQUARE);
            around.lows.forget(&forgotten, SQUARE);
        }
        let within = self.tiles.get(tile).and_then(|reach| reach.within);
        let mut done: Vec<usize> = Vec::new();
        match within {
            Some(within) => {
                for index in self.all.boxes.near(within, self.margin) {
                    front.left[index] = front.left[index].saturating_sub(1);
                    if front.left[index] == 0 {
                        done.push(index);
                    }
                }
            }
            None => front.everywhere = front.everywhere.saturating_sub(1),
        }
        if front.everywhere > 0 {
            return self.all.check().map(|()| Vec::new());
        }
        if within.is_none() || tile == 0 {
            done = (0..front.left.len()).filter(|&index| front.left[index] == 0).collect();
        }
        done.retain(|&index| !std::mem::replace(&mut front.is_handed_out[index], true));
        done.sort_unstable();
        self.all.check()?;
        Ok(done.into_iter().map(|index| (index, waiting.count(index))).collect())
    }

    /// Makes the site of a footprint that is done, with its notes; on any thread. `None` where its floor has to come from its neighbours: then it is one of
    /// [`Self::rest`].
    ///
    /// # Errors
    /// The temporary file cannot be read.
    pub fn site(&self, index: usize) -> Result<Option<(Site, Vec<String>)>> {
        let mut points = lock(&self.waiting).take(index)?;
        let mut used = points.len() as u64;
        points.sort_unstable_by(lexicographic);
        points.dedup();
        let waited = lock(&self.floors).unsure.remove(&index);
        let found = if let Some(Unsure { around, middle, used: before }) = waited {
            used = before;
            (self.neighbours().floor(around, middle), Vec::new())
        } else {
            let look = {
                let Surroundings { ground, lows, .. } = &*self.around.read().unwrap_or_else(PoisonError::into_inner);
                ground::look(index, &self.all, ground, lows, &points, self.meaning, self.options)
            };
            let place = self.all.place(index);
            lock(&self.front).looked(&place, self.margin, self.crs.metres_per_unit);
            let middle = ground::middle(&place);
            let sure = self.stated.of(index, look.ground.as_ref(), self.options);
            let mut floors = lock(&self.floors);
            let Some(found) = sure else {
                floors.unsure.insert(index, Unsure { around: look, middle, used });
                drop(floors);
                let mut waiting = lock(&self.waiting);
                waiting.add(index, points);
                waiting.settle()?;
                return Ok(None);
            };
            floors.sure.extend(middle.map(|middle| (index, (middle, found.0.height))));
            found
        };
        let made = self.make(index, points, used, found);
        self.all.check()?;
        Ok(Some(made))
    }

    /// The footprints whose floors have to come from their neighbours, each with the number of its points, once all others
    /// have been made.
    pub fn rest(&self) -> Vec<(usize, usize)> {
        // What is known of all of them is known before the first of them is made.
        self.neighbours();
        let waiting = lock(&self.waiting);
        lock(&self.floors).unsure.keys().map(|&index| (index, waiting.count(index))).collect()
    }

    fn neighbours(&self) -> &Beside {
        self.neighbours.get_or_init(|| {
            let floors = lock(&self.floors);
            let unsure = floors.unsure.values().map(|unsure| (&unsure.around, unsure.middle));
            Beside::new(floors.sure.values().copied().collect(), unsure)
        })
    }

    fn make(&self, index: usize, points: Vec<[f64; 3]>, used: u64, (ground, line): Found) -> (Site, Vec<String>) {
        let place = self.all.place(index);
        let duplicate = used - points.len() as u64;
        let (rectangles, eaves, inner) = {
            let around = self.around.read().unwrap_or_else(PoisonError::into_inner);
            let rectangles = around.covered.near(&place);
            (
                rectangles,
                around.under_eaves.get(&index).cloned(),
                ground::inside(&place.frame, around.inner_ground.get(&index)),
            )
        };
        let (finished, mut counts) = finish(points, ground, &place, &rectangles, self.options);
        let Finished { points, ground, coverage, covered } = finished;
        let roof_height = roof_height::stated(&place.about, &place.frame, &ground, self.options);
        let local = |points: Vec<[f64; 3]>| points.into_iter().map(Point3::from).collect();
        let eaves = place.roofprint.as_ref().map(|outline| {
            let mut points = eaves.unwrap_or_default();
            points.sort_unstable_by(lexicographic);
            points.dedup();
            Eaves { outline: outline.clone(), points: local(points) }
        });
        let Footprint { id, attributes, mut notes, .. } = place.about.clone();
        let site = Site {
            id,
            frame: place.frame,
            footprint: Some(place.polygon.clone()),
            points,
            ground_points: local(inner),
            ground,
            ground_line: local(line),
            coverage,
            covered,
            eaves,
            attributes: attributes.to_map(),
            edits: Vec::new(),
            record: Record { roof_height, ..Record::default() },
        };
        let guess = ground::guess(&site).filter(|_| self.meaning.is_outline());
        notes.extend(self.stated.notes.get(&index).cloned());
        if counts.dropped.dense > 0 {
            notes.push(dense::note(counts.dropped.dense, used - duplicate - counts.dropped.dense));
        }
        counts.dropped.duplicate = duplicate;
        lock(&self.totals).see(index, used, &counts, !site.points.is_empty(), guess.is_some());
        // Of an object more is known once its planes are found.
        notes.extend(guess);
        self.done(index);
        (site, notes)
    }

    /// Nobody asks any more for what was kept for a footprint.
    fn done(&self, index: usize) {
        let mut around = self.around.write().unwrap_or_else(PoisonError::into_inner);
        around.under_eaves.remove(&index);
        around.inner_ground.remove(&index);
    }

    /// What is told at the end.
    ///
    /// # Errors
    /// The building classes do not occur.
    pub fn finish(self) -> Result<Swept> {
        let totals = self.totals.into_inner().unwrap_or_else(PoisonError::into_inner);
        let tiles: Vec<&Tile> = self.tiles.iter().map(|reach| reach.tile).collect();
        if self.meaning != Meaning::OutlinesOfShare {
            refuse::without_buildings(&tiles, &totals.counts, &self.roles, self.options)?;
        }
        Ok(totals.told(self.stated.warnings, self.all.len(), self.meaning, self.options))
    }
}
