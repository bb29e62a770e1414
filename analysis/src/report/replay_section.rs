//! The section of `report.html` in which the runs play. It is hidden until the script of the page shows it.

use crate::input::coordinates::label;
use crate::replay::Replay;
use crate::report::AnalysisReport;
use crate::run::RunAnalysis;
use maud::{Markup, PreEscaped, html};

/// Factors of the speed of the playback.
const SPEEDS: [&str; 7] = ["0.1", "0.25", "0.5", "1", "2", "4", "10"];

/// The replays of the runs; nothing if there are none.
pub(super) fn section(report: &AnalysisReport) -> Markup {
    let replayed =
        || report.runs.iter().filter_map(|run| run.replay.as_ref().map(|replay| (run, replay)));
    let others: Vec<&RunAnalysis> = report.runs.iter().filter(|run| run.replay.is_none()).collect();
    html! {
        @if replayed().next().is_some() {
            section class="replay" hidden {
                h2 { "Replay" }
                @if replayed().count() > 1 {
                    p {
                        label {
                            "Run: "
                            select class="runs" autocomplete="off" {
                                @for (run, _) in replayed() { option { (run_name(run)) } }
                            }
                        }
                    }
                }
                div class="split" {
                    (stage())
                    // The script moves plots over time here.
                    div class="adjacent" {}
                }
                p class="note" {}
                @if !others.is_empty() {
                    details {
                        summary { (others.len()) " more runs are not replayed" }
                        ul { @for run in &others { li { (run_name(run)) " (" (run.file) ")" } } }
                    }
                }
            }
            @for (run, replay) in replayed() { (film(&run.file, replay)) }
        }
    }
}

/// The canvas with its controls.
fn stage() -> Markup {
    html! {
        div class="stage" {
            canvas tabindex="0" role="img" aria-label="Particles of the run; arrow keys change the frame, space plays" {}
            div class="controls" {
                // The script enables these two once the frames are decoded.
                button type="button" class="play" aria-label="Play" disabled { "▶" }
                input type="range" class="scrub" min="0" max="0" value="0" step="1" autocomplete="off" aria-label="Frame" disabled;
                label {
                    "speed "
                    select class="speed" autocomplete="off" {
                        @for speed in SPEEDS {
                            option value=(speed) selected[speed == "1"] { (speed) "×" }
                        }
                    }
                }
            }
            div class="facts readout" {
                output class="clock" {}
                span class="scale" { "speed 0 " span class="bar" {} " " span class="top" {} }
            }
            p class="facts row" {}
        }
    }
}

/// The data of one replay.
fn film(file: &str, replay: &Replay) -> Markup {
    let description = replay.film.as_ref().map(|film| film.description());
    let data = replay.film.as_ref().map_or_else(String::new, |film| film.base64());
    html! {
        script type="text/plain" class="film" data-file=(file) data-note=(replay.note) data-film=[description] {
            // Base64 contains no markup.
            (PreEscaped(data))
        }
    }
}

/// The run's coordinates in its sweep, or its file.
fn run_name(run: &RunAnalysis) -> String {
    match label(&run.coordinates) {
        name if name.is_empty() => run.file.clone(),
        name => name,
    }
}
