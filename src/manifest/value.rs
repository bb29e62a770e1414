//! The types of the manifest's values: each is read from TOML, written as canonical TOML and described in the schema.

use crate::diagnostics::{Diagnostic, Errors, nearest};
use crate::tree::{Node, Table, Value};
use serde_json::{Value as Json, json};
use std::num::{NonZeroU32, NonZeroU64};

/// A type of value in the manifest.
pub(crate) trait TomlValue: Sized {
    /// Reads the value of the key `name`, or reports why it cannot be.
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self>;

    /// The canonical TOML text: equal values have equal texts, and reading it gives the value back.
    fn write(&self) -> String;

    /// Type and range as JSON Schema keywords.
    fn schema() -> Json;
}

/// Reports a value that the key does not allow, and returns `None`. `expected` follows "must be".
pub(crate) fn refuse<T>(node: &Node, name: &str, expected: &str, errors: &mut Errors) -> Option<T> {
    let label = if number(node).is_some() { "out of range" } else { "wrong type" };
    refuse_with(node, name, expected, label, errors)
}

/// Reports a value of another type than the key takes, which may be a number, and returns `None`.
pub(crate) fn refuse_type<T>(
    node: &Node,
    name: &str,
    expected: &str,
    errors: &mut Errors,
) -> Option<T> {
    refuse_with(node, name, expected, "wrong type", errors)
}

fn refuse_with<T>(
    node: &Node,
    name: &str,
    expected: &str,
    label: &str,
    errors: &mut Errors,
) -> Option<T> {
    if errors.is_full() {
        errors.count();
        return None;
    }
    let found = match node.value {
        Value::Integer(integer) => integer.to_string(),
        Value::Float(number) => shortest(number).to_lowercase(),
        _ => node.what().to_owned(),
    };
    let title = format!("`{name}` is {found}; must be {expected}");
    errors.push(Diagnostic::new(title).at(node.span, label));
    None
}

/// The number, integer or not. May be infinite or NaN.
pub(crate) fn number(node: &Node) -> Option<f64> {
    match node.value {
        Value::Integer(integer) => Some(integer as f64),
        Value::Float(number) => Some(number),
        _ => None,
    }
}

/// The whole number, also where it is written as `1e3` or `20.0`.
pub(crate) fn whole_number(node: &Node) -> Option<i128> {
    /// Above it, not every whole number is an f64: `1e16` may be the rounded value of another.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match node.value {
        Value::Integer(integer) => Some(integer),
        Value::Float(x) if x.fract() == 0.0 && x.abs() <= EXACT => Some(x as i128),
        _ => None,
    }
}

/// A count that is written in the source.
///
/// # Panics
/// If it is zero.
pub(crate) const fn count(count: u32) -> NonZeroU32 {
    NonZeroU32::new(count).expect("not zero")
}

/// A finite number in the shortest decimal form that reads back to the same bits, with an exponent where it is long.
pub(crate) fn shortest(x: f64) -> String {
    // Debug and not Display: 1e-26, not 0.00000000000000000000000001. Pinned by a test.
    format!("{x:?}")
}

/// A TOML basic string.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for character in text.chars() {
        match character {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            control if control.is_control() => {
                quoted.push_str(&format!("\\u{:04X}", u32::from(control)));
            }
            other => quoted.push(other),
        }
    }
    quoted.push('"');
    quoted
}

/// Reads whole numbers: each line gives a type, its range, and the type that converts to it.
macro_rules! whole_values {
    ($($name:ty: $minimum:literal..=$maximum:literal, through $bits:ty);* $(;)?) => {$(
        impl TomlValue for $name {
            fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
                let range = concat!("a whole number from ", $minimum, " to ", $maximum);
                whole_number(node)
                    .filter(|whole| ($minimum..=$maximum).contains(whole))
                    .and_then(|whole| <$bits>::try_from(whole).ok())
                    .and_then(|whole| Self::try_from(whole).ok())
                    .or_else(|| refuse(node, name, range, errors))
            }

            fn write(&self) -> String {
                self.to_string()
            }

            fn schema() -> Json {
                json!({ "type": "integer", "minimum": $minimum as u64, "maximum": $maximum as u64 })
            }
        }
    )*};
}
whole_values!(
    u32: 0..=4_294_967_295, through u32;
    u64: 0..=18_446_744_073_709_551_615, through u64;
    NonZeroU32: 1..=4_294_967_295, through u32;
    NonZeroU64: 1..=18_446_744_073_709_551_615, through u64;
);

