//! Flags of the programs before 0.1.0, with what replaces them. Kept for 0.1 only.

/// Old flag and its replacement: a command that starts with `kinetoscope`, or the new name of the flag.
const OLD_FLAGS: &[(&str, &str)] = &[
    ("--verify", "kinetoscope verify RECORDING"),
    ("--compare", "kinetoscope compare RECORDING OTHER"),
    ("--attested", "kinetoscope verify --check-attestation RECORDING"),
    ("--why", "kinetoscope why MANIFEST"),
    ("--new", "kinetoscope new MODEL"),
    ("--schema", "kinetoscope schema"),
    ("--time", "kinetoscope benchmark MANIFEST"),
    ("--metrics", "kinetoscope analyze --list-metrics"),
    ("--thumbnail", "kinetoscope export --thumbnail FILE RECORDING"),
    ("--thumbnail-frames", "kinetoscope export --thumbnail FILE --thumbnail-frames N RECORDING"),
    ("--thumbnail-width", "kinetoscope export --thumbnail FILE --thumbnail-width PIXELS RECORDING"),
    ("--fresh", "--no-cache"),
    ("--remember", "--cache-only"),
    ("--pictures-at", "--snapshots-at"),
    ("--table", "--metrics-table"),
    ("--github", "--github-annotations"),
    ("--starts-in", "--start-from-dir"),
    ("--only", "--only-keys"),
];

/// What to use in place of an old flag; `None` for a flag that never existed.
pub(crate) fn replacement(flag: &str) -> Option<String> {
    let (_, new) = OLD_FLAGS.iter().find(|(old, _)| *old == flag)?;
    Some(format!("use `{new}`"))
}
