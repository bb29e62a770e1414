//! From TOML text to a tree, with the syntax errors.

use crate::diagnostics::{Diagnostic, Diagnostics, Errors};
use crate::tree::{self, Span, Table};
use toml::de::DeTable;

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
    let (parsed, refused) = DeTable::parse_recoverable(source);
    let mut syntax =
        SyntaxErrors { errors: Errors::default(), lines: Vec::new(), hides_tables: false };
    for error in refused {
        let range = error.span().unwrap_or(0..0);
        let start = source.floor_char_boundary(range.start);
        let begin = source[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let end = source[start..].find('\n').map_or(source.len(), |length| start + length);
        syntax.hides_tables |= source[begin..end].trim_start().starts_with('[');
        syntax.lines.push(begin..end + 1);
        let span = Span { source: number, start: range.start, end: range.end };
        syntax.errors.push(Diagnostic::new("this is not TOML").at(span, error.message()));
    }
    (tree::table(parsed.get_ref(), number, 0), syntax)
}
