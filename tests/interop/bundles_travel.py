#!/usr/bin/env python3
"""Does a bundle that a wheel wrote reproduce in another folder and as another user? Outside of the sources, with the program of the wheel.

    tests/interop/bundles_travel.py WHEEL [FOLDER]    # the bundles are kept in FOLDER

One experiment of each model is bundled twice: both files must be equal, at most 2 MB long, and name the wheel's hash and its packages. As
root, `reproduce` also runs as the user 65534, who can write to one folder only.

Exit code 1 if something is not as expected.
"""

import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXPERIMENTS = ("first_run", "gas_300_kelvin", "packing_fifty_discs", "orbit_exercise")
BY = ("--author", "A. Author <https://orcid.org/0000-0002-1825-0097>", "--affiliation", "The Institute <https://institute.example>")
MOST_BYTES = 2_000_000


def call(command, folder, **options):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, **options)
    if done.returncode:
        sys.exit(f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def bundles(program, wheel, folder):
    hash_of_wheel = hashlib.sha256(wheel.read_bytes()).hexdigest()
    for name in EXPERIMENTS:
        shutil.copy(ROOT / f"experiments/{name}.toml", folder)
        files = [folder / f"{name}.zip", folder / f"{name}-again.zip"]
        for file in files:
            call([program, "bundle", f"{name}.toml", *BY, "--license", "CC-BY-4.0", "--wheel", wheel, "--file", file], folder)
        one, other = (file.read_bytes() for file in files)
        assert one == other, f"two bundles of {name} differ"
        assert len(one) <= MOST_BYTES, f"{files[0]} has {len(one)} bytes"
        with zipfile.ZipFile(files[0]) as bundle:
            about = json.loads(bundle.read("bundle.json"))
            packages = json.loads(bundle.read("kinetoscope.cdx.json"))
        assert about["program"]["wheel"]["sha256"] == hash_of_wheel
        assert packages["bomFormat"] == "CycloneDX" and packages["components"]
        yield files[0]


def main():
    wheel = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as name:
        temporary = pathlib.Path(name)
        os.chmod(temporary, 0o755)
        environment = {**os.environ, "WHEEL": str(wheel), "TMPDIR": name}
        programs = call(["sh", ROOT / "action/install.sh"], temporary, env=environment).strip()
        # The environment's folder is private.
        os.chmod(pathlib.Path(programs).parents[1], 0o755)
        folder = pathlib.Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else temporary / "written"
        folder.mkdir(parents=True, exist_ok=True)
        place = temporary / "read"
        place.mkdir()
        place.chmod(0o777)
        other_user = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "env", "-i", f"TMPDIR={place}"]
        users = {"this user": []}
        if os.geteuid() == 0 and shutil.which("setpriv"):
            users["another user"] = other_user
        else:
            print("skipped: another user, which needs root and setpriv")
        for file in bundles(f"{programs}/kinetoscope", wheel, folder):
            shutil.copy(file, place)
            (place / file.name).chmod(0o644)
            for user, prefix in users.items():
                said = call([*prefix, f"{programs}/kinetoscope", "reproduce", file.name], place)
                assert f"{file.name} is reproduced" in said, said
                print(f"{file.name}, {file.stat().st_size} bytes: reproduced by {user}, in another folder, with the program of the wheel")


if __name__ == "__main__":
    main()
