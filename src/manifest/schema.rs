//! The JSON Schema of the manifest, so that editors complete and check it.

use crate::checks::CheckKeys;
use crate::experiment::Head;
use crate::keys::Keys;
use crate::model::ModelConfig;
use crate::record::RecordConfig;
use crate::tree::{self, Node, Value};
use crate::value::TomlValue;
use serde_json::{Map, Value as Json, json};
use toml::de::DeValue;

/// Collects the keys of a table as a JSON Schema.
#[derive(Default)]
pub(crate) struct Describer {
    properties: Map<String, Json>,
    exclusive: Vec<&'static [&'static str]>,
}

impl Describer {
    fn insert<T: TomlValue>(&mut self, name: &str, unit: &str, about: &str, default: Option<&T>) {
        let unit = match unit {
            "" => String::new(),
            "1" => " Unit: none, a pure number.".to_owned(),
            unit => format!(" Unit: {unit}."),
        };
        let mut schema = T::schema();
        schema["description"] = json!(format!("{about}{unit}"));
        if let Some(default) = default {
            schema["default"] = to_json(&default.write());
        }
        self.properties.insert(name.to_owned(), schema);
    }

    /// The table as a schema: its keys and no others, and of exclusive keys at most one.
    fn table(self) -> Json {
        let mut rules = Vec::new();
        for group in self.exclusive {
            for (index, one) in group.iter().enumerate() {
                for other in &group[index + 1..] {
                    rules.push(json!({ "not": { "required": [one, other] } }));
                }
            }
        }
        let mut table = json!({
            "type": "object", "properties": self.properties, "additionalProperties": false
        });
        if !rules.is_empty() {
            table["allOf"] = json!(rules);
        }
        table
    }
}

impl Keys for Describer {
    fn key<T: TomlValue>(
        &mut self,
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        value: &mut T,
    ) {
        self.insert(name, unit, about, Some(&*value));
    }

    fn optional<T: TomlValue>(
        &mut self,
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        current: Option<T>,
    ) -> Option<T> {
        self.insert(name, unit, about, current.as_ref());
        current
    }

    fn exclusive(&mut self, names: &'static [&'static str]) {
        self.exclusive.push(names);
    }
}

/// A canonical TOML value as JSON.
fn to_json(toml: &str) -> Json {
    let (parsed, _) = DeValue::parse_recoverable(toml);
    node_to_json(&tree::node(parsed.get_ref(), &parsed.span(), 0, 0))
}

fn node_to_json(node: &Node) -> Json {
    match &node.value {
        Value::Text(text) => json!(text),
        Value::Integer(integer) => {
            u64::try_from(*integer).map_or(json!(*integer as f64), |whole| json!(whole))
        }
        Value::Float(number) => json!(number),
        Value::Boolean | Value::Datetime => Json::Null,
        Value::Array(elements) => elements.iter().map(node_to_json).collect(),
        Value::Table(table) => {
            let entries = table.entries.iter();
            entries.map(|entry| (entry.key.clone(), node_to_json(&entry.node))).collect()
        }
    }
}

/// The schema of `[model.<NAME>]`.
fn model_table(name: &str) -> Json {
    let mut describer = Describer::default();
    if let Some(mut model) = ModelConfig::with_defaults(name) {
        model.keys(&mut describer);
    }
    describer.table()
}

/// The schema of `[record]`, which names the keys of all models.
fn record_table() -> Json {
    let mut describer = Describer::default();
    let model = ModelConfig::Dem(crate::model::DemConfig::default());
    RecordConfig::default().keys(&model, &mut describer);
    describer.table()
}

/// The schema of one of `[[checks]]`.
fn check_table() -> Json {
    let mut describer = Describer::default();
    CheckKeys::default().keys(&mut describer);
    let mut table = describer.table();
    table["properties"]["where"] = json!({
        "type": "object",
        "description": "Where in the sweep: swept keys, or `variant`, and their values. Everywhere by default."
    });
    if let Some(metric) = table["properties"]["metric"].as_object_mut() {
        metric.remove("default");
    }
    table["required"] = json!(["metric"]);
    table
}

fn sweep_table() -> Json {
    let range = json!({
        "type": "object",
        "properties": {
            "from": { "type": "number", "description": "First value. For log spacing > 0." },
            "to": { "type": "number", "description": "Last value. For log spacing > 0." },
            "count": { "type": "integer", "minimum": 2, "maximum": 1_000_000, "description": "Number of values, both ends included." },
            "spacing": { "enum": ["linear", "log"], "default": "linear", "description": "Equal differences or equal ratios." }
        },
        "required": ["from", "to", "count"],
        "additionalProperties": false
    });
    let axis = json!({
        "description": "A list of values or a range.",
        "anyOf": [{ "type": "array", "minItems": 1 }, range]
    });
    json!({
        "type": "object",
        "description": "One run for each combination of the values of all axes.",
        "properties": {
            "zip": {
                "type": "array", "items": { "type": "array", "items": { "type": "string" } },
                "description": "Groups of axes of equal length that advance together."
            },
            "variants": {
                "type": "array",
                "items": {
                    "type": "object", "required": ["name"],
                    "properties": {
                        "name": { "type": "string", "minLength": 1, "description": "Name of the variant." },
                        "model": { "type": "object" }, "record": { "type": "object" }
                    },
                    "patternProperties": { "^(model|record)\\.": {} },
                    "additionalProperties": false
                },
                "description": "Named sets of keys: one axis."
            },
            "model": { "type": "object", "description": "Axes by dotted keys without quotes." },
            "record": { "type": "object", "description": "Axes by dotted keys without quotes." }
        },
        "patternProperties": { "^(model|record)\\.": axis },
        "additionalProperties": false
    })
}

/// The JSON Schema of a manifest, draft 2020-12, as text.
#[must_use]
pub fn json_schema() -> String {
    let mut head = Describer::default();
    Head::default().keys(&mut head);
    let mut schema = head.table();
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
    format!("{schema:#}\n")
}

/// Whether a dotted key such as `model.gas.particles` takes whole numbers only.
pub(crate) fn is_whole(key: &str) -> bool {
    let mut parts = key.split('.');
    let (table, key) = match (parts.next(), parts.next(), parts.next()) {
        (Some("model"), Some(model), Some(key)) => (model_table(model), key),
        (Some("record"), Some(key), None) => (record_table(), key),
        _ => return false,
    };
    parts.next().is_none() && table["properties"][key]["type"] == "integer"
}
