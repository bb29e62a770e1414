//! The columns of the state that a model declares.

/// One column of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateColumn {
    /// Name in the recording, such as `vx`.
    pub name: &'static str,
    /// Unit, such as "m/s"; empty for dimensionless.
    pub unit: &'static str,
}
