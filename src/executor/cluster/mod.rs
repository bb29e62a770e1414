//! Executes the plan on a cluster, through Slurm or HyperQueue.

mod active_tasks;
mod engine_command;
mod hyperqueue;
pub mod queue;
pub mod scheduler;
mod silence;
mod slurm;
mod squeue;
pub mod submission;
pub mod task;
