"""Laws: an experiment, the metric that it measures, its exact value, a tolerance, and a control that must be rejected.

A law is one table `[[law]]` of `book/laws/MODEL.toml`:

    id, title, statement, source, setup             text of the page
    formula             the law in LaTeX
    derivation          two to five steps; `$...$` is LaTeX
    plot                arguments of `kinetoscope plot`, which draws the quantity from the law's recordings
    manifest            the experiment, without its name; the name is the id
    manifest_file       in place of `manifest`: a shipped experiment, by its path in the repository
    metric              the metric compared; or `measured`, an expression of metrics, m("name")
    where               coordinates of the points compared (default: all)
    exact               expression of the exact value (default: `theory`, that of the analysis)
    expected            expression of the expected |measured - exact| (default: `error`, the standard error)
    tolerance           expression of the largest |measured - exact| that is accepted
    tolerance_reason    where both come from, and which of them was chosen after the result was known
    constants           numbers that formulas need and no manifest contains
    [law.control]       text, and one or both of: set = {KEY = "VALUE"}, replace = {"OLD" = "NEW"} in the text of the manifest

Expressions are Python with the functions of `math`. They may use every key of the manifest by the last part of its name, and
`theory`, `accuracy` (of the theory), `error` (the standard error) and, in a tolerance and an expected deviation, `exact`; in a
tolerance also `expected`. A control is another run, of a changed system or another method, which is compared with the law of the
first run: the same metric, exact value and tolerance. Keys that a manifest sweeps cannot be set; `replace` changes their line.

Three conditions hold at every point of a law, and the build fails without them:

    |measured - exact| <= tolerance                    the law is not violated
    tolerance <= 10 expected                           a tolerance is not so wide that it contains every result
    |control measured - exact| >= 3 tolerance          the comparison rejects another system clearly, not by chance

A deviation is expected from a statistical error, or from a bound that follows from the time step, the number of steps or a
neglected term. It is never the deviation that was measured. A margin over it that was chosen with the result in view says so.
"""

import json
import math
import shlex
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

FUNCTIONS = {name: getattr(math, name) for name in dir(math) if not name.startswith("_")}
FUNCTIONS |= {"abs": abs, "max": max, "min": min, "sum": sum, "len": len}

# The largest ratio of a tolerance to the expected deviation, and the smallest one of a control's deviation to the tolerance.
WIDEST_TOLERANCE, SMALLEST_CONTROL = 10.0, 3.0
# The report of a law is a page of the book: 0.3 MB of replay keep some sixty of them together below 30 MB.
REPLAY = ["--replay-budget", "0.3"]


class LawError(Exception):
    """A law that cannot be evaluated, with the reason."""


@dataclass
class Point:
    """One comparison: a run, the mean of replicates at one point of a sweep, or a fit along a sweep."""

    label: str
    names: dict
    measured: float
    error: float | None
    run_keys: list[str]
    exact: float = math.nan
    expected: float = math.nan
    tolerance: float = math.nan

    def deviation(self):
        """The deviation from the exact value, in units of the tolerance."""
        return abs(self.measured - self.exact) / self.tolerance


@dataclass
class Result:
    """A law with its measurement, its control and the commands that repeat both."""

    law: dict
    unit: str
    points: list[Point]
    control_points: list[Point]
    commands: list[str]
    control_commands: list[str]

    def failures(self):
        """What is wrong with the law, as sentences."""
        found = [f"{point.label or 'the run'}: measured {point.measured!r}, exact {point.exact!r}, tolerance {point.tolerance!r}"
                 for point in self.points if not point.deviation() <= 1]
        found += [f"{point.label or 'the run'}: the tolerance {point.tolerance!r} is {point.tolerance / point.expected:.3g} times the "
                  f"expected deviation {point.expected!r}; at most {WIDEST_TOLERANCE:g} times it"
                  for point in self.points if not point.tolerance <= WIDEST_TOLERANCE * point.expected]
        found += [f"the control at {point.label or 'its run'} deviates by {point.deviation():.3g} tolerances: {point.measured!r}, compared "
                  f"with {point.exact!r} within {point.tolerance!r}; at least {SMALLEST_CONTROL:g} are required"
                  for point in self.control_points if not point.deviation() >= SMALLEST_CONTROL]
        return found


