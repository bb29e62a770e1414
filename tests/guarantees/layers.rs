//! Guarantee: folders import only from lower layers, no two folders import each other, and no file exceeds 500 lines.
//!
//! The test reads every `use` below `src/` and `analysis/src/`, so that a newcomer can rely on the order of layers in
//! ARCHITECTURE.md. An import cycle inside a folder is an error unless [`KNOWN_CYCLES`] names it with its reason.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The layers from the lowest to the highest. An entry imports only from lower layers and from itself.
type Layers = [&'static [&'static str]];

/// The layers of `src/`, and of the analysis as a whole.
const LAYERS: &Layers = &[
    &["console"],
    &["files"],
    &["manifest", "recording", "interrupt.rs"],
    &["object_storage", "physics", "live"],
    &["run"],
    &["plan"],
    &["outputs"],
    &["executor", "verify", "analysis"],
    &["lib.rs"],
    &["program", "browser"],
];
/// The layers of `analysis/src/`.
const ANALYSIS_LAYERS: &Layers = &[
    &["number_text.rs", "statistics", "table", "write_file.rs"],
    &["metric", "plot"],
    &["input", "models"],
    &["replay"],
    &["run"],
    &["metric_files", "sweep"],
    &["checks", "export", "thumbnail"],
    &["answer"],
    &["report"],
    &["cli", "checked_experiment"],
    &["lib.rs"],
];
/// Packages of the sources: the name in `use`, and the folder below `src/`.
const PACKAGES: &[(&str, &str)] = &[
    ("kinetoscope_analysis", "analysis"),
    ("kinetoscope_browser", "browser"),
    ("kinetoscope_console", "console"),
    ("kinetoscope_files", "files"),
    ("kinetoscope_manifest", "manifest"),
    ("kinetoscope_object_storage", "object_storage"),
    ("kinetoscope_physics", "physics"),
    ("kinetoscope_program", "program"),
    ("kinetoscope_recording", "recording"),
];
/// Files that import each other, and the reason: a list of paths, or the start of the paths. The first entry that fits a cycle
/// names it. An entry without a cycle is an error.
const KNOWN_CYCLES: &[(&str, &str)] = &[(
    "recording/recorder",
    "one type in two files: recorder.rs writes, recorder/resuming.rs resumes",
)];
const MAX_LINES: usize = 500;
/// Files above the limit, and the reason. An entry at or below the limit is an error.
const LONG_FILES: &[(&str, &str)] = &[];
const MAX_TOP_LEVEL_ENTRIES: usize = 16;

type Graph = BTreeMap<String, BTreeSet<String>>;

/// The analysis is a package outside `src/`. In the graph, its files are below this prefix.
const ANALYSIS: &str = "analysis/";

/// All source files below a folder of the repository, by their paths relative to it.
fn files_below(folder: &str) -> BTreeMap<String, String> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(folder);
    let (mut files, mut folders) = (BTreeMap::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path: PathBuf = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
                files.insert(name, fs::read_to_string(&path).unwrap());
            }
        }
    }
    assert!(files.len() > 50, "the sources in {folder} were not found");
    files
}

/// The files of `src/` and `analysis/src/`.
fn files() -> BTreeMap<String, String> {
    let analysis = files_below("analysis/src");
    let prefixed = analysis.into_iter().map(|(file, source)| (format!("{ANALYSIS}{file}"), source));
    files_below("src").into_iter().chain(prefixed).collect()
}

/// Whether a file belongs to a library or a program, not to a package's tests or benches.
fn is_product(file: &str) -> bool {
    !file.split('/').any(|part| part == "tests" || part == "benches")
}

