//! Errors in the arguments of all programs: `error:` states what is wrong, `help:` names the nearest or the new name.

mod old_flags;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::io::Write as _;

/// How a call ends whose arguments were not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Help or version was requested and printed.
    Answered,
    /// The arguments are wrong; the error was printed.
    Rejected,
}

/// Prints the help, the version or the error of `command`, such as "kinetoscope run". A closed pipe is not an error.
#[must_use]
pub fn report(error: &clap::Error, command: &str) -> Ended {
    if !error.use_stderr() {
        let _ = error.print();
        return Ended::Answered;
    }
    let _ = writeln!(std::io::stderr(), "{}", message(error, command));
    Ended::Rejected
}

/// Formats an error as `error: …` and `help: …`.
#[must_use]
pub fn message(error: &clap::Error, command: &str) -> String {
    let context = |kind| error.get(kind).and_then(best_text);
    match error.kind() {
        ErrorKind::UnknownArgument => {
            let name = context(ContextKind::InvalidArg).unwrap_or_default();
            let what = if name.starts_with('-') { "option" } else { "argument" };
            let help = old_flags::replacement(&name).unwrap_or_else(|| {
                match context(ContextKind::SuggestedArg) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("`{command} --help` lists the options"),
                }
            });
            format!("error: unknown {what} `{name}`\nhelp: {help}")
        }
        ErrorKind::InvalidSubcommand => {
            let name = context(ContextKind::InvalidSubcommand).unwrap_or_default();
            let help = match context(ContextKind::SuggestedSubcommand) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("`{command} --help` lists the subcommands"),
            };
            format!("error: unknown subcommand `{name}`\nhelp: {help}")
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            error.render().to_string().trim_end().to_owned()
        }
        _ => {
            let text = error.render().to_string();
            let what = ["\n\nUsage:", "\n\nFor more", "\n\n  tip:"]
                .iter()
                .filter_map(|end| text.find(end))
                .min()
                .map_or(text.as_str(), |end| &text[..end]);
            format!("{}\nhelp: `{command} --help` lists the options", what.trim_end())
        }
    }
}

/// The best text of a context: if an error suggests several names, the nearest is the last one.
fn best_text(value: &ContextValue) -> Option<String> {
    match value {
        ContextValue::String(text) => Some(text.clone()),
        ContextValue::Strings(texts) => texts.last().cloned(),
        _ => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::message;
    use clap::{Arg, ArgAction, Command};

    fn error(arguments: &[&str]) -> String {
        let command = Command::new("program")
            .arg(Arg::new("force").long("force").action(ArgAction::SetTrue))
            .arg(Arg::new("time-limit").long("time-limit"))
            .subcommands(["schema", "check", "verify"].map(Command::new));
        let words = std::iter::once("program").chain(arguments.iter().copied());
        message(&command.try_get_matches_from(words).unwrap_err(), "program")
    }

    #[test]
    fn old_flag_names_its_replacement() {
        let expected = "error: unknown option `--time`\nhelp: use `kinetoscope benchmark MANIFEST`";
        assert_eq!(error(&["--time"]), expected);
    }

    #[test]
    fn misspelled_option_names_the_nearest() {
        let expected = "error: unknown option `--forse`\nhelp: did you mean `--force`?";
        assert_eq!(error(&["--forse"]), expected);
    }

    #[test]
    fn misspelled_subcommand_names_the_nearest() {
        let expected = "error: unknown subcommand `verfy`\nhelp: did you mean `verify`?";
        assert_eq!(error(&["verfy"]), expected);
        assert!(error(&["chek"]).ends_with("did you mean `check`?"));
    }
}
