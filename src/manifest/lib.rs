//! The manifest of an experiment: what to run, and what must hold afterwards.
//!
//! Past this package every value is in range by its type.

pub mod model;
pub mod quantity;
pub mod record;
