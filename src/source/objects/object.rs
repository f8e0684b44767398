//! An object that was opened: its size and its version.

use std::fs::File;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use futures_util::TryStreamExt;
use object_store::path::Path as Key;
use object_store::{Error as StoreError, GetOptions, GetRange, ObjectMeta, ObjectStoreExt};

use super::cache::{self, BLOCK};
use super::client::{self, Answer, Store};
use super::fault;
use crate::error::{Error, InputError, Result};

/// Bytes that were read, shared by all who look at them.
pub(super) type Bytes = bytes::Bytes;

/// What is expected of an object, for messages.
const WANTED: &str = "an object that can be read";

/// An object of one version.
#[derive(Debug)]
pub(crate) struct Object {
    path: PathBuf,
    store: Store,
    key: Key,
    version: Version,
    /// What it is called in the cache.
    number: u64,
    /// All of it, where the server gives no ranges.
    whole: Option<Arc<File>>,
    /// What ended all reading of it.
    fault: OnceLock<InputError>,
}

/// What an object is known by while it is read.
#[derive(Debug, Clone, PartialEq)]
struct Version {
    size: u64,
    tag: Option<String>,
    /// When it was written, where it has no tag; seconds.
    written: Option<i64>,
}

impl Version {
    fn of(meta: &ObjectMeta) -> Self {
        let written = meta.e_tag.is_none().then(|| meta.last_modified.timestamp());
        Self { size: meta.size, tag: meta.e_tag.clone(), written }
    }
}

impl Object {
    /// Opens the object at `path`: reads its first block, with which come its size and its version.
    ///
    /// # Errors
    /// It is not there, may not be read, or the server cannot be reached.
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let path = super::label(path);
        let (store, key) = client::of(&path)?;
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let object = |version, whole| {
            Arc::new(Self {
                path: path.clone(),
                store: store.clone(),
                key: key.clone(),
                version,
                number,
                whole,
                fault: OnceLock::new(),
            })
        };
        let first = {
            let (store, key) = (store.clone(), key.clone());
            client::wait(async move { ranged(&store, &key, 0..BLOCK, None).await })?
        };
        match first {
            Ok((meta, block)) => {
                cache::keep((number, 0), block);
                Ok(object(Version::of(&meta), None))
            }
            Err(error) if has_no_ranges(&error) => {
                let (store, key) = (store.clone(), key.clone());
                let got = client::wait(async move { fetch_whole(&store, &key).await })?;
                let (file, version) = got.map_err(|error| match error {
                    Fetch::Store(error) => fault::of(&path, &error, WANTED).into(),
                    Fetch::Write(error) => Error::io(&path, "make a temporary copy of", error),
                })?;
                Ok(object(version, Some(Arc::new(file))))
            }
            Err(error) => Err(fault::of(&path, &error, WANTED).into()),
        }
    }

    /// Its address, without secrets.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its size in bytes.
    pub fn size(&self) -> u64 {
        self.version.size
    }

    /// All of it, where it had to be read at once.
    pub(super) fn whole(&self) -> Option<&Arc<File>> {
        self.whole.as_ref()
    }

    /// What ended all reading of it: whoever takes a fault of reading for damage of a file must ask in the end.
    ///
    /// # Errors
    /// That.
    pub fn verdict(&self) -> Result<(), InputError> {
        self.fault.get().cloned().map_or(Ok(()), Err)
    }

    /// Begins to read a range, which must lie in the object.
    pub(super) fn begin(self: &Arc<Self>, range: Range<u64>) -> Result<Answer<Result<Bytes, InputError>>> {
        let object = self.clone();
        client::begin(async move { object.read(range).await })
    }

    /// A block, from the cache if it is there.
    ///
    /// # Errors
    /// It cannot be read, or the object was changed.
    pub(super) fn block(self: &Arc<Self>, index: u64) -> Result<Bytes> {
        if let Some(block) = cache::get((self.number, index)) {
            return Ok(block);
        }
        let start = index * BLOCK;
        let object = self.clone();
        let read = client::wait(async move { object.read(start..(start + BLOCK).min(object.size())).await })?;
        let block = read?;
        cache::keep((self.number, index), block.clone());
        Ok(block)
    }

    async fn read(&self, range: Range<u64>) -> Result<Bytes, InputError> {
        self.verdict()?;
        let read = ranged(&self.store, &self.key, range, self.version.tag.as_deref()).await;
        let fault = match read {
            Ok((meta, bytes)) if Version::of(&meta) == self.version => return Ok(bytes),
            Ok(_) => InputError::new(&self.path, fault::changed(), "the same object from the first range to the last")
                .remedy("Run again, when nobody writes to it any more"),
            Err(error) => fault::of(&self.path, &error, WANTED),
        };
        Err(self.fault.get_or_init(|| fault).clone())
    }
}

