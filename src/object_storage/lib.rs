//! Finished recordings on object storage: uploaded once, never overwritten unchecked, listed, and read by byte ranges.
//!
//! The package does not depend on the contents of the files, except that it implements the storage from which recordings are
//! read. Without the feature `s3`, every address is rejected with a message that names the feature.

pub mod address;
pub mod error;
mod object;
pub mod ranged_input;

pub use object::{Object, Put, Upload};

#[cfg(feature = "s3")]
mod s3;
#[cfg(feature = "s3")]
pub use s3::Store;

#[cfg(not(feature = "s3"))]
mod absent;
#[cfg(not(feature = "s3"))]
pub use absent::Store;
