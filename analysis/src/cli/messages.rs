//! What all commands print: errors, with the exit codes to which they lead, at the width of the terminal.

use super::exit::CommandError;
use crate::input::UnreadableRecording;
use crate::report::table::Terminal;
use kinetoscope_console::{Exit, StandardOutput, complain};
use serde_json::json;
use std::io::IsTerminal;

/// Width of a table that is written to a file or a pipe.
const PLAIN_WIDTH: usize = 100;

/// Prints the error of a command or of its output, and returns the exit code. A finding weighs more than output that cannot be
/// written.
pub(super) fn concluded(
    result: Result<Exit, CommandError>,
    output: &StandardOutput,
    is_json: bool,
) -> Exit {
    let exit = result.unwrap_or_else(|CommandError { exit, message }| {
        // The errors of a checks file begin with the word already.
        let message = message.to_string();
        let text = format!("error: {}", message.strip_prefix("error: ").unwrap_or(&message));
        complain(&text, false);
        if is_json {
            let document = json!({ "exit_code": exit.code(), "errors": [text] });
            output.print_json(&format!("{document:#}\n"));
        }
        exit
    });
    match output.failure() {
        Some(failure) => {
            complain(&failure, false);
            if exit == Exit::Done { Exit::Retryable } else { exit }
        }
        None => exit,
    }
}

/// Prints why an input cannot be read, and what to do.
pub(super) fn complain_unreadable(why: &UnreadableRecording) {
    complain(&format!("error: {}", why.message), false);
}

pub(super) fn terminal() -> Terminal {
    let interactive = std::io::stdout().is_terminal();
    let size = terminal_size::terminal_size().filter(|_| interactive);
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = size.map(|(width, _)| usize::from(width.0)).or(columns).unwrap_or(PLAIN_WIDTH);
    let colors = interactive && std::env::var_os("NO_COLOR").is_none();
    Terminal { width: width.max(40), colors }
}
