//! The plan of an experiment: how it is made, and the report that `check` prints.

pub(crate) mod plan_report;
pub(crate) mod planner;
pub(crate) mod rows;
