//! The journal of a sweep whose recordings are not kept: one file with the rows of its finished runs, as they finish.
//!
//! Each row is preceded by its length and the first bytes of its SHA-256. A torn end, which a kill leaves, is cut off when the file is
//! opened again.

use kinetoscope_analysis::RunRow;
use kinetoscope_files::regular_file::{open, open_or_create};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, Read, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The first bytes of a journal, with the version of its layout.
const MAGIC: &[u8; 8] = b"KSROWS01";
/// Bytes of a row's checksum.
const SUM_BYTES: usize = 8;
/// Maximum length of a row: some hundred metrics.
const MOST_ROW_BYTES: u32 = 1 << 20;
/// Bytes that are read at once.
const READ_AT_ONCE: usize = 1 << 18;
/// Rows and time after which the file is synced.
const ROWS_PER_SYNC: usize = 4096;
pub(crate) const BETWEEN_SYNCS: Duration = Duration::from_secs(1);

/// The place of a row in a journal, in bytes.
pub(crate) type PlaceOfRow = u64;

/// A journal that is written.
#[derive(Debug)]
pub(crate) struct Journal {
    file: File,
    path: PathBuf,
    /// The length of the file with the rows that are not written yet.
    end: PlaceOfRow,
    /// Bytes of rows that are not written yet.
    waiting: Vec<u8>,
    rows: usize,
    synced: Instant,
}

impl Journal {
    /// Opens the journal in a folder, locks it, cuts off a torn end, and calls `each` with its rows and their places.
    ///
    /// # Errors
    /// A file that cannot be read or written, is no journal, or is locked by another process.
    pub(crate) fn open(path: &Path, each: impl FnMut(&RunRow, PlaceOfRow)) -> io::Result<Self> {
        let (mut file, _) = open_or_create(path)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(io::Error::new(io::ErrorKind::WouldBlock, "another program writes it"));
            }
            // Some network file systems have no locks.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        let mut end = read(&file, each)?;
        file.set_len(end)?;
        file.seek(SeekFrom::Start(end))?;
        if end == 0 {
            file.write_all(MAGIC)?;
            end = MAGIC.len() as u64;
        }
        let (path, waiting, synced) = (path.to_owned(), Vec::new(), Instant::now());
        Ok(Self { file, path, end, waiting, rows: 0, synced })
    }

    /// Appends a row, syncs the file if it is time to, and returns the row's place.
    ///
    /// # Errors
    /// A disk that fails.
    pub(crate) fn append(&mut self, row: &RunRow) -> io::Result<PlaceOfRow> {
        let bytes = row.to_bytes().map_err(io::Error::other)?;
        let length = u32::try_from(bytes.len()).map_err(io::Error::other)?;
        self.waiting.extend_from_slice(&length.to_le_bytes());
        self.waiting.extend_from_slice(&Sha256::digest(&bytes)[..SUM_BYTES]);
        self.waiting.extend_from_slice(&bytes);
        self.rows += 1;
        if self.rows >= ROWS_PER_SYNC || self.synced.elapsed() >= BETWEEN_SYNCS {
            self.sync()?;
        }
        let place = self.end;
        self.end += u64::from(length) + 4 + SUM_BYTES as u64;
        Ok(place)
    }

    /// The rows at these places, which must be synced.
    ///
    /// # Errors
    /// A disk that fails.
    pub(crate) fn rows_at(
        &self,
        places: impl Iterator<Item = PlaceOfRow>,
    ) -> io::Result<Vec<RunRow>> {
        let damaged = || io::Error::other("a row of the journal is damaged");
        let mut input = BufReader::with_capacity(READ_AT_ONCE, &self.file);
        input.rewind()?;
        let mut at: PlaceOfRow = 0;
        // Rows of neighboring runs are near each other, mostly within what was read at once.
        let record = |place: PlaceOfRow| {
            input.seek_relative(place.cast_signed() - at.cast_signed())?;
            let record = read_record(&mut input)?.ok_or_else(damaged)?;
            at = place + record.length_in_file();
            Ok(record)
        };
        let records = places.map(record).collect::<io::Result<Vec<Record>>>()?;
        records.par_iter().map(|record| record.row().ok_or_else(damaged)).collect()
    }

    /// Writes what is waiting to the disk.
    ///
    /// # Errors
    /// A disk that fails.
    pub(crate) fn sync(&mut self) -> io::Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        // A row may have been read since.
        self.file.seek(SeekFrom::End(0))?;
        self.file.write_all(&self.waiting)?;
        self.file.sync_data()?;
        self.waiting.clear();
        (self.rows, self.synced) = (0, Instant::now());
        Ok(())
    }

    /// Removes the file: its rows are in the table.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub(crate) fn remove(self) -> io::Result<()> {
        fs::remove_file(self.path)
    }
}

