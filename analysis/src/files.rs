//! Everything that an analysis leaves behind, file by file.

use crate::html;
use crate::metrics;
use crate::report::Report;
use std::path::{Path, PathBuf};

/// A file or folder that can't be written.
#[derive(Debug)]
pub struct WriteError {
    path: PathBuf,
    why: String,
}

impl std::fmt::Display for WriteError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let path = self.path.display();
        write!(
            formatter,
            "{path} can't be written: {}. Make room or make it writable, or name another folder with --output DIR",
            self.why
        )
    }
}

/// Writes `metrics.json`, `metrics.csv` (with the feature `parquet` also `metrics.parquet`), `report.html` and the plots; returns how many plots there are.
///
/// # Errors
/// The first file that can't be written.
pub fn write(report: &Report, folder: &Path) -> Result<usize, WriteError> {
    create_folder(folder)?;
    let failed = |name: &str, why: String| WriteError { path: folder.join(name), why };
    let json = metrics::to_json(&report.name, report.model(), &report.metrics)
        .map_err(|error| failed("metrics.json", error.to_string()))?;
    replace(&folder.join("metrics.json"), &json)?;
    let csv = metrics::to_csv(&report.metrics)
        .map_err(|error| failed("metrics.csv", error.to_string()))?;
    replace(&folder.join("metrics.csv"), &csv)?;
    #[cfg(feature = "parquet")]
    {
        let parquet = crate::metrics_parquet::to_parquet(&report.metrics)
            .map_err(|error| failed("metrics.parquet", error.to_string()))?;
        replace(&folder.join("metrics.parquet"), parquet)?;
    }
    let mut drawn = Vec::new();
    for (stem, plot) in &report.plots {
        let name = format!("{stem}.svg");
        let svg = plot.svg().map_err(|error| failed(&name, error.to_string()))?;
        if let Some(svg) = svg {
            replace(&folder.join(name), &svg)?;
            drawn.push((plot.title(), svg));
        }
    }
    replace(&folder.join("report.html"), html::page(report, &drawn))?;
    Ok(drawn.len())
}

/// Makes a folder with all above it.
///
/// # Errors
/// A folder that can't be made.
pub fn create_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder)
        .map_err(|error| WriteError { path: folder.to_path_buf(), why: error.to_string() })
}

/// Replaces a whole file: a reader sees the old contents or the new ones.
///
/// # Errors
/// A file that cannot be written.
pub fn replace(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    kinetoscope_recording::atomic_file::replace(path, content.as_ref())
        .map_err(|error| WriteError { path: path.to_path_buf(), why: error.to_string() })
}
