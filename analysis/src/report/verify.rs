//! "Verify in this browser": a button that repeats the runs in the reader's browser and compares each frame with the recording.

use crate::report::engine::{NONCE, hash, scripts};
use crate::report::engine_place::EnginePlace;
use crate::report::{AnalysisReport, rerun};
use crate::run::RunAnalysis;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use kinetoscope_recording::claim::Claim;
use maud::{Markup, PreEscaped, html};

const VERIFY: &str = include_str!("verify.js");

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
    let hash = hash(module);
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
        (scripts(report.engine))
        script nonce=(NONCE) { (PreEscaped(VERIFY)) }
        (rerun::section(report, matches!(report.engine, EnginePlace::InPage(_))))
    }
}

fn runs_in_words(claimed: usize, all: usize) -> String {
    match (claimed, all) {
        (1, 1) => "the run".to_owned(),
        (some, all) if some < all => format!("{some} of {all} runs"),
        (all, _) => format!("the {all} runs"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::engine;

    #[test]
    fn scripts_do_not_end_their_elements() {
        for script in [VERIFY, engine::SCRIPT, engine::WORKER, rerun::SCRIPT] {
            assert!(!script.contains("</script") && !script.contains("<!--"));
        }
    }
}
