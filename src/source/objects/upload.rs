//! Writing objects: they appear when they are whole.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use object_store::path::Path as Key;
use object_store::{Error as StoreError, ObjectStoreExt, PutPayload, WriteMultipart};

use super::client::{self, Store};
use super::fault;
use super::listing::list;
use crate::error::{Error, Result};

/// Bytes of a part, at least; the smallest that S3 takes, so that one goes through slow lines in time.
const PART: u64 = 5 << 20;
/// No more parts than S3 takes.
const MOST_PARTS: u64 = 9_000;
/// Parts that are under way at the same time.
const AT_ONCE: usize = 3;

/// Why an object was not written.
enum Fault {
    Store(StoreError),
    Read(std::io::Error),
}

/// Writes the local file `from` to the object `to`, in the place of one that is there. An upload that fails leaves nothing
/// behind, no parts either.
///
/// # Errors
/// The file cannot be read, or the object not written.
pub(crate) fn put(from: &Path, to: &Path) -> Result<()> {
    let (store, key) = client::of(to)?;
    let file = File::open(from).map_err(|e| Error::io(to, "read what was written for", e))?;
    let size = file.metadata().map_err(|e| Error::io(to, "read what was written for", e))?.len();
    client::wait(async move { upload(&store, &key, file, size).await })?.map_err(|fault| match fault {
        Fault::Store(error) => fault::of(to, &error, "a place that can be written to").into(),
        Fault::Read(error) => Error::io(to, "read what was written for", error),
    })
}

/// Writes the files below the local folder `from` to objects below `to`, the file `mark` last, with which the others count; then
/// removes what an earlier folder of that name had beside them.
///
/// # Errors
/// As [`put`], or what is there cannot be listed.
pub(crate) fn put_folder(from: &Path, to: &Path, mark: &str) -> Result<()> {
    let mut names = Vec::new();
    walk(from, Path::new(""), &mut names).map_err(|e| Error::io(to, "read what was written for", e))?;
    names.sort_by_key(|name| (name == Path::new(mark), name.clone()));
    let folder = to.to_string_lossy();
    let object = |name: &Path| {
        let parts: Vec<_> = name.components().map(|part| part.as_os_str().to_string_lossy()).collect();
        PathBuf::from(format!("{}/{}", folder.trim_end_matches('/'), parts.join("/")))
    };
    let written: BTreeSet<PathBuf> = names.iter().map(|name| object(name)).collect();
    for name in &names {
        put(&from.join(name), &object(name))?;
    }
    for old in list(to, true)?.into_iter().filter(|old| !written.contains(old)) {
        let (store, key) = client::of(&old)?;
        let removed = client::wait(async move { store.delete(&key).await })?;
        removed.map_err(|error| fault::of(&old, &error, "an object that can be removed"))?;
    }
    Ok(())
}

/// The files below a folder, by their names in it.
fn walk(root: &Path, within: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(root.join(within))? {
        let entry = entry?;
        let name = within.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            walk(root, &name, found)?;
        } else {
            found.push(name);
        }
    }
    Ok(())
}

async fn upload(store: &Store, key: &Key, mut file: File, size: u64) -> Result<(), Fault> {
    if size <= PART {
        let mut bytes = Vec::with_capacity(size as usize);
        file.read_to_end(&mut bytes).map_err(Fault::Read)?;
        return store.put(key, PutPayload::from(bytes)).await.map(drop).map_err(Fault::Store);
    }
    let part = PART.max(size.div_ceil(MOST_PARTS));
    let begun = store.put_multipart(key).await.map_err(Fault::Store)?;
    let mut upload = WriteMultipart::new_with_chunk_size(begun, part as usize);
    loop {
        let mut bytes = Vec::new();
        let fault = match file.by_ref().take(part).read_to_end(&mut bytes) {
            Ok(0) => break,
            Ok(_) => match upload.wait_for_capacity(AT_ONCE).await {
                Ok(()) => {
                    upload.put(bytes.into());
                    continue;
                }
                Err(error) => Fault::Store(error),
            },
            Err(error) => Fault::Read(error),
        };
        // What is left of it costs its owner money for as long as nobody removes it.
        let _ = upload.abort().await;
        return Err(fault);
    }
    upload.finish().await.map(drop).map_err(Fault::Store)
}
