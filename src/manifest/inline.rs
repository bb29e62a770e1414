//! Tables on one line, such as `{ min = 1e-3, max = 2e-3 }`: values that have keys of their own.

use crate::diagnostics::Errors;
use crate::keys::Reader;
use crate::tree::{Node, Span};
use crate::value::{TomlValue, refuse_type};
use serde_json::{Map, Value as Json, json};

/// A table on one line. The macros [`inline_table`] and [`inline_enum`] implement it.
pub(crate) trait InlineTable: Sized {
    /// What the key takes, for the error of another value. Reads after "must be".
    const EXPECTED: &'static str;

    /// Reads the keys; a required one that is missing is reported at `at`.
    fn read_keys(reader: &mut Reader<'_>, at: Span) -> Option<Self>;

    /// Reports the broken rules between the keys of the table `name`.
    fn check(&self, name: &str, reader: &mut Reader<'_>);

    /// Appends `key = value` for each key that has a value.
    fn write_keys(&self, pairs: &mut Vec<String>);

    /// The sets of keys that the table may have.
    fn forms() -> Vec<Form>;
}

/// The keys that one form of a table has, with the schemas of their values.
#[derive(Clone, Default)]
pub(crate) struct Form {
    properties: Map<String, Json>,
    required: Vec<&'static str>,
}

impl Form {
    /// Adds a key.
    pub(crate) fn insert(&mut self, key: &'static str, schema: Json, is_required: bool) {
        self.properties.insert(key.to_owned(), schema);
        if is_required {
            self.required.push(key);
        }
    }

    /// The schema of a table that has these keys and no others.
    pub(crate) fn schema(&self) -> Json {
        json!({
            "type": "object",
            "properties": self.properties,
            "required": self.required,
            "additionalProperties": false
        })
    }

    /// Every form joined with every one of the others.
    pub(crate) fn product(forms: &[Self], others: &[Self]) -> Vec<Self> {
        let join = |form: &Self, other: &Self| {
            let mut joined = form.clone();
            joined.properties.extend(other.properties.clone());
            joined.required.extend(&other.required);
            joined
        };
        forms.iter().flat_map(|form| others.iter().map(move |other| join(form, other))).collect()
    }
}

/// Reads a table on one line with all its errors.
pub(crate) fn read<T: InlineTable>(node: &Node, name: &str, errors: &mut Errors) -> Option<T> {
    let Some(table) = node.table() else { return refuse_type(node, name, T::EXPECTED, errors) };
    let mut reader = Reader::new(name, table, errors);
    let value = T::read_keys(&mut reader, node.span);
    if let Some(value) = &value {
        value.check(name, &mut reader);
    }
    let sound = reader.is_sound();
    reader.finish();
    value.filter(|_| sound)
}

/// The canonical text of a table on one line.
pub(crate) fn write<T: InlineTable>(table: &T) -> String {
    let mut pairs = Vec::new();
    table.write_keys(&mut pairs);
    format!("{{ {} }}", pairs.join(", "))
}

/// The schema of a table on one line; `or` is what the key takes in place of a table.
pub(crate) fn schema<T: InlineTable>(or: Option<Json>) -> Json {
    let mut schemas: Vec<Json> =
        or.into_iter().chain(T::forms().iter().map(Form::schema)).collect();
    if schemas.len() == 1 { schemas.remove(0) } else { json!({ "anyOf": schemas }) }
}

/// The schema of the value of an optional key.
pub(crate) trait OptionalValue {
    /// The schema of the value inside.
    fn inner_schema() -> Json;
}

impl<T: TomlValue> OptionalValue for Option<T> {
    fn inner_schema() -> Json {
        T::schema()
    }
}

/// Defines a struct that is written as a table on one line. In brackets after the type: `[required]`; `[nonempty]`, a
/// required list; `[or DEFAULT]`, always written; `[optional]`, an `Option`; `[flatten]`, a table whose keys are listed
/// with the others. In `[flatten else STANDIN]` and `[required else STANDIN]`, STANDIN is a value that breaks no rule: where none can be read,
/// it takes its place while the rules for the other keys are checked.
macro_rules! inline_table {
    (
        $(#[$meta:meta])*
        $vis:vis struct $table:ident = $expected:literal $(with $rules:path)? {
            $($(#[$field_meta:meta])* $field:ident: $type:ty [$($kind:tt)+],)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        $vis struct $table {
            $($(#[$field_meta])* $vis $field: $type,)+
        }

        impl $crate::inline::InlineTable for $table {
            const EXPECTED: &'static str = $expected;

            fn read_keys(
                reader: &mut $crate::keys::Reader<'_>,
                _at: $crate::tree::Span,
            ) -> Option<Self> {
                $(let $field = $crate::inline::read_key!(reader, _at, $field, [$($kind)+]);)+
                Some(Self { $($field: $field?,)+ })
            }

            fn check(&self, _name: &str, _reader: &mut $crate::keys::Reader<'_>) {
                $($rules(self, _name, _reader);)?
            }

            fn write_keys(&self, pairs: &mut Vec<String>) {
                $($crate::inline::write_key!(pairs, $field, &self.$field, [$($kind)+]);)+
            }

            fn forms() -> Vec<$crate::inline::Form> {
                let mut forms = vec![$crate::inline::Form::default()];
                $($crate::inline::add_key!(forms, $field, $type, [$($kind)+]);)+
                forms
            }
        }

        impl $crate::value::TomlValue for $table {
            fn read(
                node: &$crate::tree::Node,
                name: &str,
                errors: &mut $crate::diagnostics::Errors,
            ) -> Option<Self> {
                $crate::inline::read(node, name, errors)
            }

            fn write(&self) -> String {
                $crate::inline::write(self)
            }

            fn schema() -> serde_json::Value {
                $crate::inline::schema::<Self>(None)
            }
        }
    };
}

/// Defines an enum whose variants are the forms that a table on one line may have: the first one of which a key is
/// present, else the first with a key that is like one of the table, else the first. The variant after `|` is a value that is not a table.
macro_rules! inline_enum {
    (
        $(#[$meta:meta])*
        $vis:vis enum $table:ident = $expected:literal $(with $rules:path)? {
            $($(#[$variant_meta:meta])* $variant:ident {
                $($(#[$field_meta:meta])* $field:ident: $type:ty [$($kind:tt)+],)+
            })+
            $(| $(#[$bare_meta:meta])* $bare:ident($bare_type:ty))?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $vis enum $table {
            $($(#[$bare_meta])* $bare($bare_type),)?
            $($(#[$variant_meta])* $variant { $($(#[$field_meta])* $field: $type,)+ },)+
        }

        impl $crate::inline::InlineTable for $table {
            const EXPECTED: &'static str = $expected;

            fn read_keys(
                reader: &mut $crate::keys::Reader<'_>,
                at: $crate::tree::Span,
            ) -> Option<Self> {
                let forms: &[&[&'static str]] = &[$(&[$(stringify!($field)),+]),+];
                let form = reader.form_among(forms)?;
                let mut number = 0..;
                $(if number.next() == Some(form) {
                    $(let $field = $crate::inline::read_key!(reader, at, $field, [$($kind)+]);)+
                    return Some(Self::$variant { $($field: $field?,)+ });
                })+
                None
            }

            fn check(&self, _name: &str, _reader: &mut $crate::keys::Reader<'_>) {
                $($rules(self, _name, _reader);)?
            }

            fn write_keys(&self, pairs: &mut Vec<String>) {
                match self {
                    $(Self::$bare(_) => {})?
                    $(Self::$variant { $($field),+ } => {
                        $($crate::inline::write_key!(pairs, $field, $field, [$($kind)+]);)+
                    })+
                }
            }

            fn forms() -> Vec<$crate::inline::Form> {
                vec![$({
                    let mut form = [$crate::inline::Form::default()];
                    $($crate::inline::add_key!(form, $field, $type, [$($kind)+]);)+
                    let [form] = form;
                    form
                }),+]
            }
        }
    };
}

/// Reads one key of a table on one line.
macro_rules! read_key {
    ($reader:ident, $at:ident, $field:ident, [or $default:expr]) => {
        Some($reader.maybe(stringify!($field)).unwrap_or(const { $default }))
    };
    ($reader:ident, $at:ident, $field:ident, [optional]) => {
        Some($reader.maybe(stringify!($field)))
    };
    ($reader:ident, $at:ident, $field:ident, [flatten]) => {
        $crate::inline::InlineTable::read_keys($reader, $at)
    };
    ($reader:ident, $at:ident, $field:ident, [flatten else $standin:expr]) => {
        Some($crate::inline::InlineTable::read_keys($reader, $at).unwrap_or(const { $standin }))
    };
    ($reader:ident, $at:ident, $field:ident, [required else $standin:expr]) => {
        Some($reader.required(stringify!($field), $at).unwrap_or(const { $standin }))
    };
    ($reader:ident, $at:ident, $field:ident, [$required:ident]) => {
        $reader.required(stringify!($field), $at)
    };
}

/// Writes one key of a table on one line.
macro_rules! write_key {
    ($pairs:ident, $field:ident, $value:expr, [flatten $(else $standin:expr)?]) => {
        $crate::inline::InlineTable::write_keys($value, $pairs)
    };
    ($pairs:ident, $field:ident, $value:expr, [optional]) => {
        if let Some(value) = $value {
            $crate::inline::write_key!($pairs, $field, value, [required]);
        }
    };
    ($pairs:ident, $field:ident, $value:expr, [$($kind:tt)+]) => {
        $pairs.push(format!("{} = {}", stringify!($field), $crate::value::TomlValue::write($value)))
    };
}

/// Adds one key to the forms of a table on one line.
macro_rules! add_key {
    ($forms:ident, $field:ident, $type:ty, [flatten $(else $standin:expr)?]) => {
        $forms =
            $crate::inline::Form::product(&$forms, &<$type as $crate::inline::InlineTable>::forms())
    };
    ($forms:ident, $field:ident, $type:ty, [optional]) => {
        for form in &mut $forms {
            let schema = <$type as $crate::inline::OptionalValue>::inner_schema();
            form.insert(stringify!($field), schema, false);
        }
    };
    ($forms:ident, $field:ident, $type:ty, [$kind:ident $($default:tt)*]) => {
        for form in &mut $forms {
            let mut schema = <$type as $crate::value::TomlValue>::schema();
            if stringify!($kind) == "nonempty" {
                schema["minItems"] = 1.into();
            }
            form.insert(stringify!($field), schema, stringify!($kind) != "or");
        }
    };
}

pub(crate) use {add_key, inline_enum, inline_table, read_key, write_key};
