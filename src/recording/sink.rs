//! The sink of the container's bytes, which counts them.

use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A sink that only grows at its end and knows its length.
pub(crate) struct CountingSink<W> {
    inner: W,
    written: Arc<AtomicU64>,
}

impl<W> CountingSink<W> {
    pub(crate) fn new(inner: W, written: Arc<AtomicU64>) -> Self {
        Self { inner, written }
    }

    pub(crate) fn into_inner(self) -> W {
        self.inner
    }
}

impl<W: Write> Write for CountingSink<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.written.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W> Seek for CountingSink<W> {
    /// Tells the position, which is all that the container's writer asks for.
    fn seek(&mut self, target: SeekFrom) -> io::Result<u64> {
        match target {
            SeekFrom::Current(0) => Ok(self.written.load(Ordering::Relaxed)),
            _ => {
                Err(io::Error::new(io::ErrorKind::Unsupported, "a recording only grows at its end"))
            }
        }
    }
}