/// Reads a range, of one version if its tag is given. What the library does not try again, a body that is cut off where there
/// is no tag, is tried again here.
async fn ranged(
    store: &Store,
    key: &Key,
    range: Range<u64>,
    tag: Option<&str>,
) -> Result<(ObjectMeta, Bytes), StoreError> {
    let retries = client::retries();
    let mut pause = retries.backoff.init_backoff;
    let mut left = retries.max_retries;
    loop {
        // A weak tag says nothing of single bytes, and servers must not compare it; what comes back is compared here.
        let if_match = tag.filter(|tag| !tag.starts_with("W/")).map(str::to_owned);
        let options = GetOptions { range: Some(GetRange::Bounded(range.clone())), if_match, ..GetOptions::default() };
        let error = match store.get_opts(key, options).await {
            Ok(result) => {
                let (meta, wanted) = (result.meta.clone(), result.range.end - result.range.start);
                match result.bytes().await {
                    Ok(bytes) if bytes.len() as u64 == wanted => return Ok((meta, bytes)),
                    Ok(bytes) => {
                        let told = format!("{} of {wanted} bytes", bytes.len());
                        StoreError::Generic { store: "", source: std::io::Error::other(told).into() }
                    }
                    Err(error) => error,
                }
            }
            // Whatever else was refused has been tried again already.
            Err(error) => return Err(error),
        };
        if left == 0 {
            return Err(error);
        }
        left -= 1;
        tokio::time::sleep(pause).await;
        pause = (pause * 2).min(retries.backoff.max_backoff).max(Duration::from_millis(1));
    }
}

/// Whether a server answered a request for a range with all of the object, or says that there is no such range, as it does of
/// an empty one.
fn has_no_ranges(error: &StoreError) -> bool {
    let text = error.to_string();
    ["non-partial response", "Range request not supported", "status code: 416"].iter().any(|told| text.contains(told))
}

/// Why an object could not be fetched as a whole.
enum Fetch {
    Store(StoreError),
    Write(std::io::Error),
}

/// Fetches all of an object into a temporary file without a name.
async fn fetch_whole(store: &Store, key: &Key) -> Result<(File, Version), Fetch> {
    let retries = client::retries();
    let mut pause = retries.backoff.init_backoff;
    let mut left = retries.max_retries;
    loop {
        let mut file = tempfile::tempfile().map_err(Fetch::Write)?;
        let error = match store.get(key).await {
            Ok(result) => {
                let (version, stated) = (Version::of(&result.meta), result.meta.size);
                let mut stream = result.into_stream();
                let mut got = 0;
                loop {
                    match stream.try_next().await {
                        Ok(Some(bytes)) => {
                            got += bytes.len() as u64;
                            file.write_all(&bytes).map_err(Fetch::Write)?;
                        }
                        // Some servers do not say how long an answer will be.
                        Ok(None) if got == stated || stated == 0 => {
                            return Ok((file, Version { size: got, ..version }));
                        }
                        Ok(None) => {
                            let told = format!("{got} of {stated} bytes");
                            break StoreError::Generic { store: "", source: std::io::Error::other(told).into() };
                        }
                        Err(error) => break error,
                    }
                }
            }
            Err(error) => return Err(Fetch::Store(error)),
        };
        if left == 0 {
            return Err(Fetch::Store(error));
        }
        left -= 1;
        tokio::time::sleep(pause).await;
        pause = (pause * 2).min(retries.backoff.max_backoff);
    }
}
