//! Kinetoscope: reproducible particle experiments. A model moves, a recording testifies, a law judges.
//!
//! In reading order: what may be random, where a model meets the rest, the models, when frames are taken, who watches, one run, the plan
//! of all runs, who executes it, what proves a recording, and the command line on top.

pub mod allocation;
pub mod constants;
pub mod hard_discs;
pub mod placement;
pub mod random;
mod recorded_start;
pub mod sum;
pub mod vector_width;

pub mod model;
pub mod models;

pub mod schedule;

pub mod live;

pub mod checkpointing;
pub mod run;

pub mod plan;
pub mod stale;
pub mod start_file;

pub mod analyzing;
pub mod executor;
pub mod interrupt;
pub mod progress;
pub mod side_files;

pub mod difference;

pub mod attestation;
pub mod compare;
pub mod verify;
pub mod why;

pub mod timing;

pub mod evidence;

mod conclusion;
pub mod depot;
pub mod destination;
pub mod disk_space;
pub mod distribution;
mod telling;
pub mod watching;

pub mod exit;

pub mod command;
