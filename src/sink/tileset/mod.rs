//! 3D Tiles 1.1 (OGC 22-025r4): a folder with `tileset.json` and tiles in binary glTF.
//!
//! Features wait on disk, cut into triangles, until the last one is known. Then a [quadtree](quadtree) over their centres is
//! gone through from the root; each of its leaves is a tile with the blocks of LoD 1, which refines into one with the
//! finest level (`REPLACE`). A cell above the leaves is an overview: it shows the blocks of its largest features, as many as a
//! tile holds, and is as wrong as the largest that it leaves out is large. So there is something to be seen from any height, and
//! never more at once than a screen needs. Tiles are listed, not implicit: cells are as deep as features are dense, their boxes are as
//! tight as their content, and two levels of detail of one cell have no place in an implicit tree. A subtree goes to a
//! file of its own, so that no file grows with the number of features.
//!
//! Coordinates go through PROJ to geocentric ones, vertex by vertex, and from there to the frame of the tileset: east, north
//! and up from its centre, whose place on earth is the transform of the root. A tile's vertices are 32-bit floats from the
//! tile's own centre, a node of the glTF, so that they are exact to a millimetre within kilometres of it.
//!
//! Each vertex has two feature ids: of the [feature](tile::FEATURE_PROPERTIES) (`feature`, the first) and of the
//! [semantic surface](tile::SURFACE_PROPERTIES) (`surface`). Each has a property table; absent values are `noData`.

mod bytes;
mod frame;
mod glb;
mod properties;
mod quadtree;
mod record;
mod tile;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use serde_json::{Value, json};

use super::columns::Columns;
use super::folder::OutputFolder;
use super::header::Metadata;
use super::{Feature, Format, Sink, Written};
use crate::error::{Error, InputError, Result};
use crate::source::crs::{Crs, Geocentric};
use bytes::Take;
use frame::{Bounds, EarthFrame};
use properties::Class;
use quadtree::{Cell, CellWriter, Entry, Overview, Split};
use record::Record;
use tile::{Detail, FEATURE_PROPERTIES, Placer, SURFACE_PROPERTIES, feature_row, giving_way, surface_row};

/// The file that viewers open.
const TILESET: &str = "tileset.json";
/// A cell with at most so many features, in one with more, is a tileset of its own.
const MOST_IN_FILE: u64 = 20_000;
/// The widest side of a cell in metres: so that 32-bit floats from its centre are exact to some millimetres.
const WIDEST: f64 = 50_000.0;
/// The least error of a block in metres, where its top is that of the finest level.
const LEAST_BLOCK_ERROR: f64 = 1.0;

/// Writes a tileset; see the [module](self).
pub(super) struct Tileset {
    folder: OutputFolder,
    crs: Crs,
    spill: BufWriter<File>,
    /// How many bytes are spilled.
    spilled: u64,
    index: CellWriter,
    /// Smallest and largest coordinates of all vertices.
    extent: Option<[[f64; 3]; 2]>,
    feature_columns: Columns,
    surface_columns: Columns,
    features: usize,
    objects: usize,
    /// Features without a face.
    flat: usize,
    /// Children whose attributes are in no table.
    left_out: usize,
    /// The attributes that have the name of a property of gable's and say something else.
    giving_way: BTreeSet<String>,
    buffer: Vec<u8>,
}

impl Tileset {
    /// Opens a sink for the folder `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let Some(crs) = metadata.crs else {
            return Err(InputError::new(path, "a model without a CRS", "one that says where on earth it stands")
                .remedy("Give its CRS with --crs.")
                .into());
        };
        let folder = OutputFolder::create(path, overwrite, scratch, TILESET)?;
        let open = || -> io::Result<(File, CellWriter)> {
            Ok((tempfile::tempfile_in(folder.scratch())?, CellWriter::create(folder.scratch())?))
        };
        let (spill, index) = open().map_err(|e| Error::io(path, "create a spill file for", e))?;
        Ok(Self {
            folder,
            crs,
            spill: BufWriter::with_capacity(1 << 18, spill),
            spilled: 0,
            index,
            extent: None,
            feature_columns: Columns::new(&[]),
            surface_columns: Columns::new(&[]),
            features: 0,
            objects: 0,
            flat: 0,
            left_out: 0,
            giving_way: BTreeSet::new(),
            buffer: Vec::new(),
        })
    }

    fn fault(&self) -> impl Fn(io::Error) -> Error + use<> {
        let path = self.folder.path().to_path_buf();
        move |error| Error::io(&path, "write", error)
    }
}

