//! `play.html`: the page that runs the manifest of its address, or of a model's starter, without a recording.

use super::engine::{self, ENGINE, NONCE, PLAY};
use super::engine_place::EnginePlace;
use super::html::page_head;
use super::rerun;
use crate::plot::palette;
use crate::write_file::{WriteError, replace};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use maud::{DOCTYPE, PreEscaped, html};
use miniz_oxide::deflate::compress_to_vec_zlib;
use std::path::Path;

/// Characters of the longest link that is offered, as in the script.
const MOST_CHARACTERS: usize = 8192;
/// The parts of the report's script that the page needs.
const PARTS: [&str; 2] = [include_str!("numbers.js"), include_str!("report.js")];

/// The address of a manifest in the page, unless it is too long.
pub(super) fn link(manifest: &str) -> Option<String> {
    let packed = URL_SAFE_NO_PAD.encode(compress_to_vec_zlib(manifest.as_bytes(), 9));
    Some(format!("{PLAY}#manifest={packed}")).filter(|link| link.len() <= MOST_CHARACTERS)
}

/// Writes the module next to the pages that need it, and the play page.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(place: EnginePlace, folder: &Path) -> Result<(), WriteError> {
    let EnginePlace::NextToPage(module) = place else { return Ok(()) };
    replace(&folder.join(ENGINE), engine::module_script(module))?;
    replace(&folder.join(PLAY), page(module))
}

/// The page with the engine of this hash next to it.
fn page(module: &'static [u8]) -> String {
    let (place, hash) = (EnginePlace::NextToPage(module), engine::hash(module));
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (page_head("Simulation", &palette::style_sheet(), &engine::policy(place)))
            body {
                main class="play" {
                    header {
                        h1 { "A simulation in this page" }
                        p class="facts" { "The engine runs the manifest in this browser. Nothing is installed or sent." }
                    }
                    script nonce=(NONCE) { (PreEscaped(PARTS.concat())) }
                    (engine::scripts(place))
                    (rerun::play(&hash))
                    p class="facts" { "Engine " (env!("CARGO_PKG_VERSION")) ", SHA-256 " (hash[..16]) "; its messages are those of the program." }
                    noscript { p { "Simulations in this page need JavaScript and WebAssembly." } }
                }
            }
        }
    };
    page.into_string() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_contain_the_manifest_or_are_not_offered() {
        let manifest = kinetoscope_manifest::starter("orbit").unwrap();
        let link = link(manifest).unwrap();
        let packed = URL_SAFE_NO_PAD.decode(link.strip_prefix("play.html#manifest=").unwrap());
        let text = miniz_oxide::inflate::decompress_to_vec_zlib(&packed.unwrap()).unwrap();
        assert_eq!(text, manifest.as_bytes());
        let random: String = (0..9_000u64).map(|n| format!("{}", n * n % 9973)).collect();
        assert_eq!(super::link(&random), None);
    }
}
