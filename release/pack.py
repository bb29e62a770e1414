#!/usr/bin/env python3
"""Packs a folder of programs as a wheel, an archive and a Debian package. Equal input gives equal bytes.

Usage: pack.py STAGE VERSION OUTPUT [PLATFORM]     (SOURCE_DATE_EPOCH is the time of every file)

With PLATFORM, only the wheel for it is made: manylinux_2_17_aarch64, win_amd64, or any, which is the Python package without programs.

STAGE is laid out as below /usr: bin, share/man/man1, share/bash-completion/completions, ... The wheel contains the Python
package in python/kinetoscope, with the dependencies and entry points of python/pyproject.toml, if they exist.
"""

import base64
import gzip
import hashlib
import io
import os
import re
import sys
import tarfile
import time
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EPOCH = int(os.environ["SOURCE_DATE_EPOCH"])
# glibc of the linker's target in build.sh; the second name is that of older versions of pip.
PLATFORM = "manylinux_2_17_x86_64.manylinux2014_x86_64"
CARGO = tomllib.loads((ROOT / "Cargo.toml").read_text())
SUMMARY = CARGO["package"]["description"]
ABOUT = CARGO["workspace"]["package"]
DEVELOPERS = "The Kinetoscope developers"
# Of the Debian package, below the summary.
DESCRIPTION = (
    " Kinetoscope simulates discs with springs and friction (DEM), gases in a container, event-driven packings, and orbits.\n"
    " A TOML manifest describes an experiment; each run writes one MCAP recording with the exact state of every frame, which\n"
    " Foxglove and Lichtblick play. The same manifest gives the same bytes on any number of threads.\n .\n"
    " The programs are kinetoscope, run-experiment and analyze-recordings, which computes metrics with standard errors,\n"
    " theoretical values, plots and checks from the recordings.\n"
)
# A link of the README to a file or a part of the repository.
RELATIVE_LINK = re.compile(r"\]\((?!https?://|#)([^)\s]+)\)")
OTHER_RELATIVE_LINK = re.compile(r"""(?:\]\(|^\[[^]]+\]: *|(?:src|href) *= *["'])(?!https?://|#)""", re.MULTILINE)
# The packages of the program (CycloneDX) in STAGE.
PACKAGES = "share/doc/kinetoscope.cdx.json"
# The last one is that of the font in the plots, which is part of the program.
LICENSES = ("LICENSE-APACHE", "LICENSE-MIT", "analysis/src/plot/font/LICENSE.txt")


# The subcommand that a program is, for formats without links. The program itself decides by the name of the call.
SUBCOMMANDS = {"run-experiment": "run", "analyze-recordings": "analyze"}


class Link(str):
    """The target of a symbolic link, in place of the bytes of a file."""


def files_below(folder):
    """Path within the folder, bytes or link, and whether it is a program, in a fixed order."""
    for path in sorted(folder.rglob("*")):
        # On the stage of Windows, links name the program without its ending.
        if (path.is_file() or path.is_symlink()) and "__pycache__" not in path.parts:
            data = Link(os.readlink(path)) if path.is_symlink() else path.read_bytes()
            yield path.relative_to(folder).as_posix(), data, path.parent.name == "bin"


def batch_file_for(name, link):
    """The same for Windows, where the program itself answers --version by its own name."""
    return f'@"%~dp0{link}.exe" {SUBCOMMANDS[name]} %*\r\n'.encode()


def script_for(name, link, version):
    """Two lines of shell in place of a link: a wheel contains files only."""
    return (
        f'#!/bin/sh\ncase $1 in -V | --version) echo "{name} {version}"; exit ;; esac\n'
        f'exec "$(dirname "$(readlink -f "$0")")/{link}" {SUBCOMMANDS[name]} "$@"\n'
    ).encode()


def readme(version):
    """The README outside the repository: its relative links lead to the repository at this version."""
    text = (ROOT / "README.md").read_text()
    dead = [link for link in RELATIVE_LINK.findall(text) if not (ROOT / link.partition("#")[0]).is_file()]
    if dead:
        sys.exit(f"error: README.md has links to missing files: {', '.join(dead)}")
    text = RELATIVE_LINK.sub(lambda link: f"]({address(link[1], version)})", text)
    # In another notation, such as HTML.
    if OTHER_RELATIVE_LINK.search(text):
        sys.exit("error: README.md has a relative link that is not of the form [text](path)")
    return text


