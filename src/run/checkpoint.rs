//! What a run that was killed leaves behind, and how the next one goes on from there.
//!
//! While a run writes `OUT`, the folder `OUT.partial` beside it holds the files that have no name yet and the
//! checkpoint: a head that says which run it belongs to, then one line per building in the order in which they got
//! done. Every line carries a checksum, so that one that was cut off is known. The folder goes when the model and its
//! report are whole. A process that is killed leaves the folder, and its lock on the checkpoint dies with it.
//!
//! What is kept is the building as the method returned it, not a piece of a file: a resumed run writes it as if it had
//! just been made, and so the same bytes in every format.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::identity::Identity;
use crate::building::Building;
use crate::error::{Error, InputError, Result};

/// The checkpoint's name in its folder.
const FILE: &str = "buildings.jsonl";
/// Characters of a checksum and the blank behind it.
const CHECKSUM: usize = 17;

/// A building and what it cost, as a line of the checkpoint.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Record<B> {
    /// Its place in the order of the tasks.
    pub(super) index: usize,
    pub(super) wall: Duration,
    pub(super) cpu: Option<Duration>,
    pub(super) building: B,
}

/// The part of a [`Record`] that is wanted of all lines.
#[derive(Deserialize)]
struct Index {
    index: usize,
}

/// The folder `OUT.partial` of a run, locked.
#[derive(Debug)]
pub(super) struct Checkpoint {
    folder: PathBuf,
    file: Mutex<File>,
    /// First byte and length of the lines that were found, by the index of their building.
    found: BTreeMap<usize, (u64, usize)>,
}

/// The folder of the checkpoint of `model`: beside the file itself where `model` is a link, so that the finished file
/// can be renamed.
pub(super) fn folder_of(model: &Path) -> PathBuf {
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
        Ok(Self { folder, file: Mutex::new(file), found: lines.found })
    }

    /// Where files may stand that have no name yet.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// How many buildings were found.
    pub(super) fn len(&self) -> usize {
        self.found.len()
    }

    /// Whether the building of this index was found.
    pub(super) fn has(&self, index: usize) -> bool {
        self.found.contains_key(&index)
    }

    /// A building that was found; `None` when there is none, or when it can no longer be read: then it is made anew.
    pub(super) fn recall(&self, index: usize) -> Option<Record<Building>> {
        let &(start, length) = self.found.get(&index)?;
        let mut bytes = vec![0; length];
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes)).ok()?;
        drop(file);
        let record: Record<Building> = serde_json::from_slice(content(&bytes)?).ok()?;
        (record.index == index).then_some(record)
    }

    /// Keeps a building that was made. It is safe from the end of this process as soon as this returns.
    ///
    /// # Errors
    /// The system refuses to write.
    pub(super) fn keep(&self, record: &Record<&Building>) -> Result<()> {
        let bytes = line(record).map_err(|e| self.fault(e.into()))?;
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::End(0)).and_then(|_| file.write_all(&bytes)).map_err(|e| self.fault(e))
    }

    /// Removes it: the model is whole.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn remove(self) -> Result<()> {
        let Self { folder, file, .. } = self;
        // Not every system removes a file that is open.
        drop(file);
        match fs::remove_dir_all(&folder) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(Error::io(&folder, "remove", e)),
            _ => Ok(()),
        }
    }

    fn fault(&self, source: io::Error) -> Error {
        Error::io(self.folder.join(FILE), "write", source)
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

/// The lines of a checkpoint that are whole.
#[derive(Debug, Default)]
struct Lines {
    head: Option<Identity>,
    found: BTreeMap<usize, (u64, usize)>,
    /// The end of the last of them.
    end: u64,
}

/// Reads up to the first line that is not whole.
fn scan(file: &File) -> io::Result<Lines> {
    let mut reader = BufReader::with_capacity(1 << 18, file);
    reader.seek(SeekFrom::Start(0))?;
    let mut lines = Lines::default();
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes)?;
        let Some(content) = content(&bytes) else { return Ok(lines) };
        if lines.head.is_none() {
            let Ok(head) = serde_json::from_slice(content) else { return Ok(lines) };
            lines.head = Some(head);
        } else {
            let Ok(Index { index }) = serde_json::from_slice(content) else { return Ok(lines) };
            lines.found.insert(index, (lines.end, length));
        }
        lines.end += length as u64;
    }
}

