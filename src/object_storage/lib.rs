//! Finished recordings on object storage: put once and never replaced unseen, found again, and read by ranges.
//!
//! Of what the files hold it knows nothing; of recordings, only what reading one asks of the place where it lies. Built without the
//! feature `s3`, every address is refused with a word on how to build with it.

pub mod address;
pub mod error;
pub mod ranged_input;

#[cfg(feature = "s3")]
mod s3;
#[cfg(feature = "s3")]
pub use s3::Store;

#[cfg(not(feature = "s3"))]
mod absent;
#[cfg(not(feature = "s3"))]
pub use absent::Store;

use std::path::Path;

/// An object: its name below the place that was asked, with slashes, and its size.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Object {
    /// Its name below the place, with slashes.
    pub name: String,
    /// Its size.
    pub bytes: u64,
}

/// What came of putting a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Put {
    /// It is there now.
    Created,
    /// It was there, with the same bytes.
    Same,
    /// Other bytes are there under its name, and were left as they are.
    Differs,
}

/// A file that is put, and whether to stop doing so: it is asked several times a second.
#[derive(Clone, Copy)]
pub struct Upload<'a> {
    /// The file.
    pub file: &'a Path,
    /// Name of the object below the place.
    pub name: &'a str,
    /// Whether to stop.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}
