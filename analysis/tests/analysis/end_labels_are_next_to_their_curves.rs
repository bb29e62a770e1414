//! Guarantee: labels at the ends of curves lie right of the plotted area and within the figure, each at the height of the end of its curve or pushed from there by
//! its neighbors, on a page without a replay as well, whose figure is wider than its plot, in windows from 600 to 1920 px.
//!
//! Setup: the stacked energy of a fall with dashpots, in headless Chromium. Control: with the labels of another place, the same comparison fails.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{dumped, element, with_script};
use crate::synthetic::{Folder, analyze, frames_of};
use kinetoscope_recording::channels::DemEnergy;
use std::fs;

const MANIFEST: &str = "name = \"areas\"\n[model.dem]\ndiscs = 2\nduration_s = 1.0\n[record]\nframes = 20\nchannels = [\"state\", \"energy\"]\n\
    [[plots]]\nfigure = \"energy_balance\"\n";

/// Writes the number of labels, and the faults of their places, to the title; labels are moved by so many pixels before.
const PROBE: &str = r#"<script>
held((async () => {
  await nextFrames(5);
  const faults = [];
  let labels = 0;
  for (const { figure, data, pixel } of charts) {
    const all = [...figure.querySelectorAll(".legend.ends button")];
    if (!all.length) continue;
    for (const label of all) label.style.marginLeft = "SHIFT" + "px";
    const frame = figure.querySelector(".frame").getBoundingClientRect(), outer = figure.getBoundingClientRect(), sheet = figure.querySelector(".sheet").getBoundingClientRect();
    const middles = all.map((label) => label.getBoundingClientRect()).map((box, i) => {
      labels++;
      if (box.left < frame.right || box.right > outer.right + 1) faults.push(`${all[i].textContent} is from ${box.left} to ${box.right}, the area ends at ${frame.right}`);
      if (box.top < frame.top - 12 || box.bottom > frame.bottom + 12) faults.push(`${all[i].textContent} is at ${box.top}`);
      return (box.top + box.bottom) / 2;
    });
    const curve = data.curves.find(({ name }) => name === "lost in dashpots"), end = curve.x.length - 1;
    const wanted = sheet.top + pixel(curve.x[end], (curve.y[end] + curve.below[end]) / 2)[1];
    const found = middles[all.findIndex((label) => label.textContent === curve.name)];
    if (Math.abs(found - wanted) > 1.5) faults.push(`the widest area ends at ${wanted}, its label is at ${found}`);
  }
  document.title = `${labels} ${faults.join("; ")}`;
})());
</script>"#;

#[test]
#[ignore = "needs chromium"]
fn labels_are_at_the_ends_without_a_replay() {
    let folder = Folder::write(MANIFEST, |_| {
        frames_of(0..=20, |index, frame| {
            let time = f64::from(index) / 20.0;
            frame.push_state(&[0.01, 0.01, 0.0, 0.0]);
            frame.push_state(&[0.02, 0.01, 0.0, 0.0]);
            frame.push(&DemEnergy {
                kinetic_j: 1e-4 * (1.0 - time),
                gravitational_j: 3e-4 * (1.0 - time) + 1e-5,
                dissipated_j: 4e-4 * time,
                ..DemEnergy::default()
            });
            time
        })
    });
    assert!(analyze(&["--no-replay", folder.name()]).code != 2);
    let page = folder.page();
    let probed = folder.path().join("probed.html");
    for (width, shift) in [(600, 0), (1280, 0), (1920, 0), (1280, -300)] {
        fs::write(&probed, with_script(&page, &PROBE.replace("SHIFT", &shift.to_string())))
            .unwrap();
        let (document, console) = dumped(&probed, width, false);
        assert_eq!(console, "");
        let (labels, faults) = element(&document, "title").split_once(' ').unwrap();
        assert!(labels.parse::<u32>().unwrap() >= 3, "{labels} labels at {width} px");
        assert_eq!(faults.is_empty(), shift == 0, "{width} px: {faults}");
    }
}
