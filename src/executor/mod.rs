//! Execution of the plan on this machine or on a cluster.
//!
//! Invariant: a run counts as finished if and only if its recording exists, whatever a scheduler reports.

pub mod analyze;
pub mod cluster;
mod heartbeat;
pub mod local;
pub mod memory;
pub mod progress;
