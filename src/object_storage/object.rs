//! Objects on object storage, and the upload of a file as an object.

use std::path::Path;

/// An object below an address.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Object {
    /// Name relative to the address, with slashes.
    pub name: String,
    /// Size of the object.
    pub bytes: u64,
}

/// Result of an upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Put {
    /// The object was created.
    Created,
    /// The object existed with the same bytes.
    Same,
    /// An object with other bytes has this name; it was not changed.
    Differs,
}

/// A file to upload.
#[derive(Clone, Copy)]
pub struct Upload<'a> {
    /// The file.
    pub file: &'a Path,
    /// Name of the object relative to the address.
    pub name: &'a str,
    /// Returns whether to stop; called several times per second.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}
