//! Large memory pages for arrays that are read in random order.

#![allow(unsafe_code)]

/// Size of a large page.
#[cfg(target_os = "linux")]
const LARGE_PAGE: usize = 2 << 20;

/// Creates an empty vector with this capacity, in large pages where the system has them. Neighboring particles may be
/// anywhere in memory; with small pages, nearly each access would miss the translation lookaside buffer.
pub(crate) fn with_large_pages<T>(capacity: usize) -> Vec<T> {
    let vector: Vec<T> = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        let begin = vector.as_ptr().addr();
        let end = begin + vector.capacity() * size_of::<T>();
        let (first, last) = (begin.next_multiple_of(LARGE_PAGE), end / LARGE_PAGE * LARGE_PAGE);
        if first < last {
            let pages = vector.as_ptr().cast::<u8>().wrapping_add(first - begin);
            // SAFETY: the advice changes no value, and the range belongs to this vector only. The system may ignore it.
            let _ = unsafe {
                libc::madvise(pages.cast_mut().cast(), last - first, libc::MADV_HUGEPAGE)
            };
        }
    }
    vector
}
