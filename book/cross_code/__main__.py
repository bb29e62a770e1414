"""Writes the pages that compare Kinetoscope with other programs: `python3 book/cross_code --bin FOLDER --output FOLDER`.

Each comparison has a tolerance and a control, the same comparison with a changed constant in the other program, which must exceed
it. A program that cannot be loaded is skipped by name. The summary of the pages goes to `pages.json`.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "generator")]

from pages import number

EXPERIMENTS = HERE.parents[1] / "experiments"


def table(heads, rows):
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    return "\n".join(lines + [f"| {' | '.join(cells)} |" for cells in rows])


def page(title, text, heads, rows, control, tolerance, key):
    """A page with both tables: the comparison and its control."""
    return f"""# {title}

{text}

{table(heads, rows)}

**Tolerance:** {tolerance}

**Run key:** `{key}`

## The control that fails

{control[0]}

{table(heads, control[1])}
"""


def discs(kinetoscope, folder, model):
    """Hard discs against the plain event-driven program."""
    from event_driven import compare

    radius, duration, unit = (1.0, 14.0, "") if model == "packing" else (0.1, 3.5, " m")
    rows, key, manifest = compare(kinetoscope, folder, model, 20, duration)
    control, _, _ = compare(kinetoscope, folder, model, 20, duration, 1 + 1e-6)
    tolerance = 1e-3 * radius

    def agree(rows):
        return all(ours == theirs and distance <= tolerance for _, ours, theirs, distance in rows)

    def cells(rows):
        return [[number(time), str(ours[0]), str(theirs[0]), str(ours[1]), str(theirs[1]), number(distance, 2)]
                for time, ours, theirs, distance in rows]

    heads = ["time", "pair collisions", "in the plain program", "wall collisions", "in the plain program", f"largest distance{unit}"]
    shape = "a square with walls" if model == "packing" else "a circle"
    title = f"{model.capitalize()} and a plain event-driven program"
    text = f"""Twenty hard discs in {shape}, from the same start, in Kinetoscope and in `book/cross_code/event_driven.py`. That program moves all discs to each event
and finds the next event among all pairs by the textbook's quadratic formula; it shares no code and no algorithm with Kinetoscope.

```toml
{manifest.strip()}
```

Rounding errors grow by a factor of a few per collision of a disc, in any program, so the distance grows exponentially with time."""
    body = page(title, text, heads, cells(rows), ("The discs of the plain program are larger by a millionth:", cells(control)),
                "equal numbers of collisions in every frame, and no disc farther away than a thousandth of its radius.", key)
    return title, body, agree(rows), agree(control), f"{sum(rows[-1][1])} collisions in the same order"


def lammps_page(kinetoscope, folder):
    """DEM against LAMMPS."""
    from lammps_discs import MANIFEST, RADIUS, compare

    rows, key, version = compare(kinetoscope, folder)
    control, _, _ = compare(kinetoscope, folder, 1 + 1e-6)
    tolerance = 1e-6 * RADIUS
    heads = ["time, s", "kinetic energy, J", "in LAMMPS, J", "largest distance, m"]

    def cells(rows):
        return [[number(time), number(ours, 12), number(theirs, 12), number(distance, 2)] for time, ours, theirs, distance in rows]

    title = "DEM and LAMMPS"
    text = f"""Twenty discs in a box with gravity, from the same start, in Kinetoscope and in LAMMPS {version} (`pair_style gran/hooke`, `fix wall/gran`,
`fix nve/sphere disc`), step by step.

```toml
{MANIFEST.strip()}
```"""
    body = page(title, text, heads, cells(rows), ("The damping in LAMMPS is larger by a millionth:", cells(control)),
                "no disc is farther away than a millionth of its radius at any frame.", key)
    worst = max(row[-1] for row in rows)
    return title, body, worst <= tolerance, max(row[-1] for row in control) <= tolerance, f"discs within {number(worst, 2)} m"


def lever_arm_page(title, describe, compare, manifest, moduli, control_name, kinetoscope, folder):
    """Discs with friction against LAMMPS, of a modulus and of one with overlaps that are a hundred times larger. `describe` takes the program's
    version, the manifest and the ratio of the distances, and returns the text."""
    from lammps_discs import RADIUS

    rows, key, version = compare(kinetoscope, folder, moduli[0])
    control, _, _ = compare(kinetoscope, folder, moduli[0], 1 + 1e-3)
    soft, _, _ = compare(kinetoscope, folder, moduli[1])
    tolerance, ratio = 1e-4 * RADIUS, soft[-1][-1] / rows[-1][-1]
    heads = ["time, s", "kinetic energy, J", "in LAMMPS, J", "largest distance, m"]

    def cells(rows):
        return [[number(time), number(ours, 9), number(theirs, 9), number(distance, 2)] for time, ours, theirs, distance in rows]

    def worst(rows):
        return max(row[-1] for row in rows)

    body = page(title, describe(version, manifest.strip(), number(ratio, 3)), heads, cells(rows), (f"{control_name} in LAMMPS is larger by a thousandth:", cells(control)),
                "no disc is farther away than 1e-4 of its radius at any frame, and the ratio of distances is from 80 to 125.", key)
    return title, body, worst(rows) <= tolerance and 80 <= ratio <= 125, worst(control) <= tolerance, f"discs within {number(worst(rows), 2)} m"


def lammps_friction_page(kinetoscope, folder):
    """DEM with friction against LAMMPS."""
    from lammps_discs import STIFFEST, compare_friction, friction_manifest

    def describe(version, manifest, ratio):
        return f"""Twenty discs with friction and tangential springs, from the same start, in Kinetoscope and in LAMMPS {version} (`pair_style granular` with
`tangential linear_history` and `limit_damping`, `fix wall/gran`, `fix nve/sphere disc`), step by step. Kinetic energies include the rotation.

