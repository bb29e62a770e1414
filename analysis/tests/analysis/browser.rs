//! Pages in headless Chromium, with scripts that examine them.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

/// The document of a page after its scripts, and the console of the browser.
pub(crate) fn dumped(page: &Path, width: u32, dark: bool) -> (String, String) {
    let mut chromium = Command::new("chromium");
    chromium.args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"]);
    if dark {
        chromium.arg("--force-dark-mode");
    }
    let output = chromium
        .arg(format!("--window-size={width},2000"))
        .args(["--disable-quic", "--no-first-run", "--disable-background-networking"])
        .args(["--disable-component-update", "--disable-sync"])
        .arg("--dump-dom")
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("chromium must be installed");
    let dom = String::from_utf8_lossy(&output.stdout).into_owned();
    let log = String::from_utf8_lossy(&output.stderr);
    let console: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    (dom, console.join("\n"))
}

/// Precedes a script that is appended to a page: a frame that is not loaded holds the page's event `load`, at which the browser writes
/// the document, until an asynchronous function has ended, for at most two minutes. `until` waits for a condition, such as that another
/// run is decoded.
const HOLD: &str = r"<script>
function held(promise) {
  const frame = document.createElement('iframe');
  frame.hidden = true;
  document.body.append(frame);
  frame.contentDocument.open();
  const release = () => frame.contentDocument?.close();
  setTimeout(release, 120000);
  promise.finally(release);
}
const nextFrames = async (count) => { while (count--) await new Promise(requestAnimationFrame); };
const until = async (holds) => { for (const end = performance.now() + 15000; !holds() && performance.now() < end;) await nextFrames(1); };
</script>";

/// The page with a script at its end.
pub(crate) fn with_script(page: &str, script: &str) -> String {
    page.replace("</body>", &format!("{HOLD}{script}</body>"))
}

/// The document of a page and the console of the browser, after a script at the end of the page. The page stays as it is. Several tests
/// may examine one page at the same time.
pub(crate) fn examined(page: &Path, script: &str, dark: bool) -> (String, String) {
    static EXAMINED: AtomicU32 = AtomicU32::new(0);
    let number = EXAMINED.fetch_add(1, Ordering::Relaxed);
    let probed = page.with_file_name(format!("examined_{}_{number}.html", std::process::id()));
    fs::write(&probed, with_script(&fs::read_to_string(page).unwrap(), script)).unwrap();
    let found = dumped(&probed, 1280, dark);
    fs::remove_file(&probed).unwrap();
    found
}

/// The text of the first element of this kind, such as `title`; empty without one.
pub(crate) fn element<'a>(document: &'a str, kind: &str) -> &'a str {
    let start = document.split_once(&format!("<{kind}>")).map_or("", |(_, rest)| rest);
    start.split(&format!("</{kind}>")).next().unwrap_or_default()
}
