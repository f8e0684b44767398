//! A model that goes to several files, one after the other.

use std::path::{Path, PathBuf};

use super::template::Files;
use crate::error::{Error, Result};
use crate::sink::{self, Feature, Format, Metadata, Sink, Written};
use crate::source::objects;

/// Writes each feature to its file. One file is open at a time; each appears under its name when it is whole.
pub(super) struct ManyFiles<'a> {
    files: &'a Files,
    /// The head of each file.
    heads: Vec<Metadata>,
    /// Where files stand that have no name yet.
    scratch: PathBuf,
    overwrite: bool,
    open: Option<(usize, Box<dyn Sink>)>,
    whole: Written,
    /// Takes the name of each file that is whole.
    done: &'a mut Vec<PathBuf>,
}

impl<'a> ManyFiles<'a> {
    /// Nothing is written yet; `heads` are those of the files in their order. `done` gets the names of files that are whole.
    pub(super) fn new(
        files: &'a Files,
        heads: Vec<Metadata>,
        scratch: &Path,
        overwrite: bool,
        done: &'a mut Vec<PathBuf>,
    ) -> Self {
        let format = files.paths.first().and_then(|path| Format::of(path).ok());
        let whole = Written { path: PathBuf::new(), format, features: 0, objects: 0, bytes: 0, notes: Vec::new() };
        Self { files, heads, scratch: scratch.to_path_buf(), overwrite, open: None, whole, done }
    }

    /// Opens a file, and the folder that it is in.
    fn create(&self, file: usize) -> Result<Box<dyn Sink>> {
        let path = self.files.paths.get(file).map_or(self.whole.path.as_path(), PathBuf::as_path);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        // Objects have no folders.
        if let Some(folder) = folder.filter(|_| !objects::is_object(path)) {
            std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
        }
        let head = self.heads.get(file).cloned().unwrap_or_default();
        sink::create_in(Some(&self.scratch), path, head, self.overwrite)
    }

    fn close(&mut self) -> Result<()> {
        let Some((_, sink)) = self.open.take() else { return Ok(()) };
        let Written { path, features, objects, bytes, notes, .. } = sink.finish()?;
        self.whole.features += features;
        self.whole.objects += objects;
        self.whole.bytes += bytes;
        for note in notes {
            let note = format!("{}: {note}", path.display());
            self.whole.notes.push(note);
        }
        self.done.push(path);
        Ok(())
    }
}

impl Sink for ManyFiles<'_> {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        let file = self.files.of_building.get(&feature.id).copied().unwrap_or_default();
        if self.open.as_ref().is_some_and(|(open, _)| *open != file) {
            self.close()?;
        }
        if self.open.is_none() {
            self.open = Some((file, self.create(file)?));
        }
        self.open.as_mut().map_or(Ok(()), |(_, sink)| sink.write(feature))
    }

    fn finish(mut self: Box<Self>) -> Result<Written> {
        self.close()?;
        Ok(self.whole)
    }
}
