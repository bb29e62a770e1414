//! From TOML text to a tree, with the syntax errors.

use crate::diagnostics::{Diagnostic, Diagnostics, Errors};
use crate::tree::{self, Span, Table};
use toml::Spanned;
use toml::de::DeTable;
use toml_parser::Source;

/// Maximum number of words and signs of a TOML text. Parsing takes up to about 100 bytes for each. The side file of 100,000 runs
/// with six swept keys has 7.8 million.
const MAX_TOKENS: usize = 8 << 20;
/// Size up to which all syntax errors of a text are reported. Of a larger text only the first is: each takes 300 bytes.
const MAX_BYTES_WITH_ALL_ERRORS: usize = 1 << 20;
/// Maximum number of syntax errors that are examined.
const MAX_SYNTAX_ERRORS: usize = 1000;
/// Errors of the parser that are shown: a text with more is probably no manifest.
const SHOWN_SYNTAX_ERRORS: usize = 10;

/// Why a TOML text is not parsed: a text of the size that a file may have can take many times its size in memory.
#[must_use]
pub fn excess_of_toml(text: &str) -> Option<String> {
    if text.contains('\0') {
        return Some("it has bytes that are zero, as UTF-16 has: save it as UTF-8".to_owned());
    }
    Source::new(text).lex().nth(MAX_TOKENS).is_some().then(|| {
        format!("it has more than {MAX_TOKENS} words and signs, the maximum for a TOML file")
    })
}

/// The errors of the TOML parser.
pub(crate) struct SyntaxErrors {
    pub(crate) errors: Errors,
    lines: Vec<std::ops::Range<usize>>,
    /// A `[table]` header could not be read, so the keys below it appear in the wrong table.
    pub(crate) hides_tables: bool,
}

impl SyntaxErrors {
    /// Whether an error only follows from a line that could not be read.
    pub(crate) fn explains(&self, source: &str, error: &Diagnostic) -> bool {
        error.starts_in(|start| {
            self.lines.iter().any(|line| line.contains(&start.min(source.len())))
        })
    }
}

/// The error of a TOML text that is not a manifest, shown with its line as those of a manifest are.
#[must_use]
pub fn toml_error(text: &str, origin: &str, title: &str, error: &toml::de::Error) -> Diagnostics {
    let mut diagnostics = Diagnostics::default();
    let source = diagnostics.source(origin, text);
    let Some(range) = error.span() else {
        let title = format!("{title}: {}", error.message());
        return diagnostics.with(Errors::of(Diagnostic::new(title)));
    };
    let start = text.floor_char_boundary(range.start);
    let end_of_line = text[start..].find('\n').map_or(text.len(), |length| start + length);
    // A table without a key is marked at its first line.
    let span = Span { source, start, end: range.end.min(end_of_line) };
    diagnostics.with(Errors::of(Diagnostic::new(title).at(span, error.message())))
}

/// Counts the lines of a text up to places in it. Places in ascending order take one pass over the text together.
pub(crate) struct LineCounter<'a> {
    text: &'a [u8],
    byte: usize,
    line: usize,
}

impl<'a> LineCounter<'a> {
    /// At the start of a text.
    pub(crate) fn new(text: &'a str) -> Self {
        Self { text: text.as_bytes(), byte: 0, line: 1 }
    }

    /// The line of a byte, from 1.
    pub(crate) fn line_of(&mut self, byte: usize) -> usize {
        if byte < self.byte {
            (self.byte, self.line) = (0, 1);
        }
        let passed = self.text.get(self.byte..byte).unwrap_or_default();
        self.line += passed.iter().filter(|&&byte| byte == b'\n').count();
        self.byte = byte;
        self.line
    }
}

/// Parses a TOML text into a tree, as far as it can be read.
pub(crate) fn parse_toml(
    source: &str,
    origin: &str,
    diagnostics: &mut Diagnostics,
) -> (Table, SyntaxErrors) {
    let number = diagnostics.source(origin, source);
    let mut syntax =
        SyntaxErrors { errors: Errors::default(), lines: Vec::new(), hides_tables: false };
    if let Some(excess) = excess_of_toml(source) {
        syntax.errors.push(Diagnostic::new(excess));
        syntax.hides_tables = true;
        return (Table::default(), syntax);
    }
    let (parsed, refused) = if source.len() <= MAX_BYTES_WITH_ALL_ERRORS {
        DeTable::parse_recoverable(source)
    } else {
        match DeTable::parse(source) {
            Ok(parsed) => (parsed, Vec::new()),
            Err(first) => {
                syntax.hides_tables = true;
                (Spanned::new(0..0, DeTable::default()), vec![first])
            }
        }
    };
    let hidden = refused.len().saturating_sub(SHOWN_SYNTAX_ERRORS);
    for (index, error) in refused.into_iter().take(MAX_SYNTAX_ERRORS).enumerate() {
        let range = error.span().unwrap_or(0..0);
        let start = source.floor_char_boundary(range.start);
        let begin = source[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let end = source[start..].find('\n').map_or(source.len(), |length| start + length);
        syntax.hides_tables |= source[begin..end].trim_start().starts_with('[');
        syntax.lines.push(begin..end + 1);
        if index >= SHOWN_SYNTAX_ERRORS {
            continue;
        }
        let span = Span { source: number, start: range.start, end: range.end };
        let label = number_as_meant(&source[begin..end]);
        let label = label.map_or_else(|| error.message().to_owned(), str::to_owned);
        syntax.errors.push(Diagnostic::new("this is not TOML").at(span, label));
    }
    if hidden > 0 {
        let more = format!("{hidden} more places are not TOML: is this file a manifest?");
        syntax.errors.push(Diagnostic::new(more));
    }
    (tree::table(parsed.into_inner(), number, 0), syntax)
}

/// How to write the number of a line such as `discs = 20 20`, `temperature_k = 300 K` or `radius_m = 0,1`; `None` for other lines.
fn number_as_meant(line: &str) -> Option<&'static str> {
    let value = line.split_once('=')?.1.split('#').next()?.trim();
    let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '_' | '+' | '-');
    let mut rest = value.trim_start_matches(is_of_number);
    if let Some(exponent) = rest.strip_prefix(['e', 'E']).filter(|it| it.starts_with(is_of_number))
    {
        rest = exponent.trim_start_matches(is_of_number);
    }
    if rest.len() == value.len() || !value.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let next = rest.trim_start().chars().next()?;
    match next {
        '*' | '/' | '^' | '(' | '+' | '-' => {
            Some("a number stands alone, computed: 3e2, not 3*10^2")
        }
        ',' => Some("a number has a decimal point, no comma: 0.1"),
        _ if next.is_ascii_digit() => {
            Some("one number has no spaces; several numbers are a list: [1, 2]")
        }
        _ if next.is_alphabetic() || matches!(next, '%' | '°') => {
            Some("a number stands without a unit: the end of the key's name is the unit")
        }
        _ => None,
    }
}
