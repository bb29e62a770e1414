//! `doctor`: reports the versions, the machine and what is missing for a run, with the remedy.

use crate::messages::progress::size;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, existing_ancestor};
use clap::Args;
use kinetoscope::run::resources::memory::memory_bytes;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_physics::kinds;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use serde_json::{Map, Value as Json, json};
use std::env;
use std::path::{Path, PathBuf};

/// Less free disk space than this is a problem: small recordings take some MiB.
const MIN_DISK_BYTES: u64 = 100 << 20;
/// Less available memory than this is a problem: a run without particles takes 64 MiB.
const MIN_MEMORY_BYTES: u64 = 128 << 20;
/// Programs of clusters, with the executor that needs them.
const CLUSTER_PROGRAMS: [(&str, &str); 4] =
    [("sbatch", "slurm"), ("squeue", "slurm"), ("scancel", "slurm"), ("hq", "hyperqueue")];

/// Report versions, SIMD width, threads, memory, free disk space, features and cluster programs.
#[derive(Debug, Args)]
pub(crate) struct DoctorArguments {
    /// Folder of the recordings, to check its free space and its permissions
    #[arg(long, value_name = "DIR", default_value = "recordings", help_heading = "Output")]
    output: PathBuf,
    #[command(flatten)]
    result: ResultArguments,
}

/// What was found, line by line, and what is wrong.
#[derive(Default)]
struct Findings {
    lines: Vec<(&'static str, String)>,
    json: Map<String, Json>,
    problems: Vec<Failure>,
}

impl Findings {
    fn add(&mut self, name: &'static str, text: String, json: Json) {
        self.json.insert(name.replace(' ', "_"), json);
        self.lines.push((name, text));
    }

    fn problem(&mut self, what: String, help: &str) {
        self.problems.push(Failure::new(Exit::RunFailed, what).help(help));
    }
}

impl DoctorArguments {
    /// Prints the findings. `features` are the optional features of the program, and whether it was built with them.
    #[must_use]
    pub(crate) fn execute(&self, features: &[(&str, bool)]) -> Exit {
        let mut findings = Findings::default();
        versions(&mut findings);
        processor(&mut findings);
        memory(&mut findings);
        disk(&mut findings, &self.output);
        let list: Vec<String> = features
            .iter()
            .map(|(name, is_built)| format!("{name}: {}", if *is_built { "yes" } else { "no" }))
            .collect();
        let json = features.iter().map(|(name, is_built)| ((*name).to_owned(), json!(is_built)));
        findings.add("features", list.join(", "), Json::Object(json.collect()));
        cluster(&mut findings);
        let problems: Vec<String> = findings.problems.iter().map(Failure::text).collect();
        findings.json.insert("problems".to_owned(), json!(problems));
        let lines: Vec<String> =
            findings.lines.iter().map(|(name, text)| format!("{name:<10} {text}")).collect();
        self.result.print(&lines.join("\n"), || Json::Object(findings.json));
        let exits = findings.problems.iter().map(Failure::report);
        self.result.concluded(exits.fold(Exit::Done, Exit::worst))
    }
}

fn versions(findings: &mut Findings) {
    let program = env!("CARGO_PKG_VERSION");
    findings.add("version", program.to_owned(), json!(program));
    findings.add(
        "system",
        format!("{} {}", env::consts::OS, env::consts::ARCH),
        json!({ "operating_system": env::consts::OS, "architecture": env::consts::ARCH }),
    );
    findings.add(
        "recording",
        format!("schema version {SCHEMA_VERSION}"),
        json!({ "schema_version": SCHEMA_VERSION }),
    );
    let kinds = kinds();
    let text: Vec<String> =
        kinds.iter().map(|kind| format!("{} {}", kind.name, kind.physics_version)).collect();
    let json = kinds.iter().map(|kind| (kind.name.to_owned(), json!(kind.physics_version)));
    findings.add("physics", text.join(", "), Json::Object(json.collect()));
}

/// The width of the vector registers that the kernels use here, in bits.
fn simd_bits() -> u32 {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            return 512;
        }
        if is_x86_feature_detected!("avx2") {
            return 256;
        }
    }
    128
}

fn processor(findings: &mut Findings) {
    let bits = simd_bits();
    let text = format!("{bits} bits, {} numbers per instruction", bits / 64);
    findings.add("SIMD", text, json!({ "bits": bits, "numbers": bits / 64 }));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    findings.add("threads", threads.to_string(), json!(threads));
}

fn memory(findings: &mut Findings) {
    let bytes = |label| memory_bytes("/proc/meminfo", label);
    let (available, total) = (bytes("MemAvailable"), bytes("MemTotal"));
    let shown = match (available, total) {
        (Some(available), Some(total)) => {
            format!("{} available of {}", size(available), size(total))
        }
        _ => "unknown on this system".to_owned(),
    };
    findings.add("memory", shown, json!({ "available_bytes": available, "total_bytes": total }));
    if let Some(available) = available.filter(|&available| available < MIN_MEMORY_BYTES) {
        findings.problem(
            format!("only {} of memory is available", size(available)),
            "end other programs; a run needs at least 64 MiB",
        );
    }
}

fn disk(findings: &mut Findings, output: &Path) {
    let folder = existing_ancestor(output);
    let free = folder.as_deref().and_then(|folder| fs4::available_space(folder).ok());
    let shown = free.map_or_else(|| "unknown".to_owned(), |free| format!("{} free", size(free)));
    findings.add(
        "disk",
        format!("{shown} for {}", shown_path(output)),
        json!({ "folder": output, "free_bytes": free }),
    );
    if let Some(free) = free.filter(|&free| free < MIN_DISK_BYTES) {
        findings.problem(
            format!("only {} is free for {}", size(free), shown_path(output)),
            "free disk space, or choose another folder with --output DIR",
        );
    }
    let writable = folder.is_some_and(|folder| {
        let is_folder = !output.exists() || output.is_dir();
        is_folder && tempfile::tempfile_in(folder).is_ok()
    });
    if !writable {
        findings.problem(
            format!("no recording can be written to {}", shown_path(output)),
            "make the folder writable, or choose another one with --output DIR",
        );
    }
}

fn cluster(findings: &mut Findings) {
    let path = env::var_os("PATH").unwrap_or_default();
    let find = |program: &str| {
        env::split_paths(&path).map(|dir| dir.join(program)).find(|file| file.is_file())
    };
    let found: Vec<(&str, &str, Option<PathBuf>)> = CLUSTER_PROGRAMS
        .iter()
        .map(|(program, executor)| (*program, *executor, find(program)))
        .collect();
    let names: Vec<&str> =
        found.iter().filter(|(.., file)| file.is_some()).map(|(program, ..)| *program).collect();
    let text =
        if names.is_empty() { "no program on the PATH".to_owned() } else { names.join(", ") };
    let json = found.iter().map(|(program, _, file)| ((*program).to_owned(), json!(file)));
    findings.add("cluster", text, Json::Object(json.collect()));
    let slurm = found.iter().filter(|(_, executor, _)| *executor == "slurm");
    let missing: Vec<&str> =
        slurm.clone().filter(|(.., file)| file.is_none()).map(|(program, ..)| *program).collect();
    if !missing.is_empty() && missing.len() < slurm.count() {
        findings.problem(
            format!("Slurm is incomplete: {} is not on the PATH", missing.join(", ")),
            "add the folder of Slurm's programs to the PATH",
        );
    }
}
