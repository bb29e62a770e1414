//! Files that a manifest names in `start_from`: recordings, and manifests of experiments that must be recorded before it can run.

use crate::diagnostics::Diagnostics;
use crate::syntax::{LineCounter, parse_toml};
use crate::tree::{Node, Table, Value};

/// A file that `start_from` names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedStart {
    /// The path as written.
    pub name: String,
    /// The line of the path, from 1.
    pub line: usize,
}

/// Whether a value of `start_from` names a manifest rather than a recording.
#[must_use]
pub fn is_manifest_name(name: &str) -> bool {
    name.ends_with(".toml")
}

/// Lists the manifests that `start_from` names, as [`start_names`] does.
#[must_use]
pub fn start_manifests(source: &str) -> Vec<NamedStart> {
    let mut found = start_names(source);
    found.retain(|start| is_manifest_name(&start.name));
    found
}

/// Lists the files that `start_from` names anywhere in a manifest, sweeps included, in the order of the file. A text
/// that is not TOML lists what can be read of it.
#[must_use]
pub fn start_names(source: &str) -> Vec<NamedStart> {
    let (root, _) = parse_toml(source, "", &mut Diagnostics::default());
    let mut found = Vec::new();
    search_table(&root, false, &mut LineCounter::new(source), &mut found);
    found
}

fn search_table(
    table: &Table,
    is_start: bool,
    lines: &mut LineCounter<'_>,
    found: &mut Vec<NamedStart>,
) {
    for entry in &table.entries {
        let names_start = entry.key.rsplit('.').next() == Some("start_from");
        search(&entry.node, is_start || names_start, lines, found);
    }
}

fn search(node: &Node, is_start: bool, lines: &mut LineCounter<'_>, found: &mut Vec<NamedStart>) {
    match &node.value {
        Value::Text(name) if is_start => {
            let line = lines.line_of(node.span.start);
            found.push(NamedStart { name: name.clone(), line });
        }
        Value::Array(nodes) => {
            nodes.iter().for_each(|node| search(node, is_start, lines, found));
        }
        Value::Table(table) => search_table(table, is_start, lines, found),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::{NamedStart, start_manifests, start_names};

    #[test]
    fn every_start_manifest_is_listed_with_its_line() {
        let source = "seed = 1\n[model.dem]\nstart_from = \"bed.toml\"\ndescription = \"not.toml\"\n\
                      [sweep]\n\"model.dem.start_from\" = [\n  \"one.mcap\",\n  \"two.toml\",\n]\n";
        let listed = |name: &str, line| NamedStart { name: name.to_owned(), line };
        assert_eq!(start_manifests(source), [listed("bed.toml", 3), listed("two.toml", 8)]);
        let all = [listed("bed.toml", 3), listed("one.mcap", 7), listed("two.toml", 8)];
        assert_eq!(start_names(source), all);
    }
}
