//! Standard output and standard error of the three programs.

use crate::ascii::as_requested;
use crate::text;
use crate::wrap::{wrapped_messages, wrapped_text};
use std::io::{self, ErrorKind, IsTerminal as _, Write as _};
use std::sync::OnceLock;

/// Standard output. The first write that fails is kept, and nothing is written after it: the command ends with exit code 75. A
/// closed pipe (`| head`) is not an error.
#[derive(Debug, Default)]
pub struct StandardOutput {
    failure: OnceLock<io::Error>,
}

impl StandardOutput {
    /// Prints text without control characters or commands of a CI system.
    pub fn print(&self, text: &str) {
        self.write(&as_requested(text::output(text, false)));
    }

    /// Prints text as [`Self::print`], wrapped between words at the width of the terminal, or of `COLUMNS` in a file or a pipe.
    pub fn print_wrapped(&self, text: &str) {
        let columns = || std::env::var("COLUMNS").ok()?.parse().ok();
        let width = if io::stdout().is_terminal() { output_width() } else { columns() };
        let wrapped = width.map(|width| wrapped_text(text, MIN_WIDTH.max(width)));
        self.print(wrapped.as_deref().unwrap_or(text));
    }

    /// Prints text whose styles are the program's own: text that was read from files is escaped in it.
    pub fn print_styled(&self, text: &str) {
        self.write(&as_requested(text::output(text, true)));
    }

    /// Prints a JSON document.
    pub fn print_json(&self, document: &str) {
        self.write(&text::json(document));
    }

    /// Prints text that contains nothing that was read from files, or nothing that is not escaped, such as commands for a CI
    /// system.
    pub fn print_exactly(&self, text: &str) {
        self.write(text);
    }

    fn write(&self, text: &str) {
        if self.failure.get().is_some() {
            return;
        }
        let mut output = io::stdout().lock();
        let written = output.write_all(text.as_bytes()).and_then(|()| output.flush());
        if let Err(error) = written {
            // Only the first failure is kept.
            let _ = self.failure.set(error);
        }
    }

    /// Why the output is incomplete, and the user's next step; `None` if all of it was written, or if its reader stopped reading.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let error = self.failure.get().filter(|error| error.kind() != ErrorKind::BrokenPipe)?;
        Some(format!(
            "error: standard output cannot be written: {error}\nhelp: free disk space or write to another file; then run the same command again"
        ))
    }
}

/// Minimum width of a message.
const MIN_WIDTH: usize = 40;

/// Prints a line to standard error, with control characters and commands of a CI system escaped. On a terminal, errors and
/// their help are wrapped; in a file or a pipe, each stays on one line. If standard error is closed, the exit code still reports the
/// error.
pub fn complain(text: &str, has_styles: bool) {
    let mut output = io::stderr().lock();
    let width = terminal_width(&output).filter(|_| output.is_terminal());
    let wrapped = width.map(|width| wrapped_messages(text, MIN_WIDTH.max(width)));
    let safe = text::output(wrapped.as_deref().unwrap_or(text), has_styles);
    let _ = writeln!(output, "{}", as_requested(safe));
}

#[cfg(any(unix, windows))]
fn terminal_width(output: &io::StderrLock<'_>) -> Option<usize> {
    terminal_size::terminal_size_of(output).map(|(width, _)| width.0.into())
}

/// The width of the terminal to which standard output goes.
#[cfg(any(unix, windows))]
fn output_width() -> Option<usize> {
    terminal_size::terminal_size().map(|(width, _)| width.0.into())
}

#[cfg(not(any(unix, windows)))]
fn output_width() -> Option<usize> {
    None
}

/// Without a terminal, messages are not wrapped.
#[cfg(not(any(unix, windows)))]
fn terminal_width(_: &io::StderrLock<'_>) -> Option<usize> {
    None
}
