"""Puts one site together that any static host can serve and that works from files: front page, gallery with all reports, play page, book and documentation
of the libraries. Usage: python3 book/generator/site.py --help
"""

import argparse
import re
import shutil
import subprocess
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
# What the front page runs: it moves for some seconds.
FRONT = "dem_rotating_drum"
ENGINE = "kinetoscope-engine.js"
PLAY = re.compile(r'<span class="play">.*?</span>')
HEADER = """<header><h1>Kinetoscope</h1><p class="question">Reproducible particle simulations: the same manifest gives the same bytes on any machine.</p>
<p>This page runs one, a rotating drum. Every report answers a question, and its reader can verify it in the browser.</p>
<pre>pip install kinetoscope &amp;&amp; kinetoscope demo</pre><p>{links}</p></header>"""
LINKS = (("index.html", "Kinetoscope"), ("gallery.html", "Gallery"), ("play.html", "Play page"), ("book/index.html", "Book"), ("api/kinetoscope/index.html", "Rust documentation"))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=Path, default=REPOSITORY / "target/release", help="folder of the programs, built with the engine")
    parser.add_argument("--recordings", type=Path, default=REPOSITORY / "target/book/recordings", help="recordings of the experiments; what is missing is run")
    parser.add_argument("--site", dest="output", type=Path, default=REPOSITORY / "target/site", help="folder of the site [default: target/site]")
    parser.add_argument("--without-api", action="store_true", help="leave out the documentation of the libraries")
    return parser.parse_known_args()[0]


def analyzed(options):
    """The gallery and its reports, with one engine for all of them."""
    for manifest in sorted((REPOSITORY / "experiments").glob("*.toml")):
        if not (options.recordings / manifest.stem).is_dir():
            subprocess.run([options.bin / "run-experiment", "--quiet", "--output", options.recordings, manifest], check=True)
    folders = [folder for folder in sorted(options.recordings.iterdir()) if folder.is_dir()]
    subprocess.run([options.bin / "analyze-recordings", "--quiet", "--output", options.output, *folders], check=True)
    (options.output / "index.html").rename(options.output / "gallery.html")
    for report in options.output.glob("*/report.html"):
        for name in (ENGINE, "play.html"):
            (report.parent / name).unlink(missing_ok=True)
        text = report.read_text().replace(f'src="{ENGINE}"', f'src="../{ENGINE}"', 1)
        report.write_text(text.replace('data-page="play.html"', 'data-page="../play.html"', 1))


def finish_play_links(options, book):
    """Puts the play page next to the book, whose lessons have links to it; without an engine, there is none, and the links are removed."""
    if (options.output / "play.html").exists():
        for name in ("play.html", ENGINE):
            shutil.copyfile(options.output / name, book.parent / name)
        return
    for page in book.rglob("*.html"):
        text = page.read_text()
        if (found := PLAY.sub("", text)) != text:
            page.write_text(found)


def front_page(options):
    """The play page with another head and a manifest that starts; without an engine, the head alone. The gallery and the play page get links to the others."""
    gallery, play = options.output / "gallery.html", options.output / "play.html"

    def links(own):
        return " · ".join(f'<a href="{page}">{name}</a>' for page, name in LINKS if page != own and (options.output / page).exists())

    header = HEADER.format(links=links("index.html"))
    if play.exists():
        # The first of its runs.
        link = re.search(rf'href="play\.html(#manifest=[^"]*)"(?:(?!href=).)*href="\./{FRONT}/report\.html"', gallery.read_text(), re.DOTALL)[1]
        text = play.read_text().replace("data-play", f'data-play data-auto="{link}"', 1)
        text = re.sub(r"<header>.*?</header>", lambda _: header, text, count=1, flags=re.DOTALL)
    else:
        text = re.sub(r"<main.*</main>", lambda _: f"<main>{header}</main>", gallery.read_text(), count=1, flags=re.DOTALL)
    (options.output / "index.html").write_text(re.sub("<title>.*?</title>", "<title>Kinetoscope</title>", text, count=1))
    for page in filter(Path.exists, (gallery, play)):
        page.write_text(page.read_text().replace("</header>", f"<p>{links(page.name)}</p></header>", 1))


def main():
    options = arguments()
    shutil.rmtree(options.output, ignore_errors=True)
    options.output.mkdir(parents=True)
    analyzed(options)
    book = REPOSITORY / "target/book/html"
    finish_play_links(options, book)
    shutil.copytree(book, options.output / "book")
    if not options.without_api:
        subprocess.run(["cargo", "doc", "--workspace", "--no-deps", "--quiet"], check=True, cwd=REPOSITORY)
        shutil.copytree(REPOSITORY / "target/doc", options.output / "api")
    front_page(options)


if __name__ == "__main__":
    main()
