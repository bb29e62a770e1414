#!/usr/bin/env python3
"""Explicit Euler for the orbit of the Earth, orbit exercise 14to4, implemented independently of Kinetoscope.

Plain Python 3, no packages. A float is an IEEE 754 double and math.sqrt is correctly rounded, so
the printed positions (17 digits) are the same on every machine. tests/orbit/euler_matches_independent_program.rs
contains them as constants.

Usage: python3 orbit_euler.py [duration in days, default 365.25] [time step in days ...]
"""

import math
import sys

GM = 2.959122082322128e-4  # AU^3/day^2
POSITION = (-1.813068419866209e-1, 9.642197733507970e-1, -6.850809238551276e-5)  # AU
VELOCITY = (-1.718334419397708e-2, -3.209800047122614e-3, 6.736104268755766e-9)  # AU/day


def explicit_euler(duration, dt):
    """Position after floor(duration / dt + 1e-9) steps: equations (14), (15) and (16) of the exercise."""
    x, y, z = POSITION
    u, v, w = VELOCITY
    for _ in range(math.floor(duration / dt + 1e-9)):
        r = math.sqrt((x * x + y * y) + z * z)
        k = -GM / ((r * r) * r)
        x, y, z, u, v, w = (
            x + u * dt,
            y + v * dt,
            z + w * dt,
            u + (k * x) * dt,
            v + (k * y) * dt,
            w + (k * z) * dt,
        )
    return x, y, z


if __name__ == "__main__":
    duration = float(sys.argv[1]) if len(sys.argv) > 1 else 365.25
    steps = [float(word) for word in sys.argv[2:]] or [1.0 / 24.0, 0.25, 0.5]
    for dt in steps:
        print(repr(dt), *map(repr, explicit_euler(duration, dt)))
