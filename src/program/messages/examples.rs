//! The examples in the help of each subcommand.

/// What a user wants to do first, at the end of the help of the program.
pub(crate) const FIRST_STEPS: &str = "First steps:
  kinetoscope demo                      one experiment from manifest to report
  kinetoscope new --list                experiments that the program carries
  kinetoscope new gas --output my.toml  a manifest to change
  kinetoscope check my.toml             what a run will cost
  kinetoscope run my.toml               record it
  kinetoscope analyze my.toml --open    the answer, and the report in the browser

The user guide is the folder `book` of a release; `kinetoscope help COMMAND` shows examples.
With KINETOSCOPE_ASCII=1, messages and results are ASCII.";

/// Examples of each subcommand, as words after `kinetoscope`.
pub(crate) const EXAMPLES: &[(&str, &[&str])] = &[
    ("run", &["run exp.toml", "run exp.toml --set seed=2 --jobs 4", "run experiments --live"]),
    ("simulate", &["simulate"]),
    ("new", &["new gas", "new first_run --output first_run.toml", "new --list"]),
    ("demo", &["demo"]),
    ("check", &["check exp.toml", "check --locked"]),
    ("lock", &["lock exp.toml"]),
    ("bundle", &["bundle exp.toml --author NAME --affiliation ORGANIZATION --license CC-BY-4.0"]),
    ("reproduce", &["reproduce first_run.zip"]),
    ("verify", &["verify recordings/first_run", "verify recordings/sweep --sample 100"]),
    ("compare", &["compare one.mcap other.mcap", "compare one.mcap other.mcap --find-step"]),
    ("fill", &["fill run.mcap"]),
    ("zoom", &["zoom run.mcap --from 0.1 --to 0.2 --every 0.001"]),
    ("restore", &["restore recordings/sweep --where replicate=17"]),
    ("why", &["why exp.toml"]),
    ("info", &["info run.mcap"]),
    ("benchmark", &["benchmark exp.toml"]),
    (
        "analyze",
        &[
            "analyze exp.toml --open",
            "analyze --junit checks.xml recordings",
            "analyze --baseline old/metrics.json recordings/first_run",
        ],
    ),
    ("export", &["export --format csv recordings/first_run"]),
    ("plot", &["plot recordings/first_run --y /energy.kinetic_j --output energy.svg"]),
    (
        "table",
        &["table recordings/sweep --columns temperature_k,pressure.measured --group temperature_k"],
    ),
    (
        "grade",
        &[
            "grade answer.toml",
            "grade answer.toml --hand-in hand_in.toml",
            "grade --class hand_ins",
        ],
    ),
    ("view", &["view recordings/first_run"]),
    ("schema", &["schema"]),
    ("completions", &["completions bash"]),
    ("man-pages", &["man-pages man"]),
    ("doctor", &["doctor"]),
];

/// The end of the help of a subcommand: its examples and what else follows.
pub(crate) fn with_examples(subcommand: &str, rest: &str) -> String {
    let own = EXAMPLES.iter().filter(|(name, _)| *name == subcommand);
    let lines: Vec<String> = own
        .flat_map(|(_, examples)| examples.iter())
        .map(|words| format!("\n  kinetoscope {words}"))
        .collect();
    let title = if lines.len() > 1 { "Examples" } else { "Example" };
    format!("{title}:{}\n\n{rest}", lines.concat())
}
