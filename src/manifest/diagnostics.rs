//! The errors of a manifest: all are reported at once, each at its line with the text underlined.

use crate::tree::Span;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use kinetoscope_console::text::one_line;
use std::fmt;

/// All errors of a manifest; never empty when returned as an error.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    sources: Vec<Source>,
    found: Vec<Diagnostic>,
    /// Number of errors beyond those found.
    more: usize,
}

/// Maximum number of errors printed: a list of a million positions may contain a million errors.
const MOST_SHOWN: usize = 100;

/// Maximum number of errors collected: a manifest may contain a million unknown keys, each with a long message.
const MOST_COLLECTED: usize = 1000;

/// The errors found so far; beyond [`MOST_COLLECTED`], only their number.
#[derive(Debug, Default)]
pub(crate) struct Errors {
    found: Vec<Diagnostic>,
    more: usize,
}

impl Errors {
    /// One error.
    pub(crate) fn of(error: Diagnostic) -> Self {
        Self { found: vec![error], more: 0 }
    }

    /// Adds an error.
    pub(crate) fn push(&mut self, error: Diagnostic) {
        if self.is_full() { self.more += 1 } else { self.found.push(error) }
    }

    /// Whether further errors are only counted, so that their messages need not be written.
    pub(crate) fn is_full(&self) -> bool {
        self.found.len() >= MOST_COLLECTED
    }

    /// Counts an error without a message.
    pub(crate) fn count(&mut self) {
        self.more += 1;
    }

    /// Number of errors.
    pub(crate) fn len(&self) -> usize {
        self.found.len() + self.more
    }

    /// Whether there are no errors.
    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Keeps the errors that satisfy a condition, and the number of those without a message.
    pub(crate) fn retain(&mut self, holds: impl Fn(&Diagnostic) -> bool) {
        self.found.retain(holds);
    }

    /// Adds the errors of another list.
    pub(crate) fn append(&mut self, other: Self) {
        self.more += other.more;
        other.found.into_iter().for_each(|error| self.push(error));
    }
}

#[derive(Clone, Debug)]
struct Source {
    name: String,
    text: String,
}

/// One error: what is wrong, where, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Diagnostic {
    title: String,
    marks: Vec<(Span, String)>,
}

impl Diagnostic {
    /// An error without a place, such as a table that is missing.
    pub(crate) fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), marks: Vec::new() }
    }

    /// An error between several places. The last one in the text is the one to change; the others are shown with it.
    pub(crate) fn between(
        title: impl Into<String>,
        mut places: Vec<Span>,
        label: impl Into<String>,
    ) -> Self {
        places.sort();
        let mut error = Self::new(title);
        if let Some(last) = places.pop() {
            error = error.at(last, label);
        }
        places.into_iter().fold(error, |error, place| error.at(place, ""))
    }

    /// Underlines a place. The first one is the place of the error; the others are context.
    pub(crate) fn at(mut self, span: Span, label: impl Into<String>) -> Self {
        self.marks.push((span, label.into()));
        self
    }

    /// Whether the error begins in the manifest itself, at a byte that satisfies a condition.
    pub(crate) fn starts_in(&self, holds: impl Fn(usize) -> bool) -> bool {
        self.place().is_some_and(|place| place.source == 0 && holds(place.start))
    }

    fn place(&self) -> Option<Span> {
        self.marks.first().map(|(span, _)| *span)
    }
}

impl Diagnostics {
    /// Adds a text that errors can point into and returns its number.
    pub(crate) fn source(&mut self, name: &str, text: &str) -> usize {
        let name = one_line(name).into_owned();
        self.sources.push(Source { name, text: text.to_owned() });
        self.sources.len() - 1
    }

    /// The errors in the order of the text, each once.
    pub(crate) fn with(mut self, errors: Errors) -> Self {
        let mut seen = std::collections::HashSet::new();
        self.found = errors.found.into_iter().filter(|error| seen.insert(error.clone())).collect();
        self.more = errors.more;
        self.found.sort_by_key(Diagnostic::place);
        self
    }

