"""Law pages of the book on a phone and on a screen: nothing scrolls sideways, formulas and pictures are drawn, and the search finds each law once.

Usage: python tests/pages/law_pages_fit.py target/book/html    (package: websockets; program: chromium)

The search of the book is asked for the title of each measured law; its page must be among the results exactly once. Controls: a page whose table is not one of cards, one without a
formula and one whose picture is missing must be found.
"""

import json
import re
import sys
import tempfile
from html import unescape
from pathlib import Path

from chromium import Browser

SIZES = ((1280, 900), (390, 844))

PROBE = """(async () => {
  await Promise.all([...document.querySelectorAll("main img")].map((image) => image.decode().catch(() => {})));
  const wide = (part) => part.clientWidth > 0 && part.scrollWidth > part.clientWidth + 1;
  const page = document.documentElement;
  const main = document.querySelector("main");
  const beyond = [...main.querySelectorAll("p, li, table, td, div, figure, math")]
    .filter((part) => !part.closest("pre, .formula") && part.getBoundingClientRect().right > innerWidth + 1);
  const formulas = [...main.querySelectorAll(".formula math")].filter((math) => math.getBoundingClientRect().height > 10);
  return { wide: [...(wide(page) ? ["page"] : []), ...[...main.querySelectorAll("table, .table-wrapper, .formula, li, p")].filter(wide).map((part) => part.tagName),
      ...beyond.map((part) => part.tagName)],
    formulas: formulas.length, derivation: main.querySelectorAll("ol li").length,
    missing: [...main.querySelectorAll("img")].filter((image) => !image.naturalWidth).map((image) => image.getAttribute("src")),
    plots: main.querySelectorAll(".plots img").length, replays: main.querySelectorAll("figure.replay img").length };
})()"""

# mdBook loads its index when the search is opened. Only references to the pages of the laws count.
SEARCH = """(async (title) => {
  if (!window.lawSearch) {
    document.getElementById("mdbook-search-toggle").click();
    for (let i = 0; i < 200 && !(window.search && document.getElementById("mdbook-searchbar")); i++) await new Promise((done) => setTimeout(done, 50));
  }
  const bar = document.getElementById("mdbook-searchbar");
  bar.value = title;
  bar.dispatchEvent(new KeyboardEvent("keyup", { key: "a" }));
  bar.dispatchEvent(new Event("input"));
  const results = document.getElementById("mdbook-searchresults");
  let last = "";
  for (let i = 0; i < 60; i++) {
    await new Promise((done) => setTimeout(done, 50));
    const now = document.getElementById("mdbook-searchresults-header").textContent + results.childElementCount;
    if (i > 10 && results.childElementCount && now === last) break;
    last = now;
  }
  return [...results.querySelectorAll("a")].map((link) => link.getAttribute("href").split("?")[0].split("#")[0]);
})"""


def faults_of(browser, page):
    """What is wrong with a law page."""
    faults = []
    for size in SIZES:
        browser.open(page.resolve().as_uri(), size)
        found = browser.value(PROBE)
        if found["wide"]:
            faults.append(f"wider than its place at {size[0]} px: {' '.join(sorted(set(found['wide'])))}")
        if found["missing"]:
            faults.append(f"not drawn: {' '.join(found['missing'])}")
        faults += [f"{found[name]} {name} at {size[0]} px" for name, least in (("formulas", 1), ("derivation", 2), ("plots", 2), ("replays", 1))
                   if found[name] < least]
    return faults


def require_controls(browser, page):
    """Faults that are there must be found."""
    text = page.read_text()
    for change, wanted in ((lambda whole: whole.replace('class="cards"', "").replace("</main>", "<table><tr><td>" + "x" * 200 + "</td></tr></table></main>"), "wider than"),
                           (lambda whole: re.sub(r'<div class="formula">.*?</div>', "", whole, count=1, flags=re.DOTALL), "0 formulas"),
                           (lambda whole: whole.replace("_deviation.svg", "_none.svg"), "not drawn")):
        control = page.with_name("control.html")
        control.write_text(change(text))
        faults = " ".join(faults_of(browser, control))
        control.unlink()
        if wanted not in faults:
            sys.exit(f"the control is not found: {wanted} in {faults}")


def main(html):
    pages = [page for page in sorted((html / "laws").glob("*.html")) if 'class="plots"' in page.read_text()]
    if not pages:
        sys.exit(f"{html} has no law pages with plots: book/build.sh")
    faults = []
    with tempfile.TemporaryDirectory() as folder, Browser(folder) as browser:
        require_controls(browser, pages[0])
        for page in pages:
            faults += [f"{page.stem}: {fault}" for fault in faults_of(browser, page)]
            browser.open((html / "laws" / "replays" / page.name).resolve().as_uri(), SIZES[0])
            if not browser.value("document.querySelectorAll('canvas').length"):
                faults.append(f"{page.stem}: the report has no replay")
        browser.open((html / "index.html").resolve().as_uri(), SIZES[0])
        for page in pages:
            title = unescape(re.search(r"<h1[^>]*>(.*?)</h1>", page.read_text().split("<main>")[1], re.DOTALL)[1])
            title = re.sub(r"<[^>]+>", "", title)
            times = browser.value(f"({SEARCH})({json.dumps(title)})").count(f"laws/{page.name}")
            if times != 1:
                faults.append(f"the search for “{title}” lists its page {times} times")
    print("\n".join(faults) if faults else f"{len(pages)} law pages fit, and the search finds each once")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