def address(link, version):
    """Pictures as files, all others as pages."""
    kind = "raw" if link.endswith(".png") else "blob"
    return f"{ABOUT['repository']}/{kind}/v{version}/{link}"


def metadata(version, project):
    """The wheel's description of itself: Core Metadata 2.4, PyPA."""
    lines = ["Metadata-Version: 2.4", "Name: kinetoscope", f"Version: {version}", f"Summary: {SUMMARY}"]
    lines += [f"Author: {DEVELOPERS}", f"Keywords: {','.join(ABOUT['keywords'])}"]
    lines += [f"Project-URL: Homepage, {ABOUT['repository']}", f"Project-URL: Documentation, {ABOUT['documentation']}"]
    lines += [f"Classifier: {name}" for name in project.get("classifiers", [])]
    lines += [f"License-Expression: {ABOUT['license']}"] + [f"License-File: {name}" for name in LICENSES]
    lines.append(f"Requires-Python: {project.get('requires-python', '>=3.9')}")
    lines += [f"Requires-Dist: {requirement}" for requirement in project.get("dependencies", [])]
    for extra, requirements in sorted(project.get("optional-dependencies", {}).items()):
        lines.append(f"Provides-Extra: {extra}")
        lines += [f"Requires-Dist: {with_extra(requirement, extra)}" for requirement in requirements]
    lines += ["Description-Content-Type: text/markdown", "", readme(version)]
    return "\n".join(lines)


def with_extra(requirement, extra):
    """The requirement under the condition that the extra was asked for."""
    name, _, marker = (part.strip() for part in requirement.partition(";"))
    condition = f'extra == "{extra}"'
    return f"{name}; ({marker}) and {condition}" if marker else f"{name}; {condition}"


def entry_points(project):
    groups = dict(project.get("entry-points", {}))
    if "scripts" in project:
        groups["console_scripts"] = project["scripts"]
    text = ""
    for group, entries in sorted(groups.items()):
        text += f"[{group}]\n" + "".join(f"{name} = {target}\n" for name, target in sorted(entries.items()))
    return text


