//! The payload of a message that is recorded, and whether its memory may be used.

use std::ops::Deref;

/// The payload of a message.
pub(crate) enum Payload<'a> {
    /// One that is needed again.
    Kept(&'a [u8]),
    /// One that is not: a large one is compressed into its own memory, because a frame of 10^6 discs would need 40 MB more.
    Used(&'a mut [u8]),
}

impl Deref for Payload<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Kept(payload) => payload,
            Self::Used(payload) => payload,
        }
    }
}

impl<'a> From<&'a [u8]> for Payload<'a> {
    fn from(payload: &'a [u8]) -> Self {
        Self::Kept(payload)
    }
}

impl<'a> From<&'a mut [u8]> for Payload<'a> {
    fn from(payload: &'a mut [u8]) -> Self {
        Self::Used(payload)
    }
}
