//! Files on the disk: opened without waiting, of bounded size, replaced as a whole, and written where the user asks; and the places of the
//! connections of a server, which are limited for the same reason.
//!
//! Invariant: every file that any package reads is opened by [`regular_file`], and the folder of a file is found by
//! [`folder::folder_of`] alone, so that a bare name means the same everywhere.

pub mod atomic_file;
pub mod connection_slots;
pub mod folder;
pub mod output_file;
pub mod regular_file;
