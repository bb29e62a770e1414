//! The models, each a folder that knows of no other.

pub mod dem;
pub mod gas;
pub mod orbit;
pub mod packing;
