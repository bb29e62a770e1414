//! Guarantee: `report.html` opens in a browser without errors and without network requests. On a phone, no element is wider than the screen.
//! Every plot has its size and its title, no text extends beyond its area, and no text of the page is below 11 px, also with two runs side by side.
//!
//! Setup: headless Chromium. Control: a page with an error, a page that is too wide, and small text are found.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{dumped, element, with_script};
use crate::synthetic::{Folder, Frames, analyze, frames_of};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{DemContactStatistics, DemEnergy, DemTemperature};
use std::fs;
use std::path::Path;

const MANIFEST: &str = r#"
name = "discs_with_a_rather_long_name_that_must_break_on_a_phone"
description = "Three <discs> & their \"energy\"."
[model.dem]
discs = 3
duration_s = 1.0
[record]
frames = 20
channels = ["state", "energy", "contact_statistics", "temperature"]
[sweep]
"model.dem.restitution" = [0.5, 0.8]
[[checks]]
metric = "coordination_number"
minimum = 1.0
[[checks]]
metric = "energy.residual_relative"
maximum = 1e-3
"#;

fn frames(_: &RunManifest) -> Frames {
    frames_of(0..=20, |index, frame| {
        let time = f64::from(index) / 20.0;
        for disc in 0..3 {
            frame.push_state(&[
                0.01 * f64::from(disc + 1),
                0.001 + 0.01 * (1.0 - time),
                0.0,
                -0.01,
            ]);
        }
        frame.push(&DemEnergy {
            kinetic_j: 1e-4 * time,
            gravitational_j: 1e-4 * (1.0 - time),
            ..DemEnergy::default()
        });
        frame.push(&DemContactStatistics {
            coordination_number: 2.0,
            ..DemContactStatistics::default()
        });
        frame.push(&DemTemperature::default());
        time
    })
}

/// Appended to the page: writes the results of the browser to its end.
const PROBE: &str = r#"<script>
const faults = [];
held((async () => {
  const page = document.documentElement;
  for (const list of document.querySelectorAll("details")) list.open = true;
  await nextFrames(5);
  const checkPage = () => {
    if (page.scrollWidth > page.clientWidth) faults.push(`page ${page.scrollWidth} wide on ${page.clientWidth}`);
    for (const part of document.querySelectorAll("main :not(svg *, script)")) {
      const size = parseFloat(getComputedStyle(part).fontSize);
      const hasText = [...part.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
      if (hasText && part.checkVisibility() && size < 10.99) faults.push(`text of ${size} px: ${part.textContent.slice(0, 40)}`);
    }
  };
  checkPage();
  const pair = document.querySelector(".pair");
  if (pair) {
    pair.click();
    await window.replay.second.ready;
    await nextFrames(5);
    checkPage();
  }
  for (const svg of document.querySelectorAll("figure:not([hidden]) > svg, .plane > svg")) {
    const sheet = svg.getBoundingClientRect();
    // The picture of a flat box is flat.
    if (!(sheet.width > 100 && sheet.height > 60)) faults.push("a plot without a size");
    if (!svg.getAttribute("aria-label")) faults.push("a plot without a title");
    for (const text of svg.querySelectorAll("text")) {
      const box = text.getBoundingClientRect();
      if (box.left < sheet.left - 1 || box.right > sheet.right + 1 || box.top < sheet.top - 1 || box.bottom > sheet.bottom + 1)
        faults.push(`outside of its plot: ${text.textContent}`);
    }
    const texts = [...svg.querySelectorAll("text")];
    for (const text of texts) {
      const size = parseFloat(getComputedStyle(text).fontSize) * sheet.width / svg.viewBox.baseVal.width;
      if (size < 10.99) faults.push(`text of ${size} px: ${text.textContent}`);
    }
    texts.forEach((one, index) => texts.slice(index + 1).forEach((other) => {
      const [a, b] = [one.getBoundingClientRect(), other.getBoundingClientRect()];
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 1 && down > 3) faults.push(`overlap: ${one.textContent} and ${other.textContent}`);
    }));
  }
  if (performance.getEntriesByType("resource").length) faults.push("something was fetched");
  const found = `plots ${document.querySelectorAll("figure:not([hidden]) > svg, .plane > svg").length}; faults ${JSON.stringify(faults)}`;
  document.title = found;
  parent.postMessage(found, "*");
})());
</script>"#;

/// The title of a page after the probe, and the console of the browser, at a given width.
fn open_page(page: &Path, width: u32, dark: bool) -> (String, String) {
    let (dom, console) = dumped(page, width, dark);
    (element(&dom, "title").to_owned(), console)
}

fn check_page(page: &Path) -> Result<(), String> {
    let probed = page.with_file_name("probed.html");
    let text = fs::read_to_string(page).unwrap();
    fs::write(&probed, with_script(&text, PROBE)).unwrap();
    // Headless windows are at least 500 pixels wide, so a frame of 390 pixels represents the phone.
    let phone = page.with_file_name("phone.html");
    fs::write(&phone, PHONE).unwrap();
    for (file, width, dark) in [(&probed, 1300, false), (&probed, 1300, true), (&phone, 600, false)]
    {
        let (title, console) = open_page(file, width, dark);
        if !console.is_empty() {
            return Err(console);
        }
        if !title.starts_with("plots ")
            || !title.ends_with("faults []")
            || title.starts_with("plots 0")
        {
            return Err(format!("{width} wide: {title}"));
        }
    }
    Ok(())
}

/// The probed page in a frame with the width of a phone; its title is copied.
const PHONE: &str = r#"<!doctype html><title></title><iframe src="probed.html" width="390" height="800"></iframe>
<script>
addEventListener("message", (message) => { document.title = message.data; });
</script>"#;

#[test]
#[ignore = "needs chromium"]
fn report_opens_without_errors_on_a_screen_and_on_a_phone() {
    let folder = Folder::write(MANIFEST, frames);
    analyze(&["--snapshots-at", "0.5", folder.name()]).exited_with(0);
    let page = folder.path().join("report.html");
    let text = fs::read_to_string(&page).unwrap();
    assert!(
        !text.contains("http:")
            || text.matches("http:").count() == text.matches("http://www.w3.org/2000/svg").count()
    );
    check_page(&page).unwrap();

    // Control: a page with an error, and one that is too wide, are found.
    let broken = folder.path().join("broken.html");
    fs::write(&broken, text.replace("<main>", "<main><script>undefined.x</script>")).unwrap();
    assert!(check_page(&broken).unwrap_err().contains("TypeError"));
    fs::write(&broken, text.replace("<main>", "<main><div style=\"width: 1400px\">x</div>"))
        .unwrap();
    assert!(check_page(&broken).unwrap_err().contains("wide on"));
    fs::write(&broken, text.replace("<main>", "<main><p style=\"font-size: 10px\">x</p>")).unwrap();
    assert!(check_page(&broken).unwrap_err().contains("text of 10 px: x"));
}

#[test]
#[ignore = "needs chromium; REPORTS contains the paths of report.html files, separated by colons"]
fn given_reports_open_without_errors() {
    let reports = std::env::var("REPORTS").expect("REPORTS must name the reports");
    for page in reports.split(':') {
        check_page(Path::new(page)).unwrap_or_else(|fault| panic!("{page}: {fault}"));
    }
}
