#!/usr/bin/env python3
"""Do the shipped experiments give the same messages and metrics on every architecture?

For each target, the program is compiled in a folder with the packages of a Debian system (extracted by mmdebstrap; needs root) and
executed by qemu-user; `kinetoscope lock` writes the hashes of all messages and the metrics into a lock file, which must be equal to
that of this machine. As WebAssembly, `lock_in_memory` of `examples` does so in Node, with neither threads nor files. Experiments that
would take over a minute have fewer runs.

    tests/architectures/compare.py                      # all targets, all experiments: two hours; writes docs/architectures.md
    tests/architectures/compare.py --targets riscv64    # one target; the page keeps the rows of the others
    tests/architectures/compare.py --quick              # aarch64 and wasm32, one experiment of each model, by lock_in_memory; writes nothing

What is equal on the page is kept: an experiment is not compared again on a target while its entry in this machine's lock file is the
same. An interrupted comparison goes on where it stopped.

Exit codes: 0 equal, 1 different, 77 the system cannot be made (no network, no permission).
"""

import argparse
import concurrent.futures
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

SOURCES = pathlib.Path(__file__).resolve().parents[2]
PAGE = SOURCES / "docs/architectures.md"
QUICK = ("first_run", "gas_300_kelvin", "packing_fifty_discs", "orbit_exercise")
IN_MEMORY = "lock_in_memory"

# Name: Rust's target, the cross compiler's prefix, the emulator and its options. This machine's own vector instructions need none.
TARGETS = {
    "x86-64 with AVX-512": ("x86_64-unknown-linux-gnu", "", []),
    "x86-64 with AVX2": ("x86_64-unknown-linux-gnu", "", ["qemu-x86_64", "-cpu", "Haswell"]),
    "x86-64 with SSE2": ("x86_64-unknown-linux-gnu", "", ["qemu-x86_64", "-cpu", "qemu64"]),
    "aarch64": ("aarch64-unknown-linux-gnu", "aarch64-linux-gnu", ["qemu-aarch64"]),
    "riscv64": ("riscv64gc-unknown-linux-gnu", "riscv64-linux-gnu", ["qemu-riscv64"]),
    "s390x (big-endian)": ("s390x-unknown-linux-gnu", "s390x-linux-gnu", ["qemu-s390x"]),
    "wasm32 (WASI, in Node)": ("wasm32-wasip1", "", ["node"]),
}
WASM = "wasm32-wasip1"
# Targets with their numbers of threads; WebAssembly has none.
PLACES = [(name, threads) for name, rest in TARGETS.items() for threads in ((1,) if rest[0] == WASM else (1, 2))]
# Experiments that a target runs before the page is saved.
AT_ONCE = 8
EQUAL, MESSAGES, METRICS = "equal", "other messages", "other metrics"
# The environment variable that names the mount namespace of the comparison.
OWN_MOUNTS = "KINETOSCOPE_OWN_MOUNTS"
PACKAGES = "base-files bash cargo coreutils gcc libc6-dev qemu-user rustc sed"
WASM_PACKAGES = "clang libclang-rt-dev-wasm32 libstd-rust-dev-wasm32 lld llvm nodejs wasi-libc"
# Text of manifests whose runs would take an emulator over a minute, and what it becomes.
SHORTENED = {
    "dem_column_collapse": ("replicates = 6", "replicates = 1"),
    "dem_granular_gas": ("replicates = 4", "replicates = 1"),
    "dem_heap": ("replicates = 4", "replicates = 1"),
    "dem_hopper_discharge": ("replicates = 4", "replicates = 1"),
    "dem_silo": ("[80, 120, 240, 480]", "[80]"),
    "gas_barometric": ("replicates = 4", "replicates = 1"),
    "gas_pressure_vs_radius": ("replicates = 10", "replicates = 2"),
    "gas_pressure_vs_temperature": ("replicates = 10", "replicates = 2"),
    "gas_stationarity": ("replicates = 4", "replicates = 1"),
    "packing_freezing": ("replicates = 4", "replicates = 1"),
    "packing_self_diffusion": ("replicates = 4", "replicates = 1"),
    "packing_timing_table": ("replicates = 100", "replicates = 2"),
    "packing_velocity_laws": ("replicates = 20", "replicates = 2"),
}
APT_OPTIONS = ('Acquire::Check-Valid-Until "false"', 'APT::Install-Recommends "false"')
STANDARD_LIBRARY = """mkdir -p "$1/root" && cd "$1/root" && APT_CONFIG="$MMDEBSTRAP_APT_CONFIG" apt-get download -qq libstd-rust-dev:{architecture} \\
    && dpkg-deb -x libstd-rust-dev_*_{architecture}.deb "$1" && rm libstd-rust-dev_*_{architecture}.deb"""
