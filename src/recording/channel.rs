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
