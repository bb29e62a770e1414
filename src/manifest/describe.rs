//! The keys of a table as a JSON Schema.

use crate::keys::{HasKeys, Key, Keys};
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
    /// The schema of a table at its defaults.
    pub(crate) fn describe(table: &mut impl HasKeys) -> Json {
        let mut describer = Self::default();
        table.keys(&mut describer);
        describer.table()
    }

    fn insert<T: TomlValue>(&mut self, key: &Key, default: Option<&T>) {
        let unit = match key.unit {
            "" => String::new(),
            "1" => " Unit: none, a pure number.".to_owned(),
            unit => format!(" Unit: {unit}."),
        };
        let mut schema = T::schema();
        schema["description"] = json!(format!("{}{unit}", key.about.trim_start()));
        if let Some(default) = default {
            schema["default"] = to_json(&default.write());
        }
        self.properties.insert(key.name.to_owned(), schema);
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
    fn key<T: TomlValue>(&mut self, key: &Key, value: &mut T) {
        self.insert(key, Some(&*value));
    }

    fn optional<T: TomlValue>(&mut self, key: &Key, current: Option<T>) -> Option<T> {
        self.insert(key, current.as_ref());
        current
    }

    fn exclusive(&mut self, names: &'static [&'static str]) {
        self.exclusive.push(names);
    }
}

/// A canonical TOML value as JSON.
fn to_json(toml: &str) -> Json {
    let (parsed, _) = DeValue::parse_recoverable(toml);
    node_to_json(&tree::node(parsed, 0, 0))
}

fn node_to_json(node: &Node) -> Json {
    match &node.value {
        Value::Text(text) => json!(text),
        Value::Integer(integer) => {
            u64::try_from(*integer).map_or(json!(*integer as f64), |whole| json!(whole))
        }
        Value::Float(number) => json!(number),
        Value::Boolean(value) => Json::Bool(*value),
        Value::Datetime => Json::Null,
        Value::Array(elements) => elements.iter().map(node_to_json).collect(),
        Value::Table(table) => {
            let entries = table.entries.iter();
            entries.map(|entry| (entry.key.clone(), node_to_json(&entry.node))).collect()
        }
    }
}

/// The schema of `[model.<NAME>]`; of no keys if there is no such model.
pub(crate) fn model_table(name: &str) -> Json {
    let mut describer = Describer::default();
    if let Some(mut model) = ModelConfig::with_defaults(name) {
        model.keys(&mut describer);
    }
    describer.table()
}

/// The schema of `[record]`, which has the keys of all models.
pub(crate) fn record_table() -> Json {
    let mut describer = Describer::default();
    RecordConfig::default().keys_for("", &mut describer);
    describer.table()
}

/// Finds the unit of one key of a table.
struct UnitFinder<'a> {
    name: &'a str,
    unit: Option<&'static str>,
}

impl Keys for UnitFinder<'_> {
    fn key<T: TomlValue>(&mut self, key: &Key, _: &mut T) {
        if key.name == self.name {
            self.unit = Some(key.unit);
        }
    }

    fn optional<T: TomlValue>(&mut self, key: &Key, current: Option<T>) -> Option<T> {
        if key.name == self.name {
            self.unit = Some(key.unit);
        }
        current
    }

    fn exclusive(&mut self, _: &'static [&'static str]) {}
}

/// Returns the unit of a dotted key such as `model.gas.temperature_k`: "1" for a pure number, and "" for a word, a key that
/// has no unit, or an unknown key.
#[must_use]
pub fn unit_of_key(key: &str) -> &'static str {
    let mut parts = key.split('.');
    let table = parts.next();
    let model = if table == Some("model") { parts.next() } else { None };
    let mut finder = UnitFinder { name: parts.next().unwrap_or_default(), unit: None };
    match (table, model.and_then(ModelConfig::with_defaults)) {
        (Some("model"), Some(mut model)) => model.keys(&mut finder),
        (Some("record"), _) => RecordConfig::default().keys_for("", &mut finder),
        _ => {}
    }
    finder.unit.unwrap_or_default()
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

#[cfg(test)]
mod tests {
    use super::unit_of_key;

    #[test]
    fn units_are_those_of_the_tables() {
        for (key, unit) in [
            ("model.gas.temperature_k", "K"),
            ("model.gas.particles", "1"),
            ("model.orbit.time_step_days", "d"),
            ("record.every_s", "s"),
            ("model.gas.speed_distribution", ""),
            ("model.none.radius", ""),
            ("variant", ""),
        ] {
            assert_eq!(unit_of_key(key), unit, "{key}");
        }
    }
}
