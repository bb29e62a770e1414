//! MCAP records of an untrusted file of known length. A length that exceeds the file is rejected, and memory is filled only by
//! bytes that were read.
//!
//! Layout of the records: `<https://mcap.dev/spec>`.

use crate::limits::{ChunkLimits, record_bytes};
use crate::record_kind as kind;
use crate::spare_memory::{Lent, SpareMemory};
use prost::bytes::Bytes;
use std::collections::BTreeMap;
use std::io::{self, Read};
#[cfg(not(target_os = "unknown"))]
use zstd::zstd_safe::{DCtx, get_error_name};

/// First and last bytes of a file.
pub(crate) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes before a record's body: its kind and its length.
pub(crate) const PREFIX: u64 = 9;
/// Maximum memory reserved for a record's body before its first byte is read.
const ROOM: u64 = 4 << 20;

/// Why the next record cannot be read.
#[derive(Debug)]
pub(crate) enum Broken {
    /// The file cannot be read.
    Io(io::Error),
    /// The file does not begin as an MCAP file does.
    NotMcap,
    /// The file is a recording of several runs.
    Merged,
    /// The file ends inside a record.
    Torn,
    /// The bytes differ from those that were written.
    Damaged(String),
}

impl From<io::Error> for Broken {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Torn } else { Self::Io(error) }
    }
}

/// An error for damaged bytes.
pub(crate) fn damaged(what: &str) -> Broken {
    Broken::Damaged(what.to_owned())
}

/// A record's kind and the length of its body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Prefix {
    pub(crate) kind: u8,
    pub(crate) length: u64,
}

/// Reads records in order, with the position and a checksum of all bytes read.
pub(crate) struct Records<R> {
    input: R,
    position: u64,
    end: u64,
    checksum: crc32fast::Hasher,
}

impl<R: Read> Records<R> {
    /// `input` is at byte `position` of a file of `end` bytes.
    pub(crate) fn new(input: R, position: u64, end: u64) -> Self {
        Self { input, position, end, checksum: crc32fast::Hasher::new() }
    }

    /// The input at its current position.
    pub(crate) fn into_input(self) -> R {
        self.input
    }

    /// Position of the next byte.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Whether all bytes were read.
    pub(crate) fn at_end(&self) -> bool {
        self.position == self.end
    }

    /// The first bytes of a file.
    pub(crate) fn magic(&mut self) -> Result<(), Broken> {
        let mut start = Vec::new();
        self.body(Prefix { kind: 0, length: MAGIC.len() as u64 }, &mut start).map_err(
            |broken| {
                if MAGIC.starts_with(&start) { broken } else { Broken::NotMcap }
            },
        )?;
        if start == MAGIC { Ok(()) } else { Err(Broken::NotMcap) }
    }

    /// Checksum of the bytes read since the start or the last [`Records::restart_checksum`].
    pub(crate) fn checksum(&self) -> crc32fast::Hasher {
        self.checksum.clone()
    }

    /// Restarts the checksum.
    pub(crate) fn restart_checksum(&mut self) {
        self.checksum = crc32fast::Hasher::new();
    }

    /// The kind and length of the next record, which may be a chunk of up to `chunk_bytes`; its body must then be read or
    /// skipped.
    pub(crate) fn prefix_or_chunk(&mut self, chunk_bytes: u64) -> Result<Prefix, Broken> {
        let bytes: [u8; PREFIX as usize] = self.array()?;
        let [kind, length @ ..] = bytes;
        let length = u64::from_le_bytes(length);
        if length > self.end - self.position {
            return Err(Broken::Torn);
        }
        let limit = if kind == kind::CHUNK { Some(chunk_bytes) } else { record_bytes(kind) };
        match limit {
            Some(limit) if length <= limit => Ok(Prefix { kind, length }),
            Some(_) => Err(damaged("a record claims a size that no recording has")),
            None => Err(damaged("a record is at a place where no recording has one")),
        }
    }

    /// As [`Records::prefix_or_chunk`], where no recording has a chunk.
    pub(crate) fn prefix(&mut self) -> Result<Prefix, Broken> {
        self.prefix_or_chunk(0)
    }

