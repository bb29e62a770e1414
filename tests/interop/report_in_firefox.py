"""Opens pages in Firefox from files, in a light and a dark theme, at 1280 and 390 pixels.

Usage: python report_in_firefox.py [--axe AXE.min.js] REPORT.html ...    (packages: requirements.txt; program: firefox-esr)

Exit code 1 if a page has an error in its console, fetches something, is wider than the window, has a plot without a size, or has a replay
that does not reach its first, middle and last frame, draws nothing there or does not play to its end, or, with the script of axe-core, violates a rule of
accessibility. Control: a page with an error, one that is too wide, and one with pale text are found first.
"""

import itertools
import json
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from websockets.sync.client import connect

# Plays the replay's frames through its slider, as a user does, and reports what is wrong.
PROBE = """async () => {
  const faults = [];
  const drawn = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const page = document.documentElement;
  if (page.scrollWidth > page.clientWidth) faults.push(`${page.scrollWidth} px wide on ${page.clientWidth}`);
  const fetched = performance.getEntriesByType("resource").map((entry) => entry.name);
  if (fetched.length) faults.push(`fetched: ${fetched}`);
  const plots = [...document.querySelectorAll("figure > svg, .plane > svg")].filter((plot) => plot.checkVisibility());
  for (const plot of plots) {
    const box = plot.getBoundingClientRect();
    if (!(box.width > 100 && box.height > 60)) faults.push("a plot without a size");
  }
  let frames = 0;
  const scrub = document.querySelector(".replay .scrub"), canvas = document.querySelector(".replay canvas");
  // A key pressed before the frames are decoded changes nothing.
  canvas?.dispatchEvent(new KeyboardEvent("keydown", { key: "End" }));
  await window.replay?.ready;
  // Without a slider, the page states why there is no replay.
  if (scrub?.checkVisibility()) {
    frames = Number(scrub.max) + 1;
    for (const frame of [0, Math.floor(scrub.max / 2), Number(scrub.max)]) {
      scrub.value = frame;
      scrub.dispatchEvent(new Event("input", { bubbles: true }));
      await drawn();
      if (Number(scrub.value) !== frame) faults.push(`frame ${scrub.value} in place of ${frame}`);
      const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
      if (new Set(pixels).size < 3) faults.push(`nothing is drawn at frame ${frame}`);
    }
    const speed = document.querySelector(".speed"), { fps } = JSON.parse(document.querySelector("script.film").dataset.film);
    const end = performance.now() + 10000;
    speed.options[0].value = scrub.max / fps;
    speed.selectedIndex = 0;
    if (frames > 1) document.querySelector(".play").click();
    await drawn();
    while (scrub.value !== scrub.max && performance.now() < end) await drawn();
    if (scrub.value !== scrub.max) faults.push(`playback ends at frame ${scrub.value}`);
    speed.options[0].value = 0.1;
  }
  return JSON.stringify({ faults, frames, plots: plots.length });
}"""

# Lists stay closed: in Chromium, they are examined open.
EXAMINE = """async () => {
  const { violations } = await axe.run(document, { iframes: false, resultTypes: ["violations"] });
  return JSON.stringify(violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map((node) => node.target).join(" | ")}`));
}"""


class Browser:
    """A headless Firefox with a profile of its own, controlled through WebDriver BiDi. To be used as a context manager."""

    def __init__(self, folder, is_dark, axe):
        self.axe = axe
        profile = Path(folder) / ("dark" if is_dark else "light")
        profile.mkdir()
        settings = {"layout.css.prefers-color-scheme.content-override": 0 if is_dark else 1, "network.proxy.type": 1}
        # A proxy that does not exist: nothing leaves this machine, also not what the browser itself asks for.
        settings |= {"network.proxy.http": "127.0.0.1", "network.proxy.http_port": 9, "network.proxy.share_proxy_settings": True}
        settings |= {"network.proxy.ssl": "127.0.0.1", "network.proxy.ssl_port": 9}
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in settings.items()]
        (profile / "user.js").write_text("\n".join(lines))
        command = ["firefox-esr", "--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        address = next(filter(None, (re.search(r"ws://[\d.:]+", line) for line in self.process.stderr))).group()
        self.connection = connect(f"{address}/session", max_size=None)
        self.numbers, self.errors = itertools.count(1), []

    def __enter__(self):
        self.socket = self.connection.__enter__()
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])
        self.tab = self.call("browsingContext.getTree")["contexts"][0]["context"]
        return self

    def call(self, method, **parameters):
        """The result of a command; errors of the page on the way are kept."""
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("method") == "log.entryAdded" and message["params"]["level"] in ("error", "warn"):
                self.errors.append(message["params"]["text"])
            if message.get("id") == number:
                if message["type"] == "error":
                    sys.exit(f"{method}: {message['message']}")
                return message["result"]

    def open(self, page, width):
        """What is wrong with a page, and its numbers of plots and frames."""
        self.errors.clear()
        self.call("browsingContext.setViewport", context=self.tab, viewport={"width": width, "height": 900})
        self.call("browsingContext.navigate", context=self.tab, url=page.resolve().as_uri(), wait="complete")
        seen = self.result_of(PROBE)
        if self.axe and width > 1000:
            self.call("script.evaluate", expression=self.axe + ";0", target={"context": self.tab}, awaitPromise=False)
            seen["faults"] += self.result_of(EXAMINE)
        return self.errors + seen["faults"], seen

    def result_of(self, function):
        """The result of a function in the page; a fault if it throws."""
        answer = self.call("script.callFunction", functionDeclaration=function, target={"context": self.tab}, awaitPromise=True)
        if answer["type"] == "exception":
            fault = [answer["exceptionDetails"]["text"]]
            return {"faults": fault} if function is PROBE else fault
        return json.loads(answer["result"]["value"])

    def __exit__(self, *error):
        self.connection.__exit__(*error)
        self.process.terminate()
        self.process.wait()


def require_control(browser, folder):
    """Faults that are there must be found."""
    controls = [("<script>undefined.x</script>", "undefined"), ('<div style="width: 2000px">x</div>', "px wide on")]
    if browser.axe:
        controls.append(('<p style="color: #ccc; background: #fff">pale</p>', "color-contrast"))
    for body, fault in controls:
        page = Path(folder) / "control.html"
        page.write_text(f"<!doctype html><title>control</title><body>{body}</body>")
        faults, _ = browser.open(page, 1280)
        if not any(fault in found for found in faults):
            sys.exit(f"the control is not found: {body} gave {faults}")


def is_faulty(pages, axe, is_dark):
    """Whether a page has a fault in a theme; prints a line per page and width."""
    faulty = False
    with tempfile.TemporaryDirectory() as folder, Browser(folder, is_dark, axe) as browser:
        require_control(browser, folder)
        for page, width in itertools.product(pages, [1280, 390]):
            faults, seen = browser.open(page, width)
            theme = "dark" if is_dark else "light"
            print(f"{page.parent.name}, {theme}, {width} px: {seen.get('plots')} plots, {seen.get('frames')} frames", *faults, flush=True)
            faulty |= bool(faults)
    return faulty


def main(pages, axe):
    # A page takes some seconds, most of them for its playback: both themes at a time.
    with ThreadPoolExecutor() as themes:
        found = [themes.submit(is_faulty, pages, axe, is_dark) for is_dark in (False, True)]
        sys.exit(any([faulty.result() for faulty in found]))


if __name__ == "__main__":
    words = sys.argv[1:]
    script = Path(words[1]).read_text() if words[:1] == ["--axe"] else None
    main([Path(page) for page in words[2 if script else 0:]], script)
