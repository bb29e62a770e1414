//! The resources of a run before it is executed: its length, its bytes on the disk, its memory and its time.
//!
//! [`Estimate`] is what `check` prints, what the plan adds up, what the memory budget of parallel runs reserves and what is
//! requested from a cluster. Every constant behind these numbers is in this folder: bytes per particle in [`memory`],
//! bytes per recording and the rates of a slow processor in `estimate`, and the particles from which a smaller run stands in for a
//! large one in [`sample`]. [`time`] measures.

mod estimate;
pub mod memory;
pub mod sample;
#[cfg(not(target_family = "wasm"))]
pub mod time;

#[cfg(not(target_family = "wasm"))]
pub(crate) use estimate::SPEED_OF_SLOW_PROCESSOR;
pub use estimate::{Estimate, nominal_seconds};
