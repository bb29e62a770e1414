//! The seal of a bundle: the comment at the end of the ZIP file is the SHA-256 of all bytes before it, so that no bit of the file can
//! change unnoticed, neither in its contents nor between them.

use data_encoding::HEXLOWER;
use sha2::{Digest as _, Sha256};
use std::io::{self, Read, Write};

/// Length of the seal in bytes: 64 hexadecimal digits.
pub(super) const SEAL_BYTES: usize = 64;

/// A sink that seals what it receives: the last bytes are replaced by the hash of the others.
pub(super) struct Sealed<W> {
    sink: W,
    hash: Sha256,
    /// What may still be the place of the seal.
    last: Vec<u8>,
    /// After an error, which its caller receives, the rest is dropped: the library would print a second error when it ends.
    has_failed: bool,
}

impl<W: Write> Sealed<W> {
    pub(super) fn new(sink: W) -> Self {
        Self { sink, hash: Sha256::new(), last: Vec::new(), has_failed: false }
    }

    /// Writes the seal, and returns the sink.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.sink.write_all(HEXLOWER.encode(&self.hash.finalize()).as_bytes())?;
        self.sink.flush()?;
        Ok(self.sink)
    }
}

impl<W: Write> Write for Sealed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.has_failed {
            return Ok(bytes.len());
        }
        self.last.extend_from_slice(bytes);
        let complete = self.last.len().saturating_sub(SEAL_BYTES);
        self.hash.update(&self.last[..complete]);
        let written = self.sink.write_all(&self.last[..complete]);
        self.has_failed = written.is_err();
        self.last.drain(..complete);
        written.map(|()| bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

/// Whether a file of this size ends with its seal.
pub(super) fn is_intact(file: &mut impl Read, bytes: u64) -> io::Result<bool> {
    let Some(before) = bytes.checked_sub(SEAL_BYTES as u64) else { return Ok(false) };
    let mut hash = Sha256::new();
    let hashed = io::copy(&mut file.take(before), &mut Hasher(&mut hash))?;
    let mut seal = [0; SEAL_BYTES];
    file.read_exact(&mut seal)?;
    Ok(hashed == before && HEXLOWER.encode(&hash.finalize()).as_bytes() == seal)
}

/// A sink of bytes that are hashed.
pub(super) struct Hasher<'a>(pub(super) &'a mut Sha256);

impl Write for Hasher<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
