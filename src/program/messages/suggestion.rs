//! The subcommand that a user meant.

use clap::Command;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

/// Adds the subcommand that differs from the unknown one by one letter, if clap suggests none: clap does
/// not suggest `run` for `rn`, because too few letters of a short name remain.
pub(crate) fn with_nearest_subcommand(mut error: Error, command: &Command) -> Error {
    let near = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(name))
            if error.kind() == ErrorKind::InvalidSubcommand
                && error.get(ContextKind::SuggestedSubcommand).is_none() =>
        {
            let mut known = command.get_subcommands().map(Command::get_name);
            known.find(|known| strsim::damerau_levenshtein(name, known) == 1).map(str::to_owned)
        }
        _ => None,
    };
    if let Some(near) = near {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::String(near));
    }
    error
}
