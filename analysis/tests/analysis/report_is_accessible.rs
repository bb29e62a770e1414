//! Guarantee: axe-core finds no violation in `report.html` and `index.html`, in the light and in the dark theme: contrast,
//! labels, focus, structure. A report of a sweep is examined with one run and with two runs side by side.
//!
//! Setup: headless Chromium; axe-core is added to a copy of the page. Control: a page with pale text and an unlabeled button is found.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{element, examined};
use std::fs;
use std::path::Path;

/// Writes the violations to the title of the page, after its script has drawn everything.
const PROBE: &str = r#"<script>
held((async () => {
  for (const list of document.querySelectorAll("details")) list.open = true;
  if (window.replay) await window.replay.ready;
  await nextFrames(5);
  const texts = [];
  let rules = 0;
  const examine = async () => {
    const found = await axe.run(document, { iframes: false, resultTypes: ["violations"] });
    texts.push(...found.violations.map((one) => `${one.id}: ${one.nodes.slice(0, 3).map((node) => node.target + " " + (node.any[0]?.message ?? "")).join(" | ")}`));
    rules = found.passes.length + found.violations.length;
  };
  await examine();
  const pair = document.querySelector(".pair");
  if (pair) {
    pair.click();
    await window.replay.second.ready;
    await nextFrames(5);
    await examine();
  }
  document.title = `rules ${rules}; found [${texts.join("; ")}]`;
})());
</script>"#;

/// The violations of a page in both themes, as one text per theme.
fn violations(page: &Path) -> Vec<String> {
    let axe = std::env::var("AXE").expect("AXE must name axe.min.js of axe-core");
    let axe = fs::read_to_string(axe).unwrap();
    let script = format!("<script>{axe}</script>{PROBE}");
    let titles = [false, true].map(|dark| {
        let (document, console) = examined(page, &script, dark);
        assert_eq!(console, "", "{}", page.display());
        element(&document, "title").to_owned()
    });
    for title in &titles {
        assert!(title.starts_with("rules "), "axe-core did not run on {}: {title}", page.display());
    }
    titles.into_iter().filter(|title| !title.ends_with("found []")).collect()
}

#[test]
#[ignore = "needs chromium; AXE names axe.min.js; REPORTS contains the paths of reports, separated by colons, and INDEX the page that lists them"]
fn pages_have_no_violation_in_either_theme() {
    let reports = std::env::var("REPORTS").expect("REPORTS must name the reports");
    let index = std::env::var("INDEX").expect("INDEX must name the page of all experiments");
    for page in reports.split(':').chain([index.as_str()]) {
        assert_eq!(violations(Path::new(page)), [""; 0], "{page}");
    }
}

#[test]
#[ignore = "needs chromium; AXE names axe.min.js"]
fn pale_text_and_unlabeled_buttons_are_violations() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let text = "<!doctype html><html lang=\"en\"><head><title>x</title></head><body><main><h1>x</h1><p style=\"color: #ccc; background: #fff\">pale</p><button></button></main></body></html>";
    fs::write(&page, text).unwrap();
    let found = violations(&page);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found.iter().all(|text| text.contains("color-contrast") && text.contains("button-name")),
        "{found:?}"
    );
}
