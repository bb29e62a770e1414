"""Computes the headline numbers of every recording anew, from the recording alone, and compares with metrics.json.

Usage: python headline_numbers.py FOLDER ...    (packages: requirements.txt)

Each FOLDER holds recordings and the metrics.json that analyze-recordings wrote beside them. Nothing of the project's code is
used: the container is read by the PyPI package mcap, messages by the schemas in the file, sums are numpy's. Exit code 1 if
a number differs by more than 1e-9 of its scale.
"""

import json
import math
import sys
import tomllib
from pathlib import Path

import numpy
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

TOLERANCE = 1e-9
GM_SUN = 2.959122082322128e-4  # AU^3/day^2, orbit document, exercise 14to4


class Recording:
    """Clock, state and scalar messages of every frame."""

    def __init__(self, path):
        self.times, self.states, self.messages = [], [], {}
        with open(path, "rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            attachments = {found.name: found.data for found in reader.iter_attachments()}
            self.manifest = tomllib.loads(attachments["manifest.toml"].decode())
            for _, channel, _, decoded in reader.iter_decoded_messages(log_time_order=False):
                if channel.topic == "/frame":
                    self.times.append(decoded.time)
                elif channel.topic == "/state":
                    names = [field.name for field in decoded.fields]
                    rows = numpy.frombuffer(decoded.data, dtype="<f8").reshape(-1, len(names))
                    self.states.append(dict(zip(names, rows.T)))
                elif channel.schema_id and "energy" in channel.topic or channel.topic in ("/collisions", "/pressure"):
                    self.messages.setdefault(channel.topic, []).append(decoded)


def dem(recording, model):
    gravity = model["gravity_m_per_s2"]
    radius = model["radius_m"]
    mean_radius = (radius["min"] + radius["max"]) / 2 if isinstance(radius, dict) else radius

    def mechanical_energy(state):
        mass = model["mass_kg"] * (state["radius"] / mean_radius) ** 2
        x, y, r = state["x"], state["y"], state["radius"]
        kinetic = 0.5 * mass * (state["vx"] ** 2 + state["vy"] ** 2)
        potential = -mass * (gravity[0] * x + gravity[1] * y)
        walls = [r - x, r - (model["width_m"] - x), r - y, r - (model["height_m"] - y)]
        overlaps = [numpy.maximum(overlap, 0.0) for overlap in walls]
        for i in range(len(x) - 1):
            apart = numpy.hypot(x[i + 1 :] - x[i], y[i + 1 :] - y[i])
            overlaps.append(numpy.maximum(r[i] + r[i + 1 :] - apart, 0.0))
        elastic = 0.5 * model["stiffness_n_per_m"] * sum(float((o**2).sum()) for o in overlaps)
        return float(kinetic.sum() + potential.sum()) + elastic

    start, end = mechanical_energy(recording.states[0]), mechanical_energy(recording.states[-1])
    dissipated = recording.messages["/energy"][-1].dissipated_j
    return {
        "energy.total_change_relative": (end - start) / abs(start),
        "energy.residual_relative": (end + dissipated - start) / abs(start),
    }


def gas(recording, model):
    state = recording.states[-1]
    square = state["vx"] ** 2 + state["vy"] ** 2
    speed = numpy.sqrt(square)
    area = math.pi * model["radius_m"] ** 2
    particles, mass = len(square), model["mass_kg"]
    impulse = sum(message.wall_impulse_n_s for message in recording.messages["/pressure"])
    return {
        "pressure.measured": impulse / (2 * math.pi * model["radius_m"] * recording.times[-1]),
        "pressure.mean_speed_formula": particles * mass * speed.mean() ** 2 / (2 * area),
        "pressure.mean_square_formula": particles * mass * square.mean() / (2 * area),
        "mean_speed": speed.mean(),
        "rms_speed": math.sqrt(square.mean()),
    }


def packing(recording, model):
    def moments(state):
        square = state["vx"] ** 2 + state["vy"] ** 2
        return square.mean(), (square**2).mean()

    first, _ = moments(recording.states[0])
    last, fourth = moments(recording.states[-1])
    collisions = recording.messages["/collisions"][-1]
    return {
        "temperature.initial": first,
        "temperature.final": last,
        "temperature.final_over_initial": last / first,
        "a2.final": fourth / (2 * last**2) - 1,
        "collision_rate": 2 * collisions.pair / (len(recording.states[-1]["x"]) * recording.times[-1]),
    }


def orbit(recording, model):
    def vectors(state):
        return tuple(numpy.array([state[name][0] for name in names]) for names in ("x y z".split(), "vx vy vz".split()))

    def energy(r, v):
        return v @ v / 2 - GM_SUN / math.sqrt(r @ r)

    (r0, v0), (r, v) = vectors(recording.states[0]), vectors(recording.states[-1])
    momentum0, momentum = (math.sqrt(c @ c) for c in (numpy.cross(r0, v0), numpy.cross(r, v)))
    exact = kepler(r0, v0, recording.times[-1])
    return {
        "energy.drift_relative": (energy(r, v) - energy(r0, v0)) / abs(energy(r0, v0)),
        "angular_momentum.drift_relative": (momentum - momentum0) / momentum0,
        "position_error.final": math.sqrt((r - exact) @ (r - exact)),
    }


def kepler(r0, v0, time):
    """The ellipse through (r0, v0), by Lagrange's f and g with the change of the eccentric anomaly."""
    radius = math.sqrt(r0 @ r0)
    axis = 1 / (2 / radius - v0 @ v0 / GM_SUN)
    motion = math.sqrt(GM_SUN / axis**3)
    cosine, sine = 1 - radius / axis, (r0 @ v0) / math.sqrt(GM_SUN * axis)
    mean = motion * time
    change = mean
    for _ in range(50):
        value = change - cosine * math.sin(change) + sine * (1 - math.cos(change)) - mean
        change -= value / (1 - cosine * math.cos(change) + sine * math.sin(change))
    f = 1 - axis / radius * (1 - math.cos(change))
    g = time + (math.sin(change) - change) / motion
    return f * r0 + g * v0


# Numbers that are differences of larger ones are compared on the larger one's scale.
SCALES = {name: 1.0 for name in (
    "energy.total_change_relative", "energy.residual_relative", "energy.drift_relative",
    "angular_momentum.drift_relative", "position_error.final", "a2.final",
)}


def check(folder):
    metrics = json.loads((folder / "metrics.json").read_text())
    reported = {}
    for metric in metrics["metrics"]:
        if "file" in metric.get("run", {}) :
            reported.setdefault(metric["run"]["file"], {})[metric["name"]] = metric["value"]
    worst, compared = 0.0, 0
    for file, values in reported.items():
        recording = Recording(folder / file)
        (name, model), = recording.manifest["model"].items()
        for metric, computed in globals()[name](recording, model).items():
            scale = SCALES.get(metric, abs(computed))
            apart = abs(values[metric] - computed) / scale
            if not apart <= TOLERANCE:
                sys.exit(f"{folder / file}: {metric} is {values[metric]!r}, here {computed!r}")
            worst, compared = max(worst, apart), compared + 1
    if compared == 0:
        sys.exit(f"{folder}: nothing to compare")
    print(f"{folder.name}: {compared} numbers of {len(reported)} recordings agree, the worst to {worst:.1e}")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    for folder in sys.argv[1:]:
        check(Path(folder))


if __name__ == "__main__":
    main()
