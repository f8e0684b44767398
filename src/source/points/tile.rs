//! A tile: what its header says.

use super::block::{Block, Records};
use super::claims;
use super::cloud::{self, Cloud};
use super::header::{self, Layout};
use super::parcels::Parcels;
use super::placement::Placement;
use super::spill::{RECORD, Spill};
use crate::error::Result;
use crate::source::crs::Crs;
use crate::source::open::Place;
use las::{Transform, Vector};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// No coordinate of any CRS of the Earth, in any of its units, is larger.
pub(super) const LARGEST: f64 = 1e9;
/// No height on the Earth, in any of its units, is larger.
pub(super) const HIGHEST: f64 = 1e5;
/// How far outside the header's extent a point may lie before it is taken for damage, CRS units. Headers that are a
/// little wrong are common; a coordinate from damaged data is off by hundreds of kilometres.
const LEEWAY: f64 = 1000.0;

/// An axis-aligned box in CRS units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Smallest coordinates.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
}

impl Extent {
    /// The box of nothing; [`Self::grow`] makes it one.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Takes `point` in.
    pub fn grow(&mut self, point: [f64; 3]) {
        for (bound, value) in self.min.iter_mut().zip(point) {
            *bound = bound.min(value);
        }
        for (bound, value) in self.max.iter_mut().zip(point) {
            *bound = bound.max(value);
        }
    }

    /// Takes another box in.
    pub fn join(&mut self, other: &Self) {
        self.grow(other.min);
        self.grow(other.max);
    }

    /// Whether it is the box of nothing.
    pub fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }
}

/// Where the records of a tile stand.
#[derive(Debug, Clone)]
pub(super) enum Origin {
    /// In a LAS file.
    Las(Place),
    /// In a temporary file.
    Spill(Spill),
    /// In a file of another kind.
    Cloud(Cloud, Place),
    /// Nowhere that is to be looked at.
    Elsewhere,
}

/// A LAS, LAZ or COPC file whose header has been read and checked; a PLY or text file that has been looked through; or
/// points that came without a file (see [`SpillWriter`](super::SpillWriter)).
#[derive(Debug, Clone)]
pub struct Tile {
    /// The file; the name of points that came without one.
    pub path: PathBuf,
    /// Its header with the variable length records; a blank one where it is no LAS file.
    pub header: las::Header,
    /// Its CRS, when it carries one.
    pub crs: Option<Crs>,
    /// What is wrong with the CRS that it carries, when it cannot be understood.
    pub crs_fault: Option<String>,
    /// Extent stated by the header; `None` when the tile is empty, or the statement cannot be true or does not hold the
    /// points, as far as a few of them tell.
    pub extent: Option<Extent>,
    /// The same as it is stated, whether or not a few points are in it; `None` when it cannot be true.
    pub stated_extent: Option<Extent>,
    /// Number of points stated by the header.
    pub points: u64,
    /// Points that stand in the file beyond those, at least; nobody reads them.
    pub unannounced: u64,
    /// LAS version, such as `1.4`; of other files how they are written.
    pub version: String,
    /// Point format, 0 to 10; 0 where it is no LAS file.
    pub point_format: u8,
    /// Whether it is a cloud-optimised point cloud, whose octree can be queried.
    pub is_copc: bool,
    /// Whether it says to which class points belong.
    pub has_classes: bool,
    /// The areas that were scanned, where they are known otherwise than by the extent of the points; `None` where that is
    /// all that is known.
    pub covered: Option<Vec<Extent>>,
    /// The ids that [`ScanPoint::building`](super::ScanPoint::building) refers to; empty for files.
    pub buildings: Arc<[String]>,
    pub(super) layout: Layout,
    pub(super) origin: Origin,
    pub(super) placement: Placement,
    pub(super) parcels: Option<Arc<Parcels>>,
    /// The extent in the coordinates of the file.
    pub(super) raw_extent: Option<Extent>,
}