def read_laws(folder):
    """All laws of a folder, in the order of the files' names; ids are unique."""
    laws, faults = [], []
    for file in sorted(Path(folder).glob("*.toml")):
        with file.open("rb") as text:
            for law in tomllib.load(text)["law"]:
                laws.append(law | {"model": file.stem})
                if missing := {"formula", "derivation", "plot", "source", "tolerance_reason", "control"} - law.keys():
                    faults.append(f"{law['id']} has no {', '.join(sorted(missing))}")
                elif not 2 <= len(law["derivation"]) <= 5:
                    faults.append(f"{law['id']}: a derivation has two to five steps")
    if faults:
        raise LawError("\n".join(faults))
    names = [law["id"] for law in laws]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise LawError(f"ids are listed twice: {', '.join(sorted(twice))}")
    return laws


def read_mutations():
    """Lines of the models that `mutations.py` multiplies by a factor, with the factors that violate laws."""
    with (Path(__file__).parents[1] / "mutations.toml").open("rb") as text:
        return tomllib.load(text)["mutation"]


def evaluate(law, text, names):
    """The value of an expression."""
    try:
        return float(eval(text, {"__builtins__": {}}, FUNCTIONS | names))
    except Exception as error:
        raise LawError(f"{law['id']}: `{text}`: {error}") from error


def run_experiment(law, bin_folder, folder, control=None, limit_s=None, replay=False):
    """Runs and analyzes the experiment of a law or its control within a time, s, and returns its metrics."""
    part = "recordings" if control is None else "controls"
    manifest = Path(folder) / "manifests" / part / f"{law['id']}.toml"
    manifest.parent.mkdir(parents=True, exist_ok=True)
    manifest.write_text(manifest_text(law, control))
    output = Path(folder) / part
    program = str(Path(bin_folder) / "kinetoscope")
    for words in ([program, "run", "--quiet", "--prune", "--output", str(output), *settings(control), str(manifest)],
                  [program, "analyze", "--quiet", *(REPLAY if replay else ["--no-replay"]), str(output / law["id"])]):
        try:
            done = subprocess.run(words, capture_output=True, text=True, timeout=limit_s)
        except subprocess.TimeoutExpired as error:
            raise LawError(f"{law['id']}: did not end within {limit_s} s") from error
        # 3: a check of the experiment fails or a run ends in a fault; the comparison of the law decides.
        if done.returncode not in (0, 3):
            raise LawError(f"{law['id']}: {shlex.join(words)}: exit code {done.returncode}\n{done.stderr}")
    with (output / law["id"] / "metrics.json").open() as text:
        return json.load(text)


def settings(control):
    """The options that change the keys of a control."""
    return [word for key, value in (control or {}).get("set", {}).items() for word in ("--set", f"{key}={value}")]


def manifest_text(law, control=None):
    """The manifest: the question of the law, the name, and the text of its table or of the shipped experiment, with the changes of a control."""
    text = law.get("manifest")
    if text is None:
        shipped = (Path(__file__).parents[2] / law["manifest_file"]).read_text()
        head, table, rest = shipped.partition("[model.")
        text = "\n".join(line for line in head.splitlines() if line.startswith(("seed", "replicates"))) + "\n\n" + table + rest
    for old, new in (control or {}).get("replace", {}).items():
        if old not in text:
            raise LawError(f"{law['id']}: the manifest does not contain: {old}")
        text = text.replace(old, new)
    return f'# {law["title"]}: {law["statement"]}\nname = "{law["id"]}"\n{text.strip()}\n'


def commands(law, control=None):
    """The commands by which a reader repeats the runs."""
    options = "".join(f" {shlex.quote(word)}" for word in settings(control))
    return [f"kinetoscope run {law['id']}.toml{options}", f"kinetoscope analyze recordings/{law['id']}"]


def coordinates_match(coordinates, wanted):
    return all(name in coordinates and coordinates[name]["value"] == value for name, value in wanted.items())


