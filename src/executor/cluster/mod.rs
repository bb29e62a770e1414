//! Executes the plan on a cluster, through Slurm or HyperQueue.

pub mod expected_time;
mod hyperqueue;
pub mod queue;
pub mod scheduler;
mod slurm;
mod squeue;
mod submission;
pub mod task;
