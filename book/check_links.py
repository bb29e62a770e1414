"""Checks every link of the book: files and anchors exist, and HTML loads nothing from another host.

    python3 book/check_links.py target/book/html               # the HTML
    python3 book/check_links.py target/book/src README.md      # Markdown: a folder without HTML, and single documents
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("source", "src")}
# 404.html is served for any address, and the print page repeats all pages with their own links.
REPEATED = ("404.html", "print.html", "toc.html")
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"^ {4}[^\n]*$|`[^`\n]+`", re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.+?) *$", re.MULTILINE)


class Page(HTMLParser):
    """The anchors of a page and the addresses that it names."""

    def __init__(self, file):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(file.read_text())

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append((tag, name, value))


class MarkdownPage:
    """The same of a page from which mdBook makes HTML, or of a document of the repository."""

    def __init__(self, file):
        text = FENCED.sub("", file.read_text())
        self.anchors = set()
        for heading in HEADING.findall(text):
            words = re.sub(r"\]\([^)]*\)", "", heading).lower()
            anchor = re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", words))
            repeated = sum(1 for known in self.anchors if re.fullmatch(rf"{re.escape(anchor)}(-\d+)?", known))
            self.anchors.add(f"{anchor}-{repeated}" if repeated else anchor)
        self.links = [("a", "href", address) for address in LINK.findall(CODE.sub("", text))]


def read_pages(place):
    """The pages of a folder, or one document."""
    if place.is_file():
        return {place: MarkdownPage(place)}
    # rustdoc checks the links of the libraries' documentation.
    if html := sorted(page for page in place.rglob("*.html") if "api" not in page.relative_to(place).parts):
        return {file: Page(file) for file in html}
    return {file: MarkdownPage(file) for file in sorted(place.rglob("*.md"))}


def fault_of(file, link, pages):
    """What is wrong with a link, if anything, and whether it is a link between files."""
    tag, name, address = link
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        is_loaded = (tag, name) in LOADED and parts.scheme != "data"
        return f"{address} is loaded from another host" if is_loaded else None, False
    target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    anchor = unquote(parts.fragment)
    # The play page is next to the built book, and what follows is the manifest that it runs.
    if anchor.startswith("manifest="):
        return None if file.suffix == ".md" or target.is_file() else f"{address} does not exist", True
    # On a web server, a folder is not a page; in a repository, it is.
    if not (target.is_file() or file.suffix == ".md" and target.is_dir()):
        return f"{address} does not exist", True
    if anchor and target in pages and anchor not in pages[target].anchors:
        return f"{address} has no such anchor", True
    return None, True


def main(places):
    pages = {}
    for place in places:
        pages |= read_pages(Path(place).resolve())
    broken, checked = [], 0
    for file, page in pages.items():
        if file.name in REPEATED:
            continue
        for link in page.links:
            fault, is_between_files = fault_of(file, link, pages)
            checked += is_between_files
            if fault:
                broken.append(f"{file}: {fault}")
    print("\n".join(broken) if broken else f"{checked} links of {len(pages)} pages are intact")
    return 1 if broken or not checked else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
