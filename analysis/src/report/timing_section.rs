//! The section of `report.html` with run times, which no metric contains.

use super::markup::breakable;
use crate::input::RecordingFolder;
use crate::input::coordinates::label;
use crate::number_text::{six_digits, with_error};
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_manifest::{Coordinate, TimingPoint, TimingTable};
use maud::{Markup, html};

/// The timing table next to the recordings; an unreadable table adds a note.
pub(super) fn timing_beside(
    source: &RecordingFolder,
    notes: &mut Vec<String>,
) -> Option<TimingTable> {
    let path = source.folder.join(TimingTable::FILE);
    let text = match read_text(&path, MAX_SIDE_FILE_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        Err(error) => {
            notes.push(format!("{} cannot be read: {error}", shown_path(&path)));
            return None;
        }
    };
    let complaint = match TimingTable::from_json(&text) {
        Ok(table) if table.schema != TimingTable::SCHEMA => {
            format!("has the layout {}, this version reads {}", table.schema, TimingTable::SCHEMA)
        }
        Ok(table) if table.experiment != source.name => {
            format!("is about the experiment {}", table.experiment)
        }
        Ok(table) => return Some(table),
        Err(error) => format!("is no timing table: {error}"),
    };
    notes.push(format!(
        "{} {complaint}; not shown. `kinetoscope benchmark --output` writes it again",
        shown_path(&path)
    ));
    None
}

/// The run times of a timing table.
pub(super) fn section(table: &TimingTable) -> Markup {
    html! {
        section {
            h2 { "Timing" }
            p {
                "The engine alone, one run at a time, nothing recorded, " (table.machine)
                ". These figures belong to that machine."
            }
            table class="numbers" {
                thead {
                    tr {
                        th { "point (runs)" } th { "mean/s" } th { "standard deviation/s" }
                        th { "median/s" } th { "steps or events/s" }
                    }
                }
                tbody {
                    @for point in &table.points {
                        @let name = format!("{} ({})", point_name(&point.coordinates), point.runs);
                        tr {
                            td { (breakable(&name)) }
                            td data-label="mean/s" { (four_digits(point.mean_s)) }
                            td data-label="deviation/s" {
                                (four_digits(point.standard_deviation_s))
                            }
                            td data-label="median/s" { (four_digits(point.median_s)) }
                            td data-label="per second" {
                                (four_digits(point.steps_or_events_per_s))
                            }
                        }
                    }
                }
            }
            (published_times(table))
            (time_ratios(table))
        }
    }
}

fn published_times(table: &TimingTable) -> Markup {
    let published = |point: &TimingPoint| {
        point.published_s.map(|seconds| (point_name(&point.coordinates), seconds, point.mean_s))
    };
    let rows: Vec<_> = table.points.iter().filter_map(published).collect();
    html! {
        @if !rows.is_empty() {
            h3 { "Published times over these" }
            p { (TimingPoint::PUBLISHED_BY) "." }
            table class="numbers" {
                thead { tr { th { "point" } th { "published/s" } th { "mean/s" } th { "ratio" } } }
                tbody {
                    @for (name, published_s, mean_s) in rows {
                        tr {
                            td { (breakable(&name)) }
                            td data-label="published/s" { (four_digits(published_s)) }
                            td data-label="mean/s" { (four_digits(mean_s)) }
                            td data-label="ratio" { (four_digits(published_s / mean_s)) }
                        }
                    }
                }
            }
        }
    }
}

fn time_ratios(table: &TimingTable) -> Markup {
    html! {
        @if let Some(comparison) = &table.comparison {
            h3 { "Time of " (comparison.of) " over time of " (comparison.over) }
            table class="numbers" {
                thead { tr { th { "point" } th { "geometric mean" } th { "median" } } }
                tbody {
                    @for ratio in comparison.ratios.iter().chain([&comparison.all]) {
                        tr {
                            td { (breakable(&point_name(&ratio.coordinates))) }
                            td data-label="mean" {
                                (with_error(ratio.mean, Some(ratio.standard_error)))
                            }
                            td data-label="median" { (four_digits(ratio.median)) }
                        }
                    }
                }
            }
        }
    }
}

/// The name of a point of a sweep.
fn point_name(coordinates: &[Coordinate]) -> String {
    match label(coordinates) {
        name if name.is_empty() => "all".to_owned(),
        name => name,
    }
}

/// A positive number in four digits.
fn four_digits(value: f64) -> String {
    let unit = libm::pow(10.0, libm::log10(value).floor() - 3.0);
    six_digits(if value > 0.0 { libm::round(value / unit) * unit } else { value })
}
