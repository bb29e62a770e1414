//! The engine in the page: its module, its worker and what the page may load.
//!
//! A program that was built with `--features kinetoscope-program/engine` carries the module (`src/browser/build.sh`). It is written once to
//! each folder of results, and its reports load it when they are opened; `--single-file` puts it into the page. Such a page has a policy
//! without network access.

use crate::report::engine_place::EnginePlace;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use kinetoscope_recording::claim::sha256;
use maud::{Markup, PreEscaped, html};

/// The module next to the pages that load it.
pub(super) const ENGINE: &str = "kinetoscope-engine.js";
/// The page next to it that runs a manifest without a recording.
pub(super) const PLAY: &str = "play.html";
/// Marks the scripts of the page, so that no other one is executed. Every text from a file is escaped; therefore, it need not be secret.
pub(super) const NONCE: &str = "kinetoscope";
/// Nothing is loaded from any network, and nothing is sent. Only a script that does not belong to the page could open another one.
const POLICY: &str = "default-src 'none'; script-src 'nonce-kinetoscope' 'wasm-unsafe-eval'; worker-src blob:; style-src 'unsafe-inline'; \
     img-src data: blob:; base-uri 'none'; form-action 'none'";
pub(super) const SCRIPT: &str = include_str!("engine.js");
pub(super) const WORKER: &str = include_str!("engine_worker.js");

/// The script that hands the module to the page.
pub(super) fn module_script(module: &[u8]) -> String {
    format!("self.kinetoscopeEngine=\"{}\";\n", STANDARD.encode(module))
}

/// The policy of a page with an engine.
pub(super) fn policy(place: EnginePlace) -> Markup {
    html! {
        @if place.module().is_some() { meta http-equiv="Content-Security-Policy" content=(POLICY); }
    }
}

/// The module, its worker and the script that starts it.
pub(super) fn scripts(place: EnginePlace) -> Markup {
    html! {
        script type="text/plain" class="engine-worker" { (PreEscaped(WORKER)) }
        @if let EnginePlace::InPage(module) = place {
            script nonce=(NONCE) { (PreEscaped(module_script(module))) }
        } @else {
            script nonce=(NONCE) src=(ENGINE) {}
        }
        script nonce=(NONCE) { (PreEscaped(SCRIPT)) }
    }
}

/// The SHA-256 of a module in words.
pub(super) fn hash(module: &[u8]) -> String {
    sha256(module).iter().map(|byte| format!("{byte:02x}")).collect()
}
