"""A hard disc among fixed obstacles with 50 digits: moves it to each event and checks all obstacles and walls again.

    python3 tests/interop/discs_among_obstacles.py    # needs the package mpmath

prints x, y, vx, vy at the end, the numbers of collisions with obstacles and with walls, and the growth of a difference at the start. It shares no code
with the program: the roots of the polynomial of fourth degree are those of mpmath's simultaneous iteration (Durand and Kerner).
"""

from mpmath import mp, mpf, polyroots, sqrt

mp.dps = 50

RADIUS, HALF = mpf("0.5"), mpf(5)
OBSTACLES = [(mpf(x), mpf(y)) for x, y in [("-2.75", "-2.5"), ("2.75", "-2.75"), ("0.25", "2.25")]]
CONTACT = RADIUS + mpf("1.75")
START = ["-0.25", "-1.5", "0.625", "-0.25"]
NEVER = mpf("1e30")
# Two roots of a contact that was just left differ from zero by far less.
ROUNDING = mpf("1e-30")


def roots(coefficients):
    """Real roots; coefficients from the highest power on."""
    while coefficients and coefficients[0] == 0:
        coefficients = coefficients[1:]
    found = polyroots(coefficients, maxsteps=1000, extraprec=400) if len(coefficients) > 1 else []
    return [root.real for root in found if abs(root.imag) < mpf("1e-25")]


def time_to_obstacle(disc, gravity, center):
    x, y, vx, vy = disc
    x, y = x - center[0], y - center[1]
    fall = gravity / 2
    distance = [fall**2, -2 * fall * vy, vx**2 + vy**2 - 2 * fall * y, 2 * (x * vx + y * vy), x**2 + y**2 - CONTACT**2]

    def approaches(t):
        return (x + vx * t) * vx + (y + vy * t - fall * t * t) * (vy - 2 * fall * t) < 0

    times = [t for t in roots(distance) if (t > ROUNDING or (t > -ROUNDING and approaches(0))) and approaches(t)]
    return min(times, default=NEVER)


def time_to_wall(position, velocity, acceleration, line, sign):
    found = roots([acceleration / 2, velocity, position - line])
    return min([t for t in found if t > -ROUNDING and sign * (velocity + acceleration * t) > 0], default=NEVER)


def run(gravity, restitution, duration, start):
    disc, now, counts = [mpf(value) for value in start], mpf(0), {"obstacle": 0, "wall": 0}
    while True:
        events = [(duration - now, "end", 0)]
        for axis in (0, 1):
            for sign in (-1, 1):
                pull = -gravity if axis == 1 else mpf(0)
                time = time_to_wall(disc[axis], disc[2 + axis], pull, sign * (HALF - RADIUS), sign)
                events.append((time, "wall", axis))
        events += [(time_to_obstacle(disc, gravity, center), "obstacle", center) for center in OBSTACLES]
        lag, kind, which = min(events, key=lambda event: event[0])
        now += lag
        disc = [
            disc[0] + disc[2] * lag,
            disc[1] + disc[3] * lag - gravity * lag * lag / 2,
            disc[2],
            disc[3] - gravity * lag,
        ]
        if kind == "end":
            return disc, counts
        counts[kind] += 1
        if kind == "wall":
            disc[2 + which] = -disc[2 + which]
        else:
            n = [(disc[axis] - which[axis]) / CONTACT for axis in (0, 1)]
            along = disc[2] * n[0] + disc[3] * n[1]
            for axis in (0, 1):
                disc[2 + axis] -= (1 + restitution) * along * n[axis]


if __name__ == "__main__":
    for gravity, restitution, duration in [("0.3", "1", 12), ("0.3", "1", 28), ("0.3", "0.75", 40), ("0", "1", 70), ("0", "0.75", 200)]:
        disc, counts = run(mpf(gravity), mpf(restitution), mpf(duration), START)
        moved = [str(mpf(START[0]) + mpf("1e-25"))] + START[1:]
        other, _ = run(mpf(gravity), mpf(restitution), mpf(duration), moved)
        growth = sqrt(sum((a - b) ** 2 for a, b in zip(disc, other))) / mpf("1e-25")
        print(f"gravity {gravity}, restitution {restitution}, time {duration}: {counts}, growth {float(growth):.1e}")
        print("   ", ", ".join(mp.nstr(value, 18) for value in disc))
