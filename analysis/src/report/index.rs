//! `index.html` of a folder of experiments: for each its name, question, result, date and an animated thumbnail, with a link to its
//! report.

use crate::report::html::{STYLE_SHEET, breakable, checks_summary};
use crate::report::{AnalysisReport, files};
use crate::thumbnail::{ThumbnailFormat, ThumbnailOptions, thumbnail};
use crate::write_file::{WriteError, replace};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_usage::text::visible;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use std::num::NonZeroU32;
use std::path::{Component, Path};
use std::time::SystemTime;

const INDEX_STYLE: &str = include_str!("index.css");
/// Marks the pages of this program; a page without it is the user's own.
const MARK: &str = "kinetoscope index";
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
        let is_own = read_text(&path, MAX_SIDE_FILE_BYTES).is_ok_and(|text| text.contains(MARK));
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
        let changed = recording.as_ref().and_then(|path| path.metadata().ok()?.modified().ok());
        Self {
            listed,
            link: link(folder, &listed.results.join(files::REPORT)),
            date: changed.and_then(date),
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

/// A day such as 2026-03-01, in universal time.
fn date(time: SystemTime) -> Option<String> {
    let time = jiff::Timestamp::try_from(time).ok()?;
    Some(time.strftime("%Y-%m-%d").to_string())
}

/// A relative link from a folder to a file below it, or else the file's path.
fn link(folder: &Path, file: &Path) -> String {
    let relative = file.strip_prefix(folder).unwrap_or(file);
    let parts = relative.components().filter(|part| *part != Component::CurDir);
    let parts: Vec<String> =
        parts.map(|part| percent_encoded(&part.as_os_str().to_string_lossy())).collect();
    // A first part with a colon would be read as the scheme of an address.
    format!("./{}", parts.join("/"))
}

/// A part of a path as a part of an address.
fn percent_encoded(part: &str) -> String {
    let mut encoded = String::new();
    for byte in part.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => {
                encoded.push(char::from(byte));
            }
            _ => encoded += &format!("%{byte:02X}"),
        }
    }
    encoded
}

fn page(cards: &[Card<'_>]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="generator" content=(MARK);
                title { "Experiments" }
                style { (PreEscaped(STYLE_SHEET)) (PreEscaped(INDEX_STYLE)) }
            }
            body {
                main {
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
    let failed = cards.iter().filter(|card| result(card.listed.report).0 == "bad").count();
    let all = match cards.len() {
        1 => "1 experiment".to_owned(),
        all => format!("{all} experiments"),
    };
    if failed == 0 { all } else { format!("{all}, {failed} with failures") }
}

fn card(card: &Card<'_>) -> Markup {
    let report = card.listed.report;
    let (class, result) = result(report);
    let runs = report.runs.len();
    html! {
        @if let Some(bytes) = &card.thumbnail {
            img src={ "data:image/png;base64," (STANDARD.encode(bytes)) } alt={ "A run of " (report.name) };
        } @else {
            div class="undrawn" {}
        }
        div class="words" {
            h2 { a href=(card.link) { (breakable(&report.name)) } }
            p { (report.description) }
            p { strong class=(class) { (result) } }
            p class="facts" {
                (report.model()) " · " (runs) @if runs == 1 { " run" } @else { " runs" }
                @if let Some(date) = &card.date { " · " (date) }
            }
        }
    }
}

/// The result of an experiment with the class of its color.
fn result(report: &AnalysisReport) -> (&'static str, String) {
    if let Some(headline) = report.headline() {
        return ("bad", format!("FAILED: {headline}"));
    }
    if !report.unreadable.is_empty() {
        return ("bad", format!("{} unreadable", report.unreadable.len()));
    }
    checks_summary(report)
}
