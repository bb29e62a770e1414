//! Files on the disk: opened without waiting, of bounded size, replaced as a whole, and written where the user asks.
//!
//! Invariant: every file that any package reads is opened by [`regular_file`], and the folder of a file is found by
//! [`folder::folder_of`] alone, so that a bare name means the same everywhere.

pub mod atomic_file;
pub mod folder;
pub mod output_file;
pub mod regular_file;
