//! Flags of the programs before 0.1.0, with what replaces them. Kept for 0.1 only.

/// Old flag, the subcommand that has its replacement, and the replacement: an option, or options and arguments of a subcommand.
const OLD_FLAGS: &[(&str, &str, &str)] = &[
    ("--verify", "verify", "RECORDING"),
    ("--compare", "compare", "RECORDING OTHER"),
    ("--attested", "verify", "--check-attestation RECORDING"),
    ("--why", "why", "MANIFEST"),
    ("--new", "new", "MODEL"),
    ("--schema", "schema", ""),
    ("--time", "benchmark", "MANIFEST"),
    ("--metrics", "analyze", "--list-metrics"),
    ("--thumbnail", "export", "--thumbnail FILE RECORDING"),
    ("--thumbnail-frames", "export", "--thumbnail FILE --thumbnail-frames N RECORDING"),
    ("--thumbnail-width", "export", "--thumbnail FILE --thumbnail-width PIXELS RECORDING"),
    ("--fresh", "analyze", "--no-cache"),
    ("--remember", "analyze", "--cache-only"),
    ("--pictures-at", "analyze", "--snapshots-at"),
    ("--table", "analyze", "--metrics-table"),
    ("--github", "analyze", "--github-annotations"),
    ("--starts-in", "run", "--start-from-dir"),
    ("--only", "run", "--only-keys"),
];

/// What to use in place of an old flag of `command`, such as "run-experiment"; `None` for a flag that never existed. An option of
/// another subcommand is named with it.
pub(crate) fn replacement(flag: &str, command: &str) -> Option<String> {
    let (_, subcommand, new) = OLD_FLAGS.iter().find(|(old, ..)| *old == flag)?;
    let called = match command {
        "run-experiment" => Some("run"),
        "analyze-recordings" => Some("analyze"),
        _ => command.strip_prefix("kinetoscope "),
    };
    let is_option = new.starts_with("--") && !new.contains(' ');
    if is_option && called == Some(*subcommand) {
        return Some(format!("use `{new}`"));
    }
    let whole = format!("kinetoscope {subcommand} {new}");
    Some(format!("use `{}`", whole.trim_end()))
}
