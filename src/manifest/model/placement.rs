//! How particles are placed at the start.

use crate::diagnostics::Diagnostic;
use crate::keys::Reader;
use crate::quantity::Finite;
use crate::tree::{Node, Value};
use crate::value::{TomlValue, word};
use serde_json::{Value as Json, json};
use std::num::NonZeroU32;

/// Positions and velocities written out in a manifest, one pair per particle, in SI units or the model's own.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenState {
    /// Centers, `[x, y]` each.
    pub positions: Vec<[Finite; 2]>,
    /// Velocities, `[vx, vy]` each; as many as positions.
    pub velocities: Vec<[Finite; 2]>,
}

/// The keys of the two lists of a given state.
#[derive(Clone, Copy)]
pub(super) struct GivenNames {
    pub(super) positions: &'static str,
    pub(super) velocities: &'static str,
}

/// The keys of a model in SI units.
pub(super) const GIVEN_SI: GivenNames =
    GivenNames { positions: "positions_m", velocities: "velocities_m_per_s" };

impl GivenState {
    fn read(
        node: &Node,
        name: &str,
        names: GivenNames,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let mut reader = Reader::new(name, node.table()?, errors);
        let positions: Option<Vec<[Finite; 2]>> = reader.required(names.positions, node.span);
        let velocities: Option<Vec<[Finite; 2]>> = reader.required(names.velocities, node.span);
        let state =
            positions.zip(velocities).map(|(positions, velocities)| Self { positions, velocities });
        if let Some(Self { positions, velocities }) = &state {
            let keys = [names.positions, names.velocities];
            let (places, speeds) = (positions.len(), velocities.len());
            if places != speeds {
                let title = format!("`{name}` has {places} positions but {speeds} velocities");
                reader.refuse(&keys, &title, "one velocity for each position");
            } else if positions.is_empty() {
                reader.refuse(&keys, &format!("`{name}` is empty"), "needs at least one particle");
            }
        }
        let sound = reader.is_sound();
        reader.finish();
        state.filter(|_| sound)
    }

    /// The canonical text.
    pub(super) fn write(&self, names: GivenNames) -> String {
        format!(
            "{{ {} = {}, {} = {} }}",
            names.positions,
            self.positions.write(),
            names.velocities,
            self.velocities.write()
        )
    }

    /// The number of particles; the key `counter` may repeat it but not contradict it.
    pub(super) fn count(
        &self,
        table: &mut Reader<'_>,
        counter: &str,
        stated: NonZeroU32,
    ) -> NonZeroU32 {
        let given = u32::try_from(self.positions.len()).ok().and_then(NonZeroU32::new);
        if table.has(counter) && given != Some(stated) {
            let title = format!("`{counter}` is {stated}, but {} are placed", self.positions.len());
            let label = format!("must be {}, or be left out", self.positions.len());
            table.refuse(&["placement", counter], &title, &label);
        }
        given.unwrap_or(stated)
    }
}

/// Reads one of some words, or a given state.
pub(super) fn read_placement<T: Clone>(
    node: &Node,
    name: &str,
    words: &[(&str, T)],
    given: impl FnOnce(GivenState) -> T,
    names: GivenNames,
    errors: &mut Vec<Diagnostic>,
) -> Option<T> {
    if let Value::Table(_) = &node.value {
        return GivenState::read(node, name, names, errors).map(given);
    }
    let or = format!(" or {{ {} = ..., {} = ... }}", names.positions, names.velocities);
    word(node, name, words, &or, errors)
}

/// The schema of one of some words, or a given state.
pub(super) fn placement_schema(words: &[&str], names: GivenNames) -> Json {
    let mut vectors = Vec::<[Finite; 2]>::schema();
    vectors["minItems"] = json!(1);
    json!({ "anyOf": [{ "enum": words }, {
        "type": "object",
        "properties": { names.positions: vectors, names.velocities: vectors },
        "required": [names.positions, names.velocities],
        "additionalProperties": false
    }] })
}

/// Defines the starts of a model: some words, a state that is written out, or a recording.
macro_rules! placements {
    (
        $(#[$meta:meta])*
        $vis:vis enum $type:ident given as $names:ident {
            $($(#[$variant_meta:meta])* $variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        $vis enum $type {
            $($(#[$variant_meta])* $variant,)+
            /// Written out, with velocities.
            Given($crate::model::placement::GivenState),
            /// The last state of a recording.
            Recorded($crate::model::start_from::StartFrom),
        }

        $crate::model::start_from::may_be_recorded!($type);

        impl $crate::value::TomlValue for $type {
            fn read(
                node: &$crate::tree::Node,
                name: &str,
                errors: &mut Vec<$crate::diagnostics::Diagnostic>,
            ) -> Option<Self> {
                let words = [$(($word, Self::$variant)),+];
                $crate::model::placement::read_placement(
                    node, name, &words, Self::Given, $names, errors,
                )
            }

            fn write(&self) -> String {
                match self {
                    $(Self::$variant => $crate::value::quoted($word),)+
                    Self::Given(state) => state.write($names),
                    Self::Recorded(start) => start.write(),
                }
            }

            fn schema() -> serde_json::Value {
                $crate::model::placement::placement_schema(&[$($word),+], $names)
            }
        }
    };
}
pub(super) use placements;

placements! {
    /// How particles are placed at the start.
    pub enum Placement given as GIVEN_SI {
        /// Uniformly at random, without overlap where particles have a size.
        Random = "random",
        /// On a regular lattice (DEM only).
        Lattice = "lattice",
    }
}
