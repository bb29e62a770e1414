//! A law of theory, with its statement and its source.

/// A law of physics or of numerical mathematics that a metric is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// The formula or the statement in one line.
    pub statement: &'static str,
    /// The literature or principle behind it.
    pub source: &'static str,
    /// The range in which the law holds, such as "packing fraction < 0.7"; empty if it holds always.
    pub range: &'static str,
    /// The law's error as a fraction of its value; 0 for an exact law.
    pub relative_accuracy: f64,
    /// The quantity that a conservation law keeps constant, in words; `None` for another law. A violation is an error of the method,
    /// always of one sign or a largest size: it does not scatter about the theoretical value, so standard errors do not measure it.
    pub conserved: Option<&'static str>,
    /// Whether a conservation law holds up to the error of an integrator, which a run without contacts does not have.
    pub is_of_integrator: bool,
    /// The name by which a sentence calls it, such as "Haff's law"; `None` for one without a common name.
    pub name: Option<&'static str>,
    /// Whether it is an identity of the recorded values, which holds whatever the run does.
    pub is_identity: bool,
    /// Whether its value follows from the manifest alone, so that it is the same for every seed.
    pub is_of_manifest: bool,
}

/// The only element, if there is one.
pub(crate) const fn first(words: &[&'static str]) -> Option<&'static str> {
    match words {
        [word, ..] => Some(*word),
        [] => None,
    }
}

/// A text that the references and reports show. The engine of a page, which is small, does not contain it.
pub(crate) const fn for_reference(text: &'static str) -> &'static str {
    if cfg!(all(target_family = "wasm", target_os = "unknown")) { "" } else { text }
}

impl Law {
    /// Whether it is a conservation law.
    #[must_use]
    pub const fn is_conservation(&self) -> bool {
        self.conserved.is_some()
    }

    /// What the legend of a plot calls it.
    pub(crate) fn title(&self) -> &'static str {
        self.name.map_or("theory", |name| name.strip_prefix("the ").unwrap_or(name))
    }
}

impl std::fmt::Display for Law {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} ({})", self.statement, self.source)
    }
}

/// Defines one constant per law: `CONSTANT: "statement", "source";`, for a law that is not exact everywhere with
/// `, range "packing fraction < 0.7", accuracy 1e-3` before the semicolon, for a conservation law with `, conserves "energy"`
/// (and `, integrator true` if an integrator keeps it), for an identity with `, identity true`, for a value that follows from the manifest alone with `, manifest true`, and at last the name of a
/// law that has one, with `, named "Haff's law"`.
macro_rules! laws {
    ($($constant:ident: $statement:literal, $source:literal $(, range $range:literal)? $(, accuracy $accuracy:literal)? $(, conserves $conserved:literal)? $(, integrator $integrator:literal)? $(, identity $identity:literal)? $(, manifest $manifest:literal)? $(, named $name:literal)?;)+) => {
        $(
            #[doc = concat!("`", $statement, "` (", $source, ").")]
            pub(crate) const $constant: $crate::metric::Law = $crate::metric::Law {
                statement: $crate::metric::law::for_reference($statement),
                source: $crate::metric::law::for_reference($source),
                range: concat!("", $($range)?),
                relative_accuracy: 0.0 $(+ $accuracy)?,
                conserved: $crate::metric::law::first(&[$($conserved)?]),
                name: $crate::metric::law::first(&[$($name)?]),
                is_of_integrator: false $(|| $integrator)?,
                is_identity: false $(|| $identity)?,
                is_of_manifest: false $(|| $manifest)?,
            };
        )+
    };
}
pub(crate) use laws;