impl Sink for Tileset {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        let metres = self.crs.metres_per_unit;
        let (record, left_out) = Record::of(feature, metres);
        self.features += 1;
        self.objects += feature.objects.len();
        self.left_out += left_out;
        let (Some([min, max]), true) = (feature.extent(), record.size() > 0) else {
            self.flat += 1;
            return Ok(());
        };
        for level in std::iter::once(&record.fine).chain(&record.block) {
            let row = feature_row(&record, level, metres[2]);
            self.giving_way.extend(giving_way(&row, &record.attributes, &FEATURE_PROPERTIES));
            self.feature_columns.see(&row);
            for surface in &level.surfaces {
                let row = surface_row(&surface.object, &surface.class, &surface.attributes);
                self.giving_way.extend(giving_way(&row, &surface.attributes, &SURFACE_PROPERTIES));
                self.surface_columns.see(&row);
            }
        }
        let [all_min, all_max] = self.extent.unwrap_or([min, max]);
        self.extent =
            Some([std::array::from_fn(|i| min[i].min(all_min[i])), std::array::from_fn(|i| max[i].max(all_max[i]))]);
        self.buffer.clear();
        record.put(&mut self.buffer);
        let entry = Entry {
            at: self.spilled,
            length: self.buffer.len() as u64,
            centre: [0, 1].map(|i| f64::midpoint(min[i], max[i])),
            triangles: record.size() as u64,
            size: (0..3).map(|axis| (max[axis] - min[axis]) * metres[axis]).fold(0.0, f64::max),
        };
        self.spilled += entry.length;
        self.spill.write_all(&self.buffer).and_then(|()| self.index.push(entry)).map_err(self.fault())
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let fault = self.fault();
        let renamed = [self.feature_columns.renamed(&[]), self.surface_columns.renamed(&[])];
        let Self { mut folder, crs, spill, index, extent, features, objects, flat, left_out, giving_way, .. } = *self;
        let path = folder.path().to_path_buf();
        let mut notes: Vec<String> = renamed.into_iter().flatten().collect();
        if !giving_way.is_empty() {
            let names: Vec<String> = giving_way.iter().map(|name| format!("{name:?}")).collect();
            notes.push(format!(
                "attributes {} have the names of properties that 3D Tiles get here: \"attribute_\" stands before theirs",
                names.join(", ")
            ));
        }
        if let Some([min, max]) = extent {
            let geocentric = Geocentric::new(&crs, [min, max])
                .map_err(|why| InputError::new(&path, why, "a CRS from which PROJ finds the way to WGS 84"))?;
            notes.extend(geocentric.warnings().iter().cloned());
            let mut centre = [std::array::from_fn(|i| f64::midpoint(min[i], max[i]))];
            geocentric.transform(&mut centre);
            let frame = EarthFrame::at(centre[0]);
            let spill = spill.into_inner().map_err(io::IntoInnerError::into_error).map_err(&fault)?;
            let mut writer = Writer {
                placer: Placer { geocentric: &geocentric, frame, metres: crs.metres_per_unit[2] },
                feature_class: Class::new("feature", &self.feature_columns),
                surface_class: Class::new("surface", &self.surface_columns),
                folder: &mut folder,
                spill,
                widest: WIDEST / crs.metres_per_unit[0].max(crs.metres_per_unit[1]),
                misplaced: 0,
            };
            let root = index.root([min[0], min[1]], [max[0], max[1]]).map_err(&fault)?;
            let tile = writer.cell(root, true)?;
            if writer.misplaced > 0 {
                notes.push(format!(
                    "{} of {features} features have no place on earth and are in no tile",
                    writer.misplaced
                ));
            }
            folder.write(TILESET, &tileset(tile.as_ref(), Some(frame)).map_err(|e| fault(e.into()))?)?;
        } else {
            folder.write(TILESET, &tileset(None, None).map_err(|e| fault(e.into()))?)?;
        }
        if flat > 0 {
            notes.push(format!("{flat} of {features} features have no face and are in no tile"));
        }
        if left_out > 0 {
            notes.push(format!(
                "the attributes of {left_out} children have no property of their own and are not written"
            ));
        }
        let bytes = folder.commit()?;
        Ok(Written { path, format: Some(Format::Tileset), features, objects, bytes, notes })
    }
}

