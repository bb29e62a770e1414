"""Hashes every recorded number, so that a refactoring can show that it changed none.

Usage: python reference_numbers.py RECORDINGS > numbers.txt              (packages: requirements.txt)
       python reference_numbers.py --compare BEFORE.txt AFTER.txt

RECORDINGS holds one folder per experiment. Names take no part in a hash: of `/state` the columns as little-endian f64 are
hashed, of a scalar channel the values of each field (by its Protobuf tag), frame after frame; of metrics.json all values
as a multiset. The runs of an experiment are taken in the order of their hashes, because file names contain the run key.
Log lines and drawings are not numbers and are left out.

--compare prints the lines that differ and ends with exit code 1 if there are any. Topics and experiments that have been
renamed are matched by the table RENAMED below.
"""

import hashlib
import json
import struct
import sys
from pathlib import Path

RENAMED = {
    "/contacts": "/force_chains",
    "/contact_count": "/contact_statistics",
    "/energy_share": "/energy_percent",
    "/ledger": "/energy_balance",
    "dem_turning_drum": "dem_rotating_drum",
    "dem_document_damping": "dem_exercise_damping",
    "gas_adiabatic_piston": "gas_adiabatic_compression",
    "gas_document_temperature": "gas_exercise_temperature",
    "gas_hit_statistics": "gas_wall_collisions",
    "gas_literal_scheme": "gas_as_printed_scheme",
    "gas_warm_wall": "gas_thermal_wall",
    "orbit_document": "orbit_exercise",
}


def fields(payload):
    """Tag and raw bytes of each field of a Protobuf message."""
    at = 0

    def varint():
        nonlocal at
        value, shift = 0, 0
        while True:
            byte = payload[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(payload):
        key = varint()
        start = at
        if key & 7 == 0:
            value = struct.pack("<Q", varint())
        elif key & 7 == 1:
            at += 8
            value = payload[start:at]
        elif key & 7 == 5:
            at += 4
            value = payload[start:at]
        elif key & 7 == 2:
            length = varint()
            value = payload[at : at + length]
            at += length
        else:
            raise ValueError(f"wire type {key & 7} is not used by Kinetoscope's schemas")
        yield key >> 3, value


def recording_hashes(path):
    """Topic and field of every number of one recording, with the hash of its values in all frames."""
    from mcap.reader import make_reader

    hashes = {}
    with open(path, "rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            is_state = channel.topic in ("/particles", "/state")
            if not is_state and not schema.name.startswith("kinetoscope."):
                continue
            for tag, value in fields(message.data):
                # foxglove.PointCloud: tag 6 is `data`, the rows of the state.
                if is_state and tag != 6:
                    continue
                found = hashes.setdefault((channel.topic, tag), hashlib.sha256())
                found.update(struct.pack("<Q", len(value)) + value)
    return {name: found.digest() for name, found in hashes.items()}


def experiment_lines(folder):
    runs = [recording_hashes(path) for path in sorted(folder.glob("*.mcap"))]
    for topic in sorted({topic for run in runs for topic, _ in run}):
        tags = sorted({tag for run in runs for found, tag in run if found == topic})
        digests = []
        for tag in tags:
            of_runs = sorted(run.get((topic, tag), b"absent") for run in runs)
            digests.append(f"{tag}:{hashlib.sha256(b''.join(of_runs)).hexdigest()[:16]}")
        yield f"{folder.name} {topic} {len(runs)} " + " ".join(digests)
    report = folder / "metrics.json"
    if report.exists():
        for metric in json.loads(report.read_text())["metrics"]:
            value = metric["value"]
            yield f"{folder.name} metric {metric['name']} {value!r} {metric['standard_error']!r}"


def by_name(path):
    lines = {}
    for line in Path(path).read_text().splitlines():
        experiment, topic, rest = line.split(" ", 2)
        experiment = RENAMED.get(experiment, experiment)
        topic = RENAMED.get(topic, topic)
        if topic == "metric":
            name, numbers = rest.split(" ", 1)
            lines.setdefault((experiment, "metrics"), []).append(numbers)
        else:
            runs, *tags = rest.split()
            lines[(experiment, topic, "runs")] = runs
            for tag in tags:
                number, digest = tag.split(":")
                lines[(experiment, topic, number)] = digest
    return {name: sorted(found) if isinstance(found, list) else found for name, found in lines.items()}


def compare(before, after):
    old, new = by_name(before), by_name(after)
    differing = 0
    for name in sorted(old.keys() | new.keys(), key=str):
        if old.get(name) == new.get(name):
            continue
        differing += 1
        if name[-1] == "metrics":
            was, now = list(old.get(name, [])), list(new.get(name, []))
            for number in list(was):
                if number in now:
                    was.remove(number)
                    now.remove(number)
            print(name[0], "metrics:", "gone", was, "new", now)
        else:
            print(*name, old.get(name, "absent"), "->", new.get(name, "absent"))
    print(f"{len(old)} entries before, {len(new)} after, {differing} differ")
    return differing != 0


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "--compare":
        sys.exit(compare(sys.argv[2], sys.argv[3]))
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for folder in sorted(path for path in Path(sys.argv[1]).iterdir() if path.is_dir()):
        for line in experiment_lines(folder):
            print(line)


if __name__ == "__main__":
    main()
