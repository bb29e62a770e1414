"""REBOUND's integrator IAS15 on the bodies of a recorded orbit experiment: the Sun and the outer planets.

Rein and Spiegel, MNRAS 446 (2015) 1424.
"""

import csv
import math
import subprocess
import tomllib

import rebound

YEARS = 100


def recorded(kinetoscope, folder, manifest):
    """Times and states of a run by the method of order 8, and its run key."""
    settings = [f"model.orbit.duration_days={YEARS * 365.25}", 'record.frames=5', 'model.orbit.integrator="dop853"']
    words = [word for setting in settings for word in ("--set", setting)]
    text = manifest.read_text().partition("[sweep]")[0].partition("[[sweep")[0].partition("[[checks]]")[0]
    path = folder / "cross_code_orbit.toml"
    # The answer and the picture name variants of the sweep.
    path.write_text("\n".join(line for line in text.splitlines() if not line.startswith(("name =", "answer =", "compare ="))))
    for command in (["run", "--quiet", "--force", "--output", folder, *words, path],
                    ["export", "--format", "csv", folder / "cross_code_orbit"]):
        subprocess.run([kinetoscope, *command], check=True, capture_output=True)
    tables = next((folder / "cross_code_orbit" / "export").iterdir())
    found = {}
    with (tables / "state.csv").open() as lines:
        for frame, time, _, *state in list(csv.reader(lines))[1:]:
            found.setdefault(frame, (float(time), []))[1].append([float(number) for number in state[:6]])
    return list(found.values()), tables.name.rsplit("__", 1)[1], tomllib.loads(path.read_text())["model"]["orbit"]["bodies"]


def simulation(bodies, states, factor):
    """The bodies in REBOUND; `factor` multiplies the mass of the second one."""
    simulation = rebound.Simulation()
    simulation.G = 1.0
    simulation.integrator = "ias15"
    for number, (body, state) in enumerate(zip(bodies, states, strict=True)):
        gm = body["gm_au3_per_day2"] * (factor if number == 1 else 1.0)
        simulation.add(m=gm, **dict(zip(("x", "y", "z", "vx", "vy", "vz"), state)))
    return simulation


def compare(kinetoscope, folder, manifest, factor=1.0):
    """One row per frame: time, and the largest distance of a body between the two programs."""
    frames, key, bodies = recorded(kinetoscope, folder, manifest)
    peer = simulation(bodies, frames[0][1], factor)
    rows = []
    for time, states in frames[1:]:
        peer.integrate(time, exact_finish_time=1)
        distance = max(math.dist(state[:3], particle.xyz) for state, particle in zip(states, peer.particles))
        rows.append((time, distance))
    return rows, key, rebound.__version__
