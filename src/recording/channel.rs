//! A channel: the message of a topic, and its declaration by a model.

use crate::channel_field::Field;
use prost::Message;

/// A message with a fixed topic and schema.
pub trait Channel: Message + Clone + Default + 'static {
    /// The topic, with its leading slash.
    const TOPIC: &'static str;
    /// The schema's full name.
    const SCHEMA: &'static str;
    /// The fields, in tag order.
    const FIELDS: &'static [Field];

    /// Whether all series of the message have the same length: they are the columns of one table.
    fn has_equal_columns(&self) -> bool;
    /// The message with the bits of `f64::NAN` in place of those of every other NaN, if it has one.
    fn with_canonical_nan(&self) -> Option<Self>;
}

/// A channel as a model declares it, without its Rust type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelDeclaration {
    /// The topic, with its leading slash.
    pub topic: &'static str,
    /// The schema's full name.
    pub schema: &'static str,
    /// The fields, in tag order.
    pub fields: &'static [Field],
    /// Recorded only when the manifest names it.
    pub opt_in: bool,
}

impl ChannelDeclaration {
    /// A channel that is recorded unless the manifest leaves it out.
    #[must_use]
    pub const fn of<C: Channel>() -> Self {
        Self { topic: C::TOPIC, schema: C::SCHEMA, fields: C::FIELDS, opt_in: false }
    }

    /// A channel that is recorded only when the manifest names it.
    #[must_use]
    pub const fn opt_in<C: Channel>() -> Self {
        Self { opt_in: true, ..Self::of::<C>() }
    }
}

/// Declares messages: each topic with its schema and its fields.
macro_rules! channels {
    ($($(#[$doc:meta])* $name:ident on $topic:literal {
        $($(#[$field_doc:meta])* $field:ident: $type:ty [$($kind:tt)+] = $tag:tt,)+
    })+) => {
        $(
            $(#[$doc])*
            #[derive(Clone, PartialEq, prost::Message)]
            pub struct $name {
                $($(#[$field_doc])* #[prost($($kind)+, tag = $tag)] pub $field: $type,)+
            }

            impl Channel for $name {
                const TOPIC: &'static str = $topic;
                const SCHEMA: &'static str = concat!("kinetoscope.", stringify!($name));
                const FIELDS: &'static [Field] = &[
                    $(Field { name: stringify!($field), kind: stringify!($($kind)+), tag: $tag },)+
                ];

                fn has_equal_columns(&self) -> bool {
                    let mut lengths = [$(self.$field.length()),+].into_iter().flatten();
                    let first = lengths.next();
                    lengths.all(|length| Some(length) == first)
                }

                fn with_canonical_nan(&self) -> Option<Self> {
                    let is_other = false $(|| self.$field.has_other_nan())+;
                    let mut message = is_other.then(|| self.clone())?;
                    $(message.$field.make_nan_canonical();)+
                    Some(message)
                }
            }
        )+

        /// Every channel of ours, in the order of this file.
        pub const ALL: &[ChannelDeclaration] = &[$(ChannelDeclaration::of::<$name>(),)+];
    };
}
pub(crate) use channels;
