//! What a run that was killed leaves behind, and how the next one goes on from there.
//!
//! While a run writes `OUT`, the folder `OUT.partial` beside it holds the files that have no name yet and the
//! checkpoint: a head that says which run it belongs to, then one line per building in the order in which they got
//! done. Every line carries a checksum, so that one that was cut off is known. The folder goes when the model and its
//! report are whole. A process that is killed leaves the folder, and its lock on the checkpoint dies with it.
//!
//! What is kept is the building as the method returned it, not a piece of a file: a resumed run writes it as if it had
//! just been made, and so the same bytes in every format.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::identity::Identity;
use super::records::{Lines, Records, line, scan};
use crate::error::{Error, InputError, Result};
use crate::source::objects;

/// The checkpoint's name in its folder.
const FILE: &str = "buildings.jsonl";

/// The folder `OUT.partial` of a run, locked.
#[derive(Debug)]
pub(super) struct Checkpoint {
    folder: PathBuf,
    records: Records,
}

/// The folder of the checkpoint of `model`: beside the file itself where `model` is a link, so that the finished file
/// can be renamed; of an object in the folder that the run was started in.
pub(super) fn folder_of(model: &Path) -> PathBuf {
    if objects::is_object(model) {
        let mut name: OsString = model.file_name().unwrap_or_else(|| "model".as_ref()).to_owned();
        name.push(".partial");
        return PathBuf::from(name);
    }
    let target = fs::canonicalize(model).unwrap_or_else(|_| model.to_path_buf());
    let mut name: OsString = target.into_os_string();
    name.push(".partial");
    PathBuf::from(name)
}

/// How many buildings a killed run has left for `model`; `None` when there is no checkpoint.
///
/// # Errors
/// A run that is alive writes to it, or it cannot be read.
pub(super) fn left_over(model: &Path) -> Result<Option<usize>> {
    let folder = folder_of(model);
    let path = folder.join(FILE);
    let file = match File::open(&path) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(folder.is_dir().then_some(0)),
        Err(e) => return Err(Error::io(path, "open", e)),
    };
    lock(&file, &folder)?;
    let lines = scan(&file).map_err(|e| Error::io(path, "read", e))?;
    Ok(Some(lines.found.len()))
}

/// Whether nothing but the folder is left of the checkpoint of `model`: its run was killed as it had begun, or as it ended
/// and the model stood already.
pub(super) fn is_bare(model: &Path) -> bool {
    let folder = folder_of(model);
    folder.is_dir() && !folder.join(FILE).exists()
}

impl Checkpoint {
    /// Makes the checkpoint of `model`; with `resume`, takes over what is there.
    ///
    /// # Errors
    /// Another run writes to it; what is there comes from other inputs or parameters; or the system refuses.
    pub(super) fn open(model: &Path, identity: &Identity, resume: bool) -> Result<Self> {
        let folder = folder_of(model);
        fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, "create", e))?;
        let path = folder.join(FILE);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(|e| Error::io(&path, "create", e))?;
        lock(&file, &folder)?;
        clear(&folder).map_err(|e| Error::io(&folder, "clear", e))?;

        let mut lines = Lines::default();
        if resume {
            lines = scan(&file).map_err(|e| Error::io(&path, "read", e))?;
            match &lines.head {
                Some(head) if !lines.found.is_empty() => identity.check(head, &folder)?,
                _ => lines = Lines::default(),
            }
        }
        // What was being written when the run ended is cut off; the next line begins where it began.
        let begin = |file: &mut File| -> io::Result<()> {
            file.set_len(lines.end)?;
            file.seek(SeekFrom::End(0))?;
            if lines.end == 0 {
                file.write_all(&line(identity)?)?;
            }
            Ok(())
        };
        begin(&mut file).map_err(|e| Error::io(&path, "write", e))?;
        Ok(Self { folder, records: Records::new(file, path, lines.found) })
    }

    /// Where files may stand that have no name yet.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The buildings that were found, and those that are kept.
    pub(super) fn records(&self) -> &Records {
        &self.records
    }

    /// Removes it: the model is whole.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn remove(self) -> Result<()> {
        let Self { folder, records } = self;
        // Not every system removes a file that is open.
        drop(records);
        match fs::remove_dir_all(&folder) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(Error::io(&folder, "remove", e)),
            _ => Ok(()),
        }
    }
}

