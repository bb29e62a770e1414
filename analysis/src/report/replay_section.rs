//! The section of `report.html` that answers with pictures: the runs play, with the plot of the question next to them. The players are hidden until the
//! script of the page shows them; the plot is an image without it.

use crate::input::coordinates::label;
use crate::models::height_layers;
use crate::replay::{self, Replay};
use crate::report::AnalysisReport;
use crate::run::{RunAnalysis, RunStatus};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{ViewColor, ViewFrame, ViewRequest};
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// Factors of the speed of the playback.
const SPEEDS: [&str; 7] = ["0.1", "0.25", "0.5", "1", "2", "4", "10"];

/// What the color of a particle can mean, in words.
const COLORS: [(ViewColor, &str); 5] = [
    (ViewColor::Speed, "speed"),
    (ViewColor::Height, "height at start"),
    (ViewColor::Side, "side at start"),
    (ViewColor::Species, "species"),
    (ViewColor::Spin, "spin"),
];

/// Maximum number of runs that play in parallel, as in the script.
const MOST_PLAYERS: usize = 6;

/// A run that plays.
type Played<'a> = (&'a RunAnalysis, &'a Replay);

/// The replays of the runs and the plot of the question; nothing if there are neither.
pub(super) fn section(report: &AnalysisReport, plot: &Markup) -> Markup {
    let played = played(report);
    let has_plot = !plot.0.is_empty();
    html! {
        @if !played.is_empty() || has_plot {
            section class="replay" {
                h2 class="unseen" { "Replay" }
                div class="split" {
                    @if !played.is_empty() { (deck(&played, report.runs.len(), &report.view)) }
                    @if has_plot { div class="adjacent" { (plot) (live(&played)) } }
                }
            }
        }
        @for (run, replay) in &played { (film(run, replay)) }
    }
}

/// The distribution in the frame that is shown, which the script draws: for a gas in gravity of the heights, if the law of all runs is the same, else for
/// equal particles of the speeds.
fn live(played: &[Played<'_>]) -> Markup {
    let Some((first, replay)) = played.first() else { return html! {} };
    let layers_of = |run: &RunAnalysis| height_layers(&run.manifest.model);
    let layers = layers_of(first).filter(|own| {
        played.iter().all(|(run, _)| layers_of(run).is_some_and(|other| other == *own))
    });
    if let Some(layers) = layers {
        // Numbers cannot be refused.
        let data = serde_json::to_string(&layers).unwrap_or_default();
        let caption = "Density by height in this frame, with the barometric law";
        let label =
            "Histogram of the heights as densities over their mean, with the barometric law";
        return live_figure(caption, label, "height (m)", Some(&data));
    }
    // The speeds of several masses have no common distribution.
    let has_law = match &*first.manifest.model {
        ModelConfig::Gas(gas) => gas.additional_masses_kg.is_empty(),
        ModelConfig::Packing(_) => true,
        _ => false,
    };
    let unit = replay.film.as_ref().map(|film| film.units[1].as_str());
    let axis = match unit.filter(|unit| !unit.is_empty()) {
        Some(unit) => format!("speed ({unit})"),
        None => "speed".to_owned(),
    };
    let caption = "Speeds in this frame, with Maxwell's distribution";
    let label = "Histogram of the speeds, with Maxwell's distribution of the same mean square";
    html! { @if has_law { (live_figure(caption, label, &axis, None)) } }
}

fn live_figure(caption: &str, label: &str, axis: &str, layers: Option<&str>) -> Markup {
    html! {
        figure class="live" data-axis=(axis) data-layers=[layers] hidden {
            figcaption { (caption) }
            svg class="sheet" viewBox="0 0 480 190" role="img" aria-label=(label) {}
        }
    }
}

/// What the replays leave out: runs, or all positions. Nothing if all runs are replayed.
pub(super) fn left_out(report: &AnalysisReport) -> Markup {
    let replays = || report.runs.iter().filter_map(|run| run.replay.as_ref());
    if replays().all(|replay| replay.film.is_none()) {
        let notes: BTreeSet<&str> = replays().map(|replay| replay.note.as_str()).collect();
        return html! { @for note in notes { p class="facts" { (note) } } };
    }
    let others: Vec<&RunAnalysis> = report.runs.iter().filter(|run| run.replay.is_none()).collect();
    let text = match others.len() {
        1 => " more run is not replayed",
        _ => " more runs are not replayed",
    };
    html! {
        @if !others.is_empty() {
            details {
                summary { (others.len()) (text) }
                ul { @for run in &others { li { (run_name(run, &report.view)) " (" (run.file) ")" } } }
            }
        }
    }
}

/// The runs with a replay; none if there is no film, because nothing is left to control.
fn played(report: &AnalysisReport) -> Vec<Played<'_>> {
    let runs = report.runs.iter();
    let all: Vec<_> =
        runs.filter_map(|run| run.replay.as_ref().map(|replay| (run, replay))).collect();
    if all.iter().any(|(_, replay)| replay.film.is_some()) { all } else { Vec::new() }
}

