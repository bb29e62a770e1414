//! The exact state of one frame: one row per particle, one column per quantity.

use crate::column::{Column as _, StateColumn, is_constant};
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

/// Particles whose constants are copied before they are compared.
const ROWS_OF_PIECE: usize = 512;

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

    /// The message of `/particles` with the constants of these rows, as a `foxglove.PointCloud` without a time, piece by piece until `take`
    /// returns false.
    pub(crate) fn particles(&self, columns: &[StateColumn], mut take: impl FnMut(&[u8]) -> bool) {
        let indices: Vec<usize> =
            (0..columns.len()).filter(|&index| is_constant(columns[index].name)).collect();
        let rows = self.values().len() / columns.len();
        let mut piece = message_header(columns, true, indices.len() * rows, None);
        for rows in self.values().chunks(ROWS_OF_PIECE * columns.len()) {
            for row in rows.chunks_exact(columns.len()) {
                indices.iter().for_each(|&index| piece.extend(row[index].to_le_bytes()));
            }
            if !take(&piece) {
                return;
            }
            piece.clear();
        }
        // Of a state without particles, there is only the header.
        take(&piece);
    }

    /// Moves the values that are not constants of the particles to the start. Returns their number.
    fn remove_constants(&mut self, columns: &[StateColumn]) -> usize {
        let values = &mut self.words[self.room..];
        let kept: Vec<usize> =
            (0..columns.len()).filter(|&index| !is_constant(columns[index].name)).collect();
        if kept.len() == columns.len() {
            return values.len();
        }
        let mut end = 0;
        for row in (0..values.len()).step_by(columns.len()) {
            for index in &kept {
                values[end] = values[row + index];
                end += 1;
            }
        }
        end
    }

    /// The message of `/state`: a `foxglove.PointCloud` with the values as FLOAT64 fields. The header is written before the values, which
    /// stay in place without the constants of the particles. Therefore, no rows are left.
    pub(crate) fn take_message(&mut self, columns: &[StateColumn], time: Timestamp) -> &mut [u8] {
        self.remove_cleared();
        let values = self.remove_constants(columns);
        let header = message_header(columns, false, values, Some(time));
        let words = header.len().div_ceil(size_of::<f64>());
        if let Some(missing) = words.checked_sub(self.room) {
            self.words.splice(0..0, std::iter::repeat_n(0.0, missing));
            self.room = words;
        }
        let values_at = size_of::<f64>() * self.room;
        let message_at = values_at - header.len();
        self.is_cleared = true;
        let bytes = self.little_endian_bytes();
        bytes[message_at..values_at].copy_from_slice(&header);
        &mut bytes[message_at..values_at + size_of::<f64>() * values]
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

/// The message with the columns that are constants of the particles, or with the others, up to the values, which are its last field.
fn message_header(
    columns: &[StateColumn],
    are_constants: bool,
    values: usize,
    timestamp: Option<Timestamp>,
) -> Vec<u8> {
    let columns = columns.iter().filter(|column| is_constant(column.name) == are_constants);
    let fields = columns.zip(0_u32..).map(|(column, index)| PackedElementField {
        name: column.name.to_owned(),
        offset: 8 * index,
        r#type: NumericType::Float64.into(),
    });
    let fields: Vec<_> = fields.collect();
    let cloud = PointCloud {
        timestamp,
        frame_id: FRAME_ID.to_owned(),
        pose: Some(pose([0.0, 0.0, 0.0])),
        point_stride: 8 * fields.len() as u32,
        fields,
        ..PointCloud::default()
    };
    let mut header = Vec::with_capacity(cloud.encoded_len() + MAX_DATA_PREFIX);
    cloud.encode_raw(&mut header);
    encode_key(DATA_TAG, WireType::LengthDelimited, &mut header);
    encode_varint((size_of::<f64>() * values) as u64, &mut header);
    header
}

/// The values of a message whose columns are those of the recording that are constants of the particles, or the others.
fn values_of<'a>(
    cloud: &'a PointCloud,
    columns: &[String],
    are_constants: bool,
) -> Result<&'a [[u8; 8]], &'static str> {
    let float64 = i32::from(NumericType::Float64);
    let fields = columns.iter().filter(|name| is_constant(name) == are_constants).zip(0_u32..);
    let fields = fields.map(|(name, index)| (name.as_str(), float64, 8 * index));
    let found = cloud.fields.iter().map(|field| (field.name.as_str(), field.r#type, field.offset));
    let stride = 8 * cloud.fields.len();
    if !fields.eq(found) || cloud.point_stride as usize != stride || stride == 0 {
        return Err("the state's columns are not those of the recording");
    }
    if !cloud.data.len().is_multiple_of(stride) {
        return Err("the state ends inside a row");
    }
    Ok(cloud.data.as_chunks().0)
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
    /// Joins the messages of a state and of the particles, or returns how they differ from the recording's columns or from each other.
    pub(crate) fn joined(
        state: &PointCloud,
        particles: Option<&PointCloud>,
        columns: &Arc<[String]>,
        spare: &SpareMemory<f64>,
    ) -> Result<Self, &'static str> {
        let rows = values_of(state, columns, false)?;
        let mut table = Self { columns: Arc::clone(columns), values: spare.take() };
        let values = &mut table.values.vector;
        let constants = columns.iter().filter(|name| is_constant(name)).count();
        let width = columns.len() - constants;
        let count = rows.len() / width;
        if values.try_reserve_exact(count.saturating_mul(columns.len())).is_err() {
            return Err("the state does not fit into memory");
        }
        if constants == 0 {
            values.extend(rows.iter().map(|bytes| f64::from_le_bytes(*bytes)));
            return Ok(table);
        }
        let particles = particles.ok_or("a state has no message of /particles before it")?;
        let particles = values_of(particles, columns, true)?;
        if particles.len() / constants != count {
            return Err("the state has another number of particles than /particles");
        }
        let (mut next, mut next_constant) = (0..width, 0..constants);
        let places = columns.iter().map(|name| match is_constant(name) {
            true => (true, next_constant.next().unwrap_or_default()),
            false => (false, next.next().unwrap_or_default()),
        });
        let places: Vec<(bool, usize)> = places.collect();
        for (row, particle) in rows.chunks_exact(width).zip(particles.chunks_exact(constants)) {
            values.extend(places.iter().map(|&(is_constant, index)| {
                f64::from_le_bytes(if is_constant { particle[index] } else { row[index] })
            }));
        }
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
