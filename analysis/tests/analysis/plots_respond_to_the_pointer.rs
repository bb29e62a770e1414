//! Guarantee: in `report.html`, a plot shows the values of the point under the pointer, is zoomed by dragging and by no click, hides curves
//! by their legend entries and has a logarithmic scale on request. Moving over a plot over time moves the replay, and the replay's time is
//! a line in the plot. Every metric of a sweep can be plotted over every swept key.
//!
//! Setup: headless Chromium with synthetic events. Control: the same checks fail on a page whose script does not handle them.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{element, examined};
use crate::synthetic::{Folder, Frames, analyze, frames_of};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{DemContactStatistics, DemEnergy, DemTemperature};
use std::fs;
use std::path::Path;

const MANIFEST: &str = r#"# Do <discs> fall? Expected: "yes" & no.
name = "falling"
[model.dem]
discs = 2
duration_s = 1.0
[record]
frames = 20
channels = ["state", "energy", "contact_statistics", "temperature"]
[sweep]
"model.dem.restitution" = [0.25, 0.5, 0.75]
[[plots]]
y = "/contact_statistics.coordination_number"
"#;

/// Discs whose kinetic energy is 1e-4 J at the time 0.5 s, which alone has a coordination number.
fn frames(_: &RunManifest) -> Frames {
    frames_of(0..=20, |index, frame| {
        let time = f64::from(index) / 20.0;
        for disc in 0..2 {
            frame.push_state(&[0.01 * f64::from(disc + 1), 0.02 * (1.0 - time), 0.0, -0.01]);
        }
        frame.push(&DemEnergy {
            kinetic_j: 2e-4 * time,
            gravitational_j: 3e-4 - 1e-4 * time,
            ..DemEnergy::default()
        });
        frame.push(&DemContactStatistics {
            coordination_number: if index == 10 { 1.0 } else { f64::NAN },
            ..DemContactStatistics::default()
        });
        frame.push(&DemTemperature::default());
        time
    })
}

