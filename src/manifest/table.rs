//! Macros that generate a table of the manifest from one line per key.

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
        pub enum $choice:ident {
            $($(#[doc = $about:literal])* $key:ident: $variant:ident($type:ty) [$unit:literal],)+
            $(| $(#[$bare_meta:meta])* $bare:ident,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum $choice {
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
