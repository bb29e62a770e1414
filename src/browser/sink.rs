//! Where the bytes of a recording go in a page.

use std::io::{self, Write};

/// Keeps the bytes of a recording up to a limit, or none of them.
#[derive(Debug, Default)]
pub(crate) struct Sink {
    bytes: Vec<u8>,
    limit: usize,
}

impl Sink {
    /// A sink for a run whose messages are only compared.
    pub(crate) fn empty() -> Self {
        Self::default()
    }

    /// A sink that keeps at most so many bytes.
    pub(crate) fn of(limit: usize) -> Self {
        Self { bytes: Vec::new(), limit }
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.limit == 0 {
            return Ok(bytes.len());
        }
        if self.limit - self.bytes.len() < bytes.len()
            || self.bytes.try_reserve(bytes.len()).is_err()
        {
            let megabytes = self.limit >> 20;
            let what = format!("the recording exceeds the {megabytes} MB that a page keeps");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