    /// The value, if there are no errors; otherwise all of them.
    pub(crate) fn ok_or<T>(self, value: T, found: Errors) -> Result<T, Self> {
        if found.is_empty() { Ok(value) } else { Err(self.with(found)) }
    }

    /// Number of errors.
    #[must_use]
    pub fn len(&self) -> usize {
        self.found.len() + self.more
    }

    /// Whether there are no errors.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Renders the errors as text, with terminal colors on request. Beyond a hundred errors, only their number is given.
    #[must_use]
    pub fn render(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let shown = self.found.iter().take(MOST_SHOWN);
        let mut rendered: Vec<String> =
            shown.map(|error| self.render_one(error, &renderer)).collect();
        if self.len() > rendered.len() {
            let more = format!("and {} more errors", self.len() - rendered.len());
            let title = Level::ERROR.primary_title(more);
            rendered.push(renderer.render(&[Group::with_title(title)]));
        }
        rendered.join("\n\n")
    }

    fn render_one(&self, error: &Diagnostic, renderer: &Renderer) -> String {
        let title = Level::ERROR.primary_title(&*error.title);
        let Some(place) = error.place() else {
            let origin = self.sources.first().map_or("manifest", |source| &*source.name);
            let title = Level::ERROR.primary_title(format!("{origin}: {}", error.title));
            return renderer.render(&[Group::with_title(title)]);
        };
        let mut group = Group::with_title(title);
        let mut sources = vec![place.source];
        for (span, _) in &error.marks {
            if !sources.contains(&span.source) {
                sources.push(span.source);
            }
        }
        for number in sources {
            group = group.element(self.snippet(number, error));
        }
        renderer.render(&[group])
    }

    /// The lines of one text that an error's marks touch.
    fn snippet<'a>(
        &'a self,
        number: usize,
        error: &'a Diagnostic,
    ) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
        let source = &self.sources[number];
        let marks: Vec<_> = error.marks.iter().filter(|(span, _)| span.source == number).collect();
        let first = marks.iter().map(|(span, _)| span.start).min().unwrap_or(0);
        let last = marks.iter().map(|(span, _)| span.end).max().unwrap_or(0);
        // Only the lines in question: a manifest may hold a million positions.
        // A mark may lie within a character.
        let whole = |byte: usize| source.text.floor_char_boundary(byte);
        let (first, last) = (whole(first), whole(last));
        let begin = source.text[..first].rfind('\n').map_or(0, |newline| newline + 1);
        let end = source.text[last..].find('\n').map_or(source.text.len(), |length| last + length);
        let line = 1 + source.text[..begin].matches('\n').count();
        let mut snippet =
            Snippet::source(&source.text[begin..end]).line_start(line).path(&*source.name);
        for (span, label) in marks {
            let kind = if Some(*span) == error.place() {
                AnnotationKind::Primary
            } else {
                AnnotationKind::Context
            };
            let range = whole(span.start) - begin..whole(span.end) - begin;
            // A title and a source are escaped by the renderer, a label is not: it may name what the manifest contains.
            snippet = snippet.annotation(kind.span(range).label(one_line(label)));
        }
        snippet
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}

/// Returns the known name that the user most likely meant: one of whose words, between hyphens, this is, or one a few letters away, or else
/// the shortest that contains the word.
pub fn nearest<'a>(
    word: &str,
    known: impl IntoIterator<Item = &'a str> + Clone,
) -> Option<&'a str> {
    let mut names = known.clone().into_iter();
    if let Some(name) =
        names.find(|name| name.contains('-') && name.split('-').any(|it| it == word))
    {
        return Some(name);
    }
    let typo = known
        .clone()
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(word, name), name))
        .filter(|(distance, name)| *distance <= 1 + name.chars().count() / 5)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name);
    let part = || {
        let names = known.into_iter().filter(|name| word.len() > 2 && name.contains(word));
        names.min_by_key(|name| name.len())
    };
    typo.or_else(part)
}
