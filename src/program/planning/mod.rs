//! The plan of an experiment: how it is made, `check`, and the report that `check` prints.

pub(crate) mod check;
pub(crate) mod plan_report;
pub(crate) mod planner;