/// A tile with all below it.
struct Tile {
    bounds: Bounds,
    /// How wrong it is to draw what it shows instead of what is below it, metres.
    error: f64,
    json: Value,
}

impl Tile {
    fn new(bounds: Bounds, error: f64, content: Option<String>, children: Vec<Self>) -> Self {
        let error = (error * 1e3).round() / 1e3;
        let mut json = json!({"boundingVolume": {"box": bounds.to_tiles()}, "geometricError": error});
        if let Some(uri) = content {
            json["content"] = json!({"uri": uri});
        }
        if !children.is_empty() {
            json["refine"] = "REPLACE".into();
            json["children"] = children.into_iter().map(|child| child.json).collect();
        }
        Self { bounds, error, json }
    }
}

/// The text of a tileset with this root; `frame` is where it stands on earth, unless its parent says so.
fn tileset(root: Option<&Tile>, frame: Option<EarthFrame>) -> serde_json::Result<Vec<u8>> {
    // A tileset must have a root, and a root must have a volume.
    let nothing = Tile::new(Bounds::nothing(), 0.0, None, Vec::new());
    let root = root.unwrap_or(&nothing);
    let mut json = root.json.clone();
    json["refine"] = "REPLACE".into();
    let mut error = root.error;
    if let Some(frame) = frame {
        json["transform"] = json!(frame.matrix());
        // Where it is not drawn at all, everything is missing: viewers leave it out from where its error is no longer seen.
        error = error.max(root.bounds.extent());
    }
    let mut text = serde_json::to_vec(&json!({
        "asset": {"version": "1.1", "generator": concat!("gable ", env!("CARGO_PKG_VERSION"))},
        "geometricError": error,
        "root": json,
    }))?;
    text.push(b'\n');
    Ok(text)
}

/// Writes the tiles of cells.
struct Writer<'a> {
    placer: Placer<'a>,
    feature_class: Class,
    surface_class: Class,
    folder: &'a mut OutputFolder,
    spill: File,
    /// [`WIDEST`] in units of the CRS.
    widest: f64,
    misplaced: usize,
}

