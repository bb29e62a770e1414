"""Builds the engine of report pages with one constant of each model changed by one unit in the last place: a control of their verification.

Usage: python3 changed_engine.py     makes target/changed/target/browser/kinetoscope-engine.wasm.gz

Then, `python engine_verifies.py --changed` with this file and reports of the four models: each page must name the first frame that differs.
"""

import pathlib
import shutil
import subprocess

SOURCES = pathlib.Path(__file__).resolve().parents[2]
COPY = SOURCES / "target/changed"
# Boltzmann's constant of the gas, the Sun's mass for orbits, half of an impulse of hard discs, and half of the energy of a spring.
CHANGES = {
    "src/physics/constants.rs": [("= 1.380_658e-23;", "= 1.380_658e-23_f64.next_up();"), ("= 1.380_649e-23;", "= 1.380_649e-23_f64.next_up();"),
                                 ("= 2.959_122_082_322_128e-4;", "= 2.959_122_082_322_128e-4_f64.next_up();")],
    "src/physics/packing/motion.rs": [("impulse = 0.5 *", "impulse = 0.5_f64.next_up() *")],
    "src/physics/dem/laws/linear_spring.rs": [("0.5 * self.stiffness", "0.5_f64.next_up() * self.stiffness")],
}


def main():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=SOURCES, check=True, capture_output=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        text = (SOURCES / name).read_bytes()
        for old, new in CHANGES.get(name, []):
            if text.count(old.encode()) != 1:
                raise SystemExit(f"{name} does not contain {old!r} once")
            text = text.replace(old.encode(), new.encode())
        place = COPY / name
        place.parent.mkdir(parents=True, exist_ok=True)
        # What is unchanged since the last time is not compiled again.
        if not place.exists() or place.read_bytes() != text:
            place.write_bytes(text)
            shutil.copymode(SOURCES / name, place)
    subprocess.run(["src/browser/build.sh"], cwd=COPY, check=True)


if __name__ == "__main__":
    main()