def values_of(manifest):
    """The keys of a canonical manifest by the last part of their names, as numbers, words or lists."""
    return {key.rsplit(".", 1)[-1]: tomllib.loads(f"x = {value}")["x"] for key, value in manifest.items()
            if not value.startswith("sha256")}


def label_of(coordinates):
    parts = []
    for name, coordinate in coordinates.items():
        unit = "" if coordinate["unit"] in ("1", "") else f" {coordinate['unit']}"
        value = coordinate["value"]
        value = f"{value:.6g}" if isinstance(value, float) else value
        parts.append(str(value) if name == "variant" else f"{name} = {value}{unit}")
    return ", ".join(parts)


def points_of(law, metrics):
    """All points at which the metric of a law has a value, with its unit: fits, else means over replicates, else runs."""
    measured = law.get("measured")
    named = law.get("metric") or next(iter(measured.split('m("')[1:])).split('"')[0]
    entries = [entry for entry in metrics["metrics"] if entry["name"] == named and entry["applicable"]]
    fits = [entry for entry in entries if (entry.get("sweep") or {}).get("along")]
    means = [entry for entry in entries if entry.get("sweep") and not entry["sweep"]["along"]]
    entries = fits or means or [entry for entry in entries if entry.get("run")]
    points = []
    for entry in entries:
        place = (entry.get("sweep") or entry["run"])["coordinates"]
        if not coordinates_match(place, law.get("where", {})):
            continue
        same = {name: coordinate["value"] for name, coordinate in place.items()}
        runs = [run for run in metrics["runs"] if coordinates_match(run["coordinates"], same)
                and ("run" not in entry or entry["run"]["file"] == run["file"])]
        points.append(point_at(law, metrics, entry, place, runs, measured))
    if not points:
        raise LawError(f"{law['id']}: no run has a value of {named}")
    return points, entries[0]["unit"]


def point_at(law, metrics, entry, place, runs, measured):
    theory = entry.get("theory") or {}
    error = entry["conditional_standard_error"]
    error = entry["standard_error"] if error is None else error
    names = values_of(runs[0]["manifest"]) | law.get("constants", {})
    names |= {"theory": theory.get("value"), "accuracy": theory.get("accuracy") or 0.0, "error": error, "runs": len(runs)}
    key = "sweep" if entry.get("sweep") else "run"
    others = {other["name"]: other["value"] for other in metrics["metrics"] if other.get(key) == entry[key]}
    names["m"] = others.__getitem__
    value = evaluate(law, measured, names) if measured else entry["value"]
    return Point(label_of(place), names, value, error, [run["run_key"] for run in runs])


def compare(law, points, references):
    """Sets the exact value, the expected deviation and the tolerance of points, from the names of the reference."""
    for point, reference in zip(points, references, strict=True):
        names = reference.names
        point.exact = evaluate(law, law.get("exact", "theory"), names)
        if names["error"] is None and "expected" not in law:
            raise LawError(f"{law['id']}: the metric has no standard error; give `expected`, the deviation that numerical errors cause")
        point.expected = evaluate(law, law.get("expected", "error"), names | {"exact": point.exact})
        point.tolerance = evaluate(law, law["tolerance"], names | {"exact": point.exact, "expected": point.expected})
        if not (point.expected > 0 and point.tolerance > 0):
            raise LawError(f"{law['id']}: at {point.label or 'the run'}, the expected deviation is {point.expected!r} and the tolerance "
                           f"{point.tolerance!r}; both must be above 0")


def measure(law, bin_folder, folder, replay=False):
    """Runs a law and its control, if wanted with the replay of the law."""
    control = law["control"]
    if not control.keys() & {"set", "replace"} or control.keys() - {"text", "set", "replace"}:
        raise LawError(f"{law['id']}: a control changes the system or the method, by `set` or `replace`, and nothing else")
    points, unit = points_of(law, run_experiment(law, bin_folder, folder, replay=replay))
    compare(law, points, points)
    control_points, _ = points_of(law, run_experiment(law, bin_folder, folder, control))
    compare(law, control_points, points)
    return Result(law, unit, points, control_points, commands(law), commands(law, control))
