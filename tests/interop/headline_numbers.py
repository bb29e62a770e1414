"""Recomputes the headline numbers of every recording from the recording only and compares them with metrics.json.

Usage: python headline_numbers.py FOLDER ...    (packages: requirements.txt)

Each FOLDER contains recordings and the metrics.json that analyze-recordings wrote next to them. No code of the project is used:
the PyPI package mcap reads the container, the schemas in the file decode the messages, and numpy computes the sums. Exit code 1 if
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
SCHEMA = 3
GM_SUN = 2.959122082322128e-4  # AU^3/day^2, orbit exercise 14to4


class Recording:
    """Clock, state and scalar messages of every frame."""

    def __init__(self, path):
        self.times, self.events, self.states, self.messages = [], [], [], {}
        particles = {}
        with open(path, "rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            attachments = {found.name: found.data for found in reader.iter_attachments()}
            self.manifest = tomllib.loads(attachments["manifest.toml"].decode())
            for _, channel, _, decoded in reader.iter_decoded_messages(log_time_order=False):
                if channel.topic == "/frame":
                    self.times.append(decoded.time)
                elif channel.topic in ("/particles", "/state"):
                    names = [field.name for field in decoded.fields]
                    rows = numpy.frombuffer(decoded.data, dtype="<f8").reshape(-1, len(names))
                    columns = dict(zip(names, rows.T))
                    if channel.topic == "/particles":
                        particles = columns
                    else:
                        self.states.append({**columns, **particles})
                elif channel.topic in ("/energy", "/collisions", "/pressure", "/contact_statistics", "/contact_forces", "/speeds", "/energy_balance"):
                    self.messages.setdefault(channel.topic, []).append(decoded)
                if channel.topic == "/frame":
                    self.events.append(decoded.step_or_event_count)


def dem(recording, model):
    gravity = model["gravity_m_per_s2"]

    def mechanical_energy(state, energy):
        mass = state["mass"]
        x, y, r = state["x"], state["y"], state["radius"]
        kinetic = 0.5 * mass * (state["vx"] ** 2 + state["vy"] ** 2 + 0.5 * (r * state["spin"]) ** 2)
        potential = -mass * (gravity[0] * x + gravity[1] * y)
        if in_a_scene:
            return float(kinetic.sum() + potential.sum()) + energy.elastic_j
        walls = [r - x, r - (model["width_m"] - x), r - y, r - (model["height_m"] - y)]
        overlaps = [numpy.maximum(overlap, 0.0) for overlap in walls]
        for i in range(len(x) - 1):
            apart = numpy.hypot(x[i + 1 :] - x[i], y[i + 1 :] - y[i])
            overlaps.append(numpy.maximum(r[i] + r[i + 1 :] - apart, 0.0))
        elastic = 0.5 * model["stiffness_n_per_m"] * sum(float((o**2).sum()) for o in overlaps)
        return float(kinetic.sum() + potential.sum()) + elastic

    # Tangential springs and walls of any shape are not in the state; in these cases, the elastic energy is read from the channel.
    in_a_scene = model["friction"] > 0 or model["walls"] or model["periodic"] != "none"
    energies = recording.messages["/energy"]
    start = mechanical_energy(recording.states[0], energies[0])
    end = mechanical_energy(recording.states[-1], energies[-1])
    last = energies[-1]
    start += last.entered_j
    elsewhere = last.dissipated_j + last.removed_j - last.wall_work_j
    state = recording.states[-1]
    area = math.pi * state["radius"] ** 2
    covered, width = area.sum(), model["width_m"]
    numbers = {
        "energy.total_change_relative": (end - start) / abs(start),
        "energy.residual_relative": (end + elsewhere - start) / abs(start),
        "packing_fraction": covered / (width * model["height_m"]),
        "max_overlap_over_radius": max(
            message.max_overlap_over_radius for message in recording.messages["/contact_statistics"]
        ),
        "coordination_number": recording.messages["/contact_statistics"][-1].coordination_number,
    }
    has_floor = model["periodic"] in ("none", "x") and gravity[1] < 0
    if len(area) > 1 and has_floor:
        height = 2 * (area * state["y"]).sum() / covered
        floor = model["stiffness_n_per_m"] * numpy.maximum(state["radius"] - state["y"], 0).sum()
        sides = numpy.maximum(state["radius"] - state["x"], 0) + numpy.maximum(state["radius"] + state["x"] - width, 0)
        numbers |= {
            "bed.height": height,
            "bed.packing_fraction": covered / (width * height),
            "floor.force": floor,
        }
        floor_wall = level_floor(model)
        if "/contact_forces" in recording.messages and floor_wall is not None:
            numbers |= stress(recording, model, floor_wall)
        if model["periodic"] == "none":
            numbers["side_wall.stress"] = model["stiffness_n_per_m"] * sides.sum() / (2 * height)
    elif gravity[0] == 0 and has_floor and not model.get("insertion"):
        numbers |= rebounds(recording, model, -gravity[1])
    return numbers


def level_floor(model):
    """Height of the floor by time: that of the box, or of the only wall if it is level and as wide as the box; None for other scenes."""
    if not model["walls"]:
        return lambda time: 0.0
    wall = model["walls"][0]
    ends = wall.get("from_m", [0, 0]), wall.get("to_m", [0, 1])
    spans = min(ends)[0] <= 0 and max(ends)[0] >= model["width_m"]
    if len(model["walls"]) > 1 or ends[0][1] != ends[1][1] or not spans:
        return None

    def height(time):
        begin, end = wall.get("moves_s", (0.0, math.inf))
        clock = min(max(time, begin), end) - begin
        swing = math.sin(2 * math.pi * wall["frequency_hz"] * clock)
        return ends[0][1] + wall["velocity_m_per_s"][1] * clock + wall["amplitude_m"][1] * swing

    return height


def stress(recording, model, floor):
    """Love's and Weber's stress in layers of a mean diameter over the last tenth of the run. The part of each branch in a layer is the part below
    its top minus the part below its bottom."""
    radius = model["radius_m"]
    if isinstance(radius, dict):
        radius = radius["mean"] if "mean" in radius else (radius["min"] + radius["max"]) / 2
    thickness = max(2 * radius, model["height_m"] / 200)
    edges = thickness * numpy.arange(math.ceil(model["height_m"] / thickness) + 1)
    width, down = model["width_m"], -model["gravity_m_per_s2"][1]
    frames = []
    for time, state, forces in zip(recording.times, recording.states, recording.messages["/contact_forces"]):
        if time < 0.9 * model["duration_s"]:
            continue
        column = {name: numpy.array(getattr(forces, name)) for name in
                  ("from_x_m", "from_y_m", "to_x_m", "to_y_m", "force_x_n", "force_y_n")}
        ends = numpy.array([column["from_y_m"], column["to_y_m"]]) - floor(time)
        low, high = ends.min(0), ends.max(0)
        length = numpy.maximum(high - low, 1e-300)
        below = numpy.clip((edges[:, None] - low) / length, 0, 1)
        below[0], below[-1] = 0, 1
        share = numpy.diff(below, axis=0)
        height, mass = state["y"] - floor(time), state["mass"]
        layer = numpy.clip((height // thickness).astype(int), 0, len(edges) - 2)
        tensor = []
        for force, ends_of, speed in (
            (column["force_x_n"], (column["from_x_m"], column["to_x_m"]), state["vx"]),
            (column["force_y_n"], (column["from_y_m"], column["to_y_m"]), state["vy"]),
        ):
            sums = [numpy.bincount(layer, weights, len(edges) - 1) for weights in (mass, mass * speed)]
            flow = sums[1] / numpy.where(sums[0] > 0, sums[0], 1)
            kinetic = numpy.bincount(layer, mass * (speed - flow[layer]) ** 2, len(edges) - 1)
            tensor.append((share @ (force * (ends_of[0] - ends_of[1])) + kinetic) / (width * thickness))
        above = [(mass * down * numpy.clip((height - edge) / thickness, 0, 1)).sum() / width for edge in edges[:-1]]
        frames.append((*tensor, numpy.array(above)))
    if not frames:
        return {}
    horizontal, vertical, weight = (numpy.mean(columns, axis=0) for columns in zip(*frames))
    used = weight > 0
    whole = (recording.states[-1]["mass"] * down).sum() / width
    mid = int(numpy.argmax(weight <= whole / 2))
    numbers = {
        "stress.vertical_at_floor": vertical[0],
        "stress.lateral_ratio": numpy.mean([frame[0].sum() / frame[1].sum() for frame in frames]),
        "stress.overburden_deviation": numpy.abs(vertical - weight)[used].max() / whole,
    }
    if used[mid]:
        numbers["stress.vertical_at_mid_height"] = vertical[mid]
    return numbers


def rebounds(recording, model, gravity):
    """Restitution and contact time of one disc from its parabolas before and after each rebound that lasts several frames."""
    restitutions, durations, falling = [], [], None
    for time, state in zip(recording.times, recording.states):
        gap, velocity = state["y"][0] - state["radius"][0], state["vy"][0]
        if gap < 0:
            continue
        energy = velocity**2 / 2 + gravity * gap
        if velocity <= 0:
            falling = time, velocity, energy
        elif falling:
            fell, before_velocity, before = falling
            falling = None
            sag = model["mass_kg"] * gravity / model["stiffness_n_per_m"]
            if time - fell < 2 * math.sqrt(2 * energy) / gravity and before > 1e4 * gravity * sag:
                restitutions.append(math.sqrt(energy / before))
                touch = fell + (math.sqrt(2 * before) + before_velocity) / gravity
                durations.append(time - (math.sqrt(2 * energy) - velocity) / gravity - touch)
    if not restitutions:
        return {}
    return {
        "restitution.measured": sum(restitutions) / len(restitutions),
        "contact_duration.measured": sum(durations) / len(durations),
    }


def gas(recording, model):
    state, center = recording.states[-1], model["center_m"]
    ledger = recording.messages.get("/energy_balance")
    radius = ledger[-1].radius_m if ledger else model["radius_m"]
    # Particles that left through an opening continue outside.
    left = "orifice_width_m" in model
    inside = numpy.hypot(state["x"] - center[0], state["y"] - center[1]) <= radius * (1 + 1e-9)
    kept = inside if left else numpy.ones(len(inside), bool)
    square = (state["vx"] ** 2 + state["vy"] ** 2)[kept]
    speed = numpy.sqrt(square)
    area = math.pi * radius**2
    particles, mass = len(square), model["mass_kg"]
    impulse = sum(message.wall_impulse_n_s for message in recording.messages["/pressure"])
    boltzmann = {"codata-1986": 1.380658e-23, "si-2019": 1.380649e-23}[model["boltzmann_constant"]]
    hits = recording.messages["/collisions"][-1].wall_collisions
    speeds = recording.messages["/speeds"][-1]
    centers, density = numpy.array(speeds.speed_m_per_s), numpy.array(speeds.density)
    width = centers[1] - centers[0]
    numbers = {
        "temperature.mean_square": mass * square.mean() / (2 * boltzmann),
        "temperature.mean_speed": mass * speed.mean() ** 2 / (2 * boltzmann),
        "wall_collision_rate": hits / recording.times[-1],
        "speed_histogram.total_variation_distance": numpy.abs(density - numpy.array(speeds.maxwell)).sum() * width / 2,
        "pressure.measured": impulse / (2 * math.pi * model["radius_m"] * recording.times[-1]),
        "pressure.mean_speed_formula": particles * mass * speed.mean() ** 2 / (2 * area),
        "pressure.mean_square_formula": particles * mass * square.mean() / (2 * area),
        "mean_speed": speed.mean(),
        "rms_speed": math.sqrt(square.mean()),
    }
    if not left and "additional_masses_kg" not in model:
        numbers["mean_speed_over_rms"] = speed.mean() / math.sqrt(square.mean())
        numbers["a2"] = (square**2).mean() / (2 * square.mean() ** 2) - 1
    if not left and not model.get("wall_speed_m_per_s"):
        distance = numpy.hypot(state["x"] - center[0], state["y"] - center[1])
        numbers["fraction_within_half_radius"] = (distance < model["radius_m"] / 2).mean()
    if "disc_radius_m" in model:
        collisions = recording.messages["/collisions"]
        time = recording.times[-1]
        half = next(index for index, at in enumerate(recording.times) if 2 * at >= time)
        pairs = collisions[-1].pair_collisions - collisions[half].pair_collisions
        numbers["pair_collision_rate_per_disc"] = 2 * pairs / particles / (time - recording.times[half])
        energy = recording.messages["/energy"][-1].kinetic_j
        numbers["compressibility_factor"] = 1 + collisions[-1].pair_virial_sum_j_s / (2 * energy * time)
    if "additional_masses_kg" in model:
        # The state does not contain the masses of the particles.
        masses_matter = ("temperature.mean_square", "temperature.mean_speed", "pressure.mean_speed_formula")
        for name in (*masses_matter, "pressure.mean_square_formula"):
            del numbers[name]
    if model.get("wall_speed_m_per_s"):
        # The average is over a wall whose length changes between the frames.
        del numbers["pressure.measured"]
    return numbers


def packing(recording, model):
    def moments(state):
        square = state["vx"] ** 2 + state["vy"] ** 2
        return square.mean(), (square**2).mean()

    first, _ = moments(recording.states[0])
    last, fourth = moments(recording.states[-1])
    collisions = recording.messages["/collisions"][-1]
    pressure = recording.messages["/pressure"]
    begin, state = recording.states[0], recording.states[-1]
    moved = ((state["x"] - begin["x"]) ** 2 + (state["y"] - begin["y"]) ** 2)[:1000]
    product = (state["vx"] * begin["vx"] + state["vy"] * begin["vy"])[:1000]
    square = (begin["vx"] ** 2 + begin["vy"] ** 2)[:1000]
    virial = pressure[-1].collision_virial_sum / pressure[-1].kinetic_energy_time_integral / 2
    numbers = {
        "mean_square_displacement.final": moved.mean(),
        "velocity_autocorrelation.final": product.sum() / square.sum(),
        "compressibility_factor": 1 + virial,
        "wall_collision_rate_per_disc": collisions.wall_collisions / (len(state["x"]) * recording.times[-1]),
        "mean_square_velocity.initial": first,
        "mean_square_velocity.final": last,
        "temperature.initial": first / 2,
        "temperature.final": last / 2,
        "temperature.final_over_initial": last / first,
        "a2.final": fourth / (2 * last**2) - 1,
        "pair_collision_rate_per_disc": 2 * collisions.pair_collisions / (len(recording.states[-1]["x"]) * recording.times[-1]),
    }
    if model["boundary"] == "periodic":
        # Periodic images are covered by the law tests. There are no walls.
        del numbers["mean_square_displacement.final"]
        del numbers["wall_collision_rate_per_disc"]
        return numbers
    return structure(recording, model) | numbers


def structure(recording, model):
    """psi6 and g near contact over the sampled frames, computed for each pair."""
    count, diameter = model["discs"], 2 * model["radius"]
    a, b = model["width"] - diameter, model["height"] - diameter
    if count < 2 or min(a, b) < 2 * diameter:
        return {}
    stride = -(-count // 32)
    sampled = [
        state
        for index, (events, state) in enumerate(zip(recording.events, recording.states))
        if events >= 5 * count and index % stride == 0
    ] or recording.states[-1:]

    def pairs_within(r):
        return (math.pi * a * b - 4 / 3 * (a + b) * r + r**2 / 2) * r**2 / (a * b) ** 2

    at_random = count * (count - 1) / 2 * (pairs_within(1.1 * diameter) - pairs_within(diameter))
    whole, local, near = [], [], []
    for state in sampled:
        dx, dy = (numpy.subtract.outer(state[name], state[name]) for name in "xy")
        distance = numpy.hypot(dx, dy)
        bonds = (distance < 1.5 * diameter) & ~numpy.eye(count, dtype=bool)
        turned = numpy.where(bonds, numpy.exp(6j * numpy.arctan2(dy, dx)), 0).sum(axis=1)
        psi = turned / numpy.maximum(bonds.sum(axis=1), 1)
        whole.append(abs(psi.mean()))
        local.append(numpy.abs(psi).mean())
        near.append(((distance < 1.1 * diameter) & ~numpy.eye(count, dtype=bool)).sum() / 2 / at_random)
    return {
        "psi6.global": numpy.mean(whole),
        "psi6.local": numpy.mean(local),
        "pair_correlation.near_contact": numpy.mean(near),
    }


def bodies(recording, model):
    """Energy, angular momentum and return of bodies that attract each other, per total mass."""
    parameters = numpy.array([body["gm_au3_per_day2"] for body in model["bodies"]])
    shares = parameters / parameters.sum()

    def look(state):
        places = numpy.stack([state[name] for name in "xyz"], axis=1)
        velocities = numpy.stack([state[name] for name in ("vx", "vy", "vz")], axis=1)
        energy = (shares * (velocities**2).sum(axis=1)).sum() / 2
        for one in range(len(places)):
            for other in range(one):
                distance = math.sqrt(((places[one] - places[other]) ** 2).sum())
                energy -= shares[one] * parameters[other] / distance
        return places, velocities, energy, (shares[:, None] * numpy.cross(places, velocities)).sum(axis=0)

    looks = [look(state) for state in recording.states]
    places, velocities, energy, momentum = looks[0]
    lengths = [numpy.sqrt((vectors**2).sum(axis=1)) for vectors in (places, velocities)]
    scale = (shares * lengths[0] * lengths[1]).sum()
    turned = max(math.sqrt(((there - momentum) ** 2).sum()) for *_, there in looks)
    return {
        "energy.drift_relative": (looks[-1][2] - energy) / abs(energy),
        "energy.max_error_relative": max(abs((there - energy) / energy) for _, _, there, _ in looks),
        "angular_momentum.max_change_relative": turned / scale,
        "return_distance.final": numpy.sqrt(((looks[-1][0] - places) ** 2).sum(axis=1)).max(),
    }


def orbit(recording, model):
    if "bodies" in model:
        return bodies(recording, model)

    def vectors(state):
        return tuple(numpy.array([state[name][0] for name in names]) for names in ("x y z".split(), "vx vy vz".split()))

    def energy(r, v):
        return v @ v / 2 - GM_SUN / math.sqrt(r @ r)

    (r0, v0), (r, v) = vectors(recording.states[0]), vectors(recording.states[-1])
    momentum0, momentum = (math.sqrt(c @ c) for c in (numpy.cross(r0, v0), numpy.cross(r, v)))
    exact = kepler(r0, v0, recording.times[-1])
    states = [vectors(state) for state in recording.states]
    radii = [math.sqrt(place @ place) for place, _ in states]
    elements = recording.messages.get("/orbit", [])
    # The extremes are found within steps: frames alone bound them from one side.
    extremes = {"radius.min": elements[-1].min_radius_au, "radius.max": elements[-1].max_radius_au} if elements else {}
    if elements and not extremes["radius.min"] <= min(radii) <= max(radii) <= extremes["radius.max"]:
        raise SystemExit(f"frames leave the range of {extremes}: {min(radii)} to {max(radii)}")
    eccentricity0, eccentricity = (
        numpy.cross(velocity, numpy.cross(place, velocity)) / GM_SUN - place / math.sqrt(place @ place)
        for place, velocity in (states[0], states[-1])
    )
    change = eccentricity - eccentricity0
    return {
        "energy.max_error_relative": max(abs(energy(*state) / energy(r0, v0) - 1) for state in states),
        **extremes,
        "eccentricity_vector.change": math.sqrt(change @ change),
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


# Differences of larger numbers are compared on the scale of the larger number.
SCALES = {name: 1.0 for name in (
    "energy.total_change_relative", "energy.residual_relative", "energy.drift_relative",
    "angular_momentum.drift_relative", "position_error.final", "a2", "a2.final", "energy.max_error_relative",
    "stress.overburden_deviation", "eccentricity_vector.change", "angular_momentum.max_change_relative", "velocity_autocorrelation.final",
)}


def check(folder):
    metrics = json.loads((folder / "metrics.json").read_text())
    if metrics["schema"] != SCHEMA:
        sys.exit(f"{folder}: metrics.json has schema {metrics['schema']}, not {SCHEMA}")
    reported = {}
    for metric in metrics["metrics"]:
        if "run" in metric and metric["applicable"]:
            reported.setdefault(metric["run"]["file"], {})[metric["name"]] = metric["value"]
    worst, compared, without_state = 0.0, 0, 0
    for file, values in reported.items():
        recording = Recording(folder / file)
        if not recording.states:
            without_state += 1
            continue
        (name, model), = recording.manifest["model"].items()
        for metric, computed in globals()[name](recording, model).items():
            scale = SCALES.get(metric, abs(computed))
            if metric not in values:
                sys.exit(f"{folder / file}: {metric} is {computed!r} here, and not in metrics.json")
            apart = abs(values[metric] - computed) / scale if scale else abs(values[metric])
            if not apart <= TOLERANCE:
                sys.exit(f"{folder / file}: {metric} is {values[metric]!r}, here {computed!r}")
            worst, compared = max(worst, apart), compared + 1
    if compared == 0 and without_state == len(reported) > 0:
        print(f"{folder.name}: the manifest of {without_state} recordings leaves out the state")
        return
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
