"""A table of the reports of a folder: question, answer, title of the first plot next to the replay, and the frame that is shown first.

Usage: python tests/pages/table_of_answers.py RECORDINGS    (package: websockets; program: chromium)

Prints Markdown. Exit code 1 if a report has no answer or no plot. Control: a copy of the first report without either must be found.
"""

import sys
import tempfile
from pathlib import Path

from chromium import Browser

ROW = """(async () => {
  await window.replay?.ready;
  for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame);
  const text = (selector) => document.querySelector(selector)?.textContent.trim().replaceAll("\\u00a0", " ") ?? "";
  return [text(".question"), text(".result"), text(".adjacent figcaption"), text(".clock").split(" · each")[0]];
})()"""


def row(browser, report):
    browser.open(report.resolve().as_uri(), (1280, 800))
    return browser.value(ROW)


def require_control(browser, report, folder):
    """A page without an answer and without a plot must be found."""
    without = Path(folder) / "control.html"
    without.write_text(report.read_text().replace('class="result"', "").replace('class="adjacent"', ""))
    if row(browser, without)[1:3] != ["", ""]:
        sys.exit("the control is not found")


def main(recordings):
    reports = sorted(recordings.glob("*/report.html"))
    if not reports:
        sys.exit(f"{recordings} has no reports: analyze the folder")
    missing = []
    print("| experiment | question | answer | plot of the question | opening frame |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, Browser(folder) as browser:
        require_control(browser, reports[0], folder)
        for report in reports:
            cells = row(browser, report)
            print("|", " | ".join(cell.replace("|", "\\|") for cell in [f"`{report.parent.name}`", *cells]), "|")
            missing += [report.parent.name] if "" in cells[1:3] else []
    if missing:
        sys.exit(f"without an answer or a plot: {', '.join(missing)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
