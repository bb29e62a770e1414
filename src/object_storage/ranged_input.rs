//! An object as an input with random access: a range is fetched when its bytes are read.

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

/// The first range, and the one after a leap: a recording's head, or its footer and summary, mostly fit in.
const SHORTEST: u64 = 256 << 10;
/// Ranges double up to here while they are read one after the other: few requests, little memory.
const LONGEST: u64 = 4 << 20;

/// Reads an object by ranges. `fetch` gives the bytes of a range that is not empty and not beyond the object's end.
pub struct RangedInput<F> {
    fetch: F,
    bytes: u64,
    position: u64,
    /// What was fetched last, and where it begins.
    range: Vec<u8>,
    begins: u64,
}

impl<F> fmt::Debug for RangedInput<F> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bytes, position, .. } = self;
        write!(formatter, "RangedInput at {position} of {bytes}")
    }
}

impl<F: FnMut(Range<u64>) -> io::Result<Vec<u8>>> RangedInput<F> {
    /// An object of so many bytes, from its first one on.
    pub fn new(bytes: u64, fetch: F) -> Self {
        Self { fetch, bytes, position: 0, range: Vec::new(), begins: 0 }
    }

    /// The part of the last range from the position on; empty where the position lies outside of it.
    fn at_hand(&self) -> &[u8] {
        let within = self.position.checked_sub(self.begins).and_then(|at| usize::try_from(at).ok());
        within.and_then(|at| self.range.get(at..)).unwrap_or_default()
    }

    fn fetch_from_here(&mut self) -> io::Result<()> {
        let had = self.range.len() as u64;
        let goes_on = had > 0 && self.position == self.begins + had;
        let length = if goes_on { (2 * had).clamp(SHORTEST, LONGEST) } else { SHORTEST };
        // What is near the end is fetched with all that precedes it in a range: footers are read backwards.
        let last_begin = self.bytes.saturating_sub(length);
        let begins = if goes_on { self.position } else { self.position.min(last_begin) };
        let range = begins..(begins + length).min(self.bytes);
        let wanted = range.end - range.start;
        self.range = (self.fetch)(range)?;
        self.begins = begins;
        if self.range.len() as u64 != wanted {
            let what = format!("{} bytes came where {wanted} were asked for", self.range.len());
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
        if self.at_hand().is_empty() {
            self.fetch_from_here()?;
        }
        let at_hand = self.at_hand();
        let count = at_hand.len().min(buffer.len());
        buffer[..count].copy_from_slice(&at_hand[..count]);
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
    fn reading_by_ranges_gives_the_object() {
        let whole = object(3 * LONGEST + 5);
        let asked: RefCell<Vec<Range<u64>>> = RefCell::default();
        let mut input = RangedInput::new(whole.len() as u64, |range: Range<u64>| {
            asked.borrow_mut().push(range.clone());
            Ok(whole[range.start as usize..range.end as usize].to_vec())
        });
        let mut read = Vec::new();
        input.read_to_end(&mut read).unwrap();
        assert!(read == whole);
        let asked = asked.take();
        assert_eq!(asked[0], 0..SHORTEST);
        assert!(asked.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert!(asked.iter().all(|range| range.end - range.start <= LONGEST) && asked.len() < 9);
    }

    #[test]
    fn the_end_is_fetched_once() {
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
    fn a_range_that_is_too_short_is_an_error() {
        let mut input = RangedInput::new(100, |_| Ok(vec![0; 99]));
        let error = input.read(&mut [0; 4]).unwrap_err();
        assert!(error.to_string().contains("99 bytes came where 100 were asked for"), "{error}");
    }
}
