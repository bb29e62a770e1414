//! The sink of the container's bytes, which counts them and joins small writes.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of small writes that are joined: the container's writer passes each number of an index in a write of its own. A
/// recording without data has some 20 KB.
const JOINED_BYTES: usize = 32 << 10;

/// A sink that only grows at its end and knows its length. Bytes reach the sink inside it at the latest at a flush.
pub(crate) struct CountingSink<W: Write> {
    inner: BufWriter<W>,
    written: Arc<AtomicU64>,
}

impl<W: Write> CountingSink<W> {
    pub(crate) fn new(inner: W, written: Arc<AtomicU64>) -> Self {
        Self { inner: BufWriter::with_capacity(JOINED_BYTES, inner), written }
    }

    /// The sink inside it, which has received all bytes.
    pub(crate) fn into_inner(mut self) -> io::Result<W> {
        self.inner.flush()?;
        Ok(self.inner.into_parts().0)
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

impl<W: Write> Seek for CountingSink<W> {
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
