//! Recordings on object storage: found by their names, read there by ranges, and never kept here.

use crate::input::error::InvalidPath;
use crate::input::recording::is_partial;
use kinetoscope_object_storage::Store;
use kinetoscope_object_storage::address::Address;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The finished recordings below an address, folder by folder, in the order of their names.
pub(crate) type Folders = BTreeMap<PathBuf, Vec<PathBuf>>;

/// Opens the place of an address, `s3://BUCKET/PREFIX`.
///
/// # Errors
/// An address that makes no sense, or a program that was built without object storage.
pub(crate) fn open(path: &Path) -> Result<Arc<Store>, InvalidPath> {
    let address = Address::parse(&path.to_string_lossy())?;
    Ok(Arc::new(Store::open(&address)?))
}

/// Finds the recordings below the place.
///
/// # Errors
/// A store that does not answer.
pub(crate) fn folders(store: &Store) -> Result<Folders, InvalidPath> {
    let place = PathBuf::from(store.address().to_string());
    let mut folders = Folders::new();
    for object in store.objects()? {
        let path = place.join(&object.name);
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.ends_with(".mcap")
            && !is_partial(name)
            && let Some(folder) = path.parent()
        {
            folders.entry(folder.to_owned()).or_default().push(path);
        }
    }
    Ok(folders)
}