/// Calls `each` with the whole rows from a place on, of a journal that another program may write, and returns the place after them.
///
/// # Errors
/// A file that cannot be read, or is no journal.
pub(crate) fn each_row_from(
    path: &Path,
    from: PlaceOfRow,
    mut each: impl FnMut(&RunRow),
) -> io::Result<PlaceOfRow> {
    let (mut file, _) = open(path)?;
    if from == 0 {
        return read(&file, |row, _| each(row));
    }
    file.seek(SeekFrom::Start(from))?;
    whole_rows(&mut BufReader::new(file), from, |row, _| each(row))
}

/// Calls `each` with the whole rows of a journal, and returns the place after them; 0 for a file that ends within its first bytes.
fn read(file: &File, each: impl FnMut(&RunRow, PlaceOfRow)) -> io::Result<PlaceOfRow> {
    let mut input = BufReader::new(file);
    let mut magic = Vec::new();
    input.by_ref().take(MAGIC.len() as u64).read_to_end(&mut magic)?;
    if !MAGIC.starts_with(&magic) {
        return Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "it is not a journal of this version",
        ));
    }
    if magic.len() < MAGIC.len() {
        return Ok(0);
    }
    whole_rows(&mut input, MAGIC.len() as u64, each)
}

/// Calls `each` with the whole rows that follow, the first of which is at `end`, and returns the place after them.
fn whole_rows(
    input: &mut impl Read,
    mut end: PlaceOfRow,
    mut each: impl FnMut(&RunRow, PlaceOfRow),
) -> io::Result<PlaceOfRow> {
    while let Some(record) = read_record(input)? {
        let Some(row) = record.row() else { break };
        each(&row, end);
        end += record.length_in_file();
    }
    Ok(end)
}

/// A row as it is in the file.
struct Record {
    sum: [u8; SUM_BYTES],
    bytes: Vec<u8>,
}

impl Record {
    fn length_in_file(&self) -> u64 {
        (4 + SUM_BYTES + self.bytes.len()) as u64
    }

    /// The row; `None` if its bytes have changed.
    fn row(&self) -> Option<RunRow> {
        let is_whole = Sha256::digest(&self.bytes)[..SUM_BYTES] == self.sum;
        is_whole.then(|| RunRow::from_bytes(&self.bytes)).flatten()
    }
}

/// The next row; `None` at a torn end.
fn read_record(input: &mut impl Read) -> io::Result<Option<Record>> {
    let mut head = Vec::new();
    input.take(4 + SUM_BYTES as u64).read_to_end(&mut head)?;
    let Some((length, sum)) = head.split_first_chunk::<4>() else { return Ok(None) };
    let length = u32::from_le_bytes(*length);
    let Ok(sum) = sum.try_into() else { return Ok(None) };
    if length > MOST_ROW_BYTES {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    input.take(length.into()).read_to_end(&mut bytes)?;
    let is_whole = bytes.len() as u64 == u64::from(length);
    Ok(is_whole.then_some(Record { sum, bytes }))
}
