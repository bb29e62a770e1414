"""Links that download a manifest or open it in the page that runs it; `book/src/use/analysis.md` describes the latter."""

import base64
import json
import re
import tomllib
import zlib

MOST_CHARACTERS = 8192
EXERCISE = re.compile(r"^```toml\n\{\{#include ((?:\.\./)+exercises/[^}]+)\}\}\n```$", re.MULTILINE)


def play_link(manifest, page="../play.html"):
    """The address of a manifest in the play page, or `None` if it would be too long. `page` is relative to the page with the link; the default is that of
    `book/src/*.md`, and a page in a folder of the book needs one `../` more."""
    packed = base64.urlsafe_b64encode(zlib.compress(manifest.encode(), 9)).rstrip(b"=").decode()
    link = f"{page}#manifest={packed}"
    return link if len(link) <= MOST_CHARACTERS else None


def with_play_links(text, file):
    """The text of a page with links after each manifest of an exercise, a lesson or a lab; `file` is a page in a folder of the book."""
    def linked(found):
        name = found[1].removeprefix("../../")
        download = f'<a href="../{name}" download>{name}</a>'
        return f'{found[0]}\n\n<p>Download {download}.<span class="play"> {links(file.parent / found[1])}</span></p>'
    return EXERCISE.sub(linked, text)


def links(path):
    """The links of a manifest. The page executes one run: that of an exercise is completed there, and a sweep becomes its first run, with a link per variant."""
    manifest = path.read_text()
    table = tomllib.loads(manifest)
    if "exercise" in table:
        runs = " The page executes one run at a time." if {"replicates", "sweep"} & table.keys() else ""
        return f'{anchor("Complete and run it in this browser", manifest)}; “Download the manifest” keeps your file.{runs}'
    sweep = table.pop("sweep", {})
    variants = sweep.pop("variants", [{"name": "Run it in this browser"}])
    swept = {key: values[0] for key, values in sweep.items()}
    runs = ", ".join(anchor(variant["name"], one_run(manifest, swept | variant)) for variant in variants)
    runs = runs if len(variants) == 1 else f"Run it in this browser: {runs}"
    others = [f"set <code>{key.split('.')[-1]}</code> to {listed(values)} in turn" for key, values in sweep.items()]
    if table.get("replicates", 1) > 1:
        others.append("for a replicate, change <code>seed</code> in its text")
    return "; ".join([runs, *others]) + "."


def anchor(words, manifest):
    return f'<a href="{play_link(manifest, "../../play.html")}">{words}</a>'


def listed(values):
    return " and ".join(filter(None, [", ".join(map(str, values[:-1])), str(values[-1])]))


def one_run(manifest, values):
    """A manifest without sweep and replicates, in which the keys of the model have these values."""
    head = re.sub(r"^replicates = .*\n", "", manifest.split("[sweep]")[0], flags=re.MULTILINE)
    lines = "".join(f"{key.split('.')[-1]} = {toml(value)}\n" for key, value in values.items() if key != "name")
    return re.sub(r"^\[model\.\w+\]\n", lambda found: found[0] + lines, head, flags=re.MULTILINE)


def toml(value):
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)