/// Appended to the page: uses each plot as a reader does, and writes what does not respond.
const PROBE: &str = r##"<script>
held((async () => {
  const faults = [];
  let points = 0, scrubbed = 0, toggled = 0, sought = 0;
  const expect = (holds, what) => { if (!holds) faults.push(what); };
  try {
    for (const list of document.querySelectorAll("details")) list.open = true;
    if (window.replay) await replay.ready;
    await nextFrames(5);
    for (const chart of charts) {
      // Each plot that does not respond takes a wait of its own; all of them would take longer than the browser has.
      if (faults.length) break;
      const { figure, data } = chart, sheet = figure.querySelector(".sheet"), name = data.title;
      const tip = figure.querySelector(".tip"), tools = [...figure.querySelectorAll(".tools button")];
      const box = () => sheet.getBoundingClientRect(), scale = () => box().width / sheet.viewBox.baseVal.width;
      const fire = (type, [x, y], more) => sheet.dispatchEvent(new PointerEvent(type, {
        clientX: box().left + x * scale(), clientY: box().top + y * scale(), bubbles: true, button: 0, pointerId: 1, ...more }));
      const numbers = (text) => Number(text.replace("−", "-").replace(/\(\d+\)/, ""));
      // A curve drawn last is not covered by others.
      const curve = data.curves.at(-1), i = Math.floor(curve.x.length / 2);
      if (curve.x[i] === null || curve.y[i] === null || chart.isLog.some((isLog, axis) => isLog && !([curve.x, curve.y][axis][i] > 0))) continue;
      const at = chart.pixel(curve.x[i], curve.y[i]);
      fire("pointermove", at);
      expect(!tip.hidden, `${name}: no values under the pointer`);
      expect(tip.textContent.includes(`${data.x.label} = `) && tip.textContent.includes(`${data.y.label} = `), `${name}: ${tip.textContent}`);
      const [, values] = tip.textContent.split(`${data.x.label} = `);
      if (values && !data.x.words && Math.abs(curve.x[i]) > 0.01 && Math.abs(curve.x[i]) < 1000) {
        const said = numbers(values.split(/[ \n]/)[0]), reach = chart.range[0][1] - chart.range[0][0];
        expect(chart.isLog[0] || Math.abs(said - curve.x[i]) < reach / 20, `${name}: ${said}, not ${curve.x[i]}`);
      }
      const paths = [...sheet.querySelectorAll("path.curve")];
      expect(paths.every((path) => !path.getAttribute("d") || path.getTotalLength()), `${name}: a point without neighbors is not drawn`);
      points += 1;
      if (data.time && data.curves.some((each) => each.run) && window.replay) {
        const isPlayed = () => data.curves.some((each) => each.run.file === replay.file);
        // Relative, because the range of a logarithmic axis is in powers of ten; the page's numbers have seven digits.
        const isInTime = () => Math.abs(replay.time - curve.x[i]) <= 1e-6 * Math.abs(curve.x[i]);
        await until(() => isPlayed() && isInTime());
        await nextFrames(3);
        const line = figure.querySelector(".now");
        expect(isPlayed(), `${name}: another run plays`);
        expect(line.getAttribute("visibility") === "visible", `${name}: no line at the time of the replay`);
        expect(isInTime(), `${name}: the replay is at ${replay.time}, the pointer at ${curve.x[i]}`);
        replay.show(0);
        const left = Number(line.getAttribute("x1"));
        replay.show(replay.frames - 1);
        expect(Number(line.getAttribute("x1")) > left, `${name}: the line does not follow the replay`);
        scrubbed += 1;
      }
      fire("pointerleave", at);
      expect(tip.hidden, `${name}: values remain`);
      const [before] = chart.range, width = sheet.viewBox.baseVal.width;
      fire("pointerdown", [0.4 * width, 60]);
      fire("pointermove", [0.6 * width, 61]);
      fire("pointerup", [0.6 * width, 61]);
      const [zoomed] = chart.range;
      expect(zoomed[1] - zoomed[0] < 0.5 * (before[1] - before[0]), `${name}: dragging does not zoom`);
      const reset = tools.find((button) => button.textContent === "reset zoom");
      expect(getComputedStyle(reset).visibility === "visible", `${name}: no way back`);
      sheet.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
      expect(String(chart.range[0]) === String(before), `${name}: double click does not reset`);
      fire("pointerdown", [0.5 * width, 60]);
      fire("pointerup", [0.5 * width, 60]);
      expect(String(chart.range[0]) === String(before), `${name}: a click zooms`);
      for (const [axis, label] of ["log x", "log y"].entries()) {
        const button = tools.find((each) => each.textContent === label);
        if (!button) continue;
        const was = chart.isLog[axis];
        button.click();
        expect(chart.isLog[axis] !== was && button.getAttribute("aria-pressed") === String(!was), `${name}: no ${label}`);
        expect(sheet.querySelectorAll("text").length > 3, `${name}: no ticks with ${label}`);
        button.click();
        toggled += 1;
      }
      const drawn = () => sheet.querySelectorAll(".curve").length, all = drawn();
      const entry = figure.querySelector(".legend button");
      if (entry) {
        entry.click();
        expect(drawn() < all && entry.getAttribute("aria-pressed") === "false", `${name}: the legend hides nothing`);
        entry.click();
        expect(drawn() === all, `${name}: the legend shows nothing`);
      }
      sheet.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
      sheet.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true }));
    }
    // Of two times, the latter counts, although the run is not decoded at the former.
    const files = [...document.querySelectorAll("[data-file]")].map((each) => each.dataset.file);
    const other = window.replay && files.find((file) => replay.has(file) && file !== replay.file);
    if (other) {
      replay.show(replay.frames - 1);
      const end = replay.time;
      replay.seek(0, other);
      replay.seek(end, other);
      await until(() => replay.file === other);
      await nextFrames(1);
      expect(replay.time > 0, `the replay is at its start, not at ${end}`);
      sought = 1;
    }
    const any = document.querySelector(".any");
    let swept = 0;
    if (any) {
      const metric = any.querySelector(".metric");
      for (let index = 0; index < metric.options.length; index++) {
        metric.selectedIndex = index;
        metric.dispatchEvent(new Event("change"));
        await nextFrames(1);
        expect(any.querySelector("figcaption").textContent.startsWith(metric.value.replace(/ \([^()]*\)$/, "")), `${metric.value} is not plotted`);
        expect(any.querySelector(".sheet .curve"), `${metric.value} has no curve`);
        swept += 1;
      }
    }
    document.title = `points ${points}; scrubbed ${scrubbed}; toggled ${toggled}; swept ${swept}; sought ${sought}; faults ${JSON.stringify(faults)}`;
  } catch (error) { document.title = `failed: ${error.stack}`; }
})());
</script>"##;

/// The counts of what responded, or what did not.
fn use_plots(page: &Path) -> Result<String, String> {
    let (document, console) = examined(page, PROBE, false);
    if !console.is_empty() {
        return Err(console);
    }
    let title = element(&document, "title");
    match title.split_once("; faults ") {
        Some((counts, "[]")) => Ok(counts.to_owned()),
        _ => Err(title.to_owned()),
    }
}