```toml
{manifest}
```

Both programs turn a tangential spring with its contact and cut its force to μ f. With a tangential dashpot, the stretch of a sliding spring would differ: LAMMPS subtracts the
dashpot's force, Kinetoscope does not. The lever arms differ: LAMMPS takes the radius for the speed of a surface, and at walls for the torque as well; Kinetoscope takes the
distance from the center to the contact point, so that the work on the spins is that of the force. The difference is proportional to the overlap. Therefore, a
stiffness and a time step for which overlaps are a hundred times larger, {number(1e-4 * STIFFEST)} N/m and 1e-6 s, must increase the distance as much: by {ratio}. Later contacts begin
in other steps in the two programs, and the error of the time step is then larger than the difference of the laws."""

    return lever_arm_page("DEM with friction and LAMMPS", describe, compare_friction, friction_manifest(STIFFEST, 1e-8), [STIFFEST, 1e-4 * STIFFEST],
                          "The tangential stiffness", kinetoscope, folder)


def lammps_mindlin_page(kinetoscope, folder):
    """DEM with Mindlin's tangential springs against LAMMPS."""
    from lammps_discs import HARDEST, SOFTER, compare_mindlin, mindlin_manifest

    def describe(version, manifest, ratio):
        return f"""Twenty elastic spheres in a plane with Hertz's and Mindlin's laws, from the same start, in Kinetoscope and in LAMMPS {version} (`pair_style granular`
with `hertz/material` and `tangential mindlin_rescale/force`, `fix wall/gran`, `fix nve/sphere disc`), step by step. Kinetic energies include the rotation.

```toml
{manifest}
```

In both programs, the force of a tangential spring stays while the circle of contact grows, and decreases in proportion to it while it shrinks. The lever arms differ, as
with springs of a constant stiffness: LAMMPS takes the radius, Kinetoscope the distance from the center to the contact point. The difference is proportional to the
overlap, and by Hertz's law the overlap is proportional to the modulus to the power of −2/5. Therefore, spheres of {number(SOFTER)} Pa must increase the distance by a factor of
100: it increases by {ratio}."""

    return lever_arm_page("Mindlin's springs and LAMMPS", describe, compare_mindlin, mindlin_manifest(HARDEST, 5e-9), [HARDEST, SOFTER],
                          "The tangential stiffness 8 G*", kinetoscope, folder)


def rebound_page(kinetoscope, folder):
    """Orbits against REBOUND."""
    from rebound_orbits import compare

    manifest = EXPERIMENTS / "orbit_outer_planets.toml"
    rows, key, version = compare(kinetoscope, folder, manifest)
    control, _, _ = compare(kinetoscope, folder, manifest, 1 + 1e-6)
    heads, tolerance = ["time, d", "largest distance of a body, AU"], 1e-9

    def cells(rows):
        return [[number(time), number(distance, 2)] for time, distance in rows]

    title = "Orbits and REBOUND"
    text = f"""The Sun and the five outer planets of `experiments/orbit_outer_planets.toml` for a century: the method of order 8 in Kinetoscope (`dop853`), IAS15 in
REBOUND {version}, from the same start."""
    body = page(title, text, heads, cells(rows), ("The mass of Jupiter in REBOUND is larger by a millionth:", cells(control)),
                "1e-9 AU, 150 m: both methods keep about 1e-15 per step.", key)
    worst = max(row[-1] for row in rows)
    return title, body, worst <= tolerance, max(row[-1] for row in control) <= tolerance, f"bodies within {number(worst, 2)} AU"


def main():
    parser = argparse.ArgumentParser(prog="python3 book/cross_code")
    parser.add_argument("--bin", type=Path, required=True, help="folder of the programs")
    parser.add_argument("--output", type=Path, required=True, help="folder of the pages")
    options = parser.parse_args()
    comparisons = {"dem": ("LAMMPS", lammps_page), "dem_friction": ("LAMMPS", lammps_friction_page),
                   "dem_mindlin": ("LAMMPS", lammps_mindlin_page),
                   "orbit": ("REBOUND", rebound_page),
                   "packing": ("the plain program", lambda *places: discs(*places, "packing")),
                   "gas": ("the plain program", lambda *places: discs(*places, "gas"))}
    pages, lines, wrong = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for model, (program, comparison) in comparisons.items():
            try:
                title, body, agrees, control_agrees, result = comparison(options.bin / "kinetoscope", Path(folder))
            except (ImportError, OSError) as error:
                print(f"skipped: {program}: {error}")
                lines.append([model, program, "skipped, because it cannot be loaded here"])
                continue
            if not agrees:
                wrong.append(f"{title}: the programs differ")
            if control_agrees:
                wrong.append(f"{title}: the control passes")
            (options.output / f"{model}.md").write_text(body)
            pages.append([f"{model}.md", title])
            lines.append([model, f"[{program}]({model}.md)", result])
    text = f"""# Comparison with other programs

The same start in two programs, compared frame by frame. Each page has a control: the same comparison with a constant changed by a millionth in
the other program (the tangential stiffness by a thousandth), which is detected.

{table(["model", "program", "result"], lines)}
"""
    (options.output / "index.md").write_text(text)
    (options.output / "pages.json").write_text(json.dumps(pages))
    print("\n".join(f"error: {line}" for line in wrong) or f"{len(pages)} comparisons with other programs agree")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
