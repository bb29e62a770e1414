//! Prefetching: memory is requested before it is read.

#![allow(unsafe_code)]

/// Requests the cache line of `values[index]`, or of the last value if the index is out of range. It has no branch,
/// because whether an index is in range cannot be predicted.
#[inline(always)]
pub(crate) fn prefetch<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: prefetching reads nothing and is allowed for any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let value = values.as_ptr().wrapping_add(index.min(values.len().wrapping_sub(1)));
        _mm_prefetch::<_MM_HINT_T0>(value.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

/// Requests the cache lines of `values[index]`, which is written next, or of the last value. A value takes at most two lines.
#[inline(always)]
pub(crate) fn prefetch_to_write<T>(values: &mut [T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: prefetching changes nothing and is allowed for any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_ET0, _mm_prefetch};
        let value = values.as_ptr().wrapping_add(index.min(values.len().wrapping_sub(1)));
        let first: *const i8 = value.cast();
        _mm_prefetch::<_MM_HINT_ET0>(first);
        _mm_prefetch::<_MM_HINT_ET0>(first.wrapping_add(size_of::<T>().saturating_sub(1)));
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}
