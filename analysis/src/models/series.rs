//! Series of bounded length.

/// Entries over time with bounded length. When the series is full, every second entry is removed and the sampling
/// interval doubles. The last entry is always kept.
#[derive(Clone, Debug)]
pub(crate) struct Series<T> {
    entries: Vec<T>,
    last: Option<T>,
    stride: u64,
    seen: u64,
}

impl<T> Default for Series<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), last: None, stride: 1, seen: 0 }
    }
}

impl<T> Series<T> {
    const MAX_LENGTH: usize = 4096;

    /// Adds the next entry.
    pub(crate) fn add(&mut self, entry: T) {
        if self.seen.is_multiple_of(self.stride) && self.entries.len() == Self::MAX_LENGTH {
            let mut index = 0;
            self.entries.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
        if self.seen.is_multiple_of(self.stride) {
            self.entries.push(entry);
            self.last = None;
        } else {
            self.last = Some(entry);
        }
        self.seen += 1;
    }

    /// The kept entries, in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.entries.iter().chain(&self.last)
    }

    /// The first entry.
    pub(crate) fn first(&self) -> Option<&T> {
        self.entries.first()
    }

    /// The last entry.
    pub(crate) fn last(&self) -> Option<&T> {
        self.last.as_ref().or(self.entries.last())
    }

    /// The first and the last entry.
    pub(crate) fn ends(&self) -> impl Iterator<Item = &T> {
        self.first().into_iter().chain(self.last())
    }

    /// Whether there are no entries.
    pub(crate) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Number of kept entries.
    pub(crate) fn len(&self) -> usize {
        self.entries.len() + usize::from(self.last.is_some())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_series_is_thinned_evenly_and_keeps_its_ends() {
        let mut series = Series::default();
        for entry in 0..100_001 {
            series.add(entry);
        }
        let kept: Vec<i32> = series.iter().copied().collect();
        assert!((1024..=4097).contains(&kept.len()) && kept.len() == series.len());
        let step = kept[1] - kept[0];
        assert!(kept[..kept.len() - 1].windows(2).all(|pair| pair[1] - pair[0] == step));
        assert_eq!((kept[0], series.last()), (0, Some(&100_000)));
    }
}
