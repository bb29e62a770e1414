//! One run: build the model, advance it from frame to frame, record, and end in order on an interruption or a failure.
//!
//! Without threads and files (`wasm32`), a run is recorded in memory; what needs more is absent there.

#[cfg(not(target_family = "wasm"))]
pub mod benchmark;
#[cfg(not(target_family = "wasm"))]
pub mod checkpoint;
mod frame_loop;
pub mod in_memory;
#[cfg(not(target_family = "wasm"))]
mod on_disk;
pub mod prepared;
#[cfg(not(target_family = "wasm"))]
mod published_times;
pub mod recording;
pub mod resources;
pub mod restart_files;
pub mod schedule;

#[cfg(not(target_family = "wasm"))]
pub(crate) use frame_loop::adapted_budget;
pub use frame_loop::{
    Advanced, RunError, RunSpec, RunState, record_frames, record_start, record_start_on_this_thread,
};
pub(crate) use frame_loop::{encoded, record_now};
#[cfg(not(target_family = "wasm"))]
pub use on_disk::{RunContext, RunReport, RunStart, execute};
