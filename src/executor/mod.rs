//! Executes the plan: on this machine or on a cluster. A run counts as finished when its recording exists, whatever a scheduler reports.

pub mod analyze;
pub mod cluster;
pub mod local;
pub mod memory;
pub mod progress;
