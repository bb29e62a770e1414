//! Places of keys in a manifest, for errors that are found only when a run is prepared.

use crate::diagnostics::Diagnostics;
use crate::syntax::{LineCounter, parse_toml};
use crate::tree::{Node, Table, Value};

/// The line of the first key of a manifest that a message names, counted from 1; that of the model's table if it names none that the
/// text has, and `None` without a model.
#[must_use]
pub fn line_of_key_in_message(text: &str, message: &str) -> Option<usize> {
    let (root, _) = parse_toml(text, "", &mut Diagnostics::default());
    let mut keys = Vec::new();
    for entry in &root.entries {
        match (&*entry.key, entry.node.table()) {
            ("model", Some(models)) => models.entries.iter().for_each(|model| {
                model.node.table().into_iter().for_each(|table| add_keys(table, &mut keys));
            }),
            ("record" | "sweep", Some(table)) => add_keys(table, &mut keys),
            _ => {}
        }
    }
    let is_part_of_key = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut words = message.split(|c| !is_part_of_key(c)).filter(|word| !word.is_empty());
    let named = words.find_map(|word| keys.iter().find(|(key, _)| *key == word));
    let model = || {
        let models = root.entries.iter().find(|entry| entry.key == "model")?.node.table()?;
        Some(models.entries.first()?.key_span.start)
    };
    let place = named.map(|(_, place)| *place).or_else(model)?;
    Some(LineCounter::new(text).line_of(place))
}

/// Adds the keys of a table and of the tables in it, by the last parts of their names.
fn add_keys<'a>(table: &'a Table, keys: &mut Vec<(&'a str, usize)>) {
    for entry in &table.entries {
        let last = entry.key.rsplit('.').next().unwrap_or_default();
        keys.push((last, entry.key_span.start));
        add_keys_below(&entry.node, keys);
    }
}

fn add_keys_below<'a>(node: &'a Node, keys: &mut Vec<(&'a str, usize)>) {
    match &node.value {
        Value::Table(table) => add_keys(table, keys),
        Value::Array(elements) => {
            elements.iter().for_each(|element| add_keys_below(element, keys));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::line_of_key_in_message;

    #[test]
    fn line_is_that_of_the_first_key_named() {
        let text = "name = \"frames\"\n[model.gas]\nparticles = 3\n\n[record]\nframes = 9\n[sweep]\nmodel.gas.radius_m = [1, 2]\n";
        for (message, line) in [
            ("[record] frames = 9 is too many", Some(6)),
            ("radius_m is 1", Some(8)),
            ("particles = 3, but frames = 9", Some(3)),
            ("name is wrong", Some(2)),
            ("no key: parti", Some(2)),
        ] {
            assert_eq!(line_of_key_in_message(text, message), line, "{message}");
        }
        assert_eq!(line_of_key_in_message("not TOML [", "frames"), None);
    }
}