/// The paths of all `use` statements: nested groups are expanded, and `as` is dropped. Inside an inline module or a function,
/// a path that starts with `super` or `self` is left out: it refers to the file itself. A module of tests, which is at the end
/// of its file, may import anything.
fn used_paths(source: &str) -> Vec<String> {
    let mut paths = Vec::new();
    let is_test_module = |(at, _): &(usize, &str)| {
        let mut rest = source[*at..].lines().skip(1);
        rest.find(|line| !line.starts_with("#[")).is_some_and(|line| line.starts_with("mod "))
    };
    let tests = source.match_indices("#[cfg(test)]\n").find(is_test_module);
    let mut lines = source[..tests.map_or(source.len(), |(at, _)| at)].lines();
    while let Some(line) = lines.next() {
        let is_inner = line.starts_with(' ');
        let text = line.trim_start();
        let text = text
            .strip_prefix("pub")
            .map_or(text, |rest| rest.trim_start_matches(|letter| letter != ' ').trim_start());
        let Some(text) = text.strip_prefix("use ") else { continue };
        let mut statement = text.to_owned();
        while !statement.contains(';') {
            statement += lines.next().unwrap_or(";").trim();
        }
        let tree = statement.split(';').next().unwrap_or_default();
        if !(is_inner && (tree.starts_with("super") || tree.starts_with("self"))) {
            expand("", tree, &mut paths);
        }
    }
    paths
}

/// Expands a tree such as `a::{b, c::{d, e}}` into its paths.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let tree = tree.trim();
    let Some((head, rest)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        return paths.push(format!("{prefix}{path}"));
    };
    let (prefix, group) = (format!("{prefix}{head}"), rest.strip_suffix('}').unwrap_or(rest));
    let (mut depth, mut start) = (0, 0);
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                expand(&prefix, &group[start..at], paths);
                start = at + 1;
            }
            _ => {}
        }
    }
    if !group[start..].trim().is_empty() {
        expand(&prefix, &group[start..], paths);
    }
}

/// The folder of the package that a file belongs to, with a slash at the end; empty for the main package.
fn package_of(file: &str) -> String {
    let folder = file.split('/').next().unwrap_or_default();
    let is_package = PACKAGES.iter().any(|(_, package)| *package == folder);
    if is_package { format!("{folder}/") } else { String::new() }
}

/// The module of a file as path segments below `src/`: `run/mod.rs` is `["run"]`.
fn module_of(file: &str) -> Vec<&str> {
    let mut parts: Vec<&str> = file.trim_end_matches(".rs").split('/').collect();
    if matches!(parts.last(), Some(&("mod" | "lib" | "main"))) {
        parts.pop();
    }
    parts
}

/// The file that a used path refers to; `None` for other crates.
fn target(file: &str, path: &str, files: &BTreeMap<String, String>) -> Option<String> {
    let mut segments: Vec<&str> = path.split("::").collect();
    let package = package_of(file);
    let mut module: Vec<&str> = match *segments.first()? {
        "crate" => package.split('/').filter(|part| !part.is_empty()).collect(),
        "self" => module_of(file),
        "super" => {
            let mut module = module_of(file);
            while segments.get(1) == Some(&"super") {
                module.pop();
                segments.remove(0);
            }
            module.pop();
            module
        }
        "kinetoscope" => Vec::new(),
        name => match PACKAGES.iter().find(|(package, _)| *package == name) {
            Some((_, folder)) => vec![folder],
            None => {
                // A child module, such as `use checkpoint::RunState` in run/mod.rs.
                segments.insert(0, "self");
                module_of(file)
            }
        },
    };
    let is_external = segments[0] == "self" && path.split("::").next() != Some("self");
    let depth = module.len();
    module.extend(&segments[1..]);
    while module.len() >= depth && !module.is_empty() {
        let base = module.join("/");
        let candidates = [format!("{base}.rs"), format!("{base}/mod.rs"), format!("{base}/lib.rs")];
        if let Some(found) = candidates.into_iter().find(|name| files.contains_key(name)) {
            let is_own = is_external && module.len() == depth;
            return (!is_own && found != file).then_some(found);
        }
        module.pop();
    }
    None
}

/// Which file imports which.
fn imports(files: &BTreeMap<String, String>) -> Graph {
    let product = files.iter().filter(|(file, _)| is_product(file));
    product
        .map(|(file, source)| {
            let used = used_paths(source);
            let targets = used.iter().filter_map(|path| target(file, path, files)).collect();
            (file.clone(), targets)
        })
        .collect()
}

