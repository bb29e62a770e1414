//! The exact state of one frame: one row per particle, one column per quantity.

use crate::column::{Column as _, StateColumn};
use crate::scene::{FRAME_ID, pose};
use crate::spare_memory::{Lent, SpareMemory};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, PointCloud, Timestamp};
use prost::Message as _;
use prost::encoding::{WireType, encode_key, encode_varint};
use std::sync::Arc;

/// Tag of `foxglove.PointCloud.data`, its last field.
const DATA_TAG: u32 = 6;

/// Maximum length of that tag and of the length that follows it.
const MAX_DATA_PREFIX: usize = 11;

/// Words before the first value. A header of up to 2 KiB fits, which suffices for about fifty columns.
const HEADER_WORDS: usize = 256;

/// The values of one frame's state, row by row, after space for the header of their message. A state may have many
/// megabytes; therefore, it becomes a message in place.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Words for the header, then the values.
    words: Vec<f64>,
    room: usize,
    /// The values are those of an earlier frame, which `resize` reuses: to fill many megabytes with zeros takes long.
    is_cleared: bool,
    /// The words as the message has them, where memory has another order of bytes.
    #[cfg(target_endian = "big")]
    little_endian: Vec<u8>,
}

impl Default for Rows {
    fn default() -> Self {
        Self {
            words: vec![0.0; HEADER_WORDS],
            room: HEADER_WORDS,
            is_cleared: false,
            #[cfg(target_endian = "big")]
            little_endian: Vec::new(),
        }
    }
}

impl PartialEq for Rows {
    fn eq(&self, other: &Self) -> bool {
        self.values() == other.values()
    }
}

impl Rows {
    pub(crate) fn clear(&mut self) {
        self.is_cleared = true;
    }

    /// Removes the values of an earlier frame.
    fn remove_cleared(&mut self) {
        if self.is_cleared {
            self.words.truncate(self.room);
            self.is_cleared = false;
        }
    }

    pub(crate) fn push(&mut self, row: &[f64]) {
        self.remove_cleared();
        self.words.extend_from_slice(row);
    }

    /// Changes the number of values. Until they are written, they are zeros or those of an earlier frame.
    pub(crate) fn resize(&mut self, values: usize) -> &mut [f64] {
        self.is_cleared = false;
        let words = self.room + values;
        self.words.reserve_exact(words.saturating_sub(self.words.len()));
        self.words.resize(words, 0.0);
        &mut self.words[self.room..]
    }

    pub(crate) fn values(&self) -> &[f64] {
        if self.is_cleared { &[] } else { &self.words[self.room..] }
    }

    /// Gives every NaN the bits of `f64::NAN`.
    pub(crate) fn make_nan_canonical(&mut self) {
        if self.values().has_other_nan() {
            self.words[self.room..].make_nan_canonical();
        }
    }

    /// A `foxglove.PointCloud` with the values as FLOAT64 fields. The header is written before the values, which stay in place.
    pub(crate) fn as_message(&mut self, columns: &[StateColumn], time: Timestamp) -> &[u8] {
        self.remove_cleared();
        let header = message_header(columns, self.values().len(), time);
        let words = header.len().div_ceil(size_of::<f64>());
        if let Some(missing) = words.checked_sub(self.room) {
            self.words.splice(0..0, std::iter::repeat_n(0.0, missing));
            self.room = words;
        }
        let values_at = size_of::<f64>() * self.room;
        let message_at = values_at - header.len();
        let bytes = self.little_endian_bytes();
        bytes[message_at..values_at].copy_from_slice(&header);
        &bytes[message_at..]
    }
}

impl Rows {
    /// The words in the byte order of messages: on most machines, those in memory.
    #[cfg(target_endian = "little")]
    fn little_endian_bytes(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(&mut self.words)
    }

    #[cfg(target_endian = "big")]
    fn little_endian_bytes(&mut self) -> &mut [u8] {
        self.little_endian.clear();
        self.little_endian.extend(self.words.iter().flat_map(|word| word.to_le_bytes()));
        &mut self.little_endian
    }
}

/// The message of a state without the values, which are its last field.
fn message_header(columns: &[StateColumn], values: usize, time: Timestamp) -> Vec<u8> {
    let fields = columns.iter().zip(0_u32..).map(|(column, index)| PackedElementField {
        name: column.name.to_owned(),
        offset: 8 * index,
        r#type: NumericType::Float64.into(),
    });
    let cloud = PointCloud {
        timestamp: Some(time),
        frame_id: FRAME_ID.to_owned(),
        pose: Some(pose([0.0, 0.0, 0.0])),
        point_stride: 8 * columns.len() as u32,
        fields: fields.collect(),
        ..PointCloud::default()
    };
    let mut header = Vec::with_capacity(cloud.encoded_len() + MAX_DATA_PREFIX);
    cloud.encode_raw(&mut header);
    encode_key(DATA_TAG, WireType::LengthDelimited, &mut header);
    encode_varint((size_of::<f64>() * values) as u64, &mut header);
    header
}

/// The state of all particles, in the order of their ids.
#[derive(Clone, Debug)]
pub struct StateTable {
    columns: Arc<[String]>,
    values: Lent<f64>,
}

impl PartialEq for StateTable {
    fn eq(&self, other: &Self) -> bool {
        self.columns == other.columns && *self.values == *other.values
    }
}

impl StateTable {
    /// Decodes a point cloud, or returns how it differs from the recording's columns.
    pub(crate) fn from_point_cloud(
        cloud: &PointCloud,
        columns: &Arc<[String]>,
        spare: &SpareMemory<f64>,
    ) -> Result<Self, &'static str> {
        let stride = 8 * columns.len();
        let float64 = i32::from(NumericType::Float64);
        let fits = cloud.fields.len() == columns.len()
            && cloud.fields.iter().zip(columns.iter()).zip(0_u32..).all(
                |((field, name), index)| {
                    field.name == *name && field.r#type == float64 && field.offset == 8 * index
                },
            );
        if !fits || cloud.point_stride as usize != stride {
            return Err("the state's columns are not those of the recording");
        }
        if !cloud.data.len().is_multiple_of(stride) {
            return Err("the state ends inside a row");
        }
        let (values, _) = cloud.data.as_chunks();
        let mut table = Self { columns: Arc::clone(columns), values: spare.take() };
        if table.values.vector.try_reserve_exact(values.len()).is_err() {
            return Err("the state does not fit into memory");
        }
        table.values.vector.extend(values.iter().map(|bytes| f64::from_le_bytes(*bytes)));
        Ok(table)
    }

    /// Names of the columns.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of particles.
    #[must_use]
    #[inline]
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// The values of all particles, one row after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len())
    }

    /// One particle's values in the order of the columns.
    ///
    /// # Panics
    /// If the row does not exist.
    #[must_use]
    #[inline]
    pub fn row(&self, row: usize) -> &[f64] {
        let width = self.columns.len();
        &self.values[row * width..(row + 1) * width]
    }

    /// One quantity of all particles; `None` if the state has no such column.
    pub fn column(&self, name: &str) -> Option<impl Iterator<Item = f64>> {
        let column = self.index(name)?;
        Some(self.values.iter().skip(column).step_by(self.columns.len()).copied())
    }

    /// One quantity of one particle; `None` if the column or the row does not exist.
    #[must_use]
    pub fn value(&self, row: usize, name: &str) -> Option<f64> {
        let column = self.index(name)?;
        self.values.chunks_exact(self.columns.len()).nth(row).map(|values| values[column])
    }

    /// Index of a column; `None` if the state has no such column.
    #[must_use]
    pub fn index(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}
