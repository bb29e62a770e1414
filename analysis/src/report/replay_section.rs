//! The section of `report.html` in which the runs play. It is hidden until the script of the page shows it.

use crate::input::coordinates::label;
use crate::replay::Replay;
use crate::report::AnalysisReport;
use crate::run::RunAnalysis;
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// Factors of the speed of the playback.
const SPEEDS: [&str; 7] = ["0.1", "0.25", "0.5", "1", "2", "4", "10"];

/// The replays of the runs; nothing if there are none.
pub(super) fn section(report: &AnalysisReport) -> Markup {
    let replayed =
        || report.runs.iter().filter_map(|run| run.replay.as_ref().map(|replay| (run, replay)));
    let others: Vec<&RunAnalysis> = report.runs.iter().filter(|run| run.replay.is_none()).collect();
    // Without a film there is nothing to control.
    if replayed().all(|(_, replay)| replay.film.is_none()) {
        let notes: BTreeSet<&str> = replayed().map(|(_, replay)| replay.note.as_str()).collect();
        return html! { @for note in notes { p class="facts" { (note) } } };
    }
    // Times in different units have no common clock.
    let units: BTreeSet<&str> = replayed().map(|(run, _)| run.time_unit.as_str()).collect();
    let has_pair = units.len() == 1 && replayed().count() > 1;
    html! {
        @if replayed().next().is_some() {
            section class="replay" hidden {
                h2 { "Replay" }
                @let names: Vec<String> = replayed().map(|(run, _)| run_name(run)).collect();
                @if has_pair {
                    p {
                        label {
                            input type="checkbox" class="pair" autocomplete="off";
                            " two runs in parallel, with one clock"
                        }
                    }
                }
                div class="split" {
                    div class="players" {
                        (player(&names, false))
                        @if has_pair { (player(&names, true)) }
                    }
                    // The script moves plots over time here.
                    div class="adjacent" {}
                }
                @if !others.is_empty() {
                    details {
                        @let text = if others.len() == 1 { " more run is not replayed" } else { " more runs are not replayed" };
                        summary { (others.len()) (text) }
                        ul { @for run in &others { li { (run_name(run)) " (" (run.file) ")" } } }
                    }
                }
            }
            @for (run, replay) in replayed() { (film(&run.file, replay)) }
        }
    }
}

/// A menu of runs and the stage of the chosen one. The second player shows the time of the first one, which has the controls.
fn player(names: &[String], is_second: bool) -> Markup {
    html! {
        div class="player" hidden[is_second] {
            @if names.len() > 1 {
                p {
                    label {
                        (if is_second { "Second run: " } else { "Run: " })
                        select class="runs" autocomplete="off" {
                            @for name in names { option { (name) } }
                        }
                    }
                }
            }
            (stage(is_second))
            p class="note" {}
        }
    }
}

/// The canvas with its controls.
fn stage(is_second: bool) -> Markup {
    let label = match is_second {
        true => "Particles of the second run",
        false => "Particles of the run; arrow keys change the frame, space plays",
    };
    html! {
        div class="stage" {
            canvas tabindex=[(!is_second).then_some("0")] role="img" aria-label=(label) {}
            div class="controls" hidden[is_second] {
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
