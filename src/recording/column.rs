//! The columns of a state, and the lengths of the columns of a message.

/// One column of the state, as a model declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateColumn {
    /// Name in the recording, such as `vx`.
    pub name: &'static str,
    /// Unit, such as "m/s"; empty for dimensionless.
    pub unit: &'static str,
}

/// A field that may be a column.
pub(crate) trait Column {
    /// Number of values; `None` for a field with a single value.
    fn length(&self) -> Option<usize>;
}

impl<T> Column for Vec<T> {
    fn length(&self) -> Option<usize> {
        Some(self.len())
    }
}

impl Column for f64 {
    fn length(&self) -> Option<usize> {
        None
    }
}

impl Column for u64 {
    fn length(&self) -> Option<usize> {
        None
    }
}

impl Column for String {
    fn length(&self) -> Option<usize> {
        None
    }
}
