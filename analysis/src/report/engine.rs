//! The engine in the page: a button that repeats the runs in the reader's browser and compares each frame with the recording.
//!
//! A program that was built with `--features kinetoscope-program/engine` carries the module (`src/browser/build.sh`). It is written once to
//! each folder of results, and its reports load it when they are opened; `--single-file` puts it into the page. Such a page has a policy
//! without network access.

use crate::report::AnalysisReport;
use crate::report::engine_place::EnginePlace;
use crate::report::rerun;
use crate::run::RunAnalysis;
use crate::write_file::{WriteError, replace};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use kinetoscope_recording::claim::{Claim, sha256};
use maud::{Markup, PreEscaped, html};
use std::path::Path;

/// The module next to the pages that load it.
pub(crate) const ENGINE: &str = "kinetoscope-engine.js";
/// Marks the scripts of the page, so that no other one is executed. Every text from a file is escaped; therefore, it need not be secret.
pub(super) const NONCE: &str = "kinetoscope";
/// Nothing is loaded from any network, and nothing is sent. Only a script that does not belong to the page could open another one.
const POLICY: &str = "default-src 'none'; script-src 'nonce-kinetoscope' 'wasm-unsafe-eval'; worker-src blob:; style-src 'unsafe-inline'; \
     img-src data: blob:; base-uri 'none'; form-action 'none'";
const SCRIPT: &str = include_str!("engine.js");
const WORKER: &str = include_str!("engine_worker.js");

/// The script that hands the module to the page.
fn module_script(module: &[u8]) -> String {
    format!("self.kinetoscopeEngine=\"{}\";\n", STANDARD.encode(module))
}

/// Writes the module next to the page that needs it.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(report: &AnalysisReport, folder: &Path) -> Result<(), WriteError> {
    match report.engine {
        EnginePlace::NextToPage(module) => replace(&folder.join(ENGINE), module_script(module)),
        EnginePlace::NotCarried | EnginePlace::LeftOut | EnginePlace::InPage(_) => Ok(()),
    }
}

/// The policy of a page with an engine.
pub(super) fn policy(report: &AnalysisReport) -> Markup {
    html! {
        @if report.engine.module().is_some() { meta http-equiv="Content-Security-Policy" content=(POLICY); }
    }
}

/// The runs whose messages the page can compare, by name.
fn claims<'a>(report: &'a AnalysisReport) -> Vec<(&'a str, &'a Claim, String)> {
    let claimed = |run: &'a RunAnalysis| {
        let claim = run.claim.as_ref()?;
        Some((run.file.as_str(), claim, STANDARD.encode(claim.to_bytes().ok()?)))
    };
    report.runs.iter().filter_map(claimed).collect()
}

/// Why the page has no button, in a sentence; `None` if it has one.
pub(super) fn missing(report: &AnalysisReport) -> Option<String> {
    let why = match report.engine {
        EnginePlace::LeftOut => "the page was written with --no-engine",
        _ if report.engine.module().is_none() => {
            "the program was built without the engine for browsers"
        }
        _ if report.runs.iter().all(|run| run.claim.is_none()) => {
            "no run is complete, whole and smaller than 64 MB"
        }
        _ => return None,
    };
    Some(format!("This page cannot be verified in the browser: {why}."))
}

/// The button and what it needs; empty in a page without.
pub(super) fn section(report: &AnalysisReport) -> Markup {
    let claims = claims(report);
    let (Some(module), Some((_, first, _))) = (report.engine.module(), claims.first()) else {
        return html! {};
    };
    let hash = hex(&sha256(module));
    html! {
        section class="engine" data-module=(hash) {
            h2 class="unseen" { "Verify" }
            p hidden {
                button type="button" { "Verify in this browser" }
                " "
                span class="facts" {
                    "Repeats " (runs_in_words(claims.len(), report.runs.len())) " from the manifest and compares each message with the hashes of the "
                    "recording. The numbers, plots and pictures of this page are not computed again. Engine " (env!("CARGO_PKG_VERSION")) ", SHA-256 "
                    (&hash[..16]) ", physics version " (first.physics_version) "."
                }
            }
            ul {}
            p class="unseen" role="status" {}
            noscript { p class="facts" { "To verify the runs in this browser, allow JavaScript." } }
        }
        @for (file, _, data) in &claims {
            script type="text/plain" class="claim" data-file=(file) { (PreEscaped(data)) }
        }
        script type="text/plain" class="engine-worker" { (PreEscaped(WORKER)) }
        @if let EnginePlace::InPage(module) = report.engine {
            script nonce=(NONCE) { (PreEscaped(module_script(module))) }
        } @else {
            script nonce=(NONCE) src=(ENGINE) {}
        }
        script nonce=(NONCE) { (PreEscaped(SCRIPT)) }
        (rerun::section(report, NONCE))
    }
}

fn runs_in_words(claimed: usize, all: usize) -> String {
    match (claimed, all) {
        (1, 1) => "the run".to_owned(),
        (some, all) if some < all => format!("{some} of {all} runs"),
        (all, _) => format!("the {all} runs"),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_do_not_end_their_elements() {
        for script in [SCRIPT, WORKER, rerun::SCRIPT] {
            assert!(!script.contains("</script") && !script.contains("<!--"));
        }
    }
}
