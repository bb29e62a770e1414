"""The steps of `benches/gas_speed.rs` in numpy: N particles, R = 1, v_max = 1, dt = 0.02, one mirror a step, hits and impulse counted.

Run `python benches/peers/gas_numpy.py [N ...]` (needs numpy); prints particle-steps a second, best of five.
"""

import sys
import time

import numpy as np

TIME_STEP = 0.02
STEPS = 64


def start(particles, generator):
    distance = np.sqrt(generator.random(particles))
    angle = 2 * np.pi * generator.random(particles)
    speed = generator.random(particles)
    heading = 2 * np.pi * generator.random(particles)
    return (
        distance * np.cos(angle),
        distance * np.sin(angle),
        speed * np.cos(heading),
        speed * np.sin(heading),
    )


def step(x, y, vx, vy, hits, impulse):
    next_x = x + TIME_STEP * vx
    next_y = y + TIME_STEP * vy
    outside = np.nonzero(next_x * next_x + next_y * next_y > 1.0)[0]
    px, py, ux, uy = x[outside], y[outside], vx[outside], vy[outside]
    square = ux * ux + uy * uy
    along = px * ux + py * uy
    to_wall = (np.sqrt(along * along + square * (1.0 - (px * px + py * py))) - along) / square
    hit_x, hit_y = px + to_wall * ux, py + to_wall * uy
    twice = 2.0 * (ux * hit_x + uy * hit_y)
    ux, uy = ux - twice * hit_x, uy - twice * hit_y
    rest = TIME_STEP - to_wall
    next_x[outside], next_y[outside] = hit_x + rest * ux, hit_y + rest * uy
    vx[outside], vy[outside] = ux, uy
    return next_x, next_y, vx, vy, hits + len(outside), impulse + twice.sum()


def main():
    for particles in map(int, sys.argv[1:] or ["1000", "100000", "1000000"]):
        state = (*start(particles, np.random.default_rng(1)), 0, 0.0)
        best = float("inf")
        for _ in range(5):
            began = time.perf_counter()
            for _ in range(STEPS):
                state = step(*state)
            best = min(best, time.perf_counter() - began)
        print(f"N = {particles}: {particles * STEPS / best:.3g} particle-steps/s")


if __name__ == "__main__":
    main()
