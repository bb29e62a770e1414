#!/usr/bin/env python3
"""Prints the licenses of all packages in the released program: each text once, below the packages that have it.

Usage: notices.py TARGET > licenses.txt     (a target of Rust)
"""

import sys
from fnmatch import fnmatch
from pathlib import Path

from sbom import PROGRAM, released

NAMES = ("licen[cs]e*", "copying*", "notice*", "unlicense*")
RULE = "=" * 100


def texts_of(folder):
    """The license files of a package."""
    for path in sorted(folder.iterdir()):
        if path.is_file() and any(fnmatch(path.name.lower(), name) for name in NAMES):
            yield path.read_text(encoding="utf-8", errors="replace").replace("\r\n", "\n").strip()


def main():
    packages, _, needed = released(sys.argv[1])
    named, without = {}, []
    for package in sorted((packages[key] for key in needed), key=lambda package: (package["name"], package["version"])):
        # Those of this project have no other source.
        if package["source"] is None:
            continue
        name = f"{package['name']} {package['version']} ({package['license']})"
        texts = dict.fromkeys(texts_of(Path(package["manifest_path"]).parent))
        for text in texts:
            named.setdefault(text, []).append(name)
        if not texts:
            without.append(name)
    print(f"The program {PROGRAM} contains the packages below.")
    for text, names in sorted(named.items(), key=lambda entry: entry[::-1]):
        print(f"\n{RULE}\n" + "\n".join(names) + f"\n{RULE}\n\n{text}")
    print(f"\n{RULE}\nPackages without a license file of their own, under the licenses that they name:\n" + "\n".join(without))


if __name__ == "__main__":
    main()
