//! Who runs the plan. The engine's word is never trusted: a run counts when its recording is there.

pub mod local;
pub mod memory;
pub mod queue;
pub mod slurm;
pub mod task;
