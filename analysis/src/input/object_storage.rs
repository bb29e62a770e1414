//! Recordings on object storage: listed by name and read there by ranges, without local copies.

use crate::input::error::InvalidPath;
use crate::input::recording::is_partial;
use kinetoscope_files::folder::folder_of;
use kinetoscope_object_storage::Store;
use kinetoscope_object_storage::address::Address;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The finished recordings under an address by folder, in order of their names.
pub(crate) type Folders = BTreeMap<PathBuf, Vec<PathBuf>>;

/// Opens an address, `s3://BUCKET/PREFIX`.
///
/// # Errors
/// An invalid address, or a program that was built without object storage.
pub(crate) fn open(path: &Path) -> Result<Arc<Store>, InvalidPath> {
    let address = Address::parse(&path.to_string_lossy())?;
    Ok(Arc::new(Store::open(&address)?))
}

/// Lists the recordings under an address.
///
/// # Errors
/// A store that does not respond.
pub(crate) fn folders(store: &Store) -> Result<Folders, InvalidPath> {
    let address = PathBuf::from(store.address().to_string());
    let mut folders = Folders::new();
    for object in store.objects()? {
        let path = address.join(&object.name);
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.ends_with(".mcap") && !is_partial(name) {
            folders.entry(folder_of(&path).to_owned()).or_default().push(path);
        }
    }
    Ok(folders)
}
