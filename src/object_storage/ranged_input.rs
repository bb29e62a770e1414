//! An object as an input with random access, fetched by byte ranges as it is read.

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

/// Size of the first range and of a range after a seek. The header of most recordings fits, and so does the footer with the
/// summary.
const SHORTEST: u64 = 256 << 10;
/// Maximum size of a range. Sequential reads double the size up to it, which bounds requests and memory.
const LONGEST: u64 = 4 << 20;

/// Reads an object by ranges. `fetch` returns the bytes of a non-empty range within the object.
pub struct RangedInput<F> {
    fetch: F,
    bytes: u64,
    position: u64,
    /// Bytes of the last range fetched.
    range: Vec<u8>,
    /// Position of its first byte.
    range_start: u64,
}

impl<F> fmt::Debug for RangedInput<F> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bytes, position, .. } = self;
        write!(formatter, "RangedInput at {position} of {bytes}")
    }
}

impl<F: FnMut(Range<u64>) -> io::Result<Vec<u8>>> RangedInput<F> {
    /// Creates an input for an object of `bytes` bytes, at its first byte.
    pub fn new(bytes: u64, fetch: F) -> Self {
        Self { fetch, bytes, position: 0, range: Vec::new(), range_start: 0 }
    }

    /// The bytes of the last range from the current position; empty if the position is outside the range.
    fn fetched(&self) -> &[u8] {
        let within =
            self.position.checked_sub(self.range_start).and_then(|at| usize::try_from(at).ok());
        within.and_then(|at| self.range.get(at..)).unwrap_or_default()
    }

    fn fetch_next(&mut self) -> io::Result<()> {
        let previous = self.range.len() as u64;
        let is_sequential = previous > 0 && self.position == self.range_start + previous;
        let length = if is_sequential { (2 * previous).clamp(SHORTEST, LONGEST) } else { SHORTEST };
        // A range at the end of the object starts early enough to have full length, because footers are read backward.
        let last_start = self.bytes.saturating_sub(length);
        let start = if is_sequential { self.position } else { self.position.min(last_start) };
        let range = start..(start + length).min(self.bytes);
        let requested = range.end - range.start;
        self.range = (self.fetch)(range)?;
        self.range_start = start;
        if self.range.len() as u64 != requested {
            let what =
                format!("expected {requested} bytes of the object, found {}", self.range.len());
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        Ok(())
    }
}

impl<F: FnMut(Range<u64>) -> io::Result<Vec<u8>>> Read for RangedInput<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() || self.position >= self.bytes {
            return Ok(0);
        }
        if self.fetched().is_empty() {
            self.fetch_next()?;
        }
        let fetched = self.fetched();
        let count = fetched.len().min(buffer.len());
        buffer[..count].copy_from_slice(&fetched[..count]);
        self.position += count as u64;
        Ok(count)
    }
}

impl<F> Seek for RangedInput<F> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::End(offset) => self.bytes.checked_add_signed(offset),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::{LONGEST, RangedInput, SHORTEST};
    use std::cell::RefCell;
    use std::io::{Read as _, Seek as _, SeekFrom};
    use std::ops::Range;

    fn object(bytes: u64) -> Vec<u8> {
        (0..bytes).map(|byte| (byte * 7 / 3) as u8).collect()
    }

    #[test]
    fn object_is_read_by_ranges() {
        let whole = object(3 * LONGEST + 5);
        let requests: RefCell<Vec<Range<u64>>> = RefCell::default();
        let mut input = RangedInput::new(whole.len() as u64, |range: Range<u64>| {
            requests.borrow_mut().push(range.clone());
            Ok(whole[range.start as usize..range.end as usize].to_vec())
        });
        let mut read = Vec::new();
        input.read_to_end(&mut read).unwrap();
        assert!(read == whole);
        let requests = requests.take();
        assert_eq!(requests[0], 0..SHORTEST);
        assert!(requests.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert!(
            requests.iter().all(|range| range.end - range.start <= LONGEST) && requests.len() < 9
        );
    }

    #[test]
    fn end_of_the_object_is_fetched_once() {
        let whole = object(2 * SHORTEST);
        let mut requests = 0;
        let mut input = RangedInput::new(whole.len() as u64, |range: Range<u64>| {
            requests += 1;
            Ok(whole[range.start as usize..range.end as usize].to_vec())
        });
        let mut four = [0; 4];
        for back in [8, 2000, 70_000] {
            input.seek(SeekFrom::End(-back)).unwrap();
            input.read_exact(&mut four).unwrap();
            let at = whole.len() - back as usize;
            assert_eq!(four, whole[at..at + 4]);
        }
        assert_eq!(input.seek(SeekFrom::Current(-4)).unwrap(), whole.len() as u64 - 70_000);
        assert!(input.seek(SeekFrom::Current(i64::MIN)).is_err());
        input.seek(SeekFrom::End(3)).unwrap();
        assert_eq!(input.read(&mut four).unwrap(), 0);
        assert_eq!(requests, 1);
    }

    #[test]
    fn short_range_is_an_error() {
        let mut input = RangedInput::new(100, |_| Ok(vec![0; 99]));
        let error = input.read(&mut [0; 4]).unwrap_err();
        assert!(
            error.to_string().contains("expected 100 bytes of the object, found 99"),
            "{error}"
        );
    }
}
