//! Points that arrive in chunks instead of in files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::error::{InputError, Result};
use crate::source::crs::Crs;
use crate::source::points::{Extent, ScanPoint, SpillWriter, Tile};

/// Takes points in chunks, for a [`Job`](super::Job) that has no files to read: from another program, from a stage of a
/// pipeline, from memory.
///
/// Points are written to a nameless temporary file as they come, to the last bit, so memory stays flat and nothing stays
/// behind. [`Self::finish`] gives what [`Job::fed`](super::Job::fed) takes. A run on the points of a file that were pushed
/// gives the same model as a run on the file.
///
/// ```
/// use gable::run::Feed;
/// use gable::source::points::ScanPoint;
///
/// let mut feed = Feed::new("roofs")?;
/// feed.push([ScanPoint::new([85_000.0, 447_000.0, 12.5], 6)])?;
/// assert_eq!(feed.points(), 1);
/// let fed = feed.finish(Some("EPSG:7415"))?;
/// # assert_eq!(fed.points(), 1);
/// # Ok::<(), gable::error::Error>(())
/// ```
#[derive(Debug)]
pub struct Feed {
    writer: SpillWriter,
    covered: Vec<Extent>,
    buildings: Vec<String>,
    places: HashMap<String, u32>,
}

impl Feed {
    /// Opens a feed whose points wait in the system's temporary folder; `name` is what messages and reports call them.
    ///
    /// # Errors
    /// That folder cannot be written to.
    pub fn new(name: impl Into<PathBuf>) -> Result<Self> {
        Self::new_in(&std::env::temp_dir(), name)
    }

    /// The same with the points waiting in `folder`, 32 bytes each.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn new_in(folder: &Path, name: impl Into<PathBuf>) -> Result<Self> {
        let writer = SpillWriter::create(folder, name)?;
        Ok(Self { writer, covered: Vec::new(), buildings: Vec::new(), places: HashMap::new() })
    }

    /// The place of the building `id` in the table of this feed, for [`ScanPoint::building`]: points that name a building
    /// are given to the footprint of that id wherever they lie, and without footprints each building that is named is
    /// reconstructed on its own.
    pub fn building(&mut self, id: &str) -> u32 {
        if let Some(&place) = self.places.get(id) {
            return place;
        }
        let place = self.buildings.len() as u32;
        self.buildings.push(id.to_owned());
        self.places.insert(id.to_owned(), place);
        place
    }

    /// Takes a chunk of points. Their order among the chunks does not matter.
    ///
    /// # Errors
    /// A coordinate that is not a finite number, a building that is not of this feed, or a temporary folder that cannot be
    /// written to. The points before the one at fault are taken.
    pub fn push(&mut self, points: impl IntoIterator<Item = ScanPoint>) -> Result<()> {
        for point in points {
            if let Some(place) = point.building.filter(|place| *place as usize >= self.buildings.len()) {
                let expected = format!("a place that Feed::building gave, below {}", self.buildings.len());
                let place = format!("the building {place}");
                return Err(InputError::new(self.writer.name(), place, expected)
                    .at(format!("point {}", self.points()))
                    .into());
            }
            self.writer.push(&point)?;
        }
        Ok(())
    }

    /// Says that `area` was scanned, although points of it may have been left out: footprints in it are not taken to be
    /// incomplete. Without any the extent of the points is taken for what was scanned.
    ///
    /// # Errors
    /// The area is empty or not finite.
    pub fn cover(&mut self, area: Extent) -> Result<()> {
        let is_real = (0..2).all(|axis| {
            let (low, high) = (area.min[axis], area.max[axis]);
            low.is_finite() && high.is_finite() && low <= high
        });
        if !is_real {
            let ([x0, y0, _], [x1, y1, _]) = (area.min, area.max);
            let found = format!("the covered area x {x0} to {x1}, y {y0} to {y1}");
            let expected = "finite numbers, the smaller one first";
            return Err(InputError::new(self.writer.name(), found, expected).into());
        }
        self.covered.push(area);
        Ok(())
    }

    /// Number of points until now.
    pub fn points(&self) -> u64 {
        self.writer.points()
    }

    /// Ends the feed; `crs` is the CRS of the points: anything that [`Crs::parse`] takes. Without one
    /// [`Job::crs`](super::Job::crs) or another tile must name it.
    ///
    /// # Errors
    /// The CRS cannot be understood, or the temporary folder cannot be written to.
    pub fn finish(self, crs: Option<&str>) -> Result<Fed> {
        let crs = crs.map(Crs::parse).transpose()?;
        let (name, points) = (self.writer.name().to_path_buf(), self.points());
        let tiles = self.writer.finish(crs.as_ref(), self.covered, self.buildings)?;
        Ok(Fed { name, points, tiles })
    }
}

/// Points that have arrived; see [`Feed`]. Copies share them, and any number of runs may read them.
#[derive(Debug, Clone)]
pub struct Fed {
    name: PathBuf,
    points: u64,
    tiles: Vec<Tile>,
}

impl Fed {
    /// What messages and reports call the points.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// How many there are.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// The tiles that hold them.
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }
}
