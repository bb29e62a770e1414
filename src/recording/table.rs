//! The exact state of one frame: a row a particle, a column a quantity.

use crate::frame::StateColumn;
use crate::scene::{FRAME_ID, pose};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, PointCloud, Timestamp};
use prost::Message as _;
use prost::encoding::{WireType, encode_key, encode_varint};
use std::sync::Arc;

/// Tag of `foxglove.PointCloud.data`, its last field.
const DATA_TAG: u32 = 6;

/// Encodes the exact state as a `foxglove.PointCloud` with FLOAT64 fields, row by row. The values, which may be many, go
/// straight into the buffer; what the buffer holds is written over, so that one kept from frame to frame is never zeroed.
pub(crate) fn encode_state(
    columns: &[StateColumn],
    state: &[f64],
    time: Timestamp,
    buffer: &mut Vec<u8>,
) {
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
    let mut head = cloud.encode_to_vec();
    encode_key(DATA_TAG, WireType::LengthDelimited, &mut head);
    encode_varint(8 * state.len() as u64, &mut head);
    buffer.resize(head.len() + 8 * state.len(), 0);
    let (start, values) = buffer.split_at_mut(head.len());
    start.copy_from_slice(&head);
    let (slots, _) = values.as_chunks_mut();
    for (slot, value) in slots.iter_mut().zip(state) {
        *slot = value.to_le_bytes();
    }
}

/// The state of all particles, in the order of their ids.
#[derive(Clone, Debug, PartialEq)]
pub struct StateTable {
    columns: Arc<[String]>,
    values: Vec<f64>,
}

impl StateTable {
    /// The table in a point cloud, or what of it does not fit the recording's columns.
    pub(crate) fn from_point_cloud(
        cloud: &PointCloud,
        columns: &Arc<[String]>,
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
        let values = values.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        Ok(Self { columns: Arc::clone(columns), values })
    }

    /// Names of the columns.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of particles.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// One particle's values in the order of the columns.
    ///
    /// # Panics
    /// Where there is no such row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f64] {
        let width = self.columns.len();
        &self.values[row * width..(row + 1) * width]
    }

    /// One quantity of all particles; `None` where the state has no such column.
    pub fn column(&self, name: &str) -> Option<impl Iterator<Item = f64>> {
        let column = self.index(name)?;
        Some(self.values.iter().skip(column).step_by(self.columns.len()).copied())
    }

    /// One quantity of one particle; `None` where there is no such column or row.
    #[must_use]
    pub fn value(&self, row: usize, name: &str) -> Option<f64> {
        let column = self.index(name)?;
        self.values.chunks_exact(self.columns.len()).nth(row).map(|values| values[column])
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}
