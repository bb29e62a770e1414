//! The manifest of an experiment: what to run, and what must hold afterward.
//!
//! Past this package every value is in range by its type. In reading order: [`parse`] makes an [`Experiment`] with
//! all its [`Run`]s out of a TOML text, or [`Diagnostics`] with everything that is wrong with it.

mod experiment;

mod diagnostics;
mod keys;
mod tree;
mod value;

pub mod model;
pub mod quantity;
pub mod record;

mod checks;
mod sweep;

mod canonical;
mod comparison;
mod schema;
mod sidecar;
mod start_manifests;
mod starter;
mod timing;

pub use canonical::{ContentKey, RunManifest, content_key, parse_run};
pub use checks::{Bound, Check, parse_checks};
pub use comparison::{KeyDifference, differing_keys};
pub use diagnostics::Diagnostics;
pub use experiment::{Experiment, Override, Run, parse, parse_with_recordings};
pub use schema::json_schema;
pub use sidecar::{ExperimentRecord, RunRecord};
pub use start_manifests::{StartManifest, is_manifest_name, start_manifests};
pub use starter::starter;
pub use sweep::{Axis, Coordinate};
pub use timing::{TimingComparison, TimingPoint, TimingRatio, TimingTable};
