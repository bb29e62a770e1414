//! The radii of DEM's discs: equal, uniform, normal, or two sizes.

use crate::diagnostics::Errors;
use crate::inline::{self, inline_enum};
use crate::keys::Reader;
use crate::quantity::{Fraction, Positive};
use crate::tree::Node;
use crate::value::{TomlValue, number};
use serde_json::Value as Json;

inline_enum! {
    /// The discs' radius, m.
    pub enum DiscRadius = "a number > 0 or { min = ..., max = ... }" with DiscRadius::rules {
        /// Uniform between two bounds, `min <= max`.
        Uniform {
            /// Smallest radius, m.
            min: Positive [required],
            /// Largest radius, m.
            max: Positive [required],
        }
        /// Normal about a mean, drawn again beyond three deviations.
        Normal {
            /// Mean radius, m.
            mean: Positive [required],
            /// Standard deviation, m; below a third of the mean.
            std: Positive [required],
        }
        /// Two sizes.
        TwoSizes {
            /// The smaller radius, m.
            small: Positive [required],
            /// The larger radius, m.
            large: Positive [required],
            /// Probability of the smaller.
            small_fraction: Fraction [required],
        }
        |
        /// All equal.
        Equal(Positive)
    }
}

/// Largest ratio of two radii in a run: beyond it, the contacts of the smallest discs are lost among the largest ones'.
pub(super) const MOST_RADIUS_RATIO: f64 = 10.0;

impl DiscRadius {
    /// Smallest and largest radius that can be drawn, m.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Equal(radius) => (radius.get(), radius.get()),
            Self::Uniform { min, max } => (min.get(), max.get()),
            Self::Normal { mean, std } => {
                (mean.get() - 3.0 * std.get(), mean.get() + 3.0 * std.get())
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

    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        match self {
            Self::Uniform { min, max } if min > max => {
                let title = format!("`{name}` has `min` above `max`");
                reader.refuse(&["min", "max"], &title, "min must be <= max");
            }
            Self::Normal { mean, std } if 3.0 * std.get() >= mean.get() => {
                let title = format!("mean - 3 std is {:?}; must be > 0", self.range().0);
                let label = "std must be below a third of mean";
                reader.refuse(&["mean", "std"], &title, label);
            }
            Self::TwoSizes { small, large, .. } if small > large => {
                let title = "`small` is above `large`";
                reader.refuse(&["small", "large"], title, "small must be <= large");
            }
            _ => {}
        }
    }
}

impl TomlValue for DiscRadius {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        match number(node) {
            Some(_) => Positive::read(node, name, errors).map(Self::Equal),
            None => inline::read(node, name, errors),
        }
    }

    fn write(&self) -> String {
        match self {
            Self::Equal(radius) => radius.write(),
            table => inline::write(table),
        }
    }

    fn schema() -> Json {
        inline::schema::<Self>(Some(Positive::schema()))
    }
}
