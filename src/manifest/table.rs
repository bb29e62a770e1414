//! The macros of the manifest: a key, a word or a number is declared once, and everything that must agree about it is generated.
//!
//! To add a key, add a line to the `table!` of its table. From that line follow the field and its default, the reader with its
//! errors ("did you mean"), the canonical text, from which the run key is computed, and the JSON Schema with the doc comment as
//! description. A rule that involves several keys is a line of `rules!` in the model's `check`. The starter manifest of the
//! model lists the key too; a test compares the two.
//!
//! | to declare | macro | file | written in the manifest as |
//! |---|---|---|---|
//! | the keys of a table `[...]` | `table!` | here | `mass_kg = 1e-3` |
//! | keys of which a table has exactly one or at most one | `choice!` | here | `restitution = 0.5` or `damping_n_s_per_m = 1.5` |
//! | a value that is a table on one line | `inline_table!` | `inline.rs` | `{ min = 1e-3, max = 2e-3 }` |
//! | the same with several forms | `inline_enum!` | `inline.rs` | `{ min, max }` or `{ mean, std }` |
//! | a value that is one of some words | `words!` | `value.rs` | `"maxwell"` |
//! | a value that is a number within a range | `quantities!` | `quantity.rs` | `0.5` |
//! | how a model's state at the start is given | `starts!` | `model/start.rs` | `"lattice"`, `{ positions_m = ... }` or `start_from` |
//! | a rule between keys, with its error | `rules!` | `keys.rs` | |
//! | a model | `models!` | `model/mod.rs` | `[model.gas]` |
//!
//! `table!` and `choice!` implement [`HasKeys`](crate::keys::HasKeys), a list of keys; the four macros of values implement
//! [`TomlValue`](crate::value::TomlValue), which reads, writes and describes one value. A type of which a macro cannot generate
//! everything implements one of the two traits itself, as `Propagation` and `DiscRadius` do. The other macros in
//! this file and in `inline.rs` are parts of these.
//!
//! The module `example` at the end of this file declares a table with a key of each kind, and tests what follows from it.