DEBIAN = {"aarch64": "arm64", "riscv64gc": "riscv64", "s390x": "s390x"}


def shortened(manifest):
    """The text of a manifest for an emulator, and what was changed."""
    text = manifest.read_text()
    if manifest.stem not in SHORTENED:
        return text, None
    old, new = SHORTENED[manifest.stem]
    if text.count(old) != 1:
        raise ValueError(f"{manifest} does not contain {old!r} once")
    # The answer and the picture may name points that are left out; neither is part of the messages.
    text = re.sub(r"(?m)^(answer|compare) = .*\n", "", text)
    return text.replace(old, new), f"`{new}` instead of `{old}`"


class CannotBeMade(Exception):
    """The system for the compilation cannot be made here."""


def run(*words, **options):
    return subprocess.run([str(word) for word in words], check=True, **options)


def mirror():
    """The package mirror of this machine."""
    texts = [*pathlib.Path("/etc/apt").glob("sources.list*"), *pathlib.Path("/etc/apt/sources.list.d").glob("*")]
    for path in texts:
        found = re.search(r"(https?://\S+/debian)/?\s", path.read_text()) if path.is_file() else None
        if found:
            return found[1]
    raise CannotBeMade("this is no Debian system with a package mirror")


class System:
    """A folder with cross compilers and emulators."""

    def __init__(self, folder):
        self.folder = folder

    def make(self, targets):
        """Extracts the packages; those of earlier targets are kept."""
        packages, architectures = set(PACKAGES.split()), set()
        for target, prefix in targets:
            if target == WASM:
                packages.update(WASM_PACKAGES.split())
            elif prefix:
                architecture = DEBIAN[target.split("-")[0]]
                packages.update((f"gcc-{prefix}", f"libc6-dev-{architecture}-cross"))
                architectures.add(architecture)
        stamp = self.folder / "extracted"
        extracted = stamp.read_text().split() if stamp.exists() else []
        if not packages | architectures <= set(extracted):
            architectures.update(set(extracted) & set(DEBIAN.values()))
            packages.update(set(extracted) - architectures)
            self.extract(packages, architectures)
            stamp.write_text(" ".join(sorted(packages | architectures)))
        for source, place in (("/proc", "proc"), ("/dev", "dev"), (SOURCES, "sources"), (registry(), "root/.cargo/registry")):
            self.mount(source, place)

    def extract(self, packages, architectures):
        """Packages need not be configured to compile; of another architecture, Rust's standard library suffices."""
        if not shutil.which("mmdebstrap"):
            run("apt-get", "update", "-qq")
            run("apt-get", "install", "-y", "-qq", "-o", "DPkg::Lock::Timeout=300", "mmdebstrap", stdout=subprocess.DEVNULL)
        self.remove()
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        options = ["--quiet", "--variant=extract", f"--architectures={','.join(['amd64', *sorted(architectures)])}"]
        options += [f"--aptopt={option}" for option in APT_OPTIONS]
        options.append(f"--include={','.join(sorted(packages))}")
        for architecture in architectures:
            options.append(f"--extract-hook={STANDARD_LIBRARY.format(architecture=architecture)}")
        run("mmdebstrap", *options, "sid", self.folder, mirror(), stdout=subprocess.DEVNULL)

    def remove(self):
        """Not while something is mounted below: removal would go on into it, be it these sources."""
        below = f"{self.folder.resolve()}/"
        for line in pathlib.Path("/proc/self/mounts").read_text().splitlines():
            place = re.sub(r"\\([0-7]{3})", lambda code: chr(int(code[1], 8)), line.split()[1])
            if f"{place}/".startswith(below):
                raise CannotBeMade(f"{place} is mounted: run umount on it first")
        shutil.rmtree(self.folder, ignore_errors=True)

    def mount(self, source, place):
        target = self.folder / place
        target.mkdir(parents=True, exist_ok=True)
        run("mount", "--bind", source, target)

    def shell(self, script, **options):
        return run("chroot", self.folder, "bash", "-euc", script, **options)

    def build(self, targets, quick):
        """Compiles what the targets execute, from the packages in this machine's registry."""
        run("cargo", "fetch", "--locked", "--quiet", cwd=SOURCES)
        exports = ["export CARGO_TARGET_DIR=/build CARGO_NET_OFFLINE=true CARGO_TERM_COLOR=never",
                   # Packages that are not configured have no `cc`.
                   "export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_LINKER=gcc CC_x86_64_unknown_linux_gnu=gcc"]
        for target, prefix in targets:
            name, compiler = target.replace("-", "_"), "clang" if target == WASM else f"{prefix}-gcc"
            if prefix or target == WASM:
                exports.append(f"export CARGO_TARGET_{name.upper()}_LINKER={compiler} CC_{name}={compiler}")
            if target == WASM:
                # Debian's clang brings the linker and the C library of WASI.
                flags = "-C link-self-contained=no -C link-arg=/build/lz4_shim.o"
                exports.append(f"export AR_{name}=llvm-ar CARGO_TARGET_{name.upper()}_RUSTFLAGS='{flags}'")
                exports.append("clang --target=wasm32-wasip1 -O2 -c /sources/tests/architectures/lz4_shim.c -o /build/lz4_shim.o")
        in_memory = [target for target, _ in targets if quick or target == WASM]
        programs = [target for target, _ in targets if target not in in_memory]
        commands = []
        for package, of in (("kinetoscope-lock-in-memory", in_memory), ("kinetoscope-program", programs)):
            if of:
                commands.append(f"cargo build --quiet --locked --release --target {' --target '.join(of)} --package {package}")
        self.shell("\n".join(["mkdir -p /build", *exports, "cd /sources", *commands]))

    def lock(self, target, prefix, emulator, threads, work, quick):
        """The lock file of the experiments in `work`, as the target writes it, and the time that it took."""
        own = work.name
        shutil.rmtree(self.folder / own, ignore_errors=True)
        shutil.copytree(work, self.folder / own)
        emulated = " ".join([*emulator, *([f"-L /usr/{prefix}"] if prefix else [])])
        built = f"/build/{target}/release"
        started = time.monotonic()
        if target == WASM:
            emulated = "node --no-warnings /sources/tests/architectures/wasi.mjs"
            self.lock_in_memory(own, f"{emulated} {built}/{IN_MEMORY}.wasm")
        elif quick:
            self.lock_in_memory(own, f"{emulated} {built}/{IN_MEMORY}")
        else:
            self.shell(f"cd /{own} && {emulated} {built}/kinetoscope lock --quiet --jobs 1 --threads {threads} experiments")
        return (self.folder / own / "kinetoscope.lock").read_text(), time.monotonic() - started

    def lock_in_memory(self, own, program):
        """This program takes one manifest at a time."""
        self.shell(f"""
            cd /{own}
            for manifest in experiments/*.toml; do
                {program} $manifest < $manifest > entry
                sed -n '/^\\[\\[experiment/,$p' entry >> kinetoscope.lock
                echo >> kinetoscope.lock
            done
        """)