/// A whole number from 1 to a maximum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count<const MAXIMUM: u32>(u32);

/// Number of replicates of an experiment.
pub(crate) type ReplicateCount = Count<100_000>;
/// Frames per decade of time, steps or collisions.
pub type FramesPerDecade = Count<1000>;
/// Decades that a run's frames reach back from its end; with a thousand frames per decade, the list is still short.
pub type Decades = Count<15>;

impl<const MAXIMUM: u32> Count<MAXIMUM> {
    /// The number, at least 1.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl<const MAXIMUM: u32> TryFrom<u32> for Count<MAXIMUM> {
    type Error = ();

    fn try_from(count: u32) -> Result<Self, ()> {
        if (1..=MAXIMUM).contains(&count) { Ok(Self(count)) } else { Err(()) }
    }
}

impl<const MAXIMUM: u32> TomlValue for Count<MAXIMUM> {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        let count = whole_number(node).and_then(|whole| u32::try_from(whole).ok());
        count
            .and_then(|count| Self::try_from(count).ok())
            .or_else(|| refuse(node, name, &format!("a whole number from 1 to {MAXIMUM}"), errors))
    }

    fn write(&self) -> String {
        self.0.to_string()
    }

    fn schema() -> Json {
        json!({ "type": "integer", "minimum": 1, "maximum": MAXIMUM })
    }
}

impl Decades {
    /// Three decades, the default.
    pub(crate) const DEFAULT: Self = Self(3);
}

impl TomlValue for bool {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        match node.value {
            Value::Boolean(value) => Some(value),
            _ => refuse_type(node, name, "true or false", errors),
        }
    }

    fn write(&self) -> String {
        self.to_string()
    }

    fn schema() -> Json {
        json!({ "type": "boolean" })
    }
}

impl TomlValue for String {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        match &node.value {
            Value::Text(text) => Some(text.clone()),
            _ => refuse_type(node, name, "a string", errors),
        }
    }

    fn write(&self) -> String {
        quoted(self)
    }

    fn schema() -> Json {
        json!({ "type": "string" })
    }
}

impl<T: TomlValue, const N: usize> TomlValue for [T; N] {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        let Value::Array(elements) = &node.value else {
            return refuse_type(node, name, &format!("an array of {N} numbers"), errors);
        };
        if elements.len() != N {
            let title = format!("`{name}` has {} elements", elements.len());
            let label = format!("must be an array of {N} numbers");
            errors.push(Diagnostic::new(title).at(node.span, label));
            return None;
        }
        // Every element is read, so that all errors are reported at once.
        let read: Vec<_> = elements.iter().map(|element| T::read(element, name, errors)).collect();
        read.into_iter().collect::<Option<Vec<_>>>()?.try_into().ok()
    }

    fn write(&self) -> String {
        list(self)
    }

    fn schema() -> Json {
        json!({ "type": "array", "items": T::schema(), "minItems": N, "maxItems": N })
    }
}

impl<T: TomlValue> TomlValue for Vec<T> {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        let Value::Array(elements) = &node.value else {
            return refuse_type(node, name, "an array", errors);
        };
        // Every element is read, so that all errors are reported at once.
        let elements = elements.iter().enumerate();
        let read: Vec<_> =
            elements.map(|(index, element)| read_element(element, name, index, errors)).collect();
        read.into_iter().collect()
    }

    fn write(&self) -> String {
        list(self)
    }

    fn schema() -> Json {
        json!({ "type": "array", "items": T::schema() })
    }
}

