"""Enskog's self-diffusion coefficient of discs over its first approximation, for one to four Sonine polynomials.

    python3 -m venv venv && venv/bin/pip install numpy
    venv/bin/python benches/peers/disc_diffusion_sonine.py

The matrix of the linear Boltzmann operator in the functions v S_k(v^2 / 2), with associated Laguerre polynomials S_k of index 1, is a
mean over collisions of the products of their changes. It is evaluated by Monte Carlo; the ratios are exact to about 1e-4.
"""

import numpy as np

POLYNOMIALS = 4
COLLISIONS = 1_000_000
REPETITIONS = 20


def laguerre(order, x):
    values = [np.ones_like(x), 2 - x]
    for k in range(1, order):
        values.append(((2 * k + 2 - x) * values[k] - (k + 1) * values[k - 1]) / (k + 1))
    return values[order]


def function(order, velocity):
    return velocity * laguerre(order, (velocity**2).sum(1) / 2)[:, None]


def changes(generator):
    """Changes of the functions in collisions: the speed g of approach is weighted by the flux, g^2 exp(-g^2 / 4)."""
    center = generator.normal(size=(COLLISIONS, 2)) * np.sqrt(0.5)
    speed = np.sqrt(2 * generator.chisquare(3, COLLISIONS))
    angle = generator.uniform(0, 2 * np.pi, COLLISIONS)
    sine = generator.uniform(-1, 1, COLLISIONS)
    cosine = np.sqrt(1 - sine * sine)
    along = np.stack([np.cos(angle), np.sin(angle)], 1)
    across = np.stack([-along[:, 1], along[:, 0]], 1)
    normal = along * cosine[:, None] + across * sine[:, None]
    before = center + speed[:, None] * along / 2
    after = before - (speed * cosine)[:, None] * normal
    return [function(k, after) - function(k, before) for k in range(POLYNOMIALS)]


def main():
    generator = np.random.default_rng(1)
    matrix = np.zeros((POLYNOMIALS, POLYNOMIALS))
    for _ in range(REPETITIONS):
        found = changes(generator)
        matrix += [[(first * second).sum() for second in found] for first in found]
    for k in range(1, POLYNOMIALS + 1):
        print(k, np.linalg.inv(matrix[:k, :k])[0, 0] * matrix[0, 0])


if __name__ == "__main__":
    main()
