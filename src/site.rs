//! The unit of work: all that is known of one building.

use geo::orient::{Direction, Orient};
use geo::{BoundingRect, MultiPolygon};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::edits::Edit;
use crate::geometry::Aabb;
use crate::record::Record;

/// The step of the output grid in units of the CRS (metres or feet): coordinates are written as multiples of it.
pub const QUANTUM: f64 = 1e-4;

/// The local frame of a building: metres, axes parallel to those of the CRS, origin near the building.
///
/// The origin is a whole number of CRS units that depends on the footprint alone, so that neither tiling nor
/// neighbours change a single bit of the result.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Origin in CRS coordinates; whole numbers.
    pub origin: [f64; 3],
    /// Metres per CRS unit, along x, y and z.
    pub metres_per_unit: [f64; 3],
}

impl Frame {
    /// The frame with its origin at the whole CRS units at or below `place` (CRS coordinates).
    pub fn near(place: [f64; 3], metres_per_unit: [f64; 3]) -> Self {
        Self { origin: place.map(f64::floor), metres_per_unit }
    }

    /// CRS coordinates to local metres.
    pub fn to_local(&self, crs: [f64; 3]) -> Point3<f64> {
        Point3::from(std::array::from_fn(|i| (crs[i] - self.origin[i]) * self.metres_per_unit[i]))
    }

    /// Local metres to CRS coordinates.
    pub fn to_crs(&self, local: &Point3<f64>) -> [f64; 3] {
        std::array::from_fn(|i| self.origin[i] + local[i] / self.metres_per_unit[i])
    }

    /// Size of one step of the output grid in metres, along x, y and z.
    pub fn step(&self) -> [f64; 3] {
        self.metres_per_unit.map(|m| m * QUANTUM)
    }

    /// The grid point nearest to a local point.
    pub fn to_grid(&self, local: &Point3<f64>) -> [i64; 3] {
        let step = self.step();
        std::array::from_fn(|i| (local[i] / step[i]).round() as i64)
    }

    /// A grid point in local metres.
    pub fn from_grid(&self, grid: [i64; 3]) -> Point3<f64> {
        let step = self.step();
        Point3::from(std::array::from_fn(|i| grid[i] as f64 * step[i]))
    }
}

/// Where the ground height of a site comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GroundSource {
    /// An attribute of the footprint that the user named.
    Attribute,
    /// A terrain model that the user gave.
    TerrainModel,
    /// Ground-class points in a ring around the footprint.
    GroundPoints,
    /// The floors of neighbours, for want of ground points.
    Neighbours,
    /// The lowest points around the building and on its walls, for want of ground points.
    LowestPoints,
    /// The floor itself, which was scanned.
    ScannedFloor,
    /// The bottom face of the axis-aligned bounding box, for want of all these.
    BoundingBox,
    /// A person who edited the building.
    Edit,
}

/// The ground around a building.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Robust local ground height, metres in the local frame.
    pub height: f64,
    /// Spread of the ground heights around it (interquartile range), metres.
    pub spread: f64,
    /// Where it comes from.
    pub source: GroundSource,
}

/// How far the given tiles cover a footprint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Share of the footprint's area inside the extent of some tile, 0 to 1.
    pub share: f64,
}

impl Coverage {
    /// Whether the footprint lies wholly inside the given tiles (1 ‰ of its area may be missing).
    pub fn is_complete(&self) -> bool {
        self.share >= 0.999
    }
}

/// All that is known of one building.
#[derive(Debug, Clone)]
pub struct Site {
    /// The building's id as text, exactly as in the footprint file (made unique where it was not).
    pub id: String,
    /// The local frame of everything below.
    pub frame: Frame,
    /// Footprint in local metres, valid by the simple-feature rules, exteriors counter-clockwise; z is dropped.
    /// `None` for a single object without a footprint.
    pub footprint: Option<MultiPolygon<f64>>,
    /// Building points in local metres, sorted by x, y, z and without exact duplicates.
    pub points: Vec<Point3<f64>>,
    /// Ground points inside the footprint in local metres, sorted by x, y, z and without exact duplicates: where nothing
    /// stands above them, the ground is open. Thinned to one of each half metre; empty without a footprint.
    pub ground_points: Vec<Point3<f64>>,
    /// The ground around the building.
    pub ground: Ground,
    /// The ground along the outline of the footprint: places on it, in local metres, with the height of the ground there;
    /// only where ground was seen nearby, so there may be none.
    pub ground_line: Vec<Point3<f64>>,
    /// How far the tiles cover the footprint.
    pub coverage: Coverage,
    /// The part of the footprint that the tiles cover, where that is not all of it; local metres.
    pub covered: Option<MultiPolygon<f64>>,
    /// The roof beyond the footprint, where its outline is known.
    pub eaves: Option<Eaves>,
    /// The footprint's attributes, passed through to the model.
    pub attributes: Map<String, Value>,
    /// What is known of it otherwise.
    pub record: Record,
    /// What a person has decided about it, in the order in which it was decided; coordinates are those of the CRS.
    pub edits: Vec<Edit>,
}

/// The roof of a building beyond its footprint.
#[derive(Debug, Clone, PartialEq)]
pub struct Eaves {
    /// The outline of the roof in local metres, valid by the simple-feature rules; over no footprint but its own.
    pub outline: MultiPolygon<f64>,
    /// Building points in it and in no footprint, in local metres, sorted by x, y, z and without exact duplicates.
    pub points: Vec<Point3<f64>>,
}

impl Site {
    /// Smallest and largest x and y, local metres: of its footprint, else of its points; `None` where it has neither.
    pub fn extent(&self) -> Option<[[f64; 2]; 2]> {
        let rect = self.footprint.as_ref().and_then(BoundingRect::bounding_rect);
        let of_points = || Aabb::of(&self.points).map(|b| [[b.min[0], b.min[1]], [b.max[0], b.max[1]]]);
        rect.map(|rect| [rect.min(), rect.max()].map(|corner| [corner.x, corner.y])).or_else(of_points)
    }

    /// A single object without a footprint: its points in local metres, sorted here and without those that are repeated,
    /// on ground of a known height in the local frame. Only its fields say more.
    pub fn new(id: impl Into<String>, frame: Frame, mut points: Vec<Point3<f64>>, ground: f64) -> Self {
        points.sort_unstable_by(|a, b| {
            a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
        });
        points.dedup();
        Self {
            id: id.into(),
            frame,
            footprint: None,
            points,
            ground_points: Vec::new(),
            ground: Ground { height: ground, spread: 0.0, source: GroundSource::GroundPoints },
            ground_line: Vec::new(),
            coverage: Coverage { share: 1.0 },
            covered: None,
            eaves: None,
            attributes: Map::new(),
            record: Record::default(),
            edits: Vec::new(),
        }
    }

    /// The same with a footprint, valid by the simple-feature rules, in local metres.
    #[must_use]
    pub fn with_footprint(self, footprint: &MultiPolygon<f64>) -> Self {
        Self { footprint: Some(footprint.orient(Direction::Default)), ..self }
    }
}
