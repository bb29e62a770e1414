"""The source of the book as mdBook reads it: pages of `book/src` with included documents, executed commands and generated pages.

An `{{#include PATH}}` of a document of the repository is replaced by its text. Relative links of that text are changed to the
page that includes their target, or to a copy of the file. `{{#runs PATH}}` is what a manifest runs, without comments, questions, checks and plots.
"""

import os
import re
import shutil
from pathlib import Path

from play_link import with_play_links

INCLUDE = re.compile(r"\{\{#include ([^}]+)\}\}")
RUNS = re.compile(r"\{\{#runs ([^}]+)\}\}")
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)\s]+)\)")


CODE = re.compile(r"(^```.*?^```$|^ {4}[^\n]*$|`[^`\n]+`)", re.MULTILINE | re.DOTALL)
# Elements that generated pages contain; MathML has the names that begin with m.
ELEMENTS = ("math|mrow|mi|mo|mn|mtext|mspace|msub|msup|msubsup|mfrac|msqrt|mroot|mover|munder|munderover|mtable|mtr|mtd|mstyle|mpadded|"
            "div|figure|figcaption|img|table|thead|tbody|tr|th|td|code|p|span")
ANGLE = re.compile(rf"<(?!https?:|/?(?:{ELEMENTS})[ />]|a href|/a>)")


def escape_angles(text):
    """Markdown in which `<v>` outside of code is a mean and not an HTML tag."""
    parts = CODE.split(text)
    parts[::2] = [ANGLE.sub("&lt;", part) for part in parts[::2]]
    return "".join(parts)


def runs_of(manifest):
    """The lines of a manifest that determine its runs."""
    parts = re.split(r"^(?=\[)", manifest, flags=re.MULTILINE)
    parts = [part for part in parts if not re.match(r"\[\[?(checks|plots|view|baseline)\b", part)]
    text = re.sub(r"^(#.*|(question|answer|description) = .*)\n", "", "".join(parts), flags=re.MULTILINE)
    return text.strip()


class SourceError(Exception):
    """A page that cannot be assembled, with the reason."""


def included_documents(source):
    """Which page includes which document of the repository, by their paths."""
    pages = {}
    for page in sorted(source.rglob("*.md")):
        for target in INCLUDE.findall(page.read_text()):
            document = (page.parent / target).resolve()
            if not document.is_file():
                raise SourceError(f"{page}: {target} does not exist")
            pages[document] = page.relative_to(source)
    return pages


class Assembly:
    """The folder in which the book is put together."""

    def __init__(self, repository, source, target):
        self.repository, self.source, self.target = repository, source, target
        self.pages = included_documents(source)

    def assemble(self, execute):
        """Writes every page of `book/src`; `execute` replaces the commands of a page by their output. The exercises can be downloaded."""
        shutil.copytree(self.repository / "book/exercises", self.target / "exercises")
        for file in sorted(self.source.rglob("*")):
            place = self.target / file.relative_to(self.source)
            place.parent.mkdir(parents=True, exist_ok=True)
            if file.suffix != ".md":
                if file.is_file():
                    shutil.copyfile(file, place)
                continue
            text = with_play_links(file.read_text(), file)
            text = RUNS.sub(lambda found, file=file: runs_of((file.parent / found[1]).read_text()), text)
            text = INCLUDE.sub(lambda found, file=file: self.document(file, found[1]), text)
            place.write_text(execute(text, file.relative_to(self.source), place.parent))

    def document(self, page, target):
        """The text of an included document, with the links of its new place."""
        document = (page.parent / target).resolve()
        text = document.read_text()
        if document.suffix != ".md":
            return text.rstrip("\n")
        return LINK.sub(lambda found: self.link(page, document, found), text)

    def link(self, page, document, found):
        """A link of an included document, at the place of the page."""
        label, address = found[1], found[2]
        if "://" in address or address.startswith("#"):
            return found[0]
        path, _, anchor = address.partition("#")
        linked = (document.parent / path).resolve()
        anchor = f"#{anchor}" if anchor else ""
        here = page.relative_to(self.source).parent
        if linked in self.pages:
            return f"{label}({os.path.relpath(self.pages[linked], here)}{anchor})"
        if not linked.is_file():
            # A folder of the repository is not a part of the book.
            return label.removeprefix("!").strip("[]")
        copy = Path("files") / linked.relative_to(self.repository)
        place = self.target / copy
        if linked.suffix == ".md":
            copy, place = copy.with_suffix(".txt"), place.with_suffix(".txt")
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(linked, place)
        return f"{label}({os.path.relpath(copy, here)}{anchor})"
