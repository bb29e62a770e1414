//! The radii of DEM's discs: equal, uniform, normal, or two sizes.

use crate::diagnostics::Diagnostic;
use crate::keys::Reader;
use crate::quantity::{Positive, Share};
use crate::tree::{Node, Span, Value};
use crate::value::{TomlValue, number, refuse, table_schema};
use serde_json::{Value as Json, json};

/// The discs' radius, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscRadius {
    /// All equal.
    Equal(Positive),
    /// Uniform between two bounds, `min <= max`.
    Uniform {
        /// Smallest radius, m.
        min: Positive,
        /// Largest radius, m.
        max: Positive,
    },
    /// Normal about a mean, drawn again beyond three deviations.
    Normal {
        /// Mean radius, m.
        mean: Positive,
        /// Standard deviation, m; below a third of the mean.
        deviation: Positive,
    },
    /// Two sizes.
    TwoSizes {
        /// The smaller radius, m.
        small: Positive,
        /// The larger radius, m.
        large: Positive,
        /// Probability of the smaller.
        small_share: Share,
    },
}

/// Largest ratio of two radii in a run: beyond it the contacts of the smallest discs are lost among the largest's.
pub(super) const MOST_RADIUS_RATIO: f64 = 10.0;

impl DiscRadius {
    /// Smallest and largest radius that can be drawn, m.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Equal(radius) => (radius.get(), radius.get()),
            Self::Uniform { min, max } => (min.get(), max.get()),
            Self::Normal { mean, deviation } => {
                (mean.get() - 3.0 * deviation.get(), mean.get() + 3.0 * deviation.get())
            }
            Self::TwoSizes { small, large, .. } => (small.get(), large.get()),
        }
    }

    /// The radius of a disc of the manifest's mass, m: the mean of equal, uniform and normal radii, and for two sizes the
    /// mean of the two.
    #[must_use]
    pub fn mean(&self) -> f64 {
        match self {
            Self::Normal { mean, .. } => mean.get(),
            other => 0.5 * (other.range().0 + other.range().1),
        }
    }
}

impl TomlValue for DiscRadius {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            if number(node).is_none() {
                refuse(node, name, "a number > 0 or { min = ..., max = ... }", errors);
                return None;
            }
            return Positive::read(node, name, errors).map(Self::Equal);
        };
        let mut reader = Reader::new(name, table, errors);
        let is_uniform = reader.has("min") || reader.has("max");
        let radius = if !is_uniform && (reader.has("mean") || reader.has("deviation")) {
            Self::read_normal(&mut reader, node.span)
        } else if !is_uniform && (reader.has("small") || reader.has("large")) {
            Self::read_two_sizes(&mut reader, node.span)
        } else {
            Self::read_uniform(&mut reader, name, node.span)
        };
        reader.finish();
        radius
    }

    fn write(&self) -> String {
        match self {
            Self::Equal(radius) => radius.write(),
            Self::Uniform { min, max } => {
                format!("{{ min = {}, max = {} }}", min.write(), max.write())
            }
            Self::Normal { mean, deviation } => {
                format!("{{ mean = {}, deviation = {} }}", mean.write(), deviation.write())
            }
            Self::TwoSizes { small, large, small_share } => format!(
                "{{ small = {}, large = {}, small_share = {} }}",
                small.write(),
                large.write(),
                small_share.write()
            ),
        }
    }

    fn schema() -> Json {
        let table = |keys: &[(&str, Json)]| {
            let properties: serde_json::Map<String, Json> =
                keys.iter().map(|(key, schema)| ((*key).to_owned(), schema.clone())).collect();
            let required: Vec<&str> = keys.iter().map(|(key, _)| *key).collect();
            table_schema(&properties.into(), &required)
        };
        let length = Positive::schema;
        json!({ "anyOf": [
            length(),
            table(&[("min", length()), ("max", length())]),
            table(&[("mean", length()), ("deviation", length())]),
            table(&[("small", length()), ("large", length()), ("small_share", Share::schema())]),
        ] })
    }
}

impl DiscRadius {
    fn read_uniform(reader: &mut Reader<'_>, name: &str, at: Span) -> Option<Self> {
        let min: Option<Positive> = reader.required("min", at);
        let max: Option<Positive> = reader.required("max", at);
        let bounds = min.zip(max);
        let ordered = bounds.filter(|(min, max)| min <= max);
        if bounds.is_some() && ordered.is_none() {
            let title = format!("`{name}` has its smallest radius above its largest");
            reader.refuse(&["min", "max"], &title, "min must be <= max");
        }
        ordered.map(|(min, max)| Self::Uniform { min, max })
    }

    fn read_normal(reader: &mut Reader<'_>, at: Span) -> Option<Self> {
        let mean: Option<Positive> = reader.required("mean", at);
        let deviation: Option<Positive> = reader.required("deviation", at);
        let (mean, deviation) = mean.zip(deviation)?;
        if 3.0 * deviation.get() >= mean.get() {
            let title = "three deviations below the mean is no radius";
            reader.refuse(&["mean", "deviation"], title, "deviation must be below a third of mean");
            return None;
        }
        Some(Self::Normal { mean, deviation })
    }

    fn read_two_sizes(reader: &mut Reader<'_>, at: Span) -> Option<Self> {
        let small: Option<Positive> = reader.required("small", at);
        let large: Option<Positive> = reader.required("large", at);
        let small_share: Option<Share> = reader.required("small_share", at);
        let ((small, large), small_share) = small.zip(large).zip(small_share)?;
        if small > large {
            let title = "the smaller radius is above the larger";
            reader.refuse(&["small", "large"], title, "small must be <= large");
            return None;
        }
        Some(Self::TwoSizes { small, large, small_share })
    }
}
