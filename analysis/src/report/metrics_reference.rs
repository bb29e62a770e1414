//! The reference of all metrics, `docs/metrics.md`.

use crate::metric::symbols::SYMBOLS;
use crate::metric::{Definition, Law};
use crate::models::MODELS;
use crate::report::table::{Style, Terminal};
use std::fmt::Write as _;

const HEAD: &str = "\
# Metrics

The metrics that `kinetoscope analyze` computes, as `kinetoscope analyze --list-metrics` prints them; `--list-metrics gas pressure` prints those
of the gas with that word.

Each metric has a value. It has a standard error if replicates or a time series provide one (replicates: standard deviation over the root of their number; a series: blocking,
Flyvbjerg and Petersen 1989), a theoretical value if a law below provides one, and then the deviation from theory in standard errors. A
deviation within the stated rounding, or within 1e-9 of the theoretical value, is reported as rounding, without a number.
For several replicates at one point of a sweep, the mean is reported as well, under the same name. An empty unit is the model's own.

A metric does not depend on the frame interval unless its definition names frames: largest energy errors and residuals are those `of the frames`,
a settling time is that of a frame, and averages over the last tenth or the second half of a run begin at a frame.

`last frame` is the last intact frame; `/energy` and the like are topics of the recording. For packing, the `sampled frames` are every k-th
frame after 5 events per disc, with k the number of discs over 32, rounded up, or the last frame if there is none.

## Symbols

`<v>` is a mean over the particles. A subscript 0 is an initial value.

| symbol | meaning |
|---|---|
";

const FILES: &str = "
## metrics.json

`{\"schema\": 3, \"experiment\", \"question\", \"answer\", \"model\", \"analysis_version\", \"run_count\", \"runs\": [...], \"definitions\": {...}, \"metrics\": [...]}`. `docs/metrics.schema.json` is its JSON Schema.
Numbers that are not known or not finite are null. `schema` is raised when a field goes or changes its meaning; new fields do not raise it.

A run has `file`, `run_key`, `coordinates`, `replicate`, `seed`, `program_version` and `physics_version` (of the program that recorded it), `outcome`
(complete, fault, unfinished or damaged), `outcome_detail` (what failed), `frames`, and `manifest`: the dotted keys of its canonical manifest with their values as
TOML. A value of more than 200 characters is represented by its SHA-256.

`definitions` has one entry per name of a metric: `unit`, `source` (how the value is found) and `laws`, each with its `source` (law and literature) and the `range`
in which it holds (null: everywhere).

Up to 1000 runs, `metrics` contains the metrics of the sweep and those of each run. For more, `runs` is empty, `metrics` contains the means over replicates and the
fits, and `checks` contains the results of the checks (`subject`, `passed`, `finding`).

