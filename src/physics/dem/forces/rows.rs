//! Rows of four numbers at addresses that are multiples of 32: no row lies across two cache lines.
//!
//! Where memory begins at a multiple of 16, as allocators give it, every other row does, and each look at it costs two:
//! settled beds are 1.09, beds with friction 1.03 faster with this than with memory at an odd multiple of 16.
//!
//! What the unsafe code keeps to: an `Aligned` is four f64 and nothing else, 32 bytes of size and of alignment (checked where
//! it is defined), so that rows of it are rows of `[f64; 4]`, and any bits are a row.

#![allow(unsafe_code)]

use bytemuck::{Pod, Zeroable};
use std::ops::{Deref, DerefMut};

/// A row, aligned to its size.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
struct Aligned([f64; 4]);

const _: () = assert!(size_of::<Aligned>() == size_of::<[f64; 4]>());

// SAFETY: four f64 without padding, see the head of the file; all bits zero are four zeros.
unsafe impl Zeroable for Aligned {}
// SAFETY: four f64 without padding, see the head of the file; any bits are four f64.
unsafe impl Pod for Aligned {}

/// Rows of four numbers, aligned; used as `[[f64; 4]]`.
#[derive(Clone, Debug, Default)]
pub(in crate::dem) struct Rows(Vec<Aligned>);

impl Rows {
    /// Makes it so many rows of zeros.
    pub(in crate::dem) fn clear_to(&mut self, rows: usize) {
        self.0.clear();
        self.0.resize(rows, Aligned::default());
    }
}

impl Deref for Rows {
    type Target = [[f64; 4]];

    fn deref(&self) -> &[[f64; 4]] {
        bytemuck::cast_slice(&self.0)
    }
}

impl DerefMut for Rows {
    fn deref_mut(&mut self) -> &mut [[f64; 4]] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}

impl<'a> IntoIterator for &'a Rows {
    type Item = &'a [f64; 4];
    type IntoIter = std::slice::Iter<'a, [f64; 4]>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
