//! The manifest as text: its rules, its canonical form, its schema and its sweeps.
//!
//! A test belongs here if it needs the public API of this package only.

// An answer names metrics and points of the sweep that exist.
mod answers_name_what_exists;
// The canonical manifest, from which the run key is computed, never changes by accident.
mod canonical_form_is_stable;
// Damaged text gives errors, not panics.
mod damaged_manifests_never_panic;
// The comparison of two manifests lists exactly the differing keys.
mod differing_keys_are_named;
// `experiment.toml` gives the analysis what the manifest gave the run.
mod experiment_record_round_trips;
// Requested plots name metrics, channels and swept keys that exist.
mod plots_name_what_exists;
// The view names points of the sweep that exist.
mod view_names_points_of_the_sweep;
// Every rule broken once: the message states the allowed values and the position.
mod dem_rules_are_enforced;
mod gas_rules_are_enforced;
mod orbit_rules_are_enforced;
mod packing_rules_are_enforced;
mod rules_are_enforced;
// Parser, canonical form, schema and starters have the same keys.
mod schema_matches_the_manifest;
// A sweep is every combination of its axes, in a fixed order.
mod sweeps_expand_in_order;
// What these tests expect of a manifest.
mod verdicts;