#[test]
#[ignore = "needs chromium"]
fn plots_respond_and_share_the_time_of_the_replay() {
    let folder = Folder::write(MANIFEST, frames);
    analyze(&[folder.name()]).exited_with(0);
    let page = folder.path().join("report.html");
    let counts = use_plots(&page).unwrap();
    let count = |name: &str| -> u32 {
        let (_, rest) = counts.split_once(&format!("{name} ")).unwrap();
        rest.split(';').next().unwrap().parse().unwrap()
    };
    assert!(count("points") > 4 && count("scrubbed") > 2, "{counts}");
    assert!(count("toggled") > 2 && count("swept") > 5 && count("sought") == 1, "{counts}");

    // Control: a page without the handlers.
    let text = fs::read_to_string(&page).unwrap();
    let broken = folder.path().join("broken.html");
    for (handler, complaint) in [
        ("scrub(isLogX", "the replay is at"),
        ("point(nearest(to));\nscrub", "no values under the pointer"),
        ("seek.time=time;", "the replay is at"),
        ("setZoom([isWide", "dragging does not zoom"),
        ("if(isHidden)hidden.delete(each);else hidden.add(each);", "the legend hides nothing"),
        ("${top}h.01`", "a point without neighbors is not drawn"),
    ] {
        assert!(text.contains(handler), "{handler}");
        let harmless = match handler {
            "scrub(isLogX" => "Number(isLogX",
            "seek.time=time;" => "seek.time??=time;",
            "setZoom([isWide" => "Array.of([isWide",
            "if(isHidden)hidden.delete(each);else hidden.add(each);" => "",
            "${top}h.01`" => "${top}`",
            _ => "scrub",
        };
        fs::write(&broken, text.replace(handler, harmless)).unwrap();
        let fault = use_plots(&broken).unwrap_err();
        assert!(fault.contains(complaint), "{handler}: {fault}");
    }
}

/// Appended to the page: the looks of the curves of the plot of any metric, and its remark.
const LOOKS: &str = r#"<script>
held((async () => {
  for (const list of document.querySelectorAll("details")) list.open = true;
  await nextFrames(5);
  const { figure } = charts.at(-1);
  const looks = [...figure.querySelectorAll(".legend path")].map((path) => {
    const { stroke, strokeDasharray, strokeLinecap } = getComputedStyle(path);
    return [stroke, strokeDasharray, strokeLinecap, path.classList.contains("data")].join();
  });
  document.title = `${looks.length} curves, ${new Set(looks).size} looks: ${figure.querySelector(".remark").textContent}`;
})());
</script>"#;

#[test]
#[ignore = "needs chromium"]
fn every_curve_of_a_sweep_has_its_own_look() {
    let values: Vec<String> = (1..=16).map(|value| format!("{value}e4")).collect();
    let other = format!("\n\"model.dem.stiffness_n_per_m\" = [{}]\n[[plots]]", values.join(", "));
    let folder = Folder::write(&MANIFEST.replace("\n[[plots]]", &other), frames);
    analyze(&[folder.name()]).exited_with(0);
    let (document, console) = examined(&folder.path().join("report.html"), LOOKS, false);
    assert_eq!(console, "");
    let title = element(&document, "title");
    let (curves, looks) = title.split_once(" curves, ").unwrap();
    assert!(looks.starts_with(&format!("{curves} looks: the first 14 of 16 curves")), "{title}");
}

#[test]
fn head_and_numbers_name_question_result_and_files() {
    let folder = Folder::write(MANIFEST, frames);
    analyze(&[folder.name()]).exited_with(0);
    let text = folder.page();
    for shown in [
        "<h1 class=\"question\">Do &lt;discs&gt; fall?</h1>",
        "Expected: </span>&quot;yes&quot; &amp; no.",
        "<dt>physics</dt><dd>version 1</dd>",
        "href=\"./falling__000.mcap\"",
        "href=\"./metrics.csv\"",
        "href=\"./metrics.json\"",
        ".svg\">",
        "<summary><h2>Definitions</h2>",
        "<summary><h2>Manifest of the first run</h2></summary>",
    ] {
        assert!(text.contains(shown), "the report lacks {shown}");
    }
    assert!(!text.contains("class=\"machine"), "there is no host file");
    let host = r#"{"host":"<lab>","operating_system":"linux","architecture":"x86_64","finished_unix_time_s":951782400,"wall_time_s":1.5}"#;
    fs::write(folder.path().join("falling__000.host.json"), host).unwrap();
    assert_eq!(analyze(&[folder.name()]).code, 0);
    let text = folder.page();
    let machine = "recorded 2000-02-29 00:00 UTC, on &lt;lab&gt; (linux x86_64); wall time of the runs with a host file 1.5 s";
    assert!(text.contains(machine), "the report lacks {machine}");
    // Results in another folder have no links to recordings.
    let elsewhere = tempfile::TempDir::new().unwrap();
    let output = elsewhere.path().to_str().unwrap();
    assert_eq!(analyze(&["--output", output, folder.name()]).code, 0);
    let text = fs::read_to_string(elsewhere.path().join("report.html")).unwrap();
    let mut links = text.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next());
    assert!(!links.clone().any(|link| link.ends_with(".mcap")));
    assert!(links.any(|link| link == "./metrics.csv"));
}

#[test]
#[ignore = "needs chromium; REPORTS contains the paths of report.html files, separated by colons"]
fn given_plots_respond() {
    let reports = std::env::var("REPORTS").expect("REPORTS must name the reports");
    for page in reports.split(':') {
        let counts = use_plots(Path::new(page)).unwrap_or_else(|fault| panic!("{page}: {fault}"));
        println!("{page}: {counts}");
    }
}
