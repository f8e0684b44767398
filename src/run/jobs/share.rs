//! The footprints of a job: its own, those beside them, and features without a usable polygon, as a file.
//!
//! Coordinates are in the CRS of the tiles and come back bit for bit. Neither the file of the footprints nor a database is
//! needed any more.

use serde::{Deserialize, Serialize};

use crate::run::records::checksum;
use crate::source::footprints::{Attributes, Footprint, Rejected, Rings, polygons, rings};

/// A line of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum ShareLine {
    /// A footprint.
    Footprint {
        /// Its place in the model; absent where it stands beside those of the job.
        place: Option<usize>,
        /// The tile in whose extent it lies, for names of files.
        tile: usize,
        id: String,
        polygon: Rings,
        roofprint: Option<Rings>,
        attributes: Attributes,
        notes: Vec<String>,
    },
    /// A feature without a usable polygon.
    Rejected {
        /// Its place in the model.
        place: usize,
        /// Its number in the file, from 0.
        index: usize,
        id: String,
        attributes: Attributes,
        reason: String,
    },
}

/// The footprints of a job.
#[derive(Debug, Default)]
pub(super) struct Share {
    /// Its own and those beside them, in the order of their file.
    pub(super) footprints: Vec<Footprint>,
    /// Which of them are its own.
    pub(super) is_wanted: Vec<bool>,
    pub(super) rejected: Vec<Rejected>,
    /// The places in the model of all that it writes: of its own footprints, then of the features without a usable polygon.
    pub(super) places: Vec<usize>,
    /// The tiles of these, for names of files.
    pub(super) tiles: Vec<usize>,
}

impl Share {
    /// The ids of all that it writes, in the order of [`Self::places`].
    pub(super) fn ids(&self) -> impl Iterator<Item = &str> {
        let wanted = self.footprints.iter().zip(&self.is_wanted).filter(|(_, is_wanted)| **is_wanted);
        wanted.map(|(footprint, _)| footprint.id.as_str()).chain(self.rejected.iter().map(|r| r.id.as_str()))
    }
}

impl ShareLine {
    /// A footprint with its place in the model, if it is one of the job's own.
    pub(super) fn footprint(footprint: &Footprint, place: Option<usize>, tile: usize) -> Self {
        let Footprint { id, polygon, roofprint, attributes, notes } = footprint;
        Self::Footprint {
            place,
            tile,
            id: id.clone(),
            polygon: rings(polygon),
            roofprint: roofprint.as_ref().map(rings),
            attributes: attributes.clone(),
            notes: notes.clone(),
        }
    }

    /// A feature without a usable polygon.
    pub(super) fn rejected(feature: &Rejected, place: usize) -> Self {
        let Rejected { index, id, attributes, reason } = feature.clone();
        Self::Rejected { place, index, id, attributes, reason }
    }
}

/// The bytes of the file and their checksum.
///
/// # Errors
/// What is no JSON.
pub(super) fn encoded(lines: impl Iterator<Item = ShareLine>) -> serde_json::Result<(Vec<u8>, String)> {
    let mut bytes = Vec::new();
    for line in lines {
        serde_json::to_writer(&mut bytes, &line)?;
        bytes.push(b'\n');
    }
    let checksum = format!("{:016x}", checksum(&bytes));
    Ok((bytes, checksum))
}

/// What the bytes of a file hold; `None` when they are not those of this checksum.
pub(super) fn decoded(bytes: &[u8], expected: &str) -> Option<Share> {
    if format!("{:016x}", checksum(bytes)) != expected {
        return None;
    }
    let (mut share, mut last) = (Share::default(), Vec::new());
    for line in bytes.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
        match serde_json::from_slice(line).ok()? {
            ShareLine::Footprint { place, tile, id, polygon, roofprint, attributes, notes } => {
                let (polygon, roofprint) = (polygons(polygon), roofprint.map(polygons));
                share.footprints.push(Footprint { id, polygon, roofprint, attributes, notes });
                share.is_wanted.push(place.is_some());
                share.places.extend(place);
                share.tiles.extend(place.map(|_| tile));
            }
            ShareLine::Rejected { place, index, id, attributes, reason } => {
                share.rejected.push(Rejected { index, id, attributes, reason });
                last.push(place);
            }
        }
    }
    // What has no polygon belongs to the first tile.
    share.tiles.resize(share.places.len() + last.len(), 0);
    share.places.append(&mut last);
    Some(share)
}

#[cfg(test)]
mod tests {
    use serde_json::{Map, Value};

    use super::*;

    #[test]
    fn footprints_come_back_bit_for_bit_and_damage_is_seen() {
        let with_hole = geo::wkt!(MULTIPOLYGON(((0. 0., 9.1 0., 9. 9., 0. 0.), (2. 1., 3. 1., 3. 2., 2. 1.))));
        let mut polygon = with_hole;
        polygon.0[0].exterior_mut(|ring| ring.0[1].x = 0.1 + 0.2);
        let house = Footprint {
            id: "é\n".to_owned(),
            roofprint: Some(polygon.clone()),
            polygon: polygon.clone(),
            attributes: Map::from_iter([("a".to_owned(), Value::from(0.1 + 0.7))]).into(),
            notes: vec!["a note".to_owned()],
        };
        let line = Rejected {
            index: 7,
            id: "line".to_owned(),
            attributes: Attributes::default(),
            reason: "a line".to_owned(),
        };
        let lines = [
            ShareLine::footprint(&house, Some(4), 2),
            ShareLine::footprint(&house, None, 3),
            ShareLine::rejected(&line, 9),
        ];
        let (bytes, checksum) = encoded(lines.into_iter()).unwrap();
        let share = decoded(&bytes, &checksum).unwrap();
        assert_eq!((share.places.as_slice(), share.tiles.as_slice()), (&[4, 9][..], &[2, 0][..]));
        assert_eq!(share.is_wanted, [true, false]);
        assert_eq!(share.rejected, [line]);
        assert_eq!(share.footprints[1].polygon, polygon);
        assert_eq!(format!("{:?}", share.footprints[0]), format!("{house:?}"));
        assert_eq!(share.ids().collect::<Vec<_>>(), ["é\n", "line"]);
        assert!(decoded(&bytes[1..], &checksum).is_none());
    }
}
