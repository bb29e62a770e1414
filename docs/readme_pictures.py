"""Makes the pictures of the README, or compares them with new ones.

Usage: python3 docs/readme_pictures.py PROGRAMS OUTPUT              (writes the pictures)
       python3 docs/readme_pictures.py --compare PROGRAMS OUTPUT    (writes them, and compares them with those of docs)

PROGRAMS: the folder of run-experiment, analyze-recordings and kinetoscope. Needs Chromium and the package pillow.
The drum of the README is one of docs/replay, whose script is docs/replay/take_pictures.mjs.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageChops, ImageFilter

DOCS = Path(__file__).resolve().parent
# The report of the thousand discs while they fall.
FRAME = 14
SIZE = (1200, 800)
# The part of a page's pixels that may differ by more than DIFFERENCE of 255 after a blur of BLUR pixels: fonts and their smooth edges depend
# on the browser and the system. The replay of the next frame changes 0.028.
MOST_CHANGED = 0.02
DIFFERENCE = 40
BLUR = 3
SHOW_FRAME = """<script>
addEventListener("load", () => setTimeout(() => {
  const slider = document.querySelector("input[type=range]");
  slider.value = %d;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
}, 500));
</script>"""


def called(*words):
    """Calls a program, whose output is shown if it fails."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{words[0]} failed: {done.stdout}{done.stderr}")


def record(programs, name, folder):
    """The folder of a recorded experiment, without the facts of this machine."""
    called(programs / "run-experiment", "--quiet", "--output", folder, DOCS.parent / "experiments" / f"{name}.toml")
    for host in (folder / name).glob("*.host.json"):
        host.unlink()
    return folder / name


def first_run(programs, folder, picture):
    (recording,) = record(programs, "first_run", folder).glob("*.mcap")
    size = ["--thumbnail-frames", 126, "--thumbnail-width", 420]
    called(programs / "kinetoscope", "export", "--quiet", "--thumbnail", picture, *size, recording)


def dem_thousand_discs(programs, folder, picture):
    recorded = record(programs, "dem_thousand_discs", folder)
    called(programs / "analyze-recordings", "--quiet", recorded)
    page = recorded / "report.html"
    page.write_text(page.read_text().replace("</body>", SHOW_FRAME % FRAME + "</body>"))
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"]
    options += [f"--user-data-dir={folder}/browser", f"--window-size={SIZE[0]},{SIZE[1]}", f"--screenshot={picture}"]
    called("chromium", *options, page.as_uri())
    # Smaller without alpha. A palette would give two curves one color.
    Image.open(picture).convert("RGB").save(picture, optimize=True)


def changed_part(one, other):
    """The part of the pixels that differ visibly."""
    one, other = (Image.open(path).convert("RGB").filter(ImageFilter.BoxBlur(BLUR)) for path in (one, other))
    if one.size != other.size:
        return 1.0
    largest = ImageChops.difference(one, other).convert("L").histogram()
    return sum(largest[DIFFERENCE:]) / sum(largest)


def main():
    words = sys.argv[1:]
    compares = words[:1] == ["--compare"]
    programs, output = (Path(word).resolve() for word in words[compares:])
    output.mkdir(parents=True, exist_ok=True)
    failed = False
    for make in (first_run, dem_thousand_discs):
        picture = output / f"{make.__name__}.png"
        with tempfile.TemporaryDirectory() as folder:
            make(programs, Path(folder), picture)
        if compares:
            part = changed_part(picture, DOCS / picture.name)
            print(f"{picture.name}: {100 * part:.2f} % of the pixels differ from those of docs")
            failed |= part > MOST_CHANGED
    if failed:
        sys.exit(f"more than {100 * MOST_CHANGED:.0f} %: make the pictures again with docs/readme_pictures.py, and look at them")


main()
