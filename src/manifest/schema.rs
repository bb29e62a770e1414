//! The JSON Schema of the manifest, with which editors complete and check it.

use crate::baseline::BaselineKeys;
use crate::checks::CheckKeys;
use crate::describe::{Describer, model_table, record_table};
use crate::exercise::Exercise;
use crate::head::Head;
use crate::model::ModelConfig;
use crate::plots::PlotKeys;
use crate::view::ViewKeys;
use serde_json::{Map, Value as Json, json};

/// The schema of the table `where` of a check or a plot.
fn place_table() -> Json {
    json!({
        "type": "object",
        "description": "Where in the sweep: swept keys, or `variant`, and their values. Everywhere by \
            default."
    })
}

/// The schema of one of `[[plots]]`.
fn plot_table() -> Json {
    let mut table = Describer::describe(&mut PlotKeys::default());
    table["properties"]["where"] = place_table();
    table["oneOf"] = json!([{ "required": ["y"] }, { "required": ["figure"] }]);
    table
}

/// The schema of `[view]`.
fn view_table() -> Json {
    let mut table = Describer::describe(&mut ViewKeys::default());
    table["description"] = json!("How the report shows the runs first.");
    table["properties"]["compare"] = json!({
        "type": "array",
        "items": place_table(),
        "minItems": 2,
        "maxItems": 2,
        "description": "The two points of the sweep that the report compares; by default its ends."
    });
    table
}

/// The schema of one of `[[checks]]`.
fn check_table() -> Json {
    let mut table = Describer::describe(&mut CheckKeys::default());
    table["properties"]["where"] = place_table();
    if let Some(metric) = table["properties"]["metric"].as_object_mut() {
        metric.remove("default");
    }
    table["required"] = json!(["metric"]);
    table
}

/// The schema of one of `[[baseline]]`.
fn baseline_table() -> Json {
    let mut table = Describer::describe(&mut BaselineKeys::default());
    if let Some(metric) = table["properties"]["metric"].as_object_mut() {
        metric.remove("default");
    }
    table["required"] = json!(["metric", "relative_tolerance"]);
    table
}

/// The schema of `[sweep]`, whose keys are those of the other tables.
fn sweep_table() -> Json {
    let axis = json!({
        "description": "A list of values or a range.",
        "anyOf": [{ "type": "array", "minItems": 1 }, range_table()]
    });
    let nested = json!({ "type": "object", "description": "Dotted keys without quotes." });
    let variant = json!({
        "type": "object",
        "properties": {
            "name": { "type": "string", "minLength": 1, "description": "Name of the variant." },
            "model": nested,
            "record": nested
        },
        "patternProperties": { SWEPT: {} },
        "required": ["name"],
        "additionalProperties": false
    });
    json!({
        "type": "object",
        "description": "One run for each combination of the values of all axes.",
        "properties": {
            "zip": {
                "type": "array",
                "items": { "type": "array", "items": { "type": "string" } },
                "description": "Groups of axes of equal length that advance together."
            },
            "variants": {
                "type": "array",
                "items": variant,
                "description": "Named sets of keys: one axis."
            },
            "model": nested,
            "record": nested
        },
        "patternProperties": { SWEPT: axis },
        "additionalProperties": false
    })
}

/// The keys that can be swept.
const SWEPT: &str = "^(model|record)\\.";

fn range_table() -> Json {
    json!({
        "type": "object",
        "properties": {
            "from": { "type": "number", "description": "First value." },
            "to": { "type": "number", "description": "Last value." },
            "count": {
                "type": "integer",
                "minimum": 2,
                "maximum": 100_000,
                "description": "Number of values, both ends included."
            },
            "spacing": {
                "enum": ["linear", "log"],
                "default": "linear",
                "description": "Equal differences or equal ratios; log needs bounds > 0."
            }
        },
        "required": ["from", "to", "count"],
        "additionalProperties": false
    })
}

/// The JSON Schema of a manifest, draft 2020-12, as text.
#[must_use]
pub fn json_schema() -> String {
    let mut schema = Describer::describe(&mut Head::default());
    let models: Map<String, Json> =
        ModelConfig::NAMES.iter().map(|name| ((*name).to_owned(), model_table(name))).collect();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("Kinetoscope experiment");
    let properties = &mut schema["properties"];
    properties["model"] = json!({
        "type": "object",
        "description": "The physics: exactly one model.",
        "properties": models,
        "additionalProperties": false,
        "maxProperties": 1
    });
    properties["record"] = record_table();
    properties["sweep"] = sweep_table();
    properties["checks"] = json!({
        "type": "array", "items": check_table(), "description": "What analysis must find."
    });
    properties["plots"] = json!({
        "type": "array",
        "items": plot_table(),
        "description": "Plots that the report shows first."
    });
    properties["view"] = view_table();
    properties["baseline"] = json!({
        "type": "array",
        "items": baseline_table(),
        "description": "How much metrics may differ from those of an earlier analysis."
    });
    properties["exercise"] = Describer::describe(&mut Exercise::default());
    properties["exercise"]["description"] = json!("The answer that `kinetoscope grade` compares.");
    properties["exercise"]["required"] = json!(["name"]);
    if let Some(name) = properties["exercise"]["properties"]["name"].as_object_mut() {
        name.remove("default");
    }
    format!("{schema:#}\n")
}
