//! Recordings against reruns and against each other: `verify` and `compare`, `fill` and `zoom`.

pub(crate) mod fill_and_zoom;
mod forecast;
pub(crate) mod rerun;
pub(crate) mod restore;
pub(crate) mod verify_and_compare;
