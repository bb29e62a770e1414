//! Calls of an engine's commands, such as `sbatch` and `hq`.

use std::io;
use std::process::Command;

/// Runs a command and returns its output. If it fails, the error contains its own message.
pub(super) fn output_of(command: &mut Command) -> io::Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| {
        let next = match error.kind() {
            io::ErrorKind::NotFound => ". Put it on the PATH, as the site's modules may do",
            _ => "",
        };
        io::Error::new(error.kind(), format!("{name}: {error}{next}"))
    })?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        let words = if words.trim().is_empty() { printed.as_str() } else { &words };
        return Err(io::Error::other(format!("{name}: {}", words.trim())));
    }
    Ok(printed)
}
