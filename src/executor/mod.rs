//! Who runs the plan. The engine's word is never trusted: a run counts when its recording is there.

pub mod local;