impl Tile {
    /// Opens the tile at `path`: reads and checks the header, no point. PLY and text are read once from beginning to end, for
    /// they do not say where their points lie.
    ///
    /// # Errors
    /// The file cannot be read, or its header cannot be true; the message says what was found where. A CRS that cannot
    /// be understood is no error: it stands in [`Self::crs_fault`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        if let Some(opened) = Cloud::open(path)? {
            return Ok(Self::of_cloud(path, opened));
        }
        let (place, size) = Place::of(path, cloud::WANTED)?;
        let mut file = BufReader::new(place.open()?);
        let read = header::read(path, &mut file, size);
        place.verdict()?;
        let (header, layout) = read?;
        let (chunks, surplus) = claims::chunks(&mut file, &layout, layout.compression.as_ref());
        let stated_extent = stated_extent(&header, layout.points);
        let extent = stated_extent
            .filter(|extent| claims::is_plausible(&mut file, &layout, header.transforms(), extent, &chunks));
        // What could not be fetched of an object is not missing in it.
        place.verdict()?;
        let unannounced = claims::unannounced(&layout, layout.data_end, surplus);
        let (crs, crs_fault) = match Crs::from_header(&header) {
            Ok(crs) => (crs, None),
            Err(fault) => (None, Some(fault)),
        };
        Ok(Self {
            path: path.to_path_buf(),
            crs,
            crs_fault,
            extent,
            stated_extent,
            points: layout.points,
            unannounced,
            version: format!("1.{}", layout.version_minor),
            point_format: layout.point_format,
            is_copc: header.copc_info_vlr().is_some() && header.evlrs().iter().any(las::Vlr::is_copc_hierarchy),
            has_classes: true,
            header,
            covered: None,
            buildings: Arc::default(),
            layout,
            origin: Origin::Las(place),
            placement: Placement::default(),
            parcels: None,
            raw_extent: extent,
        })
    }

    /// A tile of which no more is to be known than where its points lie: nothing is opened and nothing is ever read of it.
    pub fn elsewhere(path: &Path, points: u64, extent: Option<Extent>) -> Self {
        let blank = Self::without_records(path, Origin::Elsewhere, points, 0);
        Self { extent, stated_extent: extent, raw_extent: extent, has_classes: true, ..blank }
    }

    /// Whether nothing is ever read of it.
    pub fn is_elsewhere(&self) -> bool {
        matches!(self.origin, Origin::Elsewhere)
    }

    fn of_cloud(path: &Path, opened: cloud::Opened) -> Self {
        let cloud::Opened { cloud, place, points, extent, size } = opened;
        let extent = (!extent.is_empty()).then_some(extent);
        let (version, has_classes) = (cloud.describe(), cloud.has_classes());
        let blank = Self::without_records(path, Origin::Cloud(cloud, place), points, size);
        Self { extent, raw_extent: extent, version, has_classes, ..blank }
    }

    /// A tile without LAS records, of which nothing else is known.
    fn without_records(path: &Path, origin: Origin, points: u64, size: u64) -> Self {
        let layout = Layout {
            version_minor: 0,
            point_format: 0,
            data_start: 0,
            data_end: None,
            file_size: size,
            points,
            record_len: RECORD,
            compression: None,
        };
        Self {
            path: path.to_path_buf(),
            header: las::Header::default(),
            crs: None,
            crs_fault: None,
            extent: None,
            stated_extent: None,
            points,
            unannounced: 0,
            version: String::new(),
            point_format: 0,
            is_copc: false,
            has_classes: false,
            covered: None,
            buildings: Arc::default(),
            layout,
            origin,
            placement: Placement::default(),
            parcels: None,
            raw_extent: None,
        }
    }

    /// The same tile with its coordinates brought to metres and its heights to z. What that does to a CRS that it names is
    /// for the caller to know.
    #[must_use]
    pub fn placed(self, placement: Placement) -> Self {
        let turned = |extent: Extent| {
            let mut turned = Extent::EMPTY;
            turned.grow(placement.apply(extent.min));
            turned.grow(placement.apply(extent.max));
            turned
        };
        Self {
            extent: self.raw_extent.map(turned),
            stated_extent: self.stated_extent.map(turned),
            covered: self.covered.map(|areas| areas.into_iter().map(turned).collect()),
            placement,
            ..self
        }
    }

    /// The same tile with points that name no building naming the one whose parcel they lie in, as a place in `buildings`.
    #[must_use]
    pub fn with_parcels(self, buildings: Arc<[String]>, parcels: Arc<Parcels>) -> Self {
        Self { buildings, parcels: Some(parcels), ..self }
    }

    /// What kind of file it is.
    pub fn kind(&self) -> &'static str {
        match (&self.origin, self.is_copc, &self.layout.compression) {
            (Origin::Las(_), true, _) => "COPC",
            (Origin::Las(_), false, Some(_)) => "LAZ",
            (Origin::Las(_), false, None) => "LAS",
            (Origin::Spill(_), ..) => "points",
            (Origin::Cloud(cloud, _), ..) => cloud.kind(),
            (Origin::Elsewhere, ..) => "elsewhere",
        }
    }

    /// Whether it is a LAS, LAZ or COPC file, with the records of one.
    pub fn is_las(&self) -> bool {
        matches!(self.origin, Origin::Las(_))
    }

    /// The areas that were scanned: [`Self::covered`], or the extent.
    pub fn areas(&self) -> &[Extent] {
        match &self.covered {
            Some(areas) => areas,
            None => self.extent.as_slice(),
        }
    }

    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// An empty block for records of this tile.
    pub(super) fn block(&self) -> Block {
        if !self.is_las() {
            return Block::new(self.layout.record_len, Records::Spilled(self.placement), self.parcels.clone());
        }
        let transforms = *self.header.transforms();
        let axes = [transforms.x, transforms.y, transforms.z];
        let plausible = std::array::from_fn(|axis| {
            let (low, high) = self.raw_extent.map_or((-LARGEST, LARGEST), |extent| {
                let leeway = LEEWAY.max(extent.max[axis] - extent.min[axis]);
                (extent.min[axis] - leeway, extent.max[axis] + leeway)
            });
            let most = if axis == 2 && self.placement.is_identity() { HIGHEST } else { LARGEST };
            stored_range(axes[axis], low.max(-most), high.min(most))
        });
        let extended = self.header.point_format().is_extended;
        let placement = self.placement;
        Block::new(
            self.layout.record_len,
            Records::Las { extended, transforms, plausible, placement },
            self.parcels.clone(),
        )
    }
}

/// The stored integers whose coordinates lie between `low` and `high`; a cast from float to integer saturates.
fn stored_range(transform: Transform, low: f64, high: f64) -> (i32, i32) {
    let (a, b) = ((low - transform.offset) / transform.scale, (high - transform.offset) / transform.scale);
    (a.min(b).floor() as i32, a.max(b).ceil() as i32)
}

fn stated_extent(header: &las::Header, points: u64) -> Option<Extent> {
    let array = |v: Vector<f64>| [v.x, v.y, v.z];
    let bounds = header.bounds();
    let extent = Extent { min: array(bounds.min), max: array(bounds.max) };
    let is_real = (0..3).all(|axis| {
        let (low, high) = (extent.min[axis], extent.max[axis]);
        low.is_finite() && high.is_finite() && low <= high && low.abs() <= LARGEST && high.abs() <= LARGEST
    });
    let is_blank = extent.min == [0.0; 3] && extent.max == [0.0; 3];
    (points > 0 && is_real && !is_blank).then_some(extent)
}
