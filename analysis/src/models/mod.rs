//! The analysis of each model: one folder per model, the contract that it fulfills, and the list of all.
//!
//! To add a model, add its folder, its `mod` line here, and its line in [`registry::MODELS`].

pub(crate) mod contract;
pub(crate) mod figures;
pub(crate) mod registry;
pub(crate) mod series;
pub(crate) mod snapshots;

pub(crate) mod dem;
pub(crate) mod gas;
pub(crate) mod orbit;
pub(crate) mod packing;

/// (x - reference) / |reference|.
fn relative_change(x: f64, reference: f64) -> f64 {
    (x - reference) / reference.abs()
}

/// The larger of two numbers, or NaN if either is NaN, so that a numerical blow-up stays visible.
fn max_or_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}