/// All nodes that can be reached from one.
fn reachable<'a>(graph: &'a Graph, from: &str) -> BTreeSet<&'a str> {
    let (mut found, mut stack) = (BTreeSet::new(), vec![from]);
    while let Some(node) = stack.pop() {
        for next in graph.get(node).into_iter().flatten() {
            if found.insert(next.as_str()) {
                stack.push(next);
            }
        }
    }
    found
}

/// The sets of nodes that import each other, directly or not.
fn cycles(graph: &Graph) -> BTreeSet<BTreeSet<String>> {
    let reach: BTreeMap<&str, BTreeSet<&str>> =
        graph.keys().map(|node| (node.as_str(), reachable(graph, node))).collect();
    let mut cycles = BTreeSet::new();
    for (node, found) in &reach {
        if found.contains(node) {
            let mutual = found
                .iter()
                .filter(|other| reach.get(**other).is_some_and(|back| back.contains(node)));
            cycles.insert(mutual.map(|name| (*name).to_owned()).collect());
        }
    }
    cycles
}

/// Imports below `folder` that lead to the same or a higher layer of it, and entries without a layer.
fn layer_violations(graph: &Graph, folder: &str, layers: &Layers) -> Vec<String> {
    let entry = |file: &str| -> Option<String> {
        Some(file.strip_prefix(folder)?.split('/').next()?.to_owned())
    };
    let layer_of = |entry: &String| layers.iter().position(|layer| layer.contains(&entry.as_str()));
    let mut violations = Vec::new();
    for (file, targets) in graph {
        let Some(own) = entry(file) else { continue };
        let Some(layer) = layer_of(&own) else {
            violations.push(format!("{file}: its folder has no layer"));
            continue;
        };
        for target in targets {
            let Some(other) = entry(target).filter(|other| *other != own) else { continue };
            if layer_of(&other).is_none_or(|below| below >= layer) {
                violations.push(format!("{file} imports {target}, which is not below it"));
            }
        }
    }
    violations
}

/// The graph of the folders directly below `folder`, from the imports of their files.
fn folder_graph(graph: &Graph, folder: &str) -> Graph {
    let child = |file: &str| {
        let (name, _) = file.strip_prefix(folder)?.split_once('/')?;
        Some(name.to_owned())
    };
    let mut folders = Graph::new();
    for (file, targets) in graph {
        let Some(name) = child(file) else { continue };
        let others = targets.iter().filter_map(|target| child(target));
        folders.entry(name.clone()).or_default().extend(others.filter(|other| *other != name));
    }
    folders
}

#[test]
fn folders_import_only_from_lower_layers() {
    let graph = imports(&files());
    let mut violations = layer_violations(&graph, "", LAYERS);
    violations.extend(layer_violations(&graph, ANALYSIS, ANALYSIS_LAYERS));
    assert!(violations.is_empty(), "{}", violations.join("\n"));
}

#[test]
fn folders_do_not_import_each_other() {
    let graph = imports(&files());
    let parents: BTreeSet<String> = graph
        .keys()
        .filter_map(|file| file.rsplit_once('/'))
        .flat_map(|(folder, _)| {
            let ends = folder.match_indices('/').map(|(at, _)| at + 1);
            ends.map(|end| folder[..end].to_owned()).collect::<Vec<_>>()
        })
        .chain([String::new()])
        .collect();
    for parent in parents {
        let cycles = cycles(&folder_graph(&graph, &parent));
        assert!(cycles.is_empty(), "below {parent:?}: {cycles:?} import each other");
    }
}

