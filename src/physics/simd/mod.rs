//! SIMD instructions, chosen at run time, with the same bits at every width.

pub(crate) mod aligned_rows;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod dispatch;
#[cfg(target_arch = "x86_64")]
pub(crate) mod f64x8;
pub(crate) mod instruction_set;
pub(crate) mod prefetch;
pub mod real;
pub(crate) mod registers;
