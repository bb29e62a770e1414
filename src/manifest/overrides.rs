//! Values from the command line that take the place of a manifest's.

use crate::diagnostics::{Diagnostic, Diagnostics, Errors};
use crate::head::is_name;
use crate::sweep::{Points, Setting, overlap};
use crate::tree::{self, Node, Span, Table, Value};
use toml::de::DeValue;

/// A value from the command line, `--set key=value`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// The dotted key, such as `model.gas.particles`.
    pub key: String,
    /// The value in TOML; a bare word counts as a string.
    pub value: String,
}

/// Reads the overrides; a value that is a bare word is a text.
pub(crate) fn read(
    overrides: &[Override],
    diagnostics: &mut Diagnostics,
    errors: &mut Errors,
) -> Vec<Setting> {
    let mut sets: Vec<Setting> = Vec::new();
    for Override { key, value } in overrides {
        let text = format!("{key}={value}");
        let source = diagnostics.source("--set", &text);
        let key_span = Span { source, start: 0, end: key.len() };
        let value_at = key.len() + 1;
        let value_span = Span { source, start: value_at, end: text.len() };
        let (parsed, refused) = DeValue::parse_recoverable(value);
        let node = if refused.is_empty() && !value.trim().is_empty() {
            tree::node(parsed, source, value_at)
        } else if is_name(value) {
            Node { span: value_span, value: Value::Text(value.clone()) }
        } else {
            let error = Diagnostic::new(format!("the value of `{key}` is not TOML"));
            errors.push(error.at(value_span, "text with spaces or signs needs quotes"));
            continue;
        };
        if let Some(first) = sets.iter().find(|set| set.key == *key) {
            let error = Diagnostic::new(format!("`{key}` is set twice"));
            errors.push(error.at(key_span, "set it once").at(first.key_span, ""));
        }
        sets.push(Setting { key: key.clone(), key_span, node });
    }
    sets
}

/// Applies the overrides to a manifest's tables.
pub(crate) fn apply(root: &mut Table, sets: Vec<Setting>, axes: &[Points], errors: &mut Errors) {
    for Setting { key, key_span, node } in sets {
        if let Some(setting) = axes
            .iter()
            .flat_map(|axis| axis.settings.iter().flatten())
            .find(|setting| overlap(&setting.key, &key))
        {
            let error = Diagnostic::new(format!("`{key}` is swept and cannot be set"));
            errors.push(
                error
                    .at(key_span, "leave it out, or change the sweep")
                    .at(setting.key_span, "swept here"),
            );
        } else if ["sweep", "checks", "plots", "view", "baseline"]
            .iter()
            .any(|table| overlap(table, &key))
        {
            let label = "change the manifest instead";
            errors.push(Diagnostic::new(format!("`{key}` cannot be set")).at(key_span, label));
        } else {
            set(root, &key, key_span, &node, errors);
        }
    }
}

/// Inserts a value from the command line or from a sweep.
pub(crate) fn set(root: &mut Table, key: &str, key_span: Span, node: &Node, errors: &mut Errors) {
    if let Err(no_table) = root.set(key, key_span, node.clone()) {
        let title = format!("unknown key `{key}`: `{no_table}` is not a table");
        errors.push(Diagnostic::new(title).at(key_span, "it has no keys of its own"));
    }
}
