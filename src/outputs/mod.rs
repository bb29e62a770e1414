//! Files next to the recordings, and the upload of recordings to object storage.

pub mod sidecars;
pub mod upload;
