"""Where the report draws hard discs between its frames if their collisions are recorded, against runs that are recorded ten times as densely.

Usage: python tests/pages/flights_are_true.py PROGRAMS    (package: websockets; program: chromium)

PROGRAMS: the folder of run-experiment and kinetoscope. Experiments of hard discs, shortened and with 20 frames, are recorded with the channel `events`. Prints the largest
distance of a drawn disc from its place in the denser run, in percent of the picture's width, and how far discs are drawn inside each other. Exit code 1 above MOST_PERCENT.
Control: the same page without its flights draws discs farther away.
"""

import json
import math
import sys
import tempfile
from itertools import combinations
from pathlib import Path

from chromium import Browser
from paths_are_true import DENSER, FRAMES, INSTANTS, called, record, truth

COUNT = 20
# Half a stored step and the rounding of times are a few thousandths of a percent.
MOST_PERCENT = 0.02
# The diameter of the discs, and what is shortened.
SETTINGS = {
    "packing_fifty_discs": (2.0, ["model.packing.events_per_disc=40"]),
    "packing_gravity": (1.0, ["model.packing.discs=200", "model.packing.duration=60.0"]),
    "gas_relaxation": (0.008, ["model.gas.particles=300", "model.gas.duration_s=2e-3"]),
}
# Channels that the plots of an experiment need.
PLOTTED = {"gas_relaxation": ["energy_balance", "speeds"]}


def settings(name, channels):
    return [word for change in [*SETTINGS[name][1], f"record.channels={json.dumps([*channels, *PLOTTED.get(name, [])])}"] for word in ("--set", change)]


def inside(places, diameter):
    """How far two discs are inside each other at most."""
    return max(0.0, max(diameter - math.dist(one[1:], other[1:]) for one, other in combinations(places, 2)))


def seen(browser, page, name, instants_of):
    """The largest distance from the truth, and how far discs are drawn inside each other, in percent of the width."""
    browser.open(page.resolve().as_uri(), (1280, 800))
    frames = browser.value(FRAMES % 0)
    instants = instants_of(frames["file"])
    shown = browser.value(INSTANTS % json.dumps(list(instants)))
    far = max(math.dist(places[number], place) for places, drawn in zip(instants.values(), shown) for number, *place in drawn)
    deep = max(inside(drawn, SETTINGS[name][0]) for drawn in shown)
    if browser.errors or len(shown) != len(instants) or not all(map(len, shown)):
        sys.exit(f"{name}: {browser.errors or 'no discs are drawn'}")
    return 100 * far / frames["width"], 100 * deep / frames["width"]


def main(programs):
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder, Browser(folder) as browser:
        for name in SETTINGS:
            recorded, dense = Path(folder) / "recorded", Path(folder) / "dense"
            record(programs, name, COUNT, recorded, *settings(name, ["state", "events"]))
            # Checks of the whole experiment need channels that are not recorded here.
            called(programs / "kinetoscope", "analyze", recorded / name)
            page = recorded / name / "report.html"
            instants = lambda file: truth(programs, name, DENSER * COUNT, file, dense, *settings(name, ["state"]))
            far, deep = seen(browser, page, name, instants)
            control = page.with_name("control.html")
            control.write_text(page.read_text().replace("&quot;flights&quot;:", "&quot;none&quot;:"))
            farther, deeper = seen(browser, control, name, instants)
            print(f"{name}: {far:.4f} % of the width from the truth, {deep:.4f} % inside each other; without flights {farther:.2f} % and {deeper:.2f} %", flush=True)
            worst = max(worst, far, deep)
            if farther <= MOST_PERCENT:
                sys.exit(f"{name}: the control is not found")
    if worst > MOST_PERCENT:
        sys.exit(f"more than {MOST_PERCENT} %")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
