//! State of the last frame of a recording, from which a run starts.

use crate::model::SetupError;
use kinetoscope_manifest::model::StartFrom;

/// Reads the given columns of all particles, in the order of their ids.
///
/// # Errors
/// A recording that was not read, or one without these columns.
pub(crate) fn rows<const N: usize>(
    start: &StartFrom,
    names: [&str; N],
) -> Result<Vec<[f64; N]>, SetupError> {
    let StartFrom::Read(state) = start else {
        return Err(SetupError::new(
            "the recording of start_from was not read",
            "run the manifest with run-experiment",
        ));
    };
    state.columns(names).ok_or_else(|| {
        SetupError::new(
            format!(
                "start_from: expected a recording with the state columns {}, found one without some of them",
                names.join(", ")
            ),
            "record it again with this version",
        )
    })
}