/// Defines tables: each line gives a key's name, type, unit and default, and its doc comment is the key's description.
/// From it follow the struct, its `Default`, and [`HasKeys`](crate::keys::HasKeys), and from that the known keys, the
/// reader, the canonical text and the JSON Schema. The order of the lines is the order of the canonical text.
///
/// In brackets after the type:
/// - `["m"]`: a key with a unit, always written;
/// - `["m", optional]`: an `Option`, written if it is `Some`;
/// - `["m", sparse]`: written if it differs from its default;
/// - `[group]`: a type that has keys of its own, see [`choice`];
/// - `[start]`: a start, or `start_from` in its place; `[start unless KEY]`, or `KEY` in its place;
/// - `[apart]`: not visited with the others.
macro_rules! table {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $table:ident $(at most one of [$($one:ident),+])? {
            $($(#[doc = $about:literal])* $field:ident: $type:ty [$($kind:tt)+] $(= $default:expr)?,)+
        }
    )+) => {$(
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        $vis struct $table {
            $($(#[doc = $about])* $vis $field: $type,)+
        }

        impl Default for $table {
            fn default() -> Self {
                Self { $($field: $crate::table::default_value!($($default)?),)+ }
            }
        }

        impl $table {
            /// The keys at most one of which may be present.
            const EXCLUSIVE: &'static [&'static str] = &[$($(stringify!($one)),+)?];
        }

        impl $crate::keys::HasKeys for $table {
            fn keys(&mut self, keys: &mut impl $crate::keys::Keys) {
                keys.exclusive(Self::EXCLUSIVE);
                $($crate::table::visit!(
                    self, keys, [$($about),*], $field, [$($kind)+], $crate::table::default_value!($($default)?)
                );)+
            }
        }
    )+};
}

/// The default of a key; `None` where a line gives none.
macro_rules! default_value {
    () => {
        None
    };
    ($default:expr) => {
        const { $default }
    };
}

/// A key as the visitors take it.
macro_rules! key {
    ($field:ident, $unit:literal, [$($about:literal),*]) => {
        &$crate::keys::Key {
            name: stringify!($field),
            unit: $unit,
            about: concat!("", $($about),*),
        }
    };
}

/// Visits one key of a table.
macro_rules! visit {
    ($self:ident, $keys:ident, $about:tt, $field:ident, [$unit:literal], $default:expr) => {
        $keys.key($crate::table::key!($field, $unit, $about), &mut $self.$field)
    };
    ($self:ident, $keys:ident, $about:tt, $field:ident, [$unit:literal, optional], $default:expr) => {
        $self.$field =
            $keys.optional($crate::table::key!($field, $unit, $about), $self.$field.take())
    };
    ($self:ident, $keys:ident, $about:tt, $field:ident, [$unit:literal, sparse], $default:expr) => {
        $keys.sparse($crate::table::key!($field, $unit, $about), &mut $self.$field, $default)
    };
    ($self:ident, $keys:ident, $about:tt, $field:ident, [group], $default:expr) => {
        $crate::keys::HasKeys::keys(&mut $self.$field, $keys)
    };
    ($self:ident, $keys:ident, $about:tt, $field:ident, [start $(unless $other:ident)?], $default:expr) => {
        if true $(&& $self.$other.is_none())? {
            let exclusive = &[stringify!($field), "start_from" $(, stringify!($other))?];
            let key = $crate::table::key!($field, "", $about);
            $crate::model::start_from::visit(&mut $self.$field, key, exclusive, $keys);
        }
    };
    ($self:ident, $keys:ident, $about:tt, $field:ident, [apart], $default:expr) => {};
}

/// Defines an enum each of whose variants is a key of the table, at most one of which may be present. The variant
/// after `|` has no key.
macro_rules! choice {
    (
        $(#[$meta:meta])*
        $vis:vis enum $choice:ident {
            $($(#[doc = $about:literal])* $key:ident: $variant:ident($type:ty) [$unit:literal],)+
            $(| $(#[$bare_meta:meta])* $bare:ident,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $vis enum $choice {
            $($(#[doc = $about])* $variant($type),)+
            $($(#[$bare_meta])* $bare,)?
        }

        impl $crate::keys::HasKeys for $choice {
            fn keys(&mut self, keys: &mut impl $crate::keys::Keys) {
                let current = *self;
                keys.exclusive(&[$(stringify!($key)),+]);
                $(
                    let given = match current {
                        Self::$variant(value) => Some(value),
                        _ => None,
                    };
                    let key = $crate::table::key!($key, $unit, [$($about),*]);
                    if let Some(value) = keys.optional(key, given) {
                        *self = Self::$variant(value);
                    }
                )+
            }
        }
    };
}

pub(crate) use {choice, default_value, key, table, visit};

#[cfg(test)]
mod example {
    use crate::describe::Describer;
    use crate::diagnostics::{Diagnostics, Errors};
    use crate::inline::inline_table;
    use crate::keys::{HasKeys as _, Reader, Writer, rules};
    use crate::quantity::{NonNegative, Positive};
    use crate::syntax::parse_toml;
    use crate::value::words;

    words! {
        /// The medium around a pendulum.
        enum Medium {
            /// No friction.
            Vacuum = "vacuum",
            /// Friction that is proportional to the velocity.
            Air = "air",
        }
    }

    inline_table! {
        /// A push at the start.
        struct Push = "{ speed_m_per_s = ..., after_s = ... }" {
            /// Speed after the push, m/s.
            speed_m_per_s: Positive [required],
            /// Time of the push, s.
            after_s: NonNegative [or NonNegative::literal(0.0)],
        }
    }

    choice! {
        /// The length of a pendulum, or what it follows from.
        enum Length {
            /// Length of the string.
            length_m: Given(Positive) ["m"],
            /// Period of small oscillations.
            period_s: FromPeriod(Positive) ["s"],
        }
    }

    table! {
        /// A pendulum.
        struct Pendulum {
            /// Mass of the bob.
            mass_kg: Positive ["kg"] = Positive::literal(1.0),
            /// The length of the string.
            length: Length [group] = Length::Given(Positive::literal(2.0)),
            /// What the pendulum swings in.
            medium: Medium ["", sparse] = Medium::Vacuum,
            /// A push; none by default.
            push: Option<Push> ["", optional],
        }
    }

    /// Reads the table, and returns it with its errors.
    fn read(text: &str) -> (Pendulum, String) {
        let (mut diagnostics, mut errors) = (Diagnostics::default(), Errors::default());
        let (table, _) = parse_toml(text, "pendulum.toml", &mut diagnostics);
        let mut pendulum = Pendulum::default();
        let mut reader = Reader::new("", &table, &mut errors);
        pendulum.keys(&mut reader);
        let is_pushed = pendulum.push.is_some();
        rules! { reader;
            is_pushed && pendulum.medium == Medium::Air => ["medium", "push"]
                "a pendulum in air cannot be pushed", "leave out `push`";
        }
        reader.finish();
        (pendulum, diagnostics.with(errors).to_string())
    }

    /// Guarantee: what one line per key declares is read, written in canonical form and described in the schema alike.
    #[test]
    fn reader_writer_and_schema_follow_from_the_declaration() {
        let (mut pendulum, errors) =
            read("push = { speed_m_per_s = 3 }\nperiod_s = 1\nmass_kg = 0.50");
        assert_eq!(errors, "");
        assert_eq!(pendulum.length, Length::FromPeriod(Positive::literal(1.0)));
        let mut writer = Writer::default();
        pendulum.keys(&mut writer);
        let canonical =
            "mass_kg = 0.5\nperiod_s = 1.0\npush = { speed_m_per_s = 3.0, after_s = 0.0 }\n";
        assert_eq!(writer.text, canonical);
        assert_eq!(read(canonical), (pendulum, String::new()));

        let schema = Describer::describe(&mut Pendulum::default());
        let keys: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
        assert_eq!(keys, ["length_m", "mass_kg", "medium", "period_s", "push"]);
        assert_eq!(schema["properties"]["mass_kg"]["description"], "Mass of the bob. Unit: kg.");

        for (text, message) in [
            ("mas_kg = 1", "did you mean `mass_kg`?"),
            ("mass_kg = 0", "must be a number > 0"),
            ("medium = \"water\"", "must be one of \"vacuum\", \"air\""),
            ("length_m = 1\nperiod_s = 1", "`length_m` and `period_s` cannot be used together"),
            ("push = {}", "needs `speed_m_per_s`"),
            ("medium = \"air\"\npush = { speed_m_per_s = 1 }", "leave out `push`"),
        ] {
            let (_, errors) = read(text);
            assert!(errors.contains(message), "{text}\n{errors}");
        }
    }
}
