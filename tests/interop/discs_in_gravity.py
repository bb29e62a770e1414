"""Hard discs in gravity with 50 digits: moves all discs to each event and checks all pairs and walls again.

    python3 tests/interop/discs_in_gravity.py

prints x, y, vx, vy of each disc at the end, for the floors at rest and shaken, and the number of collisions. It shares no code and no
formula of a collision time with the program: roots are those of the textbook's quadratic formula.
"""

from decimal import Decimal as D
from decimal import getcontext

getcontext().prec = 50

RADIUS, HALF_WIDTH, HALF_HEIGHT, GRAVITY = D(1), D(5), D(5), D("0.3")
START = [("-2.5", "-3.25", "0.75", "0.5"), ("1.5", "-2", "-1.25", "1.5"), ("0.25", "2.5", "0.5", "-0.25")]
NEVER = D("1e30")


def roots(a, b, c):
    """Real roots of a t^2 + b t + c."""
    if a == 0:
        return [-c / b] if b != 0 else []
    inner = b * b - 4 * a * c
    return [(-b - inner.sqrt()) / (2 * a), (-b + inner.sqrt()) / (2 * a)] if inner >= 0 else []


class AtRest:
    end = NEVER

    def arcs(self, now):
        yield now, NEVER, (D(0), D(0), D(0))


class Shaken:
    """Height S/2 (1 - cos) with each half of the wave replaced by a parabola."""

    def __init__(self, stroke, period):
        self.period, self.acceleration, self.stroke = period, 16 * stroke / (period * period), stroke

    def arcs(self, now):
        """Start, end and height, velocity and acceleration at the start of each arc from now on."""
        number = int((2 * now / self.period + D("0.5")) // 1)
        start = now
        while True:
            middle, end = number * self.period / 2, (number + D("0.5")) * self.period / 2
            sign = 1 if number % 2 == 0 else -1
            lag = start - middle
            height = (0 if sign == 1 else self.stroke) + sign * self.acceleration * lag * lag / 2
            yield start, end, (height, sign * self.acceleration * lag, sign * self.acceleration)
            start, number = end, number + 1


def first_positive(candidates, still_approaches):
    times = [time for time in candidates if time > D("1e-40") and still_approaches(time)]
    return min(times, default=NEVER)


def time_to_floor(disc, floor, now):
    """Time until the lowest point of a disc meets the floor, and the velocity of the floor there."""
    x, y, vx, vy = disc
    for start, end, (height, speed, acceleration) in floor.arcs(now):
        since = start - now
        gap = y - GRAVITY * since * since / 2 + vy * since - RADIUS + HALF_HEIGHT - height
        relative, change = vy - GRAVITY * since - speed, -GRAVITY - acceleration
        # At a collision that was just executed, the gap is zero and the disc leaves.
        found = roots(change / 2, relative, gap)
        found = [t for t in found if t > D("-1e-40") and relative + change * t < 0]
        if found and start + min(found) <= end:
            lag = min(found)
            return since + lag, speed + acceleration * lag
    return NEVER, D(0)


def run(floor, restitution, duration):
    discs = [[D(value) for value in disc] for disc in START]
    now, collisions = D(0), 0
    while True:
        events = [(duration - now, "end", 0, 0)]
        for i, (x, y, vx, vy) in enumerate(discs):
            if vx != 0:
                events.append((((HALF_WIDTH - RADIUS) * (1 if vx > 0 else -1) - x) / vx, "side", i, 0))
            lag, speed = time_to_floor(discs[i], floor, now)
            events.append((lag, "floor", i, speed))
            top = [t for t in roots(-GRAVITY / 2, vy, y - HALF_HEIGHT + RADIUS) if t > 0 and vy - GRAVITY * t > 0]
            events.extend((time, "ceiling", i, 0) for time in top)
            for j in range(i):
                r = [discs[i][k] - discs[j][k] for k in (0, 1)]
                g = [discs[i][k] - discs[j][k] for k in (2, 3)]
                dot = r[0] * g[0] + r[1] * g[1]
                found = roots(g[0] ** 2 + g[1] ** 2, 2 * dot, r[0] ** 2 + r[1] ** 2 - 4 * RADIUS**2)
                if dot < 0 and found:
                    events.append((min(found), "pair", i, j))
        lag, kind, i, other = min(events, key=lambda event: event[0])
        now += lag
        for disc in discs:
            disc[0] += disc[2] * lag
            disc[1] += disc[3] * lag - GRAVITY * lag * lag / 2
            disc[3] -= GRAVITY * lag
        if kind == "end":
            return discs, collisions
        collisions += 1
        if kind == "side":
            discs[i][2] = -discs[i][2]
        elif kind == "ceiling":
            discs[i][3] = -discs[i][3]
        elif kind == "floor":
            discs[i][3] = 2 * other - discs[i][3]
        else:
            one, two = discs[i], discs[other]
            r = [two[k] - one[k] for k in (0, 1)]
            g = [two[k] - one[k] for k in (2, 3)]
            factor = (1 + restitution) / 2 * (r[0] * g[0] + r[1] * g[1]) / (r[0] ** 2 + r[1] ** 2)
            for k in (0, 1):
                one[k + 2] += factor * r[k]
                two[k + 2] -= factor * r[k]


if __name__ == "__main__":
    # A difference at the start grows a thousand times in 20 units of time above the floor at rest, and in 14 above the shaken one.
    for name, floor, restitution, end in [
        ("at rest", AtRest(), D(1), D(20)),
        ("at rest, restitution 0.75", AtRest(), D("0.75"), D(20)),
        ("shaken", Shaken(D("0.5"), D(2)), D("0.75"), D(14)),
    ]:
        for duration in (D(10), end):
            discs, collisions = run(floor, restitution, duration)
            print(f"floor {name}, time {duration}, {collisions} collisions")
            for disc in discs:
                print("   ", ", ".join(f"{value:.17e}" for value in disc))
