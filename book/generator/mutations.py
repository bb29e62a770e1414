"""Which laws of the book notice a small change of the line of the program that they test: `python3 book/generator/mutations.py`.

Builds a copy of the sources in which each line of `book/mutations.toml` has a factor, once. An environment variable chooses one line
and its factor; all other factors are 1, which changes no bit. Each law runs with the factors 1 + 1e-3, 1 + 1e-2 and 1 + 1e-1 until it is
violated. Without a change, no law is: this is the control, and exit code 1 otherwise.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import laws as law_book

REPOSITORY = Path(__file__).resolve().parents[2]
FOLDER = REPOSITORY / "target" / "mutated_laws"
SIZES = (1e-3, 1e-2, 1e-1)
# The factor of a line is 1 unless KINETOSCOPE_MUTATION is its number and another factor.
FACTOR = """
/// The factor of a mutated line.
pub fn mutation_factor(line: usize) -> f64 {
    static CHOSEN: std::sync::LazyLock<Option<(usize, f64)>> = std::sync::LazyLock::new(|| {
        let text = std::env::var("KINETOSCOPE_MUTATION").ok()?;
        let (line, factor) = text.split_once(' ')?;
        Some((line.parse().ok()?, factor.parse().ok()?))
    });
    CHOSEN.filter(|(chosen, _)| *chosen == line).map_or(1.0, |(_, factor)| factor)
}
"""


def mutated_sources(mutations):
    """Copies the sources with a factor in each mutated line, and returns their folder."""
    copy = FOLDER / "sources"
    shutil.rmtree(copy, ignore_errors=True)
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=REPOSITORY, check=True, capture_output=True, text=True).stdout
    for name in listed.split("\0")[:-1]:
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(REPOSITORY / name, copy / name)
    for number, mutation in enumerate(mutations):
        path = copy / mutation["file"]
        text = path.read_text()
        if text.count(mutation["old"]) != 1:
            raise SystemExit(f"error: {mutation['file']} contains {text.count(mutation['old'])} times: {mutation['old']}")
        path.write_text(text.replace(mutation["old"], mutation["new"].replace("FACTOR", f"crate::mutation_factor({number})")))
    root = copy / "src" / "physics" / "lib.rs"
    root.write_text(root.read_text() + FACTOR)
    return copy


def build(copy):
    """Builds the program of the copy in a target folder of its own, and returns the folder of its programs."""
    target = FOLDER / "target"
    subprocess.run(["cargo", "build", "--quiet", "--package", "kinetoscope-program", "--target-dir", target], cwd=copy, check=True)
    return target / "debug"


def violation(law, programs, change):
    """Whether a law is violated with a line and its factor: by how many tolerances, or that it cannot be compared."""
    os.environ["KINETOSCOPE_MUTATION"] = change
    try:
        # A finished run is not repeated, so that each change has a folder of its own.
        metrics = law_book.run_experiment(law, programs, FOLDER / "laws" / change.replace(" ", "_"))
        points, _ = law_book.points_of(law, metrics)
        law_book.compare(law, points, points)
    except law_book.LawError as error:
        return f"cannot be compared: {str(error).splitlines()[0][-80:]}"
    worst = max(point.deviation() for point in points)
    return None if worst <= 1 else f"{worst:.3g} tolerances"


def main():
    with (REPOSITORY / "book" / "mutations.toml").open("rb") as text:
        mutations = tomllib.load(text)["mutation"]
    laws = {law["id"]: law for law in law_book.read_laws(REPOSITORY / "book" / "laws")}
    programs = build(mutated_sources(mutations))
    shutil.rmtree(FOLDER / "laws", ignore_errors=True)
    code, noticed = 0, dict.fromkeys(SIZES, 0)
    for law in sorted({law for mutation in mutations for law in mutation["laws"]}):
        if found := violation(laws[law], programs, ""):
            code = 1
            print(f"error: {law} is violated without a change: {found}", file=sys.stderr)
    for number, mutation in enumerate(mutations):
        print(mutation["name"])
        for law in mutation["laws"]:
            steps = ((size, violation(laws[law], programs, f"{number} {1 + size!r}")) for size in SIZES)
            size, found = next((step for step in steps if step[1]), (None, "no change is noticed"))
            print(f"  {law:36} {f'1 + {size:g}' if size else '-':10} {found}", flush=True)
            if size:
                noticed[size] += 1
    pairs = sum(len(mutation["laws"]) for mutation in mutations)
    print(f"of {pairs} pairs of a line and a law, noticed at " + ", ".join(f"1 + {size:g}: {count}" for size, count in noticed.items()))
    return code


if __name__ == "__main__":
    sys.exit(main())
