"""Checks every link of the book's HTML: files and anchors exist, and nothing is loaded from another host.

    python3 book/check_links.py target/book/html
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("source", "src")}


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


def main(folder):
    root = Path(folder).resolve()
    pages = {file: Page(file) for file in sorted(root.rglob("*.html"))}
    broken, checked = [], 0
    for file, page in pages.items():
        # 404.html is served for any address, and the print page repeats all pages with their own links.
        if file.name in ("404.html", "print.html", "toc.html"):
            continue
        for tag, name, address in page.links:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                if (tag, name) in LOADED and parts.scheme != "data":
                    broken.append(f"{file.relative_to(root)}: {address} is loaded from another host")
                continue
            checked += 1
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            anchor = unquote(parts.fragment)
            if not target.is_file():
                broken.append(f"{file.relative_to(root)}: {address} does not exist")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                broken.append(f"{file.relative_to(root)}: {address} has no such anchor")
    print("\n".join(broken) if broken else f"{checked} links of {len(pages)} pages are intact")
    return 1 if broken or not checked else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
