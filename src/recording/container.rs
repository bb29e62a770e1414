//! MCAP records from a file whose length is known, without trust: no length is believed that the file can't hold, and
//! nothing is allocated ahead of the bytes.
//!
//! Layout of the records: <https://mcap.dev/spec>.

use prost::bytes::Bytes;
use std::collections::BTreeMap;
use std::io::{self, Read};

/// First and last bytes of a file.
pub(crate) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes before a record's body: its kind and its length.
pub(crate) const PREFIX: u64 = 9;
/// A chunk may unpack to this much whatever its size...
const UNPACKED_FLOOR: u64 = 64 << 20;
/// ...or to so many times its size: more than any recorded state packs.
const UNPACKED_RATIO: u64 = 1024;

/// Kinds of records that the reader looks into.
pub(crate) mod kind {
    pub(crate) const HEADER: u8 = 0x01;
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const ATTACHMENT: u8 = 0x09;
    pub(crate) const METADATA: u8 = 0x0c;
    pub(crate) const METADATA_INDEX: u8 = 0x0d;
    pub(crate) const DATA_END: u8 = 0x0f;
}

/// Why no further record can be had.
#[derive(Debug)]
pub(crate) enum Broken {
    /// The file can't be read.
    Io(io::Error),
    /// The file does not begin as an MCAP file does.
    NotMcap,
    /// The file ends inside a record.
    Torn,
    /// The bytes are not what was written.
    Damaged(String),
}

impl From<io::Error> for Broken {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Torn } else { Self::Io(error) }
    }
}

/// Damage, in words.
pub(crate) fn damaged(what: &str) -> Broken {
    Broken::Damaged(what.to_owned())
}

/// A record's kind and the length of its body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Prefix {
    pub(crate) kind: u8,
    pub(crate) length: u64,
}

/// Reads records one after the other; keeps the position and a checksum of all bytes so far.
pub(crate) struct Records<R> {
    input: R,
    position: u64,
    end: u64,
    checksum: crc32fast::Hasher,
}

impl<R: Read> Records<R> {
    /// `input` stands at byte `position` of a file of `end` bytes.
    pub(crate) fn new(input: R, position: u64, end: u64) -> Self {
        Self { input, position, end, checksum: crc32fast::Hasher::new() }
    }

    /// The byte that comes next.
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

    /// Forgets the checksum of the bytes so far.
    pub(crate) fn restart_checksum(&mut self) {
        self.checksum = crc32fast::Hasher::new();
    }

    /// The next record's kind and length; its body must then be read or skipped.
    pub(crate) fn prefix(&mut self) -> Result<Prefix, Broken> {
        let bytes: [u8; PREFIX as usize] = self.array()?;
        let [kind, length @ ..] = bytes;
        let length = u64::from_le_bytes(length);
        if length > self.end - self.position {
            Err(Broken::Torn)
        } else {
            Ok(Prefix { kind, length })
        }
    }

    /// So many bytes, as an array.
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

    /// A record's body, left out of the checksum. The buffer grows with the bytes that come, not with the length that is
    /// claimed.
    pub(crate) fn body_without_checksum(
        &mut self,
        prefix: Prefix,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Broken> {
        buffer.clear();
        let count = self.input.by_ref().take(prefix.length).read_to_end(buffer)?;
        self.position += count as u64;
        if count as u64 == prefix.length { Ok(()) } else { Err(Broken::Torn) }
    }

    /// Passes over a record's body.
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

/// A record's fields, taken from the front. What is missing is damage: the record itself was whole.
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

/// A chunk's records, unpacked and checked.
pub(crate) fn unpack_chunk(body: Vec<u8>) -> Result<Bytes, Broken> {
    let body = Bytes::from(body);
    let mut fields = Fields(&body);
    let _start_and_end_time = (fields.u64()?, fields.u64()?);
    let unpacked_size = fields.u64()?;
    let checksum = fields.u32()?;
    let compression = fields.string()?;
    let packed_size = fields.u64()?;
    let packed = fields.0;
    if packed.len() as u64 != packed_size {
        return Err(damaged("a chunk's size does not fit its record"));
    }
    let limit = packed_size.saturating_mul(UNPACKED_RATIO);
    if unpacked_size > if limit > UNPACKED_FLOOR { limit } else { UNPACKED_FLOOR } {
        return Err(damaged("a chunk claims a size that no recording has"));
    }
    let unpacked = match compression {
        "" => body.slice_ref(packed),
        "zstd" => {
            let decoder = zstd::stream::read::Decoder::with_buffer(packed);
            read_bounded(decoder, unpacked_size, packed_size)?
        }
        "lz4" => read_bounded(lz4::Decoder::new(packed), unpacked_size, packed_size)?,
        _ => return Err(damaged("a chunk is packed by an unknown method")),
    };
    if unpacked.len() as u64 != unpacked_size || crc32fast::hash(&unpacked) != checksum {
        return Err(damaged("a chunk does not fit its checksum"));
    }
    Ok(unpacked)
}

/// What a decoder gives, up to one byte more than expected.
fn read_bounded(
    decoder: io::Result<impl Read>,
    expected: u64,
    packed: u64,
) -> Result<Bytes, Broken> {
    // Room for what may well come; the rest as it comes.
    let likely = if expected < 4 * packed { expected } else { 4 * packed };
    let mut unpacked = Vec::with_capacity(likely as usize + 1);
    // A decoder's errors speak of its data, never of the file.
    decoder
        .and_then(|decoder| decoder.take(expected + 1).read_to_end(&mut unpacked))
        .map_err(|error| Broken::Damaged(format!("a chunk can't be unpacked ({error})")))?;
    Ok(unpacked.into())
}

/// An attachment's name and content, checked.
pub(crate) fn attachment(body: &[u8]) -> Result<(&str, &[u8]), Broken> {
    let (checked, checksum) =
        body.split_last_chunk().ok_or_else(|| damaged("an attachment is too short"))?;
    if crc32fast::hash(checked) != u32::from_le_bytes(*checksum) {
        return Err(damaged("an attachment does not fit its checksum"));
    }
    let mut fields = Fields(checked);
    let _log_and_create_time = (fields.u64()?, fields.u64()?);
    let name = fields.string()?;
    let _media_type = fields.string()?;
    let length = fields.u64()?;
    if length != fields.0.len() as u64 {
        return Err(damaged("an attachment's size does not fit its record"));
    }
    Ok((name, fields.0))
}

/// A metadata record's name and entries.
pub(crate) fn metadata(body: &[u8]) -> Result<(&str, BTreeMap<String, String>), Broken> {
    let mut fields = Fields(body);
    Ok((fields.string()?, fields.map()?))
}
