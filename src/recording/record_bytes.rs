//! Bytes of the container's records: a kind, a length, and fields in little-endian order.

use crate::container::PREFIX;
use std::collections::BTreeMap;

/// Adds fields to the body of a record.
pub(crate) trait PutFields {
    fn put_u16(&mut self, value: u16);
    fn put_u32(&mut self, value: u32);
    fn put_u64(&mut self, value: u64);
    /// A text or other bytes after their length in 32 bits.
    fn put_bytes(&mut self, bytes: &[u8]);
    /// A map of texts.
    fn put_map(&mut self, map: &BTreeMap<String, String>);
    /// A map from channels to numbers.
    fn put_numbers(&mut self, map: &BTreeMap<u16, u64>);
    /// A record, whose body is written by `body`.
    fn put_record(&mut self, kind: u8, body: impl FnOnce(&mut Vec<u8>));
}

impl PutFields for Vec<u8> {
    fn put_u16(&mut self, value: u16) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_u32(&mut self, value: u32) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_u64(&mut self, value: u64) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_bytes(&mut self, bytes: &[u8]) {
        self.put_u32(bytes.len() as u32);
        self.extend_from_slice(bytes);
    }

    fn put_map(&mut self, map: &BTreeMap<String, String>) {
        let mut entries = Vec::new();
        for (key, value) in map {
            entries.put_bytes(key.as_bytes());
            entries.put_bytes(value.as_bytes());
        }
        self.put_bytes(&entries);
    }

    fn put_numbers(&mut self, map: &BTreeMap<u16, u64>) {
        let mut entries = Vec::new();
        for (channel, number) in map {
            entries.put_u16(*channel);
            entries.put_u64(*number);
        }
        self.put_bytes(&entries);
    }

    fn put_record(&mut self, kind: u8, body: impl FnOnce(&mut Vec<u8>)) {
        self.push(kind);
        self.put_u64(0);
        let start = self.len();
        body(self);
        let length = (self.len() - start) as u64;
        self[start - PREFIX as usize + 1..start].copy_from_slice(&length.to_le_bytes());
    }
}
