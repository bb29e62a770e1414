//! Errors in the arguments of a command: `error:` states what is wrong, `help:` names the nearest name.

use crate::shipped::Shipped;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use kinetoscope_console::{Exit, StandardOutput, complain};
use std::io::IsTerminal as _;

/// Prints the help, the version or the error of `command`, such as "kinetoscope run". A closed pipe is not an error.
pub(crate) fn report(error: &clap::Error, command: &str) -> Exit {
    if error.use_stderr() {
        complain(&message(error, command), false);
        return Exit::BadInput;
    }
    let output = StandardOutput::default();
    let text = error.render();
    if std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none() {
        output.print_styled(&text.ansi().to_string());
    } else {
        output.print(&text.to_string());
    }
    output.failure().map_or(Exit::Done, |failure| {
        complain(&failure, false);
        Exit::Retryable
    })
}

/// Formats an error as `error: …` and `help: …`.
pub(crate) fn message(error: &clap::Error, command: &str) -> String {
    let context = |kind| error.get(kind).and_then(best_text);
    match error.kind() {
        ErrorKind::UnknownArgument => {
            let name = context(ContextKind::InvalidArg).unwrap_or_default();
            let what = if name.starts_with('-') { "option" } else { "argument" };
            let help = key_of_manifest(&name, command).unwrap_or_else(|| {
                match context(ContextKind::SuggestedArg) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("`{command} --help` lists the options"),
                }
            });
            format!("error: unknown {what} `{name}`\nhelp: {help}")
        }
        ErrorKind::InvalidSubcommand => {
            let name = context(ContextKind::InvalidSubcommand).unwrap_or_default();
            let is_shipped = Shipped::named(&name).is_some();
            let help = match context(ContextKind::SuggestedSubcommand) {
                Some(near) => format!("did you mean `{near}`?"),
                None if is_shipped => format!(
                    "`{command} new {name} --output {name}.toml` writes this experiment, `{command} {name}.toml` runs it"
                ),
                None => format!("`{command} --help` lists the subcommands"),
            };
            format!("error: unknown subcommand `{name}`\nhelp: {help}")
        }
        ErrorKind::InvalidValue if error.get(ContextKind::ValidValue).is_some() => {
            let argument = context(ContextKind::InvalidArg).unwrap_or_default();
            let (argument, placeholder) = argument.split_once(' ').unwrap_or((&argument, ""));
            let value = context(ContextKind::InvalidValue).unwrap_or_default();
            let allowed = all_texts(error, ContextKind::ValidValue).join(", ");
            if allowed.is_empty() {
                // Any text would do, except for none.
                let placeholder = placeholder.trim_matches(['<', '>']);
                return format!(
                    "error: `{argument}` is empty\nhelp: write `{argument} {placeholder}`"
                );
            }
            let help = match context(ContextKind::SuggestedValue) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("write one of: {allowed}"),
            };
            format!("error: `{argument}` is `{value}`; must be one of: {allowed}\nhelp: {help}")
        }
        ErrorKind::MissingRequiredArgument => {
            let missing = all_texts(error, ContextKind::InvalidArg).join(", ");
            format!(
                "error: missing argument: {missing}\nhelp: `{command} --help` lists the options"
            )
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

/// What to write in place of an option that is a key of manifests, for a command that has `--set`.
fn key_of_manifest(option: &str, command: &str) -> Option<String> {
    let key = match option {
        "--seed" => "seed",
        "--replicates" => "replicates",
        "--frames" => "record.frames",
        _ => return None,
    };
    let command = command.strip_prefix("kinetoscope ").unwrap_or(command);
    let has_set = ["run-experiment", "run", "check", "why", "benchmark"].contains(&command);
    has_set.then(|| format!("write `--set {key}=N`"))
}

/// All texts of a context.
fn all_texts(error: &clap::Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::Strings(texts)) => texts.clone(),
        other => other.and_then(best_text).into_iter().collect(),
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
    use crate::messages::suggestion::with_nearest_subcommand;
    use clap::{Arg, ArgAction, Command};

    fn error(arguments: &[&str]) -> String {
        let command = Command::new("program")
            .arg(Arg::new("force").long("force").action(ArgAction::SetTrue))
            .arg(Arg::new("time-limit").long("time-limit"))
            .subcommands(["run", "schema", "check", "verify"].map(Command::new));
        let words = std::iter::once("program").chain(arguments.iter().copied());
        let error = command.clone().try_get_matches_from(words).unwrap_err();
        message(&with_nearest_subcommand(error, &command), "program")
    }

    #[test]
    fn key_of_a_manifest_is_set() {
        let message = |name: &str| {
            let command = clap::Command::new("program");
            message(&command.try_get_matches_from(["program", "--seed", "3"]).unwrap_err(), name)
        };
        let expected = "error: unknown option `--seed`\nhelp: write `--set seed=N`";
        assert_eq!(message("kinetoscope run"), expected);
        assert_eq!(message("run-experiment"), expected);
        assert!(!message("kinetoscope analyze").contains("--set"));
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
        for (written, meant) in [("chek", "check"), ("rn", "run"), ("urn", "run"), ("runn", "run")]
        {
            assert!(error(&[written]).ends_with(&format!("did you mean `{meant}`?")), "{written}");
        }
        assert!(error(&["first_run"]).contains("program new first_run --output first_run.toml"));
        assert!(error(&["simulate"]).ends_with("`program --help` lists the subcommands"));
    }
}
