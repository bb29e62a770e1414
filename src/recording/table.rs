//! The exact state of one frame: a row a particle, a column a quantity.

use foxglove::messages::PointCloud;
use foxglove::messages::packed_element_field::NumericType;
use std::sync::Arc;

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
