//! Writes the files of an analysis.

#[cfg(feature = "parquet")]
use crate::input::RUNS_TABLE;
use crate::metric_files::document::MOST_RUNS;
#[cfg(feature = "parquet")]
use crate::metric_files::run_row::RunRow;
#[cfg(feature = "parquet")]
use crate::metric_files::runs_table;
use crate::metric_files::table::to_csv;
#[cfg(feature = "parquet")]
use crate::metric_files::table::to_parquet;
use crate::report::file_links::FileLinks;
use crate::report::plot_section::DrawnPlot;
use crate::report::{AnalysisReport, html, play};
use crate::write_file::{WriteError, create_folder, replace};
use kinetoscope_recording::plot_list::{PLOT_LIST, is_plot_name, listed_plots};
#[cfg(feature = "parquet")]
use std::borrow::Cow;
#[cfg(feature = "parquet")]
use std::ops::Range;
use std::path::Path;

/// The report of an experiment.
pub(crate) const REPORT: &str = "report.html";
/// The page of a folder of experiments.
pub(crate) const INDEX: &str = "index.html";

/// Writes `metrics.json`, `metrics.csv` (for more than [`MOST_RUNS`] runs, without the metrics of single runs), `report.html` and the plots (with the feature `parquet` also
/// `metrics.parquet` and `runs.parquet`); returns the number of plots. Plots of the analysis before that are not drawn again are removed.
///
/// # Errors
/// The first file that cannot be written.
pub(crate) fn write(report: &AnalysisReport, folder: &Path) -> Result<usize, WriteError> {
    create_folder(folder)?;
    let failed = |name: &str, why: String| WriteError::new(&folder.join(name), why);
    let json =
        report.document().to_json().map_err(|error| failed("metrics.json", error.to_string()))?;
    replace(&folder.join("metrics.json"), &json)?;
    let (has_runs, metrics) = (report.runs.len() <= MOST_RUNS, &report.metrics);
    let listed = || metrics.iter().filter(|metric| has_runs || !metric.is_of_run());
    let csv = to_csv(listed()).map_err(|error| failed("metrics.csv", error.to_string()))?;
    replace(&folder.join("metrics.csv"), &csv)?;
    #[cfg(feature = "parquet")]
    {
        let parquet =
            to_parquet(listed()).map_err(|error| failed("metrics.parquet", error.to_string()))?;
        replace(&folder.join("metrics.parquet"), parquet)?;
        if !report.keeps_table || !folder.join(RUNS_TABLE).exists() {
            let rows: Vec<RunRow> = report.runs.iter().map(RunRow::of).collect();
            let manifest = |row: usize| report.runs[row].manifest.canonical();
            let mut read = |range: Range<usize>| Ok(Cow::Borrowed(&rows[range]));
            let (name, bytes) = (&report.name, Vec::new());
            let table = runs_table::to_parquet(bytes, name, rows.len(), &mut read, &manifest);
            let table = table.map_err(|error| failed(RUNS_TABLE, error.to_string()))?;
            replace(&folder.join(RUNS_TABLE), table)?;
        }
    }
    let (earlier, mut list) = (listed_plots(folder), String::new());
    let mut drawn = Vec::new();
    for (stem, plot) in &report.plots {
        let name = format!("{stem}.svg");
        if !is_plot_name(&name) {
            return Err(failed(&name, "it is no name of a plot".to_owned()));
        }
        let svg = plot.svg().map_err(|error| failed(&name, error.to_string()))?;
        if let Some(svg) = svg {
            replace(&folder.join(&name), &svg)?;
            list += &format!("{name}\n");
            drawn.push(DrawnPlot { stem, plot, svg });
        }
    }
    for stale in earlier.iter().filter(|name| !list.lines().any(|drawn| drawn == *name)) {
        // A plot that cannot be removed is of no harm.
        let _ = std::fs::remove_file(folder.join(stale));
    }
    for run in &report.runs {
        list += &format!("{}\n", run.file);
    }
    replace(&folder.join(PLOT_LIST), &list)?;
    let links = FileLinks::in_folder(report, folder, listed_plots(folder));
    play::write(report.engine, folder)?;
    replace(&folder.join(REPORT), html::page(report, &drawn, &links))?;
    Ok(drawn.len())
}
