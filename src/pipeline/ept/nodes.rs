//! The points of nodes: `ept-data/`.

use std::io::Read;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use super::{Encoding, Ept, Field, Key};
use crate::error::{Error, InputError, Result};
use crate::pipeline::las::Record;
use crate::pipeline::points::{Column, Layout, NumberType, Points, usual_name};
use crate::source::open;
use crate::source::points::Tile;

/// What is said of a file that is none.
const WANTED: &str = "the points of an EPT node";
/// The flags of points, by the bits of the dimension `ClassFlags`.
const FLAGS: [&str; 4] = ["Synthetic", "KeyPoint", "Withheld", "Overlap"];

impl Ept {
    /// The dimensions of the points.
    ///
    /// # Errors
    /// Two fields that mean the same dimension.
    pub fn layout(&self) -> Result<Layout, InputError> {
        let mut layout = Layout::default();
        let mut places: Vec<usize> = Vec::new();
        for field in self.fields.iter().filter(|field| !field.is_flags()) {
            let place = layout.add(usual_name(&field.name), field.usual());
            if places.contains(&place) {
                let found = format!("`{}` for {}, which has one already", field.name, layout.names()[place]);
                return Err(InputError::new(self.root.join("ept.json"), found, "each dimension once").at("schema"));
            }
            places.push(place);
        }
        // Of LAZ the schema cannot tell single bits.
        if self.encoding == Encoding::Laszip || self.fields.iter().any(Field::is_flags) {
            for flag in FLAGS {
                layout.add(flag, NumberType::U8);
            }
        }
        Ok(layout)
    }

    /// The file of a node.
    pub fn path(&self, key: Key) -> PathBuf {
        let extension = match self.encoding {
            Encoding::Laszip => "laz",
            Encoding::Binary => "bin",
        };
        self.root.join("ept-data").join(format!("{key}.{extension}"))
    }

    /// The points of a node that should hold `count`, in the layout of [`Self::layout`]: hands them to `next`, and gives how
    /// many there were.
    ///
    /// # Errors
    /// The file cannot be read or is not what it should be, or what `next` says.
    pub fn read(
        &self,
        key: Key,
        count: u64,
        layout: &Arc<Layout>,
        next: &mut dyn FnMut(Points) -> Result<()>,
    ) -> Result<u64> {
        match self.encoding {
            Encoding::Laszip => self.read_laszip(key, layout, next),
            Encoding::Binary => self.read_binary(key, count, layout, next),
        }
    }

    fn read_laszip(&self, key: Key, layout: &Arc<Layout>, next: &mut dyn FnMut(Points) -> Result<()>) -> Result<u64> {
        let tile = Tile::open(self.path(key))?;
        if !tile.is_las() {
            return Err(InputError::new(&tile.path, format!("a {} file", tile.kind()), "a LAZ file").into());
        }
        let record = Record::of_header(&tile.header);
        let own = Arc::new(record.layout());
        let (mut given, mut outcome) = (0, Ok(()));
        let reading = tile.stream_records(None, &mut |block| {
            let records: Vec<&[u8]> = block.records().collect();
            let mut points = Points::of_columns(Arc::clone(&own), record.decode(&records), None);
            points.conform(layout);
            given += points.len() as u64;
            outcome = next(points);
            if outcome.is_err() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        outcome?;
        match reading.problems(&tile).first() {
            Some(problem) if reading.read < reading.expected => {
                Err(InputError::new(&tile.path, problem.to_string(), "a whole file").into())
            }
            _ => Ok(given),
        }
    }

    fn read_binary(
        &self,
        key: Key,
        count: u64,
        layout: &Arc<Layout>,
        next: &mut dyn FnMut(Points) -> Result<()>,
    ) -> Result<u64> {
        let path = self.path(key);
        let (mut file, size) = open::regular(&path, WANTED)?;
        let length: usize = self.fields.iter().map(|field| field.kind.size()).sum();
        if Some(size) != count.checked_mul(length as u64) {
            let expected = format!("{count} points of {length} bytes, as the hierarchy and the schema say");
            return Err(InputError::new(&path, format!("{size} bytes"), expected).into());
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|e| Error::io(&path, "read", e))?;
        let mut at = 0;
        let mut own = Layout::default();
        let mut columns: Vec<Column> = own.dimensions().iter().map(|axis| Column::zeros(axis.kind, 0)).collect();
        for field in &self.fields {
            let mut column = Column::zeros(field.kind, 0);
            for record in bytes.chunks_exact(length) {
                column.push_bytes(&record[at..]);
            }
            at += field.kind.size();
            if field.is_flags() {
                for (bit, flag) in FLAGS.into_iter().enumerate() {
                    let is_set = |i: usize| u8::from(column.get(i) as u64 >> bit & 1 == 1);
                    if own.add(flag, NumberType::U8) == columns.len() {
                        columns.push(Column::U8((0..column.len()).map(is_set).collect()));
                    }
                }
                continue;
            }
            if let Some([scale, offset]) = field.scaled {
                column = Column::F64((0..column.len()).map(|i| column.get(i) * scale + offset).collect());
            }
            let place = own.add(usual_name(&field.name), column.kind());
            if place == columns.len() {
                columns.push(column);
            } else {
                // X, Y or Z, which are doubles whatever they are stored as.
                let mut axis = Column::zeros(own.dimensions()[place].kind, 0);
                axis.append(&column);
                columns[place] = axis;
            }
        }
        let mut points = Points::of_columns(Arc::new(own), columns, None);
        points.conform(layout);
        let given = points.len() as u64;
        next(points)?;
        Ok(given)
    }
}
