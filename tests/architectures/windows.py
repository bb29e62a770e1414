#!/usr/bin/env python3
"""Does the program for Windows give the locked messages, and lose no run? Under Wine, on Linux.

The program is compiled for x86_64-pc-windows-gnu (`rustup target add x86_64-pc-windows-gnu`, Debian's gcc-mingw-w64-x86-64) and executed by Wine
(Debian's wine64). `check --locked` reruns the shipped experiments and compares every message and metric with kinetoscope.lock; then come the
cases that only a system like Windows has. Wine is no Windows: what holds here is "the same messages under Wine".

    tests/architectures/windows.py                  # all experiments and all cases
    tests/architectures/windows.py --some first_run,gas_300_kelvin,packing_fifty_discs,orbit_exercise

Exit codes: 0 all is equal and every case passes, 1 not, 77 Wine or the compiler is missing.
"""

import argparse
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

SOURCES = pathlib.Path(__file__).resolve().parents[2]
TARGET = "x86_64-pc-windows-gnu"
FOLDER = SOURCES / "target/architectures/windows"
# Rust's standard library takes its random keys from a function that Wine has since version 9.
PRNG = """#include <windows.h>
#include <ntsecapi.h>
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T bytes) { return RtlGenRandom(data, (ULONG)bytes); }
"""
# A run of several seconds, whose partial file grows.
LONG = "[model.dem]\ndiscs = 400\nwidth_m = 0.06\nheight_m = 0.06\nduration_s = 2.0\n[record]\nframes = 600\n"


def wine():
    found = shutil.which("wine64") or next((str(path) for path in [pathlib.Path("/usr/lib/wine/wine64")] if path.exists()), None)
    if not found or not shutil.which("x86_64-w64-mingw32-gcc"):
        print("Wine (wine64) or the cross compiler (gcc-mingw-w64-x86-64) is missing")
        sys.exit(77)
    return found