/// A value as a line: checksum, blank, JSON, line end.
pub(super) fn line(value: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let json = serde_json::to_vec(value)?;
    let mut line = format!("{:016x} ", checksum(&json)).into_bytes();
    line.extend_from_slice(&json);
    line.push(b'\n');
    Ok(line)
}

/// The JSON of a line that is whole.
pub(super) fn content(line: &[u8]) -> Option<&[u8]> {
    let (head, json) = line.strip_suffix(b"\n")?.split_at_checked(CHECKSUM)?;
    (head == format!("{:016x} ", checksum(json)).as_bytes()).then_some(json)
}

pub(super) fn checksum(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::building::{Measures, Outcome};
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

    fn identity(inputs: u64) -> Identity {
        Identity::new(json!({"lambda": 0.1}), inputs)
    }

    fn keep(checkpoint: &Checkpoint, index: usize) {
        let building = building(&index.to_string());
        let record = Record { index, wall: Duration::from_millis(3), cpu: None, building: &building };
        checkpoint.keep(&record).unwrap();
    }

    #[test]
    fn what_was_kept_comes_back_bit_for_bit_and_a_line_that_was_cut_off_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("a.city.json");
        let checkpoint = Checkpoint::open(&model, &identity(7), true).unwrap();
        keep(&checkpoint, 3);
        keep(&checkpoint, 0);
        keep(&checkpoint, 5);
        drop(checkpoint);
        let path = folder.path().join("a.city.json.partial").join(FILE);
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() - 9]).unwrap();
        fs::write(path.with_file_name(".gable-1.part"), "half").unwrap();
        assert_eq!(left_over(&model).unwrap(), Some(2));

        let checkpoint = Checkpoint::open(&model, &identity(7), true).unwrap();
        assert!(!path.with_file_name(".gable-1.part").exists());
        assert_eq!(checkpoint.len(), 2);
        assert!(checkpoint.has(3) && checkpoint.has(0) && !checkpoint.has(5));
        let back = checkpoint.recall(3).unwrap();
        assert_eq!(format!("{:?}", back.building), format!("{:?}", building("3")));
        assert_eq!((back.wall, back.cpu), (Duration::from_millis(3), None));
        keep(&checkpoint, 5);
        drop(checkpoint);
        assert!(fs::read(&path).unwrap() == whole, "the line that was cut off was written again in its place");
        Checkpoint::open(&model, &identity(7), true).unwrap().remove().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn the_checkpoint_of_another_run_is_refused_with_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("a.city.json");
        let checkpoint = Checkpoint::open(&model, &identity(7), false).unwrap();
        keep(&checkpoint, 1);
        let message = Checkpoint::open(&model, &identity(7), true).unwrap_err().to_string();
        assert!(message.contains("another run that is writing"), "{message}");
        drop(checkpoint);
        let message = Checkpoint::open(&model, &identity(8), true).unwrap_err().to_string();
        assert!(message.contains("tiles, footprints") && message.contains("--overwrite"), "{message}");
        let other = Identity::new(json!({"lambda": 0.2}), 7);
        let message = Checkpoint::open(&model, &other, true).unwrap_err().to_string();
        assert!(message.contains("lambda 0.1") && message.contains("lambda 0.2"), "{message}");
        assert_eq!(Checkpoint::open(&model, &identity(8), false).unwrap().len(), 0, "without --resume it is made anew");
    }
}