/// The players with their common controls. The runs that the manifest names, or those at the ends of a sweep, are compared, unless their times have different
/// units: then they have no common clock. `all` runs are in the report.
fn deck(played: &[Played<'_>], all: usize, view: &ViewRequest) -> Markup {
    let names: Vec<String> = played.iter().map(|(run, _)| run_name(run, view)).collect();
    let units: BTreeSet<&str> = played.iter().map(|(run, _)| run.time_unit.as_str()).collect();
    let has_pair = units.len() == 1 && played.len() > 1;
    let compared = |place: usize| {
        played.iter().position(|(run, _)| view.compared(&run.coordinates) == Some(place))
    };
    // As in the picture of the list of experiments.
    let first = played.get(compared(0).unwrap_or(0));
    let film = first.and_then(|(_, replay)| replay.film.as_ref());
    let color = film.map_or(ViewColor::Speed.word(), |film| film.color.as_str());
    html! {
        div class="deck" data-species=(species(played)) hidden {
            div class="players" {
                (player(&names, compared(0).unwrap_or(0), false))
                @if has_pair { (player(&names, compared(1).unwrap_or(names.len() - 1), true)) }
            }
            (controls(if has_pair { played.len() } else { 1 }, all, view, species(played), color))
            div class="facts readout" {
                output class="clock" {}
                span class="scale" { span class="bottom" {} " " span class="bar" {} " " span class="top" {} }
            }
            p class="facts row" {}
        }
    }
}

/// Number of the species that all runs have.
fn species(played: &[Played<'_>]) -> usize {
    played.iter().map(|(run, _)| replay::species(&run.manifest.model)).min().unwrap_or(1)
}

/// Number of characters of a run's name that fit next to the words of its menu.
const LONGEST_NAME: usize = 28;

/// A menu of runs and the canvas of the chosen one. The second player shows the time of the first one, which has the controls.
fn player(names: &[String], chosen: usize, is_second: bool) -> Markup {
    let label = match is_second {
        true => "Particles of the second run",
        false => "Particles of the run; arrow keys change the frame, space plays",
    };
    // A long name needs the width of its player.
    let is_long = names.iter().any(|name| name.chars().count() > LONGEST_NAME);
    html! {
        div class="player" {
            @if names.len() > 1 {
                p {
                    label {
                        span class=[is_long.then_some("unseen")] { (if is_second { "Second run: " } else { "Run: " }) }
                        select class="runs" autocomplete="off" {
                            @for (index, name) in names.iter().enumerate() {
                                option selected[index == chosen] { (name) }
                            }
                        }
                    }
                }
            }
            div class="stage" {
                canvas tabindex=[(!is_second).then_some("0")] role="img" aria-label=(label) {}
            }
            p class="facts note" {}
        }
    }
}

/// What the first player, and the second one with it, are controlled by.
fn controls(runs: usize, all: usize, view: &ViewRequest, species: usize, color: &str) -> Markup {
    let shown = runs.min(MOST_PLAYERS);
    let many =
        if shown == all { format!("all {all} runs") } else { format!("{shown} of {all} runs") };
    let is_rotating = view.frame == Some(ViewFrame::Rotating);
    html! {
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
            label {
                "color "
                select class="colors" autocomplete="off" {
                    @for (value, name) in COLORS.iter().filter(|(value, _)| species > 1 || *value != ViewColor::Species) {
                        // The script shows that of the spin where discs spin.
                        option value=(value.word()) selected[value.word() == color] hidden[*value == ViewColor::Spin] { (name) }
                    }
                }
            }
            // The script shows the switches that the run has data for.
            label hidden { input type="checkbox" class="arrows" autocomplete="off"; " velocities" }
            label hidden { input type="checkbox" class="rotating" autocomplete="off" checked[is_rotating]; " rotating frame" }
            label hidden { input type="checkbox" class="forces" autocomplete="off" checked[view.forces]; " contact forces" }
            @if runs > 1 { label { input type="checkbox" class="pair" autocomplete="off" checked; " two runs" } }
            @if runs > 2 { label { input type="checkbox" class="many" autocomplete="off"; " " (many) } }
            button type="button" class="full" aria-label="Full screen" {
                svg viewBox="0 0 16 16" aria-hidden="true" { path d="M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4" {} }
            }
        }
    }
}

/// The data of one replay.
fn film(run: &RunAnalysis, replay: &Replay) -> Markup {
    // Continued by a time.
    let ending = match run.ending {
        RunStatus::Complete => "ended at",
        RunStatus::Fault(_) => "failed at",
        RunStatus::Unfinished | RunStatus::Damaged(_) => "stops at",
    };
    let description = replay.film.as_ref().map(|film| film.description());
    let data = replay.film.as_ref().map_or_else(String::new, |film| film.base64());
    html! {
        script type="text/plain" class="film" data-file=(run.file) data-ending=(ending) data-note=(replay.note) data-film=[description] {
            // Base64 contains no markup.
            (PreEscaped(data))
        }
    }
}

/// The run's coordinates in its sweep, or its file.
pub(super) fn run_name(run: &RunAnalysis, view: &ViewRequest) -> String {
    match label(&view.named(&run.coordinates)) {
        name if name.is_empty() => run.file.clone(),
        name => name,
    }
}
