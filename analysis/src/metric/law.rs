//! A law of theory, with its statement and its source.

/// A law of physics or of numerical mathematics that a metric is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Law {
    /// The formula or the statement in one line.
    pub statement: &'static str,
    /// The literature or principle behind it.
    pub source: &'static str,
}

impl std::fmt::Display for Law {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} ({})", self.statement, self.source)
    }
}

/// Defines one constant per law: `CONSTANT: "statement", "source";`
macro_rules! laws {
    ($($constant:ident: $statement:literal, $source:literal;)+) => {
        $(
            #[doc = concat!("`", $statement, "` (", $source, ").")]
            pub(crate) const $constant: $crate::metric::Law =
                $crate::metric::Law { statement: $statement, source: $source };
        )+
    };
}
pub(crate) use laws;