def registry():
    """Where this machine's Cargo keeps packages."""
    folder = pathlib.Path(os.environ.get("CARGO_HOME", pathlib.Path.home() / ".cargo")) / "registry"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def entries(lock):
    """The entries of a lock file by manifest, without what `lock_in_memory` does not write: the bound of the time, values, checks and checked metrics."""
    parts = re.split(r"(?m)^\[\[experiment\]\]\n", lock)[1:]
    left_out = r'(?ms)^(at_most_s = [^\n]*|checks = [^\n]*|# End of the file: [^\n]*|(values|checked) = ("""|\'\'\').*?^\3|(values|checked) = "")\n'
    kept = (re.sub(left_out, "", part) for part in parts)
    return {re.search(r'manifest = "(.*)"', part)[1]: part.strip() for part in kept}


def only(lock, names):
    """The lock file with some of its entries."""
    return "".join(f"[[experiment]]\n{part}\n" for name, part in entries(lock).items() if stem(name) in names)


def differences(ours, theirs):
    """The experiments with other messages, and those with other metrics only."""
    messages = lambda part: re.sub(r"(?m)^metrics = .*", "", part)
    ours, theirs = entries(ours), entries(theirs)
    other = [name for name in ours if messages(ours[name]) != messages(theirs.get(name, ""))]
    metrics = [name for name in ours if name not in other and ours[name] != theirs[name]]
    return list(map(stem, other)), list(map(stem, metrics))


def stem(manifest):
    return pathlib.Path(manifest).stem


