//! Kinetoscope: reproducible particle experiments. A model moves, a recording testifies, a law judges.
//!
//! In reading order: what may be random, where a model meets the rest, and the models.

pub mod constants;
pub mod model;
pub mod models;
pub mod placement;
pub mod random;
