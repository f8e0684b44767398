//! The file of edits while it is being edited.

use std::path::{Path, PathBuf};

use crate::edits::{Edited, Edits, State};
use crate::error::{Error, Result};
use crate::run::{edits_crs, edits_of_file};
use crate::sink::write_json;
use crate::source::crs::Crs;

/// The file of edits of a model, as it was when it was last read or written.
#[derive(Debug)]
pub struct Book {
    path: PathBuf,
    crs: Crs,
    known: Edits,
}

/// Why a change was not written down.
#[derive(Debug)]
pub enum Unwritten {
    /// Another program has changed the same building in the file.
    Overtaken,
    /// The file cannot be read or written.
    Failed(Error),
}

impl Book {
    /// Reads the file of edits of a model in `crs`; where there is none as yet, nothing is decided.
    ///
    /// # Errors
    /// It cannot be read, is no file of edits, or is in another CRS.
    pub fn open(path: &Path, crs: &Crs) -> Result<Self> {
        Ok(Self { path: path.to_path_buf(), crs: crs.clone(), known: on_disk(path, crs)? })
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is decided about a building.
    pub fn of(&self, id: &str) -> Edited {
        let open = || Edited { state: State::Open, edits: Vec::new() };
        self.known.buildings.get(id).cloned().unwrap_or_else(open)
    }

    /// How far a person has come with a building, and how many edits it has.
    pub fn state(&self, id: &str) -> (State, usize) {
        self.known.buildings.get(id).map_or((State::Open, 0), |edited| (edited.state, edited.edits.len()))
    }

    /// The ids of all buildings in it.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.known.buildings.keys().map(String::as_str)
    }

    /// Writes down what is decided about a building. What other programs have written about others is kept.
    ///
    /// # Errors
    /// Another program has changed this building: then its version is what is known. Or the file cannot be read or written.
    pub fn decide(&mut self, id: &str, edited: Edited) -> Result<(), Unwritten> {
        let mut all = on_disk(&self.path, &self.crs).map_err(Unwritten::Failed)?;
        if all.buildings.get(id) != self.known.buildings.get(id) {
            self.known = all;
            return Err(Unwritten::Overtaken);
        }
        all.crs.get_or_insert_with(|| edits_crs(&self.crs));
        if edited.state == State::Open && edited.edits.is_empty() {
            all.buildings.remove(id);
        } else {
            all.buildings.insert(id.to_owned(), edited);
        }
        write_json(&self.path, &all).map_err(Unwritten::Failed)?;
        self.known = all;
        Ok(())
    }
}

fn on_disk(path: &Path, crs: &Crs) -> Result<Edits> {
    match path.try_exists() {
        Ok(false) => Ok(Edits::default()),
        _ => edits_of_file(path, crs),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edits::{Action, Edit};

    #[test]
    fn what_others_write_is_kept_and_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("edits.json");
        let crs = Crs::parse("EPSG:7415").unwrap();
        let [mut one, mut other] = [(); 2].map(|()| Book::open(&path, &crs).unwrap());
        let floor = |height| Edited { state: State::Edited, edits: vec![Edit::from(Action::SetFloor { height })] };
        one.decide("a", floor(1.0)).unwrap();
        other.decide("b", floor(2.0)).unwrap();
        one.decide("a", floor(3.0)).unwrap();
        let both = Book::open(&path, &crs).unwrap();
        assert_eq!((both.of("a"), both.of("b")), (floor(3.0), floor(2.0)));
        // The other knows an older version of this building.
        assert!(matches!(other.decide("a", floor(4.0)), Err(Unwritten::Overtaken)));
        assert_eq!(other.of("a"), floor(3.0));
        other.decide("a", floor(4.0)).unwrap();
        // What is open and has no edit needs no place in the file.
        other.decide("a", Edited { state: State::Open, edits: Vec::new() }).unwrap();
        let left = Book::open(&path, &crs).unwrap();
        assert_eq!(left.ids().collect::<Vec<_>>(), ["b"]);
        assert_eq!(left.state("a"), (State::Open, 0));
        assert!(std::fs::read_to_string(&path).unwrap().contains("EPSG:7415"));
        std::fs::write(&path, "{").unwrap();
        assert!(matches!(one.decide("a", floor(5.0)), Err(Unwritten::Failed(_))));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "{");
    }
}