| field of a metric | meaning |
|---|---|
| `name`, `unit` | as in the tables above |
| `value` | the value; null if it cannot be computed |
| `standard_error` | the scatter that other seeds would show |
| `conditional_standard_error` | the error given the run's own start, where theory is computed from that start; the deviation uses it |
| `degrees_of_freedom` | of the standard error, for Student's t; null if the error is as good as exact |
| `theory` | null, or `value`, `accuracy` (of the law, in the metric's unit; 0 if exact), `law` (its index in `laws` of the definition), `in_range` (whether the run is in the range) |
| `deviation_sigma` | deviation from theory over error and accuracy together; null within rounding, with an unknown error, with an error below the accuracy, which is a bound, and outside the range |
| `applicable` | whether the metric has a value |
| `reason` | why the value, its error or its deviation is missing |
| `run` | of a metric of one run: `file`, `coordinates`, `replicate`, `outcome`, as in `runs` |
| `sweep` | of a mean or a fit: `along` (the axis of a fit; null for a mean over replicates), `coordinates`, `replicates` (their number) |

`coordinates` are the run's point in the sweep: `{\"temperature_k\": {\"value\": 300, \"unit\": \"K\"}}`. A key is named by its last part, or in full where two keys have the
same last part. The value is a number where the manifest has one; the unit is \"1\" for a pure number and empty for a word.

## metrics.csv

One row per run and metric, and one per mean or fit: first one column per coordinate, then `replicate`, `metric`, `value`, and so on as in `metrics.json`. Empty cells are
missing values; numbers have the fewest digits that give them back exactly. `metrics.parquet` and the table of a sweep
(`--metrics-table`) have the same columns. For more than 1000 runs, both files contain means and fits only.

## runs.parquet

One row per run, in the order of the sweep: the coordinates (whole numbers, numbers or words), `replicate`, `seed`, `outcome`, `outcome_detail`, `frames`, `end_time`,
`messages` (the first half of the SHA-256 of all messages, as in `kinetoscope.lock`, of recordings up to 1 MiB), `file`, `run_key`, `program_version`, `physics_version`, `details` (what else `kinetoscope analyze` needs, for this version of the program only),
`manifest`, and for each metric that any run has its value and, with the ending `.standard_error`, its standard error. The entry `kinetoscope` of the file's metadata states keys, units and definitions as JSON.
`kinetoscope table` and any reader of Parquet read it. The 32 bytes before the footer are the SHA-256 of all other bytes, which the commands of Kinetoscope check before they read
anything else.
";

/// The reference of all metrics, in Markdown.
#[must_use]
pub fn metrics_reference() -> String {
    let mut text = HEAD.to_owned();
    // Writing to a String cannot fail.
    for (symbol, meaning) in SYMBOLS {
        let _ = writeln!(text, "| {symbol} | {} |", cell(meaning));
    }
    let sweeps: Vec<&Definition> =
        MODELS.iter().flat_map(|model| model.sweep_metrics).copied().collect();
    let of_models = MODELS.iter().map(|model| (model.title, model.metrics));
    for (title, definitions) in of_models.chain([("Sweeps", &sweeps[..])]) {
        let _ = write!(
            text,
            "\n## {title}\n\n| name | unit | definition | theory | rounding |\n|---|---|---|---|---|\n"
        );
        for definition in definitions {
            let _ = writeln!(text, "{}", row(definition));
        }
    }
    text + FILES
}

/// The metrics of which name, label or definition contain every word, for a terminal; a word that is the name of a model selects it. `None` if
/// there are none.
pub(crate) fn metrics_with(words: &[String], terminal: Terminal) -> Option<String> {
    let words: Vec<String> = words.iter().map(|word| word.to_lowercase()).collect();
    let models = || MODELS.iter().map(|model| model.name);
    let (named, sought): (Vec<&String>, Vec<&String>) =
        words.iter().partition(|word| models().any(|name| name == word.as_str()));
    let is_meant = |definition: &Definition| {
        let text = [definition.name, definition.label, definition.how].join(" ").to_lowercase();
        sought.iter().all(|word| text.contains(word.as_str()))
    };
    let mut text = String::new();
    for model in MODELS.iter().filter(|it| named.is_empty() || named.iter().any(|n| *n == it.name))
    {
        let definitions = model.metrics.iter().chain(model.sweep_metrics);
        for definition in definitions.filter(|definition| is_meant(definition)) {
            let unit = match definition.unit {
                "" | "1" => String::new(),
                unit => format!(", {unit}"),
            };
            let laws: Vec<String> = definition.laws.iter().map(law_with_range).collect();
            let theory = match laws.is_empty() {
                true => String::new(),
                false => format!(" Theory: {}", laws.join("; or ")),
            };
            let heading = format!("{} ({}{unit})", definition.name, model.name);
            let inside = Terminal { width: terminal.width - 2, ..terminal };
            let about = inside.wrapped(&format!("{}.{theory}", definition.how), 2);
            let _ = writeln!(text, "{}\n  {about}", terminal.paint(Style::Heading, &heading));
        }
    }
    (!text.is_empty()).then_some(text)
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// The law with its range and accuracy; neither for an exact law.
fn law_with_range(law: &Law) -> String {
    let mut text = law.to_string();
    if !law.range.is_empty() {
        let _ = write!(text, "; range: {}", law.range);
    }
    if law.relative_accuracy > 0.0 {
        let _ = write!(text, "; accuracy {} %", 100.0 * law.relative_accuracy);
    }
    text
}

fn row(definition: &Definition) -> String {
    let laws: Vec<String> = definition.laws.iter().map(law_with_range).collect();
    let rounding = match definition.rounding {
        0.0 => String::new(),
        rounding => format!("{rounding:e}"),
    };
    format!(
        "| `{}` | {} | {} | {} | {rounding} |",
        definition.name,
        definition.unit,
        cell(definition.how),
        cell(&laws.join("; or "))
    )
}
