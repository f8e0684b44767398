//! Footprints that wait for their points: many of them, so they lie in a file once they are more than memory is for.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Mutex, PoisonError};

use geo::MultiPolygon;
use serde::{Deserialize, Serialize};
use tempfile::SpooledTempFile;

use crate::error::{Error, Result};
use crate::guard::lock;
use crate::source::footprints::{Attributes, Footprint, Rings, polygons, rings};

/// From so many bytes on they lie in a temporary file without a name.
const IN_MEMORY: usize = 1 << 20;

/// Footprints in their order.
#[derive(Debug)]
pub(super) struct Shelf {
    file: Mutex<SpooledTempFile>,
    /// Where each begins, and where the last one ends.
    starts: Vec<u64>,
    /// What first went wrong with the file.
    fault: Mutex<Option<io::Error>>,
}

/// A footprint as it is kept: its numbers come back to the last bit.
#[derive(Serialize, Deserialize)]
struct Kept {
    id: String,
    polygon: Rings,
    roofprint: Option<Rings>,
    attributes: Attributes,
    notes: Vec<String>,
}

impl Shelf {
    /// Puts footprints there.
    ///
    /// # Errors
    /// The temporary file cannot be written.
    pub(super) fn new(footprints: Vec<Footprint>) -> Result<Self> {
        let mut shelf = Self {
            file: Mutex::new(SpooledTempFile::new(IN_MEMORY)),
            starts: Vec::with_capacity(footprints.len() + 1),
            fault: Mutex::new(None),
        };
        let put = || -> io::Result<()> {
            let file = shelf.file.get_mut().unwrap_or_else(PoisonError::into_inner);
            let (mut end, mut bytes) = (0, Vec::new());
            for footprint in footprints {
                shelf.starts.push(end);
                bytes.clear();
                serde_json::to_writer(&mut bytes, &Kept::from(footprint))?;
                file.write_all(&bytes)?;
                end += bytes.len() as u64;
            }
            shelf.starts.push(end);
            Ok(())
        };
        put().map_err(fault)?;
        Ok(shelf)
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// One of them. Where it cannot be read it is one of nothing, and [`Self::check`] tells.
    pub(super) fn get(&self, index: usize) -> Footprint {
        self.read(index).map_or_else(
            |error| {
                lock(&self.fault).get_or_insert(error);
                Footprint {
                    id: String::new(),
                    polygon: MultiPolygon(Vec::new()),
                    roofprint: None,
                    attributes: Attributes::default(),
                    notes: Vec::new(),
                }
            },
            Footprint::from,
        )
    }

    /// Whether all that was asked for could be read.
    ///
    /// # Errors
    /// Why not.
    pub(super) fn check(&self) -> Result<()> {
        lock(&self.fault).take().map_or(Ok(()), |error| Err(fault(error)))
    }

    fn read(&self, index: usize) -> io::Result<Kept> {
        let &[start, end] = self.starts.get(index..index + 2).and_then(|ends| ends.try_into().ok()).unwrap_or(&[0, 0]);
        let mut file = lock(&self.file);
        file.seek(SeekFrom::Start(start))?;
        let mut bytes = vec![0; (end - start) as usize];
        file.read_exact(&mut bytes)?;
        drop(file);
        Ok(serde_json::from_slice(&bytes)?)
    }
}

fn fault(error: io::Error) -> Error {
    Error::io(std::env::temp_dir(), "use a temporary file in", error)
}

impl From<Footprint> for Kept {
    fn from(footprint: Footprint) -> Self {
        let Footprint { id, polygon, roofprint, attributes, notes } = footprint;
        Self { id, polygon: rings(&polygon), roofprint: roofprint.as_ref().map(rings), attributes, notes }
    }
}

impl From<Kept> for Footprint {
    fn from(kept: Kept) -> Self {
        let Kept { id, polygon, roofprint, attributes, notes } = kept;
        Self { id, polygon: polygons(polygon), roofprint: roofprint.map(polygons), attributes, notes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn footprints_come_back_to_the_last_bit_from_memory_and_from_a_file() {
        let one = |i: usize| {
            let x = 1e5 / (i as f64 + 3.0);
            let square =
                geo::wkt!(MULTIPOLYGON(((0. 0., 4. 0., 4. 3., 0. 3., 0. 0.),(1. 1., 2. 1., 1. 2., 1. 1.)))).clone();
            let attributes = serde_json::json!({"b": 0.1 + 0.2, "a": "é\n", "long": "x".repeat(i % 7)});
            Footprint {
                id: format!("{i}"),
                polygon: geo::MapCoords::map_coords(&square, |c| geo::coord! { x: c.x + x, y: c.y / 3.0 }),
                roofprint: i.is_multiple_of(2).then(|| square.clone()),
                attributes: attributes.as_object().unwrap().clone().into(),
                notes: vec![format!("note {i}")],
            }
        };
        for count in [0, 1, 7, 30_000] {
            let shelf = Shelf::new((0..count).map(one).collect()).unwrap();
            assert_eq!(shelf.len(), count);
            for i in (0..count).rev().step_by(1 + count / 50) {
                assert_eq!(format!("{:?}", shelf.get(i)), format!("{:?}", one(i)));
            }
            assert!(shelf.check().is_ok());
        }
    }
}
