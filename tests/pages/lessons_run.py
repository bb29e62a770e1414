"""Do the lessons and labs of the book run in a browser alone, from files?

Usage: python tests/pages/lessons_run.py target/book/html    (package: websockets; program: chromium; a book built with the engine)

Every link to the play page is followed, and its run must complete with a table of numbers. Each lesson has a link for its run and one for each of its three exercises. Control: a
link with a manifest that is rejected must be found. Exit code 1 for a fault.
"""

import sys
import tempfile
from pathlib import Path

from chromium import Browser

sys.path.append(str(Path(__file__).resolve().parents[2] / "book/generator"))
from play_link import play_link
from site_is_whole import RUN

LINKS = "[...document.querySelectorAll('span.play a')].map((link) => [link.textContent, link.href])"
LEAST_LINKS = {"lessons": 4, "labs": 1}


def fault_of(browser, address):
    """What is wrong with the run of a link, if anything."""
    browser.open("about:blank")
    browser.open(address)
    ending = browser.value(RUN)
    rows = browser.value("document.querySelectorAll('.rerun tbody tr').length")
    return None if "complete" in ending and rows else ending or "nothing happens"


def main(book):
    faults, followed = [], 0
    with tempfile.TemporaryDirectory() as folder, Browser(folder) as browser:
        for kind, least in LEAST_LINKS.items():
            for page in sorted((book / kind).glob("*.html")):
                browser.open(page.resolve().as_uri())
                links = browser.value(LINKS)
                if len(links) < least and not page.stem.endswith("_teacher"):
                    faults.append(f"{page.name}: {len(links)} links to the play page; at least {least}")
                for words, address in links:
                    followed += 1
                    if fault := fault_of(browser, address):
                        faults.append(f"{page.name}, {words}: {fault}")
        if fault_of(browser, play_link("[model.gas]\nparticles = -1\n", (book.resolve().parent / "play.html").as_uri())) is None:
            sys.exit("the control is not found: a manifest that is rejected")
    print("\n".join(faults) if faults else f"{followed} links of lessons and labs run in the browser")
    return 1 if faults or not followed else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