class Results:
    """For each target and number of threads, the experiments that are equal, and those with other messages or only other metrics."""

    def __init__(self, ours, is_kept):
        self.compared = {stem(name): hashlib.sha256(part.encode()).hexdigest()[:16] for name, part in entries(ours).items()}
        self.found = {place: {} for place in PLACES}
        text = PAGE.read_text() if is_kept and PAGE.exists() else ""
        letters = {letter: (name, int(threads)) for letter, name, threads in re.findall(r"(?m)^\| ([A-Z]) \| ([^|]+) \| (\d) \|", text)}
        for name, compared, equal in re.findall(r"(?m)^\| `(\w+)` \| `(\w+)` \| ([A-Z ]*) \|", text):
            if self.compared.get(name) == compared:
                for letter in equal.split():
                    self.found[letters[letter]][name] = EQUAL

    def missing(self, place):
        return [name for name in self.compared if name not in self.found[place]]

    def add(self, place, ours, theirs):
        messages, metrics = differences(ours, theirs)
        for name in map(stem, entries(ours)):
            self.found[place][name] = MESSAGES if name in messages else METRICS if name in metrics else EQUAL
        return messages, metrics

    def count(self, place, what):
        return list(self.found[place].values()).count(what)

    def is_equal(self, targets):
        return all(self.count(place, EQUAL) == len(self.found[place]) for place in PLACES if place[0] in targets)


def prepared(quick):
    """The experiments to be run, in a folder of their own; what was shortened; and this machine's lock file."""
    work = SOURCES / "target/architectures/work"
    shutil.rmtree(work, ignore_errors=True)
    (work / "experiments").mkdir(parents=True)
    changes = {}
    for manifest in sorted((SOURCES / "experiments").glob("*.toml")):
        if not quick or manifest.stem in QUICK:
            text, changes[manifest.stem] = shortened(manifest)
            (work / "experiments" / manifest.name).write_text(text)
    return work, changes


def lock_of_this_machine(program, work):
    run(program, "lock", "--quiet", "experiments", cwd=work)
    lock = work / "kinetoscope.lock"
    text = lock.read_text()
    lock.unlink()
    return text


def part_of(work, names, place):
    """A folder with some of the experiments, for one place."""
    part = work.with_name(f"part-{PLACES.index(place)}-{names[0]}")
    shutil.rmtree(part, ignore_errors=True)
    (part / "experiments").mkdir(parents=True)
    for name in names:
        shutil.copy(work / f"experiments/{name}.toml", part / "experiments")
    return part


def fill(results, system, targets, work, ours, quick, save, jobs):
    """Compares what is missing, some experiments at a time, and saves after each part, so that an interrupted comparison goes on from there."""
    places = [place for place in PLACES if place[0] in targets and results.missing(place) and not (quick and place[1] > 1)]
    if places:
        system.build(sorted({targets[name][:2] for name, _ in places}), quick)

    def locked(place, names):
        target, prefix, emulator = targets[place[0]]
        return place, names, *system.lock(target, prefix, emulator, place[1], part_of(work, names, place), quick)

    parts = []
    for place in places:
        missing = results.missing(place)
        parts += [(place, missing[at:at + AT_ONCE]) for at in range(0, len(missing), AT_ONCE)]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for done in concurrent.futures.as_completed([pool.submit(locked, *part) for part in parts]):
            (name, threads), names, theirs, seconds = done.result()
            messages, metrics = results.add((name, threads), only(ours, names), theirs)
            print(f"{name}, {threads} thread(s): {len(names)} experiments, {seconds:.0f} s; other messages: "
                  f"{', '.join(messages) or 'none'}; other metrics: {', '.join(metrics) or 'none'}", flush=True)
            save()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="aarch64 and wasm32, one experiment of each model, one thread")
    parser.add_argument("--targets", help="names of targets, separated by commas: the start of each suffices")
    parser.add_argument("--jobs", type=int, default=2, help="targets that run at the same time")
    parser.add_argument("--system", type=pathlib.Path, default=SOURCES / "target/architectures/system")
    parser.add_argument("--program", type=pathlib.Path, default=SOURCES / "target/release/kinetoscope")
    arguments = parser.parse_args()
    wanted = (arguments.targets or ("aarch64,wasm32" if arguments.quick else "")).split(",")
    targets = {name: rest for name, rest in TARGETS.items() if name.startswith(tuple(wanted))}
    own = f"x86-64 with {vectors()}"
    if own != "x86-64 with AVX-512":
        targets.pop("x86-64 with AVX-512", None)
    if own in targets:
        targets[own] = (*targets[own][:2], [])
    system = System(arguments.system)
    try:
        enter_own_mounts()
        system.make({rest[:2] for rest in targets.values()})
    except (CannotBeMade, OSError, subprocess.CalledProcessError) as error:
        print(f"the system for other architectures cannot be made: {error}")
        return 77
    work, changes = prepared(arguments.quick)
    ours = lock_of_this_machine(arguments.program, work)
    results = Results(ours, is_kept=not arguments.quick)
    save = (lambda: None) if arguments.quick else lambda: PAGE.write_text(page(results, changes))
    fill(results, system, targets, work, ours, arguments.quick, save, arguments.jobs)
    save()
    return int(not results.is_equal(targets))


