"""An independent event-driven program for hard discs: plain, O(N²) per event, with none of Kinetoscope's code or algorithms.

All discs are moved to each event. The collision times of all pairs are found anew by the textbook's quadratic formula, in a rectangle
(packing) or in a circle (gas). There are no cells, no queue and no local clocks.
"""

import csv
import math
import subprocess

PACKING = """name = "cross_code_packing"
seed = 3
[model.packing]
discs = {discs}
width = 16.0
height = 16.0
duration = {duration}
[record]
every_time = 1.0
channels = ["state", "collisions", "temperature"]
"""

GAS = """name = "cross_code_gas"
seed = 4
[model.gas]
particles = {discs}
disc_radius_m = 0.1
speed_distribution = "equal"
speeds_m_per_s = [1.0]
duration_s = {duration}
[record]
every_s = 0.5
channels = ["state", "collisions"]
"""


def first_root(a, b, c):
    """The smaller root of a t² + 2 b t + c = 0, or infinity if there is none or the pair moves apart."""
    discriminant = b * b - a * c
    if b >= 0 or discriminant < 0:
        return math.inf
    return (-b - math.sqrt(discriminant)) / a


class Discs:
    """Equal discs of mass 1 in a box of the given half sides, or in a circle."""

    def __init__(self, states, radius, half_sides=None, circle=None):
        self.states, self.radius, self.half_sides, self.circle = [list(state) for state in states], radius, half_sides, circle
        self.time, self.pairs, self.walls = 0.0, 0, 0

    def next_event(self):
        """The time to the next event, and the function that executes it."""
        best, event = math.inf, None
        for i, (x, y, vx, vy) in enumerate(self.states):
            wait, kind = self.wall_event(x, y, vx, vy)
            if wait < best:
                best, event = wait, (i, kind)
            for j in range(i + 1, len(self.states)):
                other = self.states[j]
                rx, ry, gx, gy = other[0] - x, other[1] - y, other[2] - vx, other[3] - vy
                wait = first_root(gx * gx + gy * gy, rx * gx + ry * gy, rx * rx + ry * ry - 4 * self.radius**2)
                if wait < best:
                    best, event = wait, (i, j)
        return max(best, 0.0), event

    def wall_event(self, x, y, vx, vy):
        if self.circle is not None:
            a, b, c = vx * vx + vy * vy, x * vx + y * vy, x * x + y * y - (self.circle - self.radius) ** 2
            return (-b + math.sqrt(max(b * b - a * c, 0.0))) / a, "circle"
        waits = []
        for place, speed, half, axis in ((x, vx, self.half_sides[0], "x"), (y, vy, self.half_sides[1], "y")):
            if speed:
                waits.append((((half - self.radius) * math.copysign(1, speed) - place) / speed, axis))
        return min(waits)

    def execute(self, event):
        i, other = event
        state = self.states[i]
        if other == "circle":
            x, y, vx, vy = state
            factor = 2 * (x * vx + y * vy) / (x * x + y * y)
            state[2:] = vx - factor * x, vy - factor * y
            self.walls += 1
        elif isinstance(other, str):
            state[2 if other == "x" else 3] *= -1
            self.walls += 1
        else:
            second = self.states[other]
            rx, ry = second[0] - state[0], second[1] - state[1]
            factor = ((second[2] - state[2]) * rx + (second[3] - state[3]) * ry) / (rx * rx + ry * ry)
            state[2], state[3] = state[2] + factor * rx, state[3] + factor * ry
            second[2], second[3] = second[2] - factor * rx, second[3] - factor * ry
            self.pairs += 1

    def drift(self, time):
        for state in self.states:
            state[0] += state[2] * time
            state[1] += state[3] * time
        self.time += time

    def advance(self, until):
        """Moves the discs to a time, event by event."""
        while True:
            wait, event = self.next_event()
            if self.time + wait > until:
                self.drift(until - self.time)
                return
            self.drift(wait)
            self.execute(event)


def frames(kinetoscope, folder, manifest, name):
    """Times, states and collision counts of a recorded run, all digits, and its run key."""
    path = folder / f"{name}.toml"
    path.write_text(manifest)
    for words in (["run", "--quiet", "--force", "--output", folder, path], ["export", "--format", "csv", folder / name]):
        subprocess.run([kinetoscope, *words], check=True, capture_output=True)
    tables = next((folder / name / "export").iterdir())
    with (tables / "collisions.csv").open() as text:
        counts = {row["frame"]: (int(row["pair_collisions"]), int(row["wall_collisions"])) for row in csv.DictReader(text)}
    found = {}
    with (tables / "state.csv").open() as text:
        for frame, time, _, *state in list(csv.reader(text))[1:]:
            found.setdefault(frame, (float(time), []))[1].append([float(number) for number in state[:4]])
    return [(time, states, counts[frame]) for frame, (time, states) in found.items()], tables.name.rsplit("__", 1)[1]


def compare(kinetoscope, folder, model, discs, duration, wrong=1.0):
    """One row per frame: time, counts of both programs, and the largest distance of a disc; `wrong` scales the radius."""
    manifest = (PACKING if model == "packing" else GAS).format(discs=discs, duration=duration)
    recorded, key = frames(kinetoscope, folder, manifest, f"cross_code_{model}")
    shape = {"half_sides": (8.0, 8.0)} if model == "packing" else {"circle": 1.0}
    program = Discs(recorded[0][1], (1.0 if model == "packing" else 0.1) * wrong, **shape)
    rows = []
    for time, states, counts in recorded[1:]:
        program.advance(time)
        distance = max(math.dist(ours[:2], theirs[:2]) for ours, theirs in zip(states, program.states))
        rows.append((time, counts, (program.pairs, program.walls), distance))
    return rows, key, manifest
