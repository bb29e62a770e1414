"""Steps a second of REBOUND on the orbit document's start: a massless body about the Sun, a quarter of a day a step.

    python3 -m venv venv && venv/bin/pip install -r benches/peers/orbit_requirements.txt
    venv/bin/python benches/peers/orbit_rebound.py [leapfrog|whfast|ias15] [steps]

Prints millions of steps a second, the best of five, and where the body is.
"""

import sys
import time

import rebound

GM = 2.959122082322128e-4  # AU^3/day^2, orbit document, exercise 14to4
STEP = 0.25  # days


def simulation(integrator):
    sim = rebound.Simulation()
    sim.G = GM
    sim.integrator = integrator
    sim.dt = STEP
    sim.add(m=1.0)
    sim.add(
        m=0.0,
        x=-1.813068419866209e-1,
        y=9.642197733507970e-1,
        z=-6.850809238551276e-5,
        vx=-1.718334419397708e-2,
        vy=-3.209800047122614e-3,
        vz=6.736104268755766e-9,
    )
    return sim


def main():
    integrator = sys.argv[1] if len(sys.argv) > 1 else "leapfrog"
    steps = int(sys.argv[2]) if len(sys.argv) > 2 else 1_461_000
    best, where = 0.0, None
    for _ in range(5):
        sim = simulation(integrator)
        begin = time.perf_counter()
        sim.steps(steps)
        best = max(best, steps / (time.perf_counter() - begin))
        where = sim.particles[1].xyz
    print(f"rebound {rebound.__version__} {integrator}: {best / 1e6:.2f} M steps/s, at {where}")


if __name__ == "__main__":
    main()
