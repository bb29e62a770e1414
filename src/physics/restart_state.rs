//! What a model takes over from the state that the run of a recording ended with.

use crate::model::SetupError;
use kinetoscope_manifest::model::StartFrom;

/// Some columns of all particles, in the order of their ids.
///
/// # Errors
/// A recording that was not found, or one without these columns.
pub(crate) fn rows<const N: usize>(
    start: &StartFrom,
    names: [&str; N],
) -> Result<Vec<[f64; N]>, SetupError> {
    let StartFrom::Read(state) = start else {
        return Err(SetupError(
            "The run starts from a recording that was not looked for: give its manifest to run-experiment."
                .to_owned(),
        ));
    };
    state.columns(names).ok_or_else(|| {
        SetupError(format!(
            "The recording that start_from names has not all of the columns {} in its state: record it anew with this \
             version.",
            names.join(", ")
        ))
    })
}