class Windows:
    """A folder with the program, and a system of Wine."""

    def __init__(self, program):
        self.wine = wine()
        shutil.rmtree(FOLDER / "bin", ignore_errors=True)
        (FOLDER / "bin").mkdir(parents=True, exist_ok=True)
        shutil.copy(program, FOLDER / "bin/kinetoscope.exe")
        (FOLDER / "prng.c").write_text(PRNG)
        library = FOLDER / "bin/bcryptprimitives.dll"
        subprocess.run(["x86_64-w64-mingw32-gcc", "-shared", "-O2", "-o", library, FOLDER / "prng.c", "-ladvapi32"], check=True)
        self.environment = {**os.environ, "WINEPREFIX": str(FOLDER / "system"), "WINEDEBUG": "-all", "NO_COLOR": "1"}
        subprocess.run([self.wine, "wineboot", "--init"], env=self.environment, check=True, capture_output=True)
        self.version = subprocess.run([self.wine, "--version"], capture_output=True, text=True, env=self.environment).stdout.strip()

    def start(self, arguments, folder):
        words = [self.wine, FOLDER / "bin/kinetoscope.exe", *arguments]
        return subprocess.Popen(words, cwd=folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def call(self, *arguments, folder):
        started = self.start(arguments, folder)
        out, err = started.communicate(timeout=3600)
        text = [part.decode(errors="replace").replace("\r\n", "\n") for part in (out, err)]
        return started.returncode, *text


class Cases:
    """The cases, each in a folder of its own; a failed one is printed."""

    def __init__(self, windows, native):
        self.windows, self.native, self.failed, self.passed = windows, native, [], []

    def folder(self, name):
        folder = FOLDER / "cases" / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def expect(self, name, holds, details=""):
        (self.passed if holds else self.failed).append(name)
        print(f"{'ok' if holds else 'FAILED'}: {name}{'' if holds else f': {details}'}", flush=True)

    def run_here(self, *arguments, folder):
        return subprocess.run([self.native, *arguments], cwd=folder, capture_output=True, text=True)

    def same_bytes_and_verified(self):
        folder = self.folder("same bytes")
        shutil.copy(SOURCES / "experiments/first_run.toml", folder)
        self.windows.call("run", "--quiet", "first_run.toml", "--output", "there", folder=folder)
        self.run_here("run", "--quiet", "first_run.toml", "--output", "here", folder=folder)
        files = [sorted((folder / place / "first_run").glob("*.mcap")) for place in ("here", "there")]
        equal = [path.name for path in files[0]] == [path.name for path in files[1]] and all(
            one.read_bytes() == other.read_bytes() for one, other in zip(*files)
        )
        self.expect("a recording is equal in every byte to that of Linux", equal and bool(files[0]), str(files))
        there = self.windows.call("verify", "here", folder=folder)
        here = self.run_here("verify", "there", folder=folder)
        self.expect("each system verifies the recording of the other", there[0] == here.returncode == 0, f"{there} {here}")
        analyzed = self.windows.call("analyze", "there\\first_run", folder=folder)
        self.expect("the analysis writes its report", analyzed[0] == 0 and (folder / "there/first_run/report.html").exists(), str(analyzed))

    def killed_run_resumes(self):
        folder = self.folder("killed")
        (folder / "long.toml").write_text(LONG)
        self.run_here("run", "--quiet", "long.toml", "--output", "whole", folder=folder)
        whole = next((folder / "whole/long").glob("*.mcap")).read_bytes()
        started = self.windows.start(["run", "--quiet", "--checkpoint-every", "0.1", "long.toml", "--output", "killed"], folder)
        partial = self.wait_for(folder / "killed/long", "*.partial.mcap", started)
        checkpoint = self.wait_for(folder / "killed/long", "*.checkpoint", started)
        seen = self.windows.call("info", partial or "none", folder=folder)
        being_written = "being written" in seen[1] + seen[2] or "not finished" in seen[1] + seen[2]
        self.expect("a file that is being written can be read", being_written, str(seen))
        second = self.windows.call("run", "--quiet", "long.toml", "--output", "killed", folder=folder)
        self.expect("a second program does not write the same run", second[0] != 0 and "another process" in second[2], str(second))
        started.kill()
        started.communicate()
        subprocess.run(["wineserver", "-k"], env=self.windows.environment, check=False)
        time.sleep(2)
        resumed = self.windows.call("run", "long.toml", "--output", "killed", folder=folder)
        files = list((folder / "killed/long").glob("*.mcap"))
        equal = len(files) == 1 and files[0].read_bytes() == whole
        from_checkpoint = "from frame" in resumed[2] + resumed[1]
        self.expect("a killed run resumes to the same bytes", bool(checkpoint) and equal and from_checkpoint, f"{resumed} {files}")

    def interrupted_run_resumes(self):
        folder = self.folder("interrupted")
        (folder / "long.toml").write_text(LONG)
        started = self.windows.start(["run", "--quiet", "long.toml"], folder)
        self.wait_for(folder / "recordings/long", "*.partial.mcap", started)
        time.sleep(1)
        # Wine passes it on as Ctrl-C of the console.
        started.send_signal(signal.SIGINT)
        out, err = started.communicate(timeout=60)
        partial = list((folder / "recordings/long").glob("*.partial.mcap"))
        text = out.decode() + err.decode()
        self.expect("Ctrl-C ends a run in order", started.returncode == 130 and len(partial) == 1, f"{started.returncode} {text}")
        resumed = self.windows.call("run", "long.toml", folder=folder)
        self.expect("the same command resumes it", resumed[0] == 0 and "from frame" in resumed[1] + resumed[2], str(resumed))

    def wait_for(self, folder, pattern, started):
        for _ in range(1200):
            found = next(iter(folder.glob(pattern)), None) if folder.exists() else None
            if found or started.poll() is not None:
                return found and str(found.relative_to(folder.parents[1]))
            time.sleep(0.05)
        return None

    def manifests_of_editors(self):
        folder = self.folder("Größe und Maß (2)")
        text = (SOURCES / "experiments/first_run.toml").read_bytes().replace(b"\n", b"\r\n")
        (folder / "first_run.toml").write_bytes(b"\xef\xbb\xbf" + text)
        ran = self.windows.call("run", "--quiet", "first_run.toml", folder=folder)
        self.run_here("run", "--quiet", str(SOURCES / "experiments/first_run.toml"), "--output", "here", folder=folder)
        files = [next(iter((folder / place / "first_run").glob("*.mcap")), None) for place in ("recordings", "here")]
        equal = all(files) and files[0].read_bytes() == files[1].read_bytes()
        self.expect("CRLF, a byte order mark, spaces and umlauts change nothing", ran[0] == 0 and equal, str(ran))

    def paths(self):
        folder = self.folder("paths")
        shutil.copy(SOURCES / "experiments/first_run.toml", folder)
        (folder / "file").mkdir()
        given = self.windows.call("run", "file", folder=folder)
        self.expect("a folder without manifests is named", given[0] == 2 and "help:" in given[2], str(given))
        verified = self.windows.call("verify", "file", folder=folder)
        self.expect("a folder in place of a recording is named", verified[0] == 5 and "os error" not in verified[2], str(verified))
        for name in ("aux", "NUL"):
            (folder / "device.toml").write_text(f'name = "{name}"\n[model.dem]\n')
            device = self.windows.call("check", "device.toml", folder=folder)
            self.expect(f"{name} names no experiment", device[0] == 2 and "device of Windows" in device[2], str(device))
        deep = "\\".join(["a" * 60] * 5)
        ran = self.windows.call("run", "--quiet", "first_run.toml", "--output", deep, folder=folder)
        has_message = ran[0] == 0 or "help:" in ran[2]
        self.expect("a path of more than 260 characters is written or named", has_message, str(ran))
        drive = self.windows.call("run", "--quiet", "first_run.toml", "--output", "C:\\recordings here", folder=folder)
        written = list((FOLDER / "system/drive_c/recordings here/first_run").glob("*.mcap"))
        self.expect("a drive letter and a space are a folder", drive[0] == 0 and len(written) == 1, str(drive))


def locked(windows, some):
    """Whether all experiments give the messages and metrics of the lock file."""
    folder = FOLDER / "locked"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copytree(SOURCES / "experiments", folder / "experiments")
    shutil.copy(SOURCES / "kinetoscope.lock", folder)
    names = [f"experiments/{name}.toml" for name in some] if some else ["--all"]
    started = time.monotonic()
    code, out, err = windows.call("check", "--locked", *names, folder=folder)
    print(f"check --locked: exit code {code}, {time.monotonic() - started:.0f} s\n{out[-2000:]}{err[-2000:]}", flush=True)
    return code == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--some", help="names of experiments, separated by commas, in place of all")
    parser.add_argument("--program", type=pathlib.Path, help="kinetoscope.exe that is compiled already")
    parser.add_argument("--native", type=pathlib.Path, default=SOURCES / "target/release/kinetoscope")
    arguments = parser.parse_args()
    wine()
    if not arguments.program:
        words = ["cargo", "build", "--quiet", "--locked", "--release", "--target", TARGET, "--package", "kinetoscope-program", "--bin", "kinetoscope"]
        subprocess.run(words, cwd=SOURCES, check=True)
    program = arguments.program or SOURCES / f"target/{TARGET}/release/kinetoscope.exe"
    windows = Windows(program)
    print(windows.version, flush=True)
    cases = Cases(windows, arguments.native.resolve())
    cases.same_bytes_and_verified()
    cases.killed_run_resumes()
    cases.interrupted_run_resumes()
    cases.manifests_of_editors()
    cases.paths()
    is_locked = locked(windows, arguments.some.split(",") if arguments.some else [])
    subprocess.run(["wineserver", "-k"], env=windows.environment, check=False)
    print(f"{len(cases.passed)} of {len(cases.passed) + len(cases.failed)} cases pass under {windows.version}")
    return int(bool(cases.failed) or not is_locked)


if __name__ == "__main__":
    sys.exit(main())
