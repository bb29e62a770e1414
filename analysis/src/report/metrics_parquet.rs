//! `metrics.parquet`: the columns of `metrics.csv`, with numbers as nullable doubles.

use crate::input::coordinates;
use crate::metric::{Metric, MetricScope};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::sync::Arc;

/// A column's values, in the order of the metrics.
enum Column {
    Text(Vec<ByteArray>),
    Numbers(Vec<Option<f64>>),
}

/// The bytes of `metrics.parquet`: one row per metric.
///
/// # Errors
/// Errors of the writer; none is expected.
pub(crate) fn to_parquet(metrics: &[Metric]) -> Result<Vec<u8>, ParquetError> {
    let columns = columns(metrics);
    let mut fields = Vec::new();
    for (name, column) in &columns {
        let field = match column {
            Column::Text(_) => Type::primitive_type_builder(name, Physical::BYTE_ARRAY)
                .with_logical_type(Some(LogicalType::String))
                .with_repetition(Repetition::REQUIRED),
            Column::Numbers(_) => Type::primitive_type_builder(name, Physical::DOUBLE)
                .with_repetition(Repetition::OPTIONAL),
        };
        fields.push(Arc::new(field.build()?));
    }
    let schema = Arc::new(Type::group_type_builder("metrics").with_fields(fields).build()?);
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties)?;
    let mut group = writer.next_row_group()?;
    for (_, values) in &columns {
        let Some(mut column) = group.next_column()? else { break };
        match values {
            Column::Text(texts) => {
                column.typed::<ByteArrayType>().write_batch(texts, None, None)?;
            }
            Column::Numbers(numbers) => {
                let present: Vec<f64> = numbers.iter().copied().flatten().collect();
                let levels: Vec<i16> =
                    numbers.iter().map(|number| i16::from(number.is_some())).collect();
                column.typed::<DoubleType>().write_batch(&present, Some(&levels), None)?;
            }
        }
        column.close()?;
    }
    group.close()?;
    writer.into_inner()
}

fn columns(metrics: &[Metric]) -> Vec<(&'static str, Column)> {
    let text = |of: &dyn Fn(&Metric) -> String| {
        Column::Text(metrics.iter().map(|metric| of(metric).into_bytes().into()).collect())
    };
    let numbers =
        |of: &dyn Fn(&Metric) -> Option<f64>| Column::Numbers(metrics.iter().map(of).collect());
    let of_run = |metric: &Metric| match &metric.scope {
        MetricScope::Run(run) => Some(run.clone()),
        MetricScope::Sweep(_) => None,
    };
    let of_sweep = |metric: &Metric| match &metric.scope {
        MetricScope::Run(_) => None,
        MetricScope::Sweep(sweep) => Some(sweep.clone()),
    };
    vec![
        ("name", text(&|metric| metric.name().to_owned())),
        ("value", numbers(&|metric| Some(metric.value))),
        ("unit", text(&|metric| metric.unit().to_owned())),
        ("standard_error", numbers(&|metric| metric.standard_error)),
        ("theory", numbers(&|metric| metric.theory)),
        ("deviation_in_standard_errors", numbers(&Metric::deviation_in_standard_errors)),
        (
            "scope",
            text(&|metric| if of_run(metric).is_some() { "run" } else { "sweep" }.to_owned()),
        ),
        ("coordinates", text(&|metric| coordinates::text(metric.coordinates()))),
        (
            "along",
            text(&|metric| of_sweep(metric).and_then(|sweep| sweep.along).unwrap_or_default()),
        ),
        ("replicate", numbers(&|metric| of_run(metric).map(|run| f64::from(run.replicate)))),
        ("replicates", numbers(&|metric| of_sweep(metric).map(|sweep| sweep.replicates as f64))),
        ("file", text(&|metric| of_run(metric).map(|run| run.file).unwrap_or_default())),
        ("outcome", text(&|metric| of_run(metric).map(|run| run.outcome).unwrap_or_default())),
        ("source", text(&|metric| metric.source.clone())),
    ]
}