/// Locks the checkpoint for this process; the system unlocks it however the process ends.
fn lock(file: &File, folder: &Path) -> Result<()> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            let fault = InputError::new(folder, "another run that is writing this model", "one run at a time");
            Err(fault.remedy("Wait until it has ended, or give another output").into())
        }
        // A file system without locks: two runs at a time are then the user's care.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(e)) => Err(Error::io(folder, "lock", e)),
    }
}

/// Removes what a killed run was writing beside the checkpoint.
fn clear(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "part") {
            if path.is_dir() { fs::remove_dir_all(path)? } else { fs::remove_file(path)? }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use serde_json::json;

    use super::*;
    use crate::building::{Building, Measures, Outcome};
    use crate::run::records::Record;
    use crate::site::Frame;
    use crate::solid::Model;

    fn building(id: &str) -> Building {
        Building {
            id: id.to_owned(),
            frame: Frame { origin: [0.1 + 0.2, 1e-300, -0.0], metres_per_unit: [1.0, 1.0, 1200.0 / 3937.0] },
            attributes: serde_json::Map::new(),
            model: Model::default(),
            outcome: Outcome::Lod22,
            record: crate::record::Record::default(),
            measures: Measures { rmse_lod22: Some(0.1 + 0.7), ..Measures::default() },
            notes: vec!["é\n".to_owned()],
        }
    }

    fn identity() -> Identity {
        Identity::new(json!({"lambda": 0.1}))
    }

    fn keep(checkpoint: &Checkpoint, index: usize) {
        let building = building(&index.to_string());
        let (wall, cpu, inputs) = (Duration::from_millis(3), None, u64::MAX);
        checkpoint.records().keep(&Record { index, inputs, wall, cpu, building: &building }).unwrap();
    }

    #[test]
    fn what_was_kept_comes_back_bit_for_bit_and_a_line_that_was_cut_off_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("a.city.json");
        let checkpoint = Checkpoint::open(&model, &identity(), true).unwrap();
        keep(&checkpoint, 3);
        keep(&checkpoint, 0);
        keep(&checkpoint, 5);
        drop(checkpoint);
        let path = folder.path().join("a.city.json.partial").join(FILE);
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() - 9]).unwrap();
        fs::write(path.with_file_name(".gable-1.part"), "half").unwrap();
        assert_eq!(left_over(&model).unwrap(), Some(2));

        let checkpoint = Checkpoint::open(&model, &identity(), true).unwrap();
        assert!(!path.with_file_name(".gable-1.part").exists());
        assert_eq!(checkpoint.records().len(), 2);
        assert!(checkpoint.records().has(3) && checkpoint.records().has(0) && !checkpoint.records().has(5));
        let back = checkpoint.records().recall(3).unwrap();
        assert_eq!(format!("{:?}", back.building), format!("{:?}", building("3")));
        assert_eq!((back.inputs, back.wall, back.cpu), (u64::MAX, Duration::from_millis(3), None));
        keep(&checkpoint, 5);
        drop(checkpoint);
        assert!(fs::read(&path).unwrap() == whole, "the line that was cut off was written again in its place");
        Checkpoint::open(&model, &identity(), true).unwrap().remove().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn the_checkpoint_of_another_run_is_refused_with_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("a.city.json");
        let checkpoint = Checkpoint::open(&model, &identity(), false).unwrap();
        keep(&checkpoint, 1);
        let message = Checkpoint::open(&model, &identity(), true).unwrap_err().to_string();
        assert!(message.contains("another run that is writing"), "{message}");
        drop(checkpoint);
        let other = Identity::new(json!({"lambda": 0.2}));
        let message = Checkpoint::open(&model, &other, true).unwrap_err().to_string();
        assert!(message.contains("lambda 0.1") && message.contains("lambda 0.2"), "{message}");
        assert_eq!(
            Checkpoint::open(&model, &identity(), false).unwrap().records().len(),
            0,
            "without --resume it is made anew"
        );
    }
}