    /// The next `N` bytes.
    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], Broken> {
        let mut bytes = [0; N];
        if self.end - self.position < N as u64 {
            return Err(Broken::Torn);
        }
        self.input.read_exact(&mut bytes)?;
        self.passed(&bytes);
        Ok(bytes)
    }

    /// A record's body.
    pub(crate) fn body(&mut self, prefix: Prefix, buffer: &mut Vec<u8>) -> Result<(), Broken> {
        let read = self.body_without_checksum(prefix, buffer);
        self.checksum.update(buffer);
        read
    }

    /// A record's body, excluded from the checksum. The buffer grows with the bytes read, not with the declared length.
    pub(crate) fn body_without_checksum(
        &mut self,
        prefix: Prefix,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Broken> {
        buffer.clear();
        buffer.reserve(if prefix.length < ROOM { prefix.length } else { ROOM } as usize);
        let count = self.input.by_ref().take(prefix.length).read_to_end(buffer)?;
        self.position += count as u64;
        if count as u64 == prefix.length { Ok(()) } else { Err(Broken::Torn) }
    }

    /// Skips a record's body.
    pub(crate) fn skip(&mut self, prefix: Prefix) -> Result<(), Broken> {
        let mut buffer = [0; 8192];
        let mut left = prefix.length;
        while left > 0 {
            let part = if left < 8192 { left as usize } else { 8192 };
            self.input.read_exact(&mut buffer[..part])?;
            self.passed(&buffer[..part]);
            left -= part as u64;
        }
        Ok(())
    }

    fn passed(&mut self, bytes: &[u8]) {
        self.position += bytes.len() as u64;
        self.checksum.update(bytes);
    }
}

