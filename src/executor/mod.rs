//! Who runs the plan. The engine's word is never trusted: a run counts when its recording is there.

pub mod engine;
pub mod expected_time;
mod hyperqueue;
pub mod local;
pub mod memory;
pub mod queue;
mod slurm;
mod slurm_queue;
mod submission;
pub mod task;
