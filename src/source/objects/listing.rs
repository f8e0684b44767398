//! Which objects there are.

use std::path::{Path, PathBuf};

use futures_util::TryStreamExt;
use object_store::path::Path as Key;
use object_store::{Error as StoreError, ObjectStoreExt};

use super::address::{Address, is_web};
use super::client;
use super::fault;
use crate::error::{InputError, Result};

/// What is expected of what is listed, for messages.
const WANTED: &str = "a bucket that can be listed";

/// The objects below `folder`, a whole part of keys that ends with a separator: those directly in it, or all; sorted.
///
/// # Errors
/// It may not be listed, or is at a web server, which has no lists.
pub(crate) fn list(folder: &Path, is_deep: bool) -> Result<Vec<PathBuf>> {
    if is_web(folder) {
        let fault = InputError::new(folder, "a folder or a pattern at a web server", "the name of a file there");
        return Err(fault
            .remedy("Web servers do not say what they have: name the files, or an index of them (STAC, tile index)")
            .into());
    }
    let (store, key) = client::of(folder)?;
    let prefix = (!key.is_root()).then_some(key);
    let listed = client::wait(async move {
        let objects = if is_deep {
            store.list(prefix.as_ref()).try_collect().await?
        } else {
            store.list_with_delimiter(prefix.as_ref()).await?.objects
        };
        Ok(objects.into_iter().map(|object: object_store::ObjectMeta| object.location).collect::<Vec<Key>>())
    })?;
    let keys = listed.map_err(|error: StoreError| fault::of(folder, &error, WANTED))?;
    let Some(root) = root(folder) else { return Ok(Vec::new()) };
    let mut found: Vec<PathBuf> = keys.into_iter().map(|key| PathBuf::from(format!("{root}{key}"))).collect();
    found.sort();
    Ok(found)
}

/// Whether there is an object, or any below that name.
///
/// # Errors
/// Nobody can say.
pub(crate) fn exists(path: &Path) -> Result<bool> {
    let (store, key) = client::of(path)?;
    let asked = client::wait(async move {
        match store.head(&key).await {
            Err(StoreError::NotFound { .. }) => Ok(store.list(Some(&key)).try_next().await?.is_some()),
            other => other.map(|_| true),
        }
    })?;
    Ok(asked.map_err(|error| fault::of(path, &error, "a place that can be written to"))?)
}

/// Scheme and bucket of an address, with the separator behind them.
fn root(path: &Path) -> Option<String> {
    let text = path.to_str()?;
    let address = Address::of(path)?;
    let scheme = &text[..text.find("://")? + "://".len()];
    Some(format!("{scheme}{}/", address.container))
}
