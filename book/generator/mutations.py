"""Which laws of the book notice a small change of the line of the program that they test.

    python3 book/generator/mutations.py              each law is violated by the factor that book/mutations.toml lists for it
    python3 book/generator/mutations.py --measure    finds the smallest of the factors 1.001, 1.01 and 1.1 that violates each law

Builds a copy of the sources in which each line of `book/mutations.toml` has a factor, once. An environment variable chooses one line
and its factor; all other factors are 1, which changes no bit. Without a change, no law is violated: this is the control. Exit code 1
if a law is violated without a change, or does not notice a factor that is listed as noticed.
"""

import argparse
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import laws as law_book

REPOSITORY = Path(__file__).resolve().parents[2]
FOLDER = REPOSITORY / "target" / "mutated_laws"
FACTORS = (1.001, 1.01, 1.1)
# A change can keep a run from ending, s: by 10 % more energy in each collision, for example.
LONGEST_RUN = 1800
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
        metrics = law_book.run_experiment(law, programs, FOLDER / "laws" / change.replace(" ", "_"), limit_s=LONGEST_RUN)
        points, _ = law_book.points_of(law, metrics)
        law_book.compare(law, points, points)
    except law_book.LawError as error:
        return f"cannot be compared: {str(error).splitlines()[0][-80:]}"
    worst = max(point.deviation() for point in points)
    return None if worst <= 1 else f"{worst:.3g} tolerances"


def first_violation(law, programs, number, factors):
    """The first factor of a line that violates a law, and by how much; infinity if none does."""
    steps = ((factor, violation(law, programs, f"{number} {factor!r}")) for factor in factors)
    return next((step for step in steps if step[1]), (math.inf, "no change is noticed"))


def main():
    parser = argparse.ArgumentParser(prog="python3 book/generator/mutations.py", description="Laws of the book on changed programs.")
    parser.add_argument("--measure", action="store_true", help="find the smallest factor that violates each law")
    measure = parser.parse_args().measure
    mutations = law_book.read_mutations()
    laws = {law["id"]: law for law in law_book.read_laws(REPOSITORY / "book" / "laws")}
    programs = build(mutated_sources(mutations))
    shutil.rmtree(FOLDER / "laws", ignore_errors=True)
    code = 0
    for law in sorted({law for mutation in mutations for law in mutation["laws"]}):
        if found := violation(laws[law], programs, ""):
            code = 1
            print(f"error: {law} is violated without a change: {found}", file=sys.stderr)
    for number, mutation in enumerate(mutations):
        print(mutation["name"])
        for law, listed in mutation["laws"].items():
            factors = FACTORS if measure else [listed] if math.isfinite(listed) else []
            factor, found = first_violation(laws[law], programs, number, factors)
            print(f"  {law:36} listed {listed:<6} found {factor:<6} {found}", flush=True)
            if factor > listed:
                code = 1
                print(f"error: {law} does not notice {mutation['name']} times {listed}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