def wheel(stage, version, output, platform=PLATFORM):
    description = ROOT / "python/pyproject.toml"
    project = tomllib.loads(description.read_text())["project"] if description.exists() else {}
    if project and project["version"] != version:
        sys.exit(f"error: python/pyproject.toml has version {project['version']}, Cargo.toml {version}")
    information = f"kinetoscope-{version}.dist-info"
    contents = [(f"kinetoscope/{name}", data, False) for name, data, _ in files_below(ROOT / "python/kinetoscope")]
    for name, data, is_program in files_below(stage) if platform != "any" else ():
        if isinstance(data, Link) and platform.startswith("win"):
            name, data = f"{name}.cmd", batch_file_for(Path(name).name, data)
        elif isinstance(data, Link):
            data = script_for(Path(name).name, data, version)
        if name == PACKAGES:
            # The place of such lists in wheels: PEP 770.
            contents.append((f"{information}/sboms/{Path(name).name}", data, False))
            continue
        kind = "scripts/" + name.removeprefix("bin/") if is_program else "data/" + name
        contents.append((f"kinetoscope-{version}.data/{kind}", data, is_program))
    tags = "".join(f"Tag: py3-none-{name}\n" for name in platform.split("."))
    texts = {"METADATA": metadata(version, project), "entry_points.txt": entry_points(project)}
    texts["WHEEL"] = f"Wheel-Version: 1.0\nGenerator: release/pack.py\nRoot-Is-Purelib: {str(platform == 'any').lower()}\n{tags}"
    contents += [(f"{information}/{name}", text.encode(), False) for name, text in sorted(texts.items()) if text]
    contents += [(f"{information}/licenses/{name}", (ROOT / name).read_bytes(), False) for name in LICENSES]
    record = "".join(f"{name},sha256={digest(data)},{len(data)}\n" for name, data, _ in contents)
    contents.append((f"{information}/RECORD", f"{record}{information}/RECORD,,\n".encode(), False))
    path = output / f"kinetoscope-{version}-py3-none-{platform}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, data, is_program in contents:
            entry = zipfile.ZipInfo(name, time.gmtime(EPOCH)[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = (0o100755 if is_program else 0o100644) << 16
            archive.writestr(entry, data, compresslevel=9)
    return path


def digest(data):
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def archive_of(contents):
    """A .tar.gz with folders before their files, owned by root. The time in the gzip header is 0."""
    raw = io.BytesIO()
    with tarfile.open(fileobj=raw, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        folders = {parent for name, _, _ in contents for parent in Path(name).parents if parent.name}
        for folder in sorted(folders):
            archive.addfile(member(folder.as_posix(), tarfile.DIRTYPE, 0o755, 0))
        for name, data, is_program in contents:
            if isinstance(data, Link):
                entry = member(name, tarfile.SYMTYPE, 0o777, 0)
                entry.linkname = str(data)
                archive.addfile(entry)
                continue
            entry = member(name, tarfile.REGTYPE, 0o755 if is_program else 0o644, len(data))
            archive.addfile(entry, io.BytesIO(data))
    return gzip.compress(raw.getvalue(), 9, mtime=0)


def member(name, kind, mode, size):
    entry = tarfile.TarInfo(name)
    entry.type, entry.mode, entry.size, entry.mtime = kind, mode, size, EPOCH
    entry.uname = entry.gname = "root"
    return entry


def archive(stage, version, output):
    folder = f"kinetoscope-{version}-x86_64-linux"
    contents = [(f"{folder}/{name}", data, program) for name, data, program in files_below(stage)]
    contents += [(f"{folder}/{name}", (ROOT / name).read_bytes(), False) for name in LICENSES]
    contents.append((f"{folder}/README.md", readme(version).encode(), False))
    path = output / f"{folder}.tar.gz"
    path.write_bytes(archive_of(contents))
    return path


def debian_package(stage, version, output):
    """Three members of an `ar` archive: format version, control, data (deb(5))."""
    contents = []
    for name, data, program in files_below(stage):
        if name.startswith("share/man/"):
            name, data = name + ".gz", gzip.compress(data, 9, mtime=0)
        # Debian's zsh does not look into site-functions.
        name = name.replace("zsh/site-functions", "zsh/vendor-completions")
        contents.append((f"usr/{name}", data, program))
    origin = f"Kinetoscope, by {DEVELOPERS}\nSource: {ABOUT['repository']}\nLicense: {ABOUT['license']}\n"
    license_text = b"\n\n".join([origin.encode()] + [(ROOT / name).read_bytes() for name in LICENSES])
    contents.append(("usr/share/doc/kinetoscope/copyright", license_text, False))
    files = [(name, data) for name, data, _ in contents if not isinstance(data, Link)]
    size = sum(len(data) for _, data in files) // 1024 + 1
    control = (
        f"Package: kinetoscope\nVersion: {version}\nArchitecture: amd64\nMaintainer: {DEVELOPERS}\n"
        f"Installed-Size: {size}\nDepends: libc6 (>= 2.17)\nSection: science\nPriority: optional\n"
        f"Homepage: {ABOUT['repository']}\nDescription: {SUMMARY.partition(':')[0]}\n{DESCRIPTION}"
    )
    sums = "".join(f"{hashlib.md5(data).hexdigest()}  {name}\n" for name, data in files)
    about = [("control", control.encode(), False), ("md5sums", sums.encode(), False)]
    path = output / f"kinetoscope_{version}_amd64.deb"
    with path.open("wb") as package:
        package.write(b"!<arch>\n")
        members = {"debian-binary": b"2.0\n", "control.tar.gz": archive_of(about), "data.tar.gz": archive_of(contents)}
        for name, data in members.items():
            package.write(f"{name:<16}{EPOCH:<12}{0:<6}{0:<6}{'100644':<8}{len(data):<10}`\n".encode())
            package.write(data + b"\n" * (len(data) % 2))
    return path


def main():
    stage, version, output = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    output.mkdir(parents=True, exist_ok=True)
    packs = (wheel, archive, debian_package)
    if len(sys.argv) > 4:
        packs = (lambda *arguments: wheel(*arguments, platform=sys.argv[4]),)
    for pack in packs:
        path = pack(stage, version, output)
        print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