#[test]
fn files_do_not_import_each_other() {
    let graph = imports(&files());
    let mut known: BTreeSet<&str> = KNOWN_CYCLES.iter().map(|(folder, _)| *folder).collect();
    let mut unknown = Vec::new();
    for cycle in cycles(&graph) {
        let is_in =
            |entry: &str, file: &String| entry.split(' ').any(|start| file.starts_with(start));
        let named =
            KNOWN_CYCLES.iter().find(|(entry, _)| cycle.iter().all(|file| is_in(entry, file)));
        match named {
            Some((entry, _)) => drop(known.remove(entry)),
            None => unknown.push(format!("{cycle:?}")),
        }
    }
    assert!(unknown.is_empty(), "files that import each other:\n{}", unknown.join("\n"));
    assert!(known.is_empty(), "no longer a cycle, remove from KNOWN_CYCLES: {known:?}");
}

#[test]
fn no_file_exceeds_the_line_limit() {
    for folder in ["src", "analysis"] {
        for (file, source) in files_below(folder) {
            let (path, lines) = (format!("{folder}/{file}"), source.lines().count());
            let is_named = LONG_FILES.iter().any(|(named, _)| *named == path);
            assert!(lines <= MAX_LINES || is_named, "{path} has {lines} lines, limit {MAX_LINES}");
            assert!(lines > MAX_LINES || !is_named, "{path}: remove from LONG_FILES");
        }
    }
}

#[test]
fn src_has_few_top_level_entries() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("src");
    let entries = fs::read_dir(root).unwrap().count();
    assert!(entries <= MAX_TOP_LEVEL_ENTRIES, "{entries} entries, limit {MAX_TOP_LEVEL_ENTRIES}");
}

/// The checks reject an import of a higher layer, two folders that import each other, and a cycle of files.
#[test]
fn control_forbidden_imports_are_found() {
    let source = |file: &str, text: &str| (file.to_owned(), text.to_owned());
    let files = BTreeMap::from([
        source("run/mod.rs", "use crate::plan::{self, prune::{stale, remove}};\n"),
        source("run/state.rs", "use super::loops::Loop;\nmod tests {\n    use super::State;\n}\n"),
        source("run/loops.rs", "pub(crate) use crate::run::state::{\n    State,\n};\n"),
        source("plan/mod.rs", "use std::fs;\nuse kinetoscope_physics::dem::Dem;\n"),
        source("plan/prune.rs", "use crate::run::execute;\n"),
        source("physics/dem/mod.rs", "use crate::gas::wall;\nuse crate::model::Model;\n"),
        source("physics/gas/mod.rs", "mod wall;\nuse wall::Wall;\n"),
        source("physics/gas/wall.rs", "use crate::dem::Dem;\n"),
        source("physics/model.rs", ""),
        source("analysis/plot/mod.rs", "use crate::report::Report;\n"),
        source("analysis/report/mod.rs", ""),
        source("manifest/plots.rs", "use kinetoscope_analysis::plot::Plot;\n"),
    ]);
    let graph = imports(&files);
    let of = |file: &str| graph[file].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(of("run/mod.rs"), ["plan/mod.rs", "plan/prune.rs"]);
    assert_eq!(of("plan/mod.rs"), ["physics/dem/mod.rs"]);
    assert_eq!(of("physics/dem/mod.rs"), ["physics/gas/wall.rs", "physics/model.rs"]);
    assert_eq!(of("physics/gas/mod.rs"), ["physics/gas/wall.rs"]);
    let violations = layer_violations(&graph, "", LAYERS);
    let upward = ["manifest/plots.rs imports analysis/", "run/mod.rs imports plan/"];
    assert_eq!(violations.len(), 3, "{violations:?}");
    assert!(violations.iter().all(|text| upward.iter().any(|start| text.starts_with(start))));
    let violations = layer_violations(&graph, ANALYSIS, ANALYSIS_LAYERS);
    let upward = "analysis/plot/mod.rs imports analysis/report/mod.rs, which is not below it";
    assert_eq!(violations, [upward]);
    assert_eq!(cycles(&folder_graph(&graph, "physics/")).len(), 1);
    assert_eq!(cycles(&folder_graph(&graph, "")).len(), 1);
    let files: Vec<usize> = cycles(&graph).iter().map(BTreeSet::len).collect();
    assert_eq!(files, [2, 2, 2]);
}
