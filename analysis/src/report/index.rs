//! `index.html` of a folder of experiments: for each its name, question, result, date and an animated thumbnail, with a link to its
//! report.

use super::file_links::address;
use super::head::{checks_summary, question, result};
use super::html::page_head;
use super::markup::breakable;
use super::{AnalysisReport, files};
use crate::input::host_file::utc;
use crate::thumbnail::{ThumbnailFormat, ThumbnailOptions, thumbnail};
use crate::write_file::{WriteError, replace};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use kinetoscope_console::text::visible;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_recording::reader::Recording;
use maud::{DOCTYPE, Markup, html};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use std::num::NonZeroU32;
use std::path::{Component, Path};

const INDEX_STYLE: &str = include_str!("index.css");
/// Marks the pages of this program; a page without it is the user's own.
const MARK: &str = "kinetoscope-index";
/// Width of a thumbnail, px.
const THUMBNAIL_WIDTH: NonZeroU32 = NonZeroU32::new(240).unwrap();
/// Pictures of a thumbnail.
const THUMBNAIL_FRAMES: NonZeroU32 = NonZeroU32::new(16).unwrap();
/// A larger thumbnail is replaced by one that does not move, or omitted, bytes.
const MAX_THUMBNAIL_BYTES: usize = 150_000;

/// An experiment with the folder of its recordings and that of its report.
pub(crate) struct Listed<'a> {
    /// Its analysis.
    pub(crate) report: &'a AnalysisReport,
    /// The folder of the recordings.
    pub(crate) recordings: &'a Path,
    /// The folder of the report.
    pub(crate) results: &'a Path,
}

/// What a card shows that is read from the recordings.
struct Card<'a> {
    listed: &'a Listed<'a>,
    link: String,
    date: Option<String>,
    thumbnail: Option<Vec<u8>>,
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
    let cards: Vec<Card<'_>> = listed.par_iter().map(|listed| Card::of(listed, folder)).collect();
    replace(&path, page(&cards))?;
    Ok(true)
}

impl<'a> Card<'a> {
    fn of(listed: &'a Listed<'a>, folder: &Path) -> Self {
        let first = listed.report.runs.first();
        let recording = first.map(|run| listed.recordings.join(&run.file));
        let ends = listed.report.hosts.iter().filter_map(|host| host.finished_unix_time_s);
        Self {
            listed,
            link: link(folder, &listed.results.join(files::REPORT)),
            date: ends.max().map(utc),
            thumbnail: recording.as_deref().and_then(drawn),
        }
    }
}

/// A thumbnail of bounded size; `None` of a recording without drawings.
fn drawn(path: &Path) -> Option<Vec<u8>> {
    [THUMBNAIL_FRAMES, NonZeroU32::MIN].into_iter().find_map(|frames| {
        let format = ThumbnailFormat::Png { frames };
        let options = ThumbnailOptions { format, width: THUMBNAIL_WIDTH };
        let bytes = thumbnail(&Recording::open(path).ok()?, options).ok()?;
        (bytes.len() <= MAX_THUMBNAIL_BYTES).then_some(bytes)
    })
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
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (page_head("Experiments", INDEX_STYLE))
            body {
                main class=(MARK) {
                    header {
                        h1 { "Experiments" }
                        p class="facts" { (summary(cards)) }
                    }
                    ul class="cards" { @for entry in cards { li { (card(entry)) } } }
                }
            }
        }
    };
    visible(&(page.into_string() + "\n")).into_owned()
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
        @if let Some(bytes) = &card.thumbnail {
            img src={ "data:image/png;base64," (STANDARD.encode(bytes)) } alt={ "A run of " (report.name) };
        } @else {
            div class="undrawn" {}
        }
        div class="words" {
            h2 { a href=(card.link) { (breakable(&report.name)) } }
            (question(report))
            (result(report, &card.link))
            p { strong class=(class) { (outcome) } }
            p class="facts" {
                (report.models_and_runs())
                @if let Some(date) = &card.date { " · " (date) }
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
