"""Elements and vectors of REBOUND, the reference values of tests/orbit/elements_agree_with_rebound.rs.

    python3 -m venv venv && venv/bin/pip install -r benches/peers/orbit_requirements.txt
    venv/bin/python benches/peers/orbit_elements_rebound.py

Prints, per body around a mass of 1 GM: a, e, inclination, node, argument of perihelion and true anomaly as given, the mean
anomaly, the position, and the velocity.
"""

import rebound

GM = 2.959122082322128e-4  # AU^3/day^2, orbit document, exercise 14to4

CASES = [  # a/AU, e, inclination, node, argument of perihelion, true anomaly (rad)
    (0.9993454, 0.0167, 0.05, 2.1, 1.3, 0.7),
    (5.2, 0.0489, 0.3, -1.2, 2.5, -2.2),
    (2.77, 0.2, 1.2, 0.4, -0.9, 1.9),
    (17.8, 0.967, 2.83, 1.0, 1.96, 0.6),
    (1.3, 0.7, 2.0, -2.5, -2.7, -1.1),
]


def main():
    for a, e, inclination, node, argument, anomaly in CASES:
        sim = rebound.Simulation()
        sim.G = 1.0
        sim.add(m=GM)
        sim.add(a=a, e=e, inc=inclination, Omega=node, omega=argument, f=anomaly)
        body = sim.particles[1]
        mean = body.orbit(primary=sim.particles[0]).M
        print([a, e, inclination, node, argument, anomaly], mean)
        print([body.x, body.y, body.z], [body.vx, body.vy, body.vz])


if __name__ == "__main__":
    main()
