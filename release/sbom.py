#!/usr/bin/env python3
"""Prints a CycloneDX 1.5 list of all packages in the released program, from `cargo metadata` and Cargo.lock.

Usage: sbom.py TARGET > kinetoscope.cdx.json     (a target of Rust, such as x86_64-unknown-linux-gnu)
"""

import json
import subprocess
import sys
import tomllib
import uuid
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = "kinetoscope-program"
DEVELOPERS = "The Kinetoscope developers"
TOOL = {"type": "application", "name": "release/sbom.py"}
COMMAND = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform"]


def linked(nodes, start):
    """Packages that the program is made of: normal dependencies and those that build them, not those of tests."""
    found, waiting = {}, [start]
    while waiting:
        package = waiting.pop()
        if package not in found:
            kinds = {d["pkg"]: {kind["kind"] for kind in d["dep_kinds"]} for d in nodes[package]["deps"]}
            found[package] = sorted(name for name, kind in kinds.items() if kind - {"dev"})
            waiting += found[package]
    return found


def component(package, checksums):
    reference = f"pkg:cargo/{package['name']}@{package['version']}"
    described = {"type": "library", "bom-ref": reference, "name": package["name"], "version": package["version"]}
    described["purl"] = reference
    if package["description"]:
        described["description"] = " ".join(package["description"].split())
    links = {"vcs": package["repository"], "website": package["homepage"], "documentation": package["documentation"]}
    described["externalReferences"] = [{"type": kind, "url": url} for kind, url in links.items() if url]
    if package["license"]:
        described["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
    checksum = checksums.get((package["name"], package["version"]))
    if checksum:
        described["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    return described


def released(target):
    """All packages by their id, that of the program, and the packages that each part of the program needs."""
    features = ["--manifest-path", str(ROOT / "src/program/Cargo.toml"), "--features", "parquet"]
    metadata = json.loads(subprocess.run([*COMMAND, target, *features], check=True, capture_output=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    start = next(key for key, package in packages.items() if package["name"] == PROGRAM)
    return packages, start, linked(nodes, start)


def main():
    packages, start, edges = released(sys.argv[1])
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    checksums = {(p["name"], p["version"]): p.get("checksum") for p in lock["package"]}
    components = {key: component(packages[key], checksums) for key in edges}
    program = {**components.pop(start), "type": "application"}
    references = {key: f"pkg:cargo/{packages[key]['name']}@{packages[key]['version']}" for key in edges}
    dependencies = [
        {"ref": references[key], "dependsOn": sorted({references[to] for to in edges[key]})} for key in edges
    ]
    about = {"component": program, "supplier": {"name": DEVELOPERS}, "tools": {"components": [TOOL]}}
    bom = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": about}
    bom["components"] = sorted(components.values(), key=lambda entry: entry["bom-ref"])
    bom["dependencies"] = sorted(dependencies, key=lambda entry: entry["ref"])
    # The same content has the same number.
    bom["serialNumber"] = f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(bom, sort_keys=True))}"
    print(json.dumps(bom, indent=1, sort_keys=True))


if __name__ == "__main__":
    main()
