"""Checks that pages of the book can be read in steps: no paragraph of more than 120 words, and no page of more than 2500.

    python3 book/check_words.py target/book/src

A word is one of prose: in paragraphs, list items and headings. Code, tables and formulas are not counted. Not checked are the changelog and the generated references of metrics
and manifests, which nobody reads from start to end.
"""

import re
import sys
from pathlib import Path

MOST_IN_PARAGRAPH, MOST_ON_PAGE = 120, 2500
EXCEPTIONS = {"project/changes.md", "reference/metrics.md", "reference/manifest.md", "SUMMARY.md"}
LEFT_OUT = re.compile(r"^```.*?^```$|<math.*?</math>|<table.*?</table>|<!--.*?-->", re.MULTILINE | re.DOTALL)
TAG = re.compile(r"<[^>]+>")
ITEM = re.compile(r"^\s*(?:[-*]|\d+\.)\s")


def paragraphs(text):
    """The paragraphs, list items and headings of a page as lists of words."""
    found, open_one = [], False
    for line in LEFT_OUT.sub("", text).splitlines():
        # A line of a table, of code, or an empty one ends a paragraph.
        is_code = line.startswith("    ") and not open_one
        if not line.strip() or line.lstrip().startswith("|") or is_code:
            open_one = False
            continue
        if not open_one or ITEM.match(line) or line.startswith("#"):
            found.append([])
        open_one = not line.startswith("#")
        found[-1] += TAG.sub(" ", line).split()
    return found


def faults_of(name, text):
    """What is too long on a page, as sentences."""
    parts = paragraphs(text)
    faults = [f"{name}: a paragraph of {len(words)} words: {' '.join(words[:8])} …" for words in parts if len(words) > MOST_IN_PARAGRAPH]
    if (total := sum(map(len, parts))) > MOST_ON_PAGE:
        faults.append(f"{name}: {total} words; at most {MOST_ON_PAGE}")
    return faults


def main(folder):
    # Control: a paragraph and a page that are too long must be found.
    if len(faults_of("control", "word " * (MOST_IN_PARAGRAPH + 1))) != 1 or len(faults_of("control", "- word\n" * (MOST_ON_PAGE + 1))) != 1:
        sys.exit("the control is not found")
    pages = {str(file.relative_to(folder)): file for file in sorted(folder.rglob("*.md"))}
    faults = [fault for name, file in pages.items() if name not in EXCEPTIONS for fault in faults_of(name, file.read_text())]
    print("\n".join(faults) if faults else f"{len(pages)} pages, none with a paragraph of more than {MOST_IN_PARAGRAPH} words")
    return 1 if faults or not pages else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
