//! The state at the start of a run: a word for how it is drawn, a state that is written out, or a recording.

use crate::inline::inline_table;
use crate::keys::{Reader, rules};
use crate::quantity::Finite;
use std::num::NonZeroU32;

inline_table! {
    /// Positions and velocities written out in a manifest, one pair per particle.
    pub struct GivenState = "{ positions_m = ..., velocities_m_per_s = ... }" with GivenState::rules {
        /// Centers, `[x, y]` each, m.
        positions_m: Vec<[Finite; 2]> [nonempty],
        /// Velocities, `[vx, vy]` each, m/s; as many as positions.
        velocities_m_per_s: Vec<[Finite; 2]> [nonempty],
    }
}

impl GivenState {
    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        let keys = ["positions_m", "velocities_m_per_s"];
        check_lengths(name, reader, keys, [self.positions_m.len(), self.velocities_m_per_s.len()]);
    }
}

/// Reports a state without particles, and one whose particles do not all have a velocity.
pub(super) fn check_lengths(
    name: &str,
    reader: &mut Reader<'_>,
    [positions_key, velocities_key]: [&str; 2],
    [positions, velocities]: [usize; 2],
) {
    rules! { reader;
        positions != velocities => [positions_key, velocities_key]
            "`{name}` has {positions} positions but {velocities} velocities", "one velocity for each position";
        positions == 0 && velocities == 0 => [positions_key, velocities_key]
            "`{name}` is empty", "needs at least one particle";
    }
}

/// The number of particles of a start that fixes it, which the key `counter` may repeat but not contradict.
pub(super) fn agreed_count(
    table: &mut Reader<'_>,
    [key, counter]: [&str; 2],
    stated: NonZeroU32,
    found: usize,
    what: &str,
) -> NonZeroU32 {
    let given = u32::try_from(found).ok().and_then(NonZeroU32::new);
    rules! { table;
        table.has(counter) && given != Some(stated) => [key, counter]
            "`{counter}` is {stated}, but {what}", "must be {found}, or be left out";
    }
    given.unwrap_or(stated)
}

/// Defines the starts of a model: some words, a state that is written out as a table, or a recording.
macro_rules! starts {
    (
        $(#[$meta:meta])*
        pub enum $type:ident {
            $($(#[$variant_meta:meta])* $variant:ident = $word:literal,)+
            | $given:ident $(with $positions:ident)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $type {
            $($(#[$variant_meta])* $variant,)+
            /// Written out, with velocities.
            Given($given),
            /// The last state of a recording.
            Recorded($crate::model::start_from::StartFrom),
        }

        $(impl $type {
            /// The number of particles, which the key `counter` states.
            pub(super) fn count(
                &self,
                table: &mut $crate::keys::Reader<'_>,
                counter: &str,
                stated: std::num::NonZeroU32,
            ) -> std::num::NonZeroU32 {
                let (key, found, what) = match self {
                    Self::Given(state) => {
                        let found = state.$positions.len();
                        ("placement", found, format!("{found} are placed"))
                    }
                    Self::Recorded(start) => match start.particles() {
                        Some(found) => ("start_from", found, format!("the recording ends with {found}")),
                        None => return stated,
                    },
                    _ => return stated,
                };
                $crate::model::start::agreed_count(table, [key, counter], stated, found, &what)
            }
        })?

        impl $crate::model::start_from::MayBeRecorded for $type {
            fn from_recorded(start: $crate::model::start_from::StartFrom) -> Self {
                Self::Recorded(start)
            }

            fn recorded(&self) -> Option<&$crate::model::start_from::StartFrom> {
                if let Self::Recorded(start) = self { Some(start) } else { None }
            }

            fn recorded_mut(&mut self) -> Option<&mut $crate::model::start_from::StartFrom> {
                if let Self::Recorded(start) = self { Some(start) } else { None }
            }
        }

        impl $crate::value::TomlValue for $type {
            fn read(
                node: &$crate::tree::Node,
                name: &str,
                errors: &mut $crate::diagnostics::Errors,
            ) -> Option<Self> {
                if node.table().is_some() {
                    return $crate::inline::read(node, name, errors).map(Self::Given);
                }
                let or = format!(" or {}", <$given as $crate::inline::InlineTable>::EXPECTED);
                $crate::value::word(node, name, &[$(($word, Self::$variant)),+], &or, errors)
            }

            fn write(&self) -> String {
                match self {
                    $(Self::$variant => $crate::value::quoted($word),)+
                    Self::Given(state) => state.write(),
                    Self::Recorded(start) => start.write(),
                }
            }

            fn schema() -> serde_json::Value {
                serde_json::json!({ "anyOf": [{ "enum": [$($word),+] }, $given::schema()] })
            }
        }
    };
}
pub(super) use starts;

starts! {
    /// How discs are placed at the start.
    pub enum Placement {
        /// Uniformly at random, without overlap.
        Random = "random",
        /// On a regular lattice.
        Lattice = "lattice",
        | GivenState with positions_m
    }
}
