//! The checksum of a table: the SHA-256 of all its other bytes, between its columns and its footer. Readers of Parquet find the footer from
//! the end of the file and the columns from the footer, so that they skip it.

use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Read as _, Seek as _, Write};

/// Bytes of the checksum.
const SUM_BYTES: usize = 32;
/// Bytes after the footer: its length, and the mark of the format.
const TAIL_BYTES: usize = 8;

/// The mark of the format.
const MARK: [u8; 4] = *b"PAR1";

/// The place of the footer in a table of this length with these last bytes; `None` for another file, of which no more is read.
fn footer_start(bytes: u64, tail: [u8; TAIL_BYTES]) -> Option<u64> {
    let [a, b, c, d, mark @ ..] = tail;
    if mark != MARK {
        return None;
    }
    bytes.checked_sub(u64::from(u32::from_le_bytes([a, b, c, d])) + TAIL_BYTES as u64)
}

/// A table that is written with its checksum, of which only the footer is kept in memory.
pub(super) struct Sealing<W> {
    output: W,
    hash: Sha256,
    /// What follows the columns, from the call of `begin_footer` on.
    footer: Option<Vec<u8>>,
}

impl<W: Write> Sealing<W> {
    pub(super) fn new(output: W) -> Self {
        Self { output, hash: Sha256::new(), footer: None }
    }

    /// Keeps what is written from now on until the end is known.
    pub(super) fn begin_footer(&mut self) {
        self.footer.get_or_insert_default();
    }

    /// Writes the checksum and the footer, and returns the output.
    ///
    /// # Errors
    /// An output that cannot be written.
    pub(super) fn finish(mut self) -> io::Result<W> {
        let rest = self.footer.unwrap_or_default();
        self.hash.update(&rest);
        let tail = rest.last_chunk().copied();
        let at = tail.and_then(|tail| footer_start(rest.len() as u64, tail));
        let (index, footer) = rest.split_at(at.map_or(0, |at| at as usize));
        for part in [index, &self.hash.finalize(), footer] {
            self.output.write_all(part)?;
        }
        Ok(self.output)
    }
}

impl<W: Write> Write for Sealing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(footer) = &mut self.footer {
            footer.extend_from_slice(bytes);
            return Ok(bytes.len());
        }
        let written = self.output.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

/// Checks all bytes of a table, before any of them is decoded, and returns to its beginning.
///
/// # Errors
/// A file that cannot be read, and `InvalidData` for one that has changed since it was written.
pub(super) fn check(mut file: &File) -> io::Result<()> {
    let changed = || io::Error::new(io::ErrorKind::InvalidData, "its checksum is wrong");
    let bytes = file.metadata()?.len();
    let mut tail = [0; TAIL_BYTES];
    let end = bytes.checked_sub(TAIL_BYTES as u64).ok_or_else(changed)?;
    file.seek(io::SeekFrom::Start(end))?;
    file.read_exact(&mut tail)?;
    let footer = footer_start(bytes, tail).ok_or_else(changed)?;
    let mut left = footer.checked_sub(SUM_BYTES as u64).ok_or_else(changed)?;
    file.rewind()?;
    let (mut hash, mut sum, mut buffer) = (Sha256::new(), [0; SUM_BYTES], vec![0; 1 << 16]);
    for part in 0..2 {
        while left > 0 {
            let most = usize::try_from(left).map_or(buffer.len(), |left| left.min(buffer.len()));
            file.read_exact(&mut buffer[..most])?;
            hash.update(&buffer[..most]);
            left -= most as u64;
        }
        if part == 0 {
            file.read_exact(&mut sum)?;
            left = bytes - footer;
        }
    }
    file.rewind()?;
    if hash.finalize().as_slice() == sum { Ok(()) } else { Err(changed()) }
}

#[cfg(test)]
mod tests {
    use super::footer_start;

    /// A sparse file of 50 GB is no table before its bytes are read. Control: the mark of a table.
    #[test]
    fn other_files_have_no_footer() {
        assert_eq!(footer_start(50 << 30, [0; 8]), None);
        assert_eq!(footer_start(100, [12, 0, 0, 0, b'P', b'A', b'R', b'1']), Some(80));
        assert_eq!(footer_start(10, [12, 0, 0, 0, b'P', b'A', b'R', b'1']), None);
    }
}
