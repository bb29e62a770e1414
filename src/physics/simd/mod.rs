//! Wide instructions: chosen at run time, with the same bits at every width.

pub mod dispatch;
pub(crate) mod registers;