def enter_own_mounts():
    """Starts again in a mount namespace of its own: what is mounted below ends with this process, however it ends.

    A mount that outlives it would be fatal: who then deletes the folder deletes /dev and the registry of packages.
    """
    if os.environ.get(OWN_MOUNTS) != os.readlink("/proc/self/ns/mnt"):
        entered = f'{OWN_MOUNTS}=$(readlink /proc/self/ns/mnt) exec "$@"'
        try:
            run("unshare", "--mount", "true")
        except (OSError, subprocess.CalledProcessError) as error:
            raise CannotBeMade("this user has no permission to mount") from error
        os.execvp("unshare", ["unshare", "--mount", "sh", "-c", entered, "sh", sys.executable, *sys.argv])


def vectors():
    """The vector instructions of this machine."""
    flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    return next((name for flag, name in (("avx512f", "AVX-512"), ("avx2", "AVX2")) if flag in flags), "SSE2")


def page(results, changes):
    """The table as a document."""
    lines = [
        "# The same messages on every architecture", "",
        "Generated by `tests/architectures/compare.py`: do not edit. On each target, `kinetoscope lock` ran the shipped experiments; the hashes of all messages "
        "(topic, time, payload), the tags of frames and the metrics, to the last digit, were compared with those of this program on x86-64. The compression of the file is not part of the guarantee. The engine of report pages is compared in [browsers](browsers.md).", "",
        "| | target | threads | experiments | equal | other messages | other metrics |", "|---|---|---|---|---|---|---|",
    ]
    lettered = list(zip("ABCDEFGHIJKLMNOPQRSTUVWXYZ", PLACES))
    for letter, (name, threads) in lettered:
        counts = [results.count((name, threads), what) for what in (EQUAL, MESSAGES, METRICS)]
        lines.append(f"| {letter} | {name} | {threads} | {' | '.join(map(str, [sum(counts), *counts]))} |")
    if any(not results.found[place] for place in PLACES):
        lines += ["", "A row with 0 experiments has not been compared since their entries changed, because no such processor was at hand. `kinetoscope.lock` was written on x86-64 with "
                      "AVX-512, and the step `lock` of `.ci/run` compares every experiment with it on any processor."]
    lines += [
        "", "## Results by experiment", "",
        "The letters are those of the table above. The number is the start of the SHA-256 of the experiment's entry in the lock file of this program on x86-64: its "
        "hashes and metrics. While it is the same, the experiment is not compared again.", "",
        f"| experiment | compared | {EQUAL} | {MESSAGES} | {METRICS} |", "|---|---|---|---|---|",
    ]
    for name, compared in sorted(results.compared.items()):
        letters = [" ".join(letter for letter, place in lettered if results.found[place].get(name) == what) for what in (EQUAL, MESSAGES, METRICS)]
        lines.append(f"| `{name}` | `{compared}` | {' | '.join(letters)} |")
    lines += ["", "## Shortened experiments", "", "Emulation is about ten times slower than the processor. These experiments had fewer runs:", ""]
    lines += [f"- `{name}`: {change}" for name, change in changes.items() if change]
    lines += [
        "", "## Windows", "",
        "`tests/architectures/windows.py` compiles the program for `x86_64-pc-windows-gnu` and executes it under Wine 8.0 (Debian 12): `check --locked --all` gives the locked messages and "
        "metrics of all 51 experiments, a recording is equal in every byte to that of Linux, each system verifies the recording of the other, and killed and interrupted runs resume to the same "
        "bytes. Wine is no Windows: the workflow `release` checks the wheel on Windows, and no claim is made before it has run.", "",
        "Two guarantees are weaker there: folders cannot be locked, so that two "
        "programs that write the same side file at the same time replace each other's; and links on the way to a served file are found before it is opened, not during the call. "
        "Calls that only Unix has are in the files that rule 6 of ARCHITECTURE.md lists, behind `cfg`; `tests/guarantees/repository_layout.rs` enforces the list.",
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
