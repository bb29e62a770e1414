//! Execution of the plan on this machine or on a cluster.
//!
//! Invariant: a run counts as finished if and only if its recording exists, whatever a scheduler reports.

pub mod budget;
pub mod cluster;
pub mod local;
pub mod observer;
