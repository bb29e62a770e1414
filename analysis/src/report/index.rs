//! `index.html` of a folder of experiments, a gallery: for each its picture, name, question and result, with a link to its report, in groups by model, and
//! a filter by model and words.

use super::engine_place::EnginePlace;
use super::file_links::address;
use super::head::{checks_summary, question, result};
use super::html::page_head;
use super::{AnalysisReport, files, play};
use crate::input::host_file::utc;
use crate::models::title_of;
use crate::run::RunAnalysis;
use crate::thumbnail::still_png;
use crate::write_file::{WriteError, replace};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use kinetoscope_console::text::{plural, visible};
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use std::collections::BTreeSet;
use std::path::{Component, Path};

const INDEX_STYLE: &str = include_str!("index.css");
/// Marks the pages of this program; a page without it is the user's own.
const MARK: &str = "kinetoscope-index";
/// The script of the filter.
const INDEX_SCRIPT: &str = include_str!("index.js");

/// An experiment with the folder of its recordings and that of its report.
pub(crate) struct Listed<'a> {
    /// Its analysis.
    pub(crate) report: &'a AnalysisReport,
    /// The folder of the report.
    pub(crate) results: &'a Path,
}

/// What a card shows that is read from the recordings.
struct Card<'a> {
    listed: &'a Listed<'a>,
    link: String,
    date: Option<String>,
    /// The address of its picture; `None` without a replay.
    picture: Option<String>,
    /// The address of its run in the play page next to the index, if there is one.
    play: Option<String>,
}

/// Writes `index.html`, unless the folder contains one that this program has not written. Returns whether it did.
///
/// # Errors
/// A page that cannot be written.
pub(crate) fn write(folder: &Path, listed: &[Listed<'_>]) -> Result<bool, WriteError> {
    let path = folder.join(files::INDEX);
    if path.symlink_metadata().is_ok() {
        let is_own = read_text(&path, MAX_SIDE_FILE_BYTES)
            .is_ok_and(|text| text.contains(&format!("<main class=\"{MARK}\">")));
        if !is_own {
            return Ok(false);
        }
    }
    if let Some(first) = listed.first() {
        play::write(first.report.engine, folder)?;
    }
    let cards: Vec<Card<'_>> = listed.par_iter().map(|listed| Card::of(listed, folder)).collect();
    replace(&path, page(&cards))?;
    Ok(true)
}

impl<'a> Card<'a> {
    fn of(listed: &'a Listed<'a>, folder: &Path) -> Self {
        let ends = listed.report.hosts.iter().filter_map(|host| host.finished_unix_time_s);
        Self {
            listed,
            link: link(folder, &listed.results.join(files::REPORT)),
            date: ends.max().map(utc),
            picture: picture(listed.report),
            play: play_link(listed.report),
        }
    }

    /// The model of its runs; empty for several models.
    fn model(&self) -> &'static str {
        let mut models = self.listed.report.runs.iter().map(|run| run.model().name());
        let first = models.next().unwrap_or_default();
        if models.all(|model| model == first) { first } else { "" }
    }
}

/// The runs, from the one that the report shows first.
fn runs_by_view(report: &AnalysisReport) -> impl Iterator<Item = &RunAnalysis> {
    let is_first = |run: &&RunAnalysis| report.view.compared(&run.coordinates) == Some(0);
    report.runs.iter().filter(is_first).chain(&report.runs)
}

/// The address that opens the manifest of the first one in the play page.
fn play_link(report: &AnalysisReport) -> Option<String> {
    let is_there = matches!(report.engine, EnginePlace::NextToPage(_));
    runs_by_view(report)
        .next()
        .filter(|_| is_there)
        .and_then(|run| play::link(&run.manifest.canonical()))
}

/// The picture of the first one that has a picture, as pixels, which take less space than thousands of discs; without such a build, as lines.
fn picture(report: &AnalysisReport) -> Option<String> {
    let svg = &runs_by_view(report).find_map(|run| run.replay.as_ref()?.film.as_ref())?.picture;
    let (kind, bytes) = match still_png(svg) {
        Ok(png) => ("png", png),
        Err(_) => ("svg+xml", svg.clone().into_bytes()),
    };
    Some(format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)))
}

/// A relative link from a folder to a file below it.
fn link(folder: &Path, file: &Path) -> String {
    let relative = file.strip_prefix(folder).unwrap_or(file);
    let parts = relative.components().filter_map(|part| match part {
        Component::Normal(name) => Some(address(&name.to_string_lossy())),
        _ => None,
    });
    format!(".{}", parts.map(|part| part.trim_start_matches('.').to_owned()).collect::<String>())
}

fn page(cards: &[Card<'_>]) -> String {
    let models: BTreeSet<&str> = cards.iter().map(Card::model).collect();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (page_head("Experiments", INDEX_STYLE, &html! {}))
            body {
                main class=(MARK) {
                    header {
                        h1 { "Experiments" }
                        p class="facts" { (summary(cards)) }
                        (filter(&models))
                    }
                    @for model in &models {
                        section class="shelf" data-model=(model) {
                            h2 { (title_of(model).unwrap_or("Several models")) }
                            ul class="cards" {
                                @for entry in cards.iter().filter(|card| card.model() == *model) {
                                    li { (card(entry)) }
                                }
                            }
                        }
                    }
                }
                script { (PreEscaped(INDEX_SCRIPT)) }
            }
        }
    };
    visible(&(page.into_string() + "\n")).into_owned()
}

/// The menu and the field of the filter, which the script shows.
fn filter(models: &BTreeSet<&str>) -> Markup {
    html! {
        p class="filter" hidden {
            label { "Search " input type="search" name="words" autocomplete="off"; }
            " "
            label {
                "Model "
                select name="model" autocomplete="off" {
                    option value="" { "all" }
                    @for model in models.iter().filter(|model| !model.is_empty()) { option value=(model) { (model) } }
                }
            }
            " " output class="found" {}
        }
    }
}

/// The number of experiments, and how many of them have failures.
fn summary(cards: &[Card<'_>]) -> String {
    let failed = cards.iter().filter(|card| outcome(card.listed.report).0 == "bad").count();
    let all = match cards.len() {
        1 => "1 experiment".to_owned(),
        all => format!("{all} experiments"),
    };
    if failed == 0 { all } else { format!("{all}, {failed} with failures") }
}

fn card(card: &Card<'_>) -> Markup {
    let report = card.listed.report;
    let (class, outcome) = outcome(report);
    html! {
        @if let Some(picture) = &card.picture {
            // The words next to it say what it shows.
            img src=(picture) alt="" width="384" height="216" loading="lazy";
        } @else {
            div class="undrawn" {}
        }
        @if let Some(play) = &card.play { a class="play" href=(play) { "▶ run " span class="unseen" { (report.name) " in this browser" } } }
        div class="words" {
            h3 { a href=(card.link) title=[card.date.as_ref()] { (report.name) } }
            (question(report))
            (result(report, &card.link))
            p class="facts" {
                @if !outcome.is_empty() { strong class=(class) { (outcome) } " · " }
                (plural(report.runs.len() as u64, "run"))
            }
        }
    }
}

/// How an experiment ended, with the class of its color.
fn outcome(report: &AnalysisReport) -> (&'static str, String) {
    if let Some(headline) = report.headline() {
        return ("bad", format!("FAILED: {headline}"));
    }
    if let Some(unreadable) = report.unreadable_files() {
        return ("bad", unreadable);
    }
    checks_summary(report)
}
