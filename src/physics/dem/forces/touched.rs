//! The discs of a block that something touches, where they were noted.

use crate::dem::neighbors::BLOCK;

const WORDS: usize = BLOCK.div_ceil(64);

/// A set of discs of a block, a bit each.
#[derive(Clone, Debug)]
pub(in crate::dem) struct Touched {
    bits: [u64; WORDS],
    /// Whether all were noted.
    is_complete: bool,
}

impl Default for Touched {
    fn default() -> Self {
        Self { bits: [0; WORDS], is_complete: false }
    }
}

impl Touched {
    /// Nobody was noted.
    pub(in crate::dem) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes note that all who are touched by discs of the block have been noted.
    pub(in crate::dem) fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Notes a disc, counted from the block's first.
    #[inline]
    pub(in crate::dem) fn note(&mut self, disc: u32) {
        self.bits[disc as usize / 64] |= 1 << (disc % 64);
    }

    /// Whether all were noted, and are few of so many.
    pub(in crate::dem) fn are_few(&self, discs: usize) -> bool {
        let noted: u32 = self.bits.iter().map(|word| word.count_ones()).sum();
        self.is_complete && 4 * (noted as usize) < discs
    }

    /// The discs in order.
    pub(in crate::dem) fn all(&self) -> impl Iterator<Item = usize> {
        self.bits.iter().enumerate().flat_map(|(number, &word)| {
            let mut left = word;
            std::iter::from_fn(move || {
                let disc = number * 64 + left.trailing_zeros() as usize;
                let found = (left != 0).then_some(disc);
                left &= left.wrapping_sub(1);
                found
            })
        })
    }
}