impl Writer<'_> {
    fn fault(&self, error: io::Error) -> Error {
        Error::io(self.folder.path(), "write", error)
    }

    /// The tile of a cell with all below it; `None` where nothing of it has a place. The root is never a file of its own.
    fn cell(&mut self, cell: Cell, is_root: bool) -> Result<Option<Tile>> {
        let (name, count) = (cell.name().to_owned(), cell.count());
        let split = cell.split(self.folder.scratch(), self.widest).map_err(|e| self.fault(e))?;
        let (cells, overview) = match split {
            Split::Leaf(entries) => {
                let leaf = self.leaf(&name, &entries)?;
                // The root holds the transform and refines into what it is.
                return Ok(leaf.map(|tile| if is_root { Self::above(vec![tile]) } else { tile }));
            }
            Split::Cells(cells, overview) => (cells, overview),
        };
        let mut children = Vec::new();
        for child in cells {
            let is_file = count > MOST_IN_FILE && child.count() <= MOST_IN_FILE;
            let file = format!("tileset-{}.json", child.name());
            let Some(tile) = self.cell(child, false)? else { continue };
            children.push(if is_file {
                let text = tileset(Some(&tile), None).map_err(|e| self.fault(e.into()))?;
                self.folder.write(&file, &text)?;
                Tile::new(tile.bounds, tile.error, Some(file), Vec::new())
            } else {
                tile
            });
        }
        if children.is_empty() {
            return Ok(None);
        }
        self.overview(&name, &overview, children).map(Some)
    }

    /// A tile without content: not to refine it leaves out all that it holds.
    fn above(children: Vec<Tile>) -> Tile {
        let bounds = children.iter().map(|child| child.bounds).reduce(Bounds::union).unwrap_or_else(Bounds::nothing);
        // Never less than that of what is below it.
        let error = children.iter().map(|child| child.error).fold(bounds.diagonal(), f64::max);
        Tile::new(bounds, error, None, children)
    }

    /// The tile of a cell above the leaves: its largest features, as blocks.
    fn overview(&mut self, name: &str, overview: &Overview, children: Vec<Tile>) -> Result<Tile> {
        let mut records = self.records(&overview.entries)?;
        self.placer.place(&mut records);
        let content = self.content(&records, Detail::Block, &format!("tiles/{name}_overview.glb"))?;
        let Some((own, uri)) = content else { return Ok(Self::above(children)) };
        // A box holds those of its children, and none of these is more wrong than it.
        let bounds = children.iter().map(|child| child.bounds).fold(own, Bounds::union);
        let error = children.iter().map(|child| child.error).fold(overview.omitted, f64::max);
        Ok(Tile::new(bounds, error.max(LEAST_BLOCK_ERROR), Some(uri), children))
    }

    /// Features as they wait on disk.
    fn records(&mut self, entries: &[Entry]) -> Result<Vec<Record>> {
        let mut records = Vec::with_capacity(entries.len());
        for entry in entries {
            let mut bytes = vec![0; entry.length as usize];
            let read = self.spill.seek(SeekFrom::Start(entry.at)).and_then(|_| self.spill.read_exact(&mut bytes));
            read.map_err(|e| self.fault(e))?;
            records.extend(Record::take(&mut Take(&bytes)));
        }
        Ok(records)
    }

    /// The tile of the features of a leaf.
    fn leaf(&mut self, name: &str, entries: &[Entry]) -> Result<Option<Tile>> {
        let mut records = self.records(entries)?;
        self.misplaced += self.placer.place(&mut records);
        let error = records.iter().map(|record| record.block_error(self.placer.metres)).fold(0.0, f64::max);
        let has_blocks = records.iter().any(|record| record.block.is_some());
        let Some((bounds, uri)) = self.content(&records, Detail::Fine, &format!("tiles/{name}_fine.glb"))? else {
            return Ok(None);
        };
        let fine = Tile::new(bounds, 0.0, Some(uri), Vec::new());
        if !has_blocks {
            return Ok(Some(fine));
        }
        let block = self.content(&records, Detail::Block, &format!("tiles/{name}_block.glb"))?;
        // A box holds those of its children.
        Ok(Some(match block {
            Some((own, uri)) => Tile::new(own.union(bounds), error.max(LEAST_BLOCK_ERROR), Some(uri), vec![fine]),
            None => fine,
        }))
    }

    /// Writes the content of a tile; its bounds and its name.
    fn content(&mut self, records: &[Record], detail: Detail, name: &str) -> Result<Option<(Bounds, String)>> {
        let Some((content, bounds)) = self.placer.content(records, detail) else { return Ok(None) };
        let glb = content.to_glb(&self.feature_class, &self.surface_class).map_err(|e| self.fault(e.into()))?;
        self.folder.write(name, &glb)?;
        Ok(Some((bounds, name.to_owned())))
    }
}