/// The fields of a complete record, read in order. A missing field means damage.
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl<'a> Fields<'a> {
    pub(crate) fn bytes(&mut self, count: usize) -> Result<&'a [u8], Broken> {
        let (bytes, rest) =
            self.0.split_at_checked(count).ok_or_else(|| damaged("a record is too short"))?;
        self.0 = rest;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Broken> {
        let (bytes, rest) =
            self.0.split_first_chunk().ok_or_else(|| damaged("a record is too short"))?;
        self.0 = rest;
        Ok(*bytes)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Broken> {
        Ok(u8::from_le_bytes(self.array()?))
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Broken> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Broken> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub(crate) fn u64(&mut self) -> Result<u64, Broken> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    pub(crate) fn string(&mut self) -> Result<&'a str, Broken> {
        let length = self.u32()? as usize;
        std::str::from_utf8(self.bytes(length)?).map_err(|_| damaged("a text is not UTF-8"))
    }

    fn map(&mut self) -> Result<BTreeMap<String, String>, Broken> {
        let length = self.u32()? as usize;
        let mut entries = Fields(self.bytes(length)?);
        let mut map = BTreeMap::new();
        while !entries.0.is_empty() {
            map.insert(entries.string()?.to_owned(), entries.string()?.to_owned());
        }
        Ok(map)
    }
}

/// Whether the chunk is compressed; of a body that is too short, decompression reports the error.
pub(crate) fn is_packed(body: &[u8]) -> bool {
    // After start and end time, size and checksum.
    body.get(28..32).is_some_and(|length| length != [0; 4])
}

/// Size that a chunk record's body claims for its content; 0 if the body is too short, which decompression reports.
pub(crate) fn claimed_bytes(body: &[u8]) -> u64 {
    // After start and end time.
    body.get(16..).and_then(|rest| Fields(rest).u64().ok()).unwrap_or(0)
}

/// Size of the frames in compressed data, without skippable frames, which contain nothing.
#[cfg(not(target_os = "unknown"))]
fn zstd_bytes(packed: &[u8]) -> Option<u64> {
    // RFC 8878, section 3.1.2: the magic numbers of skippable frames end in any 4 bits.
    let is_skippable = |frame: &[u8]| matches!(frame, [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..]);
    let (mut rest, mut bytes) = (packed, 0);
    while !rest.is_empty() {
        let size = zstd::zstd_safe::find_frame_compressed_size(rest).ok()?;
        let (frame, after) = rest.split_at_checked(size).filter(|_| size > 0)?;
        bytes += if is_skippable(frame) { 0 } else { size as u64 };
        rest = after;
    }
    Some(bytes)
}

/// Decompresses chunks.
pub(crate) struct Unpacker {
    // Reused for all chunks, because its tables take more memory than a chunk.
    #[cfg(not(target_os = "unknown"))]
    zstd: Option<DCtx<'static>>,
    /// Memory of contents that were dropped.
    #[cfg_attr(target_os = "unknown", expect(dead_code, reason = "nothing is decompressed"))]
    spare: SpareMemory<u8>,
}

/// A chunk's content.
pub(crate) struct Unpacked {
    /// The chunk's records.
    pub(crate) content: Bytes,
    /// Memory of the compressed chunk, if the content is not in it.
    pub(crate) spare: Option<Vec<u8>>,
}

impl Unpacker {
    pub(crate) fn new(spare: SpareMemory<u8>) -> Self {
        Self {
            #[cfg(not(target_os = "unknown"))]
            zstd: None,
            spare,
        }
    }

    /// The records in a chunk record's body, decompressed and checked.
    pub(crate) fn unpack(
        &mut self,
        body: Vec<u8>,
        limits: ChunkLimits,
    ) -> Result<Unpacked, Broken> {
        let mut fields = Fields(&body);
        let _start_and_end_time = (fields.u64()?, fields.u64()?);
        let unpacked_size = fields.u64()?;
        let checksum = fields.u32()?;
        let compression = fields.string()?;
        let packed_size = fields.u64()?;
        let packed = fields.0;
        if packed.len() as u64 != packed_size {
            return Err(damaged("the size of a chunk does not match its record"));
        }
        let counted = match compression {
            #[cfg(not(target_os = "unknown"))]
            "zstd" => zstd_bytes(packed),
            _ => Some(packed_size),
        };
        // Damaged frames are reported by decompression.
        if unpacked_size > limits.content_bytes(counted.unwrap_or(packed_size)) {
            return Err(damaged("a chunk claims a size that no recording has"));
        }
        let unpacked: Option<io::Result<Lent<u8>>> = match compression {
            "" => None,
            #[cfg(not(target_os = "unknown"))]
            "zstd" => Some(self.zstd(packed, unpacked_size)),
            #[cfg(not(target_os = "unknown"))]
            "lz4" => Some(self.lz4(packed, unpacked_size)),
            _ => return Err(damaged("the compression of a chunk is unknown")),
        };
        let unpacked = unpacked.transpose().map_err(cannot_be_unpacked)?;
        let content = unpacked.as_deref().unwrap_or(packed);
        if content.len() as u64 != unpacked_size || crc32fast::hash(content) != checksum {
            return Err(damaged("a chunk does not match its checksum"));
        }
        Ok(match unpacked {
            Some(content) => Unpacked { content: Bytes::from_owner(content), spare: Some(body) },
            None => {
                let start = body.len() - packed.len();
                Unpacked { content: Bytes::from(body).slice(start..), spare: None }
            }
        })
    }

    #[cfg(not(target_os = "unknown"))]
    fn zstd(&mut self, packed: &[u8], expected: u64) -> io::Result<Lent<u8>> {
        let mut unpacked = self.room(expected)?;
        let context = match &mut self.zstd {
            Some(context) => context,
            // `zstd::bulk::Decompressor` panics without memory.
            none => none.insert(DCtx::try_create().ok_or(io::ErrorKind::OutOfMemory)?),
        };
        let result = context.decompress(&mut unpacked.vector, packed);
        result.map_err(|code| io::Error::other(get_error_name(code)))?;
        Ok(unpacked)
    }

    /// Decompresses at most one byte more than expected.
    #[cfg(not(target_os = "unknown"))]
    fn lz4(&self, packed: &[u8], expected: u64) -> io::Result<Lent<u8>> {
        let mut unpacked = self.room(expected)?;
        lz4::Decoder::new(packed)?.take(expected + 1).read_to_end(&mut unpacked.vector)?;
        Ok(unpacked)
    }

    /// An empty buffer for the expected bytes and one more. Memory is used only as bytes are written.
    #[cfg(not(target_os = "unknown"))]
    fn room(&self, expected: u64) -> io::Result<Lent<u8>> {
        let mut room = self.spare.take();
        room.vector.try_reserve_exact(expected as usize + 1)?;
        Ok(room)
    }
}

/// An error of a decoder means damaged data, not a failed read, unless memory is missing.
fn cannot_be_unpacked(error: io::Error) -> Broken {
    if error.kind() == io::ErrorKind::OutOfMemory {
        return Broken::Io(error);
    }
    Broken::Damaged(format!("a chunk cannot be decompressed ({error})"))
}

/// An attachment's name and content, checked.
pub(crate) fn attachment(body: &[u8]) -> Result<(&str, &[u8]), Broken> {
    let (checked, checksum) =
        body.split_last_chunk().ok_or_else(|| damaged("an attachment is too short"))?;
    if crc32fast::hash(checked) != u32::from_le_bytes(*checksum) {
        return Err(damaged("an attachment does not match its checksum"));
    }
    let mut fields = Fields(checked);
    let _log_and_create_time = (fields.u64()?, fields.u64()?);
    let name = fields.string()?;
    let _media_type = fields.string()?;
    let length = fields.u64()?;
    if length != fields.0.len() as u64 {
        return Err(damaged("the size of an attachment does not match its record"));
    }
    Ok((name, fields.0))
}

/// A metadata record's name and entries.
pub(crate) fn metadata(body: &[u8]) -> Result<(&str, BTreeMap<String, String>), Broken> {
    let mut fields = Fields(body);
    Ok((fields.string()?, fields.map()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skippable_frames_do_not_count_as_compressed_data() {
        let packed = zstd::bulk::compress(&[0; 1000], 1).unwrap();
        let mut padded = packed.clone();
        for last in [0x50, 0x5f] {
            padded.extend([last, 0x2a, 0x4d, 0x18]);
            padded.extend(5000_u32.to_le_bytes());
            padded.extend([0; 5000]);
        }
        padded.extend(&packed);
        assert_eq!(zstd_bytes(&padded), Some(2 * packed.len() as u64));
        assert_eq!(zstd_bytes(&padded[..packed.len() + 20]), None);
    }
}
