//! The name of an experiment, from a manifest whose other keys need not be right.

use crate::diagnostics::Diagnostics;
use crate::head::is_name;
use crate::syntax::parse_toml;
use crate::tree::Value;
use std::path::Path;

/// The name of the experiment of a manifest, and of the folder of its recordings: its key `name`, else the stem of its file. `None` if that
/// cannot name a folder.
#[must_use]
pub fn experiment_name(source: &str, file: &Path) -> Option<String> {
    let (root, _) = parse_toml(source, "", &mut Diagnostics::default());
    let stated = root.entries.iter().find(|entry| entry.key == "name");
    let name = match stated.map(|entry| &entry.node.value) {
        Some(Value::Text(name)) => name.clone(),
        _ => file.file_stem()?.to_str()?.to_owned(),
    };
    is_name(&name).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_is_the_key_or_the_stem_of_the_file() {
        let name = |source: &str, file: &str| experiment_name(source, Path::new(file));
        assert_eq!(name("name = \"heap\"\n[model.dem]\ndiscs = x", "a/b.toml").unwrap(), "heap");
        assert_eq!(name("seed = 1\n[model.gas]\nname = \"no\"", "a/b.toml").unwrap(), "b");
        assert_eq!(name("name = \"../up\"", "b.toml"), None);
        assert_eq!(name("", "two words.toml"), None);
    }
}
