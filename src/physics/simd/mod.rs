//! Wide instructions: chosen at run time, with the same bits at every width.

pub mod dispatch;
#[cfg(target_arch = "x86_64")]
pub(crate) mod f64x8;
pub(crate) mod instruction_set;
pub(crate) mod prefetch;
pub mod real;
