//! Reruns and comparisons of recordings: `verify`, `compare`, `fill`, `zoom`, and lock files.
//!
//! A `source` is a recording whose run can be executed again, a `rerun` executes it, and [`diff`] compares two recordings message
//! by message.

pub mod compare;
pub mod diff;
pub mod divergence;
pub mod error;
pub mod fill;
pub mod fine_frames;
pub mod fingerprint;
mod keyframe_search;
pub mod lock_file;
pub mod merge;
mod rerun;
mod rerun_check;
pub mod restored_file;
mod source;
mod verification;
pub mod zoom;

pub use verification::{Finding, Verification, verify};
