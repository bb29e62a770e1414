//! The engine of report pages that the program carries.

/// The module as gzip; empty in a program that was built without the feature `engine`.
#[cfg(feature = "engine")]
pub(crate) const ENGINE: &[u8] = include_bytes!(env!("KINETOSCOPE_ENGINE"));
#[cfg(not(feature = "engine"))]
pub(crate) const ENGINE: &[u8] = &[];
