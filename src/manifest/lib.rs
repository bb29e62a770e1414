//! The manifest of an experiment: what to run, and which checks must pass afterward.
//!
//! [`parse`] turns a TOML text into an [`Experiment`] with all its [`Run`]s, or into [`Diagnostics`] with every error of
//! the text. After this package every value is in range by its type.

mod diagnostics;
mod inline;
mod keys;
mod syntax;
mod table;
mod tree;
mod value;
mod view;

pub mod model;
pub mod quantity;
pub mod record;

mod answer;
mod baseline;
mod canonical;
mod checks;
mod comparison;
mod describe;
mod exercise;
mod experiment;
mod experiment_name;
mod head;
mod overrides;
mod places;
mod plots;
mod schema;
mod sentence;
mod sidecar;
mod start_manifests;
mod sweep;
mod timing;

pub use answer::{AnswerPart, AnswerTemplate, FittedAlong, MetricReference, UnitOf};
pub use baseline::BaselineTolerance;
pub use canonical::{RunKey, RunManifest, run_key};
pub use checks::{Bound, Check, IfUndecided, MetricNames, parse_checks};
pub use comparison::{
    KeyDifference, differing_keys, differing_values, manifest_values, written_checks,
    written_values,
};
pub use describe::unit_of_key;
pub use diagnostics::{Diagnostics, nearest};
pub use exercise::Exercise;
pub use experiment::{Experiment, Lookup, Run, parse, parse_run, parse_with};
pub use experiment_name::experiment_name;
pub use head::ExpectedOutcome;
pub use model::starter;
pub use overrides::Override;
pub use places::line_of_key_in_message;
pub use plots::{PlotAxis, PlotFit, PlotRequest, TIME, channel_field};
pub use schema::json_schema;
pub use sidecar::{ExperimentRecord, RunRecord};
pub use start_manifests::{NamedStart, is_manifest_name, start_manifests, start_names};
pub use sweep::{Axis, Coordinate};
pub use syntax::{excess_of_toml, toml_error};
pub use timing::{TimingComparison, TimingPoint, TimingRatio, TimingTable};
pub use view::{ViewColor, ViewFrame, ViewRequest};
