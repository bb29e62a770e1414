//! Guarantee: next to the replay of a gas in gravity, the density by height is that of the frame that is shown, with the barometric law: the only
//! bar is at the particles.
//!
//! Setup: headless Chromium; 400 particles that are all in one layer of 20, another one in each frame. Control: the frames have different bars, and the law,
//! which falls with the height, does not change.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{element, examined};
use crate::synthetic::{Folder, analyze, frames_of};

const MANIFEST: &str = "name = \"heights\"\n[model.gas]\nparticles = 400\nmass_kg = 8.4429387e-22\nradius_m = 1.0\ntemperature_k = 300.0\n\
    gravity_m_per_s2 = 9.81\nduration_s = 1.0\n[record]\nframes = 2\nchannels = [\"state\"]\n";

/// Heights of the particles in the frames, m: the middles of the layers 1, 9 and 15.
const HEIGHTS: [f64; 3] = [-0.85, -0.05, 0.55];

/// The heights of the bars and of the law above the axis, px, in each frame.
const SCRIPT: &str = r#"<script>
held((async () => {
  const found = [], foot = 152;
  await replay.ready;
  for (let frame = 0; frame < 3; frame++) {
    replay.show(frame);
    await nextFrames(2);
    const [bars, law] = [...document.querySelector(".live svg").children].map((child) => child.getAttribute("d"));
    found.push([[...bars.matchAll(/V([\d.]+)H/g)].map(([, y]) => foot - y), [...law.matchAll(/ ([\d.]+)/g)].map(([, y]) => foot - y)]);
  }
  document.title = JSON.stringify(found);
})());
</script>"#;

#[test]
#[ignore = "needs chromium"]
fn density_by_height_is_that_of_the_frame() {
    let folder = Folder::write(MANIFEST, |_| {
        frames_of(0..3, |index, frame| {
            for particle in 0..400 {
                let place = 0.001 * f64::from(particle) - 0.2;
                frame.push_state(&[place, HEIGHTS[index as usize], 1.0, 0.0]);
            }
            f64::from(index) / 2.0
        })
    });
    assert!(analyze(&[folder.name()]).code != 2);
    let (document, console) = examined(&folder.path().join("report.html"), SCRIPT, false);
    assert_eq!(console, "");
    let found: Vec<[Vec<f64>; 2]> = serde_json::from_str(element(&document, "title")).unwrap();
    assert_eq!(found.len(), HEIGHTS.len());
    for ([bars, law], layer) in found.iter().zip([1, 9, 15]) {
        assert_eq!((bars.len(), law.len()), (20, 20));
        for (index, bar) in bars.iter().enumerate() {
            assert_eq!(*bar > 1.0, index == layer, "layer {index}: {bars:?}");
        }
        assert_eq!(law, &found[0][1], "control");
        assert!(law.windows(2).all(|pair| pair[0] > pair[1]), "{law:?}");
    }
}
