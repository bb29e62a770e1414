//! Kinetoscope: reproducible particle experiments, from a TOML manifest to one MCAP recording per run.
//!
//! The library runs an experiment in memory. The package `kinetoscope-analysis` derives metrics from a recording:
//!
//! ```
//! use kinetoscope::{Experiment, run};
//!
//! let experiment: Experiment = r#"
//!     seed = 7
//!     [model.gas]
//!     particles = 200
//!     duration_s = 0.05
//!     [record]
//!     frames = 100
//! "#
//! .parse()?;
//! let recording = run(&experiment.runs[0])?;
//! let analysis = kinetoscope_analysis::analyze(&recording)?;
//! let pressure = analysis.measurement("pressure.measured").ok_or("the gas has no pressure")?;
//! assert!(pressure.estimate.value > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The folder `examples` has four programs: `run_in_memory`, `read_recording`, `extend` and, as a package of its own,
//! `lock_in_memory`. On `wasm32`, the library has what needs neither threads nor files: a run in memory, with the same bits. The
//! modules are internal to the programs `run-experiment` and `kinetoscope`: they may change in every version.

pub use kinetoscope_manifest::{Diagnostics, Experiment, Run};
pub use kinetoscope_recording::error::ReadError;
pub use kinetoscope_recording::reader::{Frames, Outcome, RecordedFrame, Recording, StateTable};
pub use run::RunError;
pub use run::in_memory::run;

// In the order of their dependencies.
#[doc(hidden)]
pub mod interrupt;
#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub mod live;

#[doc(hidden)]
pub mod run;

#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub mod plan;

#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub mod outputs;

#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub mod executor;
#[doc(hidden)]
pub mod verify;
