//! Writes the files of an analysis.

use crate::report::{AnalysisReport, html, metric_files};
use crate::write_file::{WriteError, create_folder, replace};
use std::path::Path;

/// Writes `metrics.json`, `metrics.csv`, `report.html` and the plots (with the feature `parquet` also
/// `metrics.parquet`); returns the number of plots.
///
/// # Errors
/// The first file that cannot be written.
pub(crate) fn write(report: &AnalysisReport, folder: &Path) -> Result<usize, WriteError> {
    create_folder(folder)?;
    let failed = |name: &str, why: String| WriteError::new(&folder.join(name), why);
    let json = metric_files::to_json(&report.name, report.model(), &report.metrics)
        .map_err(|error| failed("metrics.json", error.to_string()))?;
    replace(&folder.join("metrics.json"), &json)?;
    let csv = metric_files::to_csv(&report.metrics)
        .map_err(|error| failed("metrics.csv", error.to_string()))?;
    replace(&folder.join("metrics.csv"), &csv)?;
    #[cfg(feature = "parquet")]
    {
        let parquet = crate::report::metrics_parquet::to_parquet(&report.metrics)
            .map_err(|error| failed("metrics.parquet", error.to_string()))?;
        replace(&folder.join("metrics.parquet"), parquet)?;
    }
    let mut drawn = Vec::new();
    for (stem, plot) in &report.plots {
        let name = format!("{stem}.svg");
        let svg = plot.svg().map_err(|error| failed(&name, error.to_string()))?;
        if let Some(svg) = svg {
            replace(&folder.join(name), &svg)?;
            drawn.push((plot.title.as_str(), svg));
        }
    }
    replace(&folder.join("report.html"), html::page(report, &drawn))?;
    Ok(drawn.len())
}