/// Reads an element of a list. Its errors name its index, counted from 0. Names are written only then: a list may hold a million elements.
fn read_element<T: TomlValue>(
    element: &Node,
    name: &str,
    index: usize,
    errors: &mut Errors,
) -> Option<T> {
    if errors.is_full() {
        return T::read(element, name, errors);
    }
    let mut own = Errors::default();
    let read = T::read(element, name, &mut own);
    if !own.is_empty() {
        T::read(element, &format!("{name}[{index}]"), errors);
    }
    read
}

/// The tables of an array of tables. Reports any other value: `expected` is what the key and what an element takes.
pub(crate) fn tables<'a>(
    node: &'a Node,
    name: &str,
    [expected, element_expected]: [&str; 2],
    errors: &mut Errors,
) -> Vec<(&'a Node, &'a Table)> {
    let Value::Array(elements) = &node.value else {
        return refuse_type(node, name, expected, errors).unwrap_or_default();
    };
    let mut table = |element: &'a Node| match element.table() {
        Some(table) => Some((element, table)),
        None => refuse_type(element, name, element_expected, errors),
    };
    elements.iter().filter_map(&mut table).collect()
}

fn list<T: TomlValue>(elements: &[T]) -> String {
    let elements: Vec<String> = elements.iter().map(TomlValue::write).collect();
    format!("[{}]", elements.join(", "))
}

/// Reads one of a fixed set of words and reports any other with the nearest of them. `or` is what else the key allows.
pub(crate) fn word<T: Clone>(
    node: &Node,
    name: &str,
    words: &[(&str, T)],
    or: &str,
    errors: &mut Errors,
) -> Option<T> {
    let known: Vec<String> = words.iter().map(|(word, _)| format!("\"{word}\"")).collect();
    let known = known.join(", ") + or;
    let Value::Text(text) = &node.value else {
        return refuse_type(node, name, &format!("one of {known}"), errors);
    };
    if let Some((_, value)) = words.iter().find(|(word, _)| word == text) {
        return Some(value.clone());
    }
    if errors.is_full() {
        errors.count();
        return None;
    }
    let is_known = |meant: &&str| words.iter().any(|(word, _)| word == meant);
    let other_name = OTHER_NAMES.iter().find(|(other, _)| *other == text.to_lowercase());
    let meant = other_name.map(|(_, word)| *word).filter(is_known);
    let label = match meant.or_else(|| nearest(text, words.iter().map(|(word, _)| *word))) {
        Some(meant) => format!("did you mean \"{meant}\"? Must be one of {known}"),
        None => format!("must be one of {known}"),
    };
    let title = format!("unknown value {} for `{name}`", quoted(text));
    errors.push(Diagnostic::new(title).at(node.span, label));
    None
}

/// Other names of values, as textbooks have them.
const OTHER_NAMES: &[(&str, &str)] = &[
    ("leapfrog", "velocity-verlet"),
    ("symplectic-euler", "semi-implicit-euler"),
    ("runge-kutta", "rk4"),
];

/// Defines an enum of words: each variant with its word in the manifest and its doc comment.
macro_rules! words {
    (
        $(#[$meta:meta])*
        $vis:vis enum $type:ident {
            $($(#[$variant_meta:meta])* $variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $type {
            $($(#[$variant_meta])* $variant,)+
        }

        impl $type {
            const WORDS: &'static [(&'static str, Self)] = &[$(($word, Self::$variant)),+];

            /// The word in the manifest.
            #[must_use]
            $vis fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word),+
                }
            }
        }

        impl $crate::value::TomlValue for $type {
            fn read(
                node: &$crate::tree::Node,
                name: &str,
                errors: &mut $crate::diagnostics::Errors,
            ) -> Option<Self> {
                $crate::value::word(node, name, Self::WORDS, "", errors)
            }

            fn write(&self) -> String {
                $crate::value::quoted(self.word())
            }

            fn schema() -> serde_json::Value {
                serde_json::json!({ "enum": [$($word),+] })
            }
        }
    };
}
pub(crate) use words;
