"""Does the site of book/build.sh work from files and from a static server, and does it ask no other host?

Usage: python site_is_whole.py SITE    (package: websockets; program: chromium)

book/check_links.py checks its links. Here, Chromium opens the front page, the gallery, the play page, the book, the documentation and every report, from files
and from a server on loopback, and logs every request: each must be of the site, and succeed. The front page runs its simulation to the end, the gallery
opens a manifest in the play page, and the first report verifies itself. Exit code 1 for a fault.
"""

import json
import sys
import tempfile
from pathlib import Path

from chromium import Browser
from engine_verifies import EQUAL, PRESS, served

PAGES = ("index.html", "gallery.html", "play.html", "book/index.html", "api/kinetoscope/index.html")
RUN = """(async () => {
  const [button] = document.querySelectorAll(".rerun button"), status = document.querySelector(".rerun [role=status]");
  while (!/manifest of the link|complete|frame/.test(status.textContent)) await new Promise((done) => setTimeout(done, 5));
  if (button.textContent === "Run") button.click();
  while (button.textContent === "Stop") await new Promise((done) => setTimeout(done, 20));
  return status.textContent;
})()"""


class Logged(Browser):
    """A browser that keeps the addresses of all requests, and those that failed."""

    requests, failed = [], []

    def until(self, wanted):
        def seen(message):
            if message.get("method") == "Network.requestWillBeSent":
                self.requests.append(message["params"]["request"]["url"])
            if message.get("method") == "Network.loadingFailed" or message.get("params", {}).get("response", {}).get("status", 200) >= 400:
                self.failed.append(json.dumps(message["params"])[:300])
            return wanted(message)
        return super().until(seen)


def examine(browser, site, address):
    """What is wrong with the site at an address."""
    faults = []
    reports = sorted(report.relative_to(site) for report in site.glob("*/report.html"))
    pages = [page for page in PAGES if (site / page).exists()]
    browser.requests.clear()
    browser.failed.clear()
    for page in [*pages, *reports]:
        browser.open(f"{address}/{page}")
        faults += [f"{page}: {error}" for error in browser.errors]
        # Pages that run something.
        ending = browser.value(RUN) if page == "index.html" else "complete"
        if page == "gallery.html":
            browser.open(browser.value("document.querySelector('a.play').href"))
            ending = browser.value(RUN)
        faults += [] if "complete" in ending else [f"{page}: {ending}"]
    browser.open(f"{address}/{site.joinpath('first_run/report.html').relative_to(site)}")
    lines = json.loads(browser.value(f"({PRESS})()"))["lines"]
    faults += [] if lines and all(map(EQUAL.search, lines)) else [f"first_run: {lines}"]
    foreign = [url for url in browser.requests if not url.startswith((f"{address}/", "blob:", "data:"))]
    print(f"{address.split(':')[0]}: {len(pages)} pages, {len(reports)} reports, {len(browser.requests)} requests, {len(foreign)} of them of another origin, "
          f"{len(browser.failed)} failed", flush=True)
    return faults + [f"request: {url[:200]}" for url in foreign] + browser.failed


def main(site):
    faults = [] if all((site / page).exists() for page in PAGES[:3]) else ["a page is missing"]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, Logged(folder) as browser:
        browser.call("Network.enable")
        for address in (site.as_uri(), served(site)):
            faults += examine(browser, site, address)
    print("\n".join(f"FAULT {text}" for text in faults[:20]))
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
