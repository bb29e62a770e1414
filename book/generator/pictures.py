"""The pictures of a law: its quantity, drawn by the program; its deviations, drawn here; its first run, and the replay that it links to."""

import re
import shutil
import subprocess
from pathlib import Path
from xml.sax.saxutils import escape

from laws import SMALLEST_CONTROL, LawError

WIDTH, HEIGHT = 480, 372
LEFT, RIGHT, TOP, BOTTOM = 62, 468, 74, 316
# The largest deviation that is drawn to scale, in tolerances. Controls beyond it are at the border, with their number.
SCALE = 5.0
DARK, LAW, CONTROL, ACCEPTED = "#262626", "#6C1DC1", "#B34700", "#E7DDF5"
ENGINE = "kinetoscope-engine.js"
FILE_LINK = re.compile(r'<a href="\./[^"]*"[^>]*>(.*?)</a>', re.DOTALL)
REPLAY = 'class="replay"'


def kinds(law):
    """The files of a law that its page shows."""
    name = law["id"]
    return {"quantity": f"pictures/{name}_quantity.svg", "deviation": f"pictures/{name}_deviation.svg",
            "poster": f"pictures/{name}.png", "replay": f"replays/{name}.html"}


def draw(result, bin_folder, recordings, folder):
    """Draws all pictures of a measured law, and copies its report."""
    law, program = result.law, str(Path(bin_folder) / "kinetoscope")
    files = {kind: Path(folder) / name for kind, name in kinds(law).items()}
    for file in files.values():
        file.parent.mkdir(parents=True, exist_ok=True)
    runs = Path(recordings) / law["id"]
    first = min(runs.glob("*.mcap"))
    for words in (["plot", "--quiet", *law["plot"], "--width", str(WIDTH), "--height", str(HEIGHT), "--output", files["quantity"], runs],
                  ["export", "--quiet", "--thumbnail", files["poster"], first]):
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
        if done.returncode:
            raise LawError(f"{law['id']}: kinetoscope {words[0]}: exit code {done.returncode}\n{done.stderr}")
    files["deviation"].write_text(deviation_svg(result))
    report = (runs / "report.html").read_text()
    if REPLAY not in report:
        raise LawError(f"{law['id']}: its report has no replay")
    # The tables and plots next to a report are no part of the book.
    files["replay"].write_text(FILE_LINK.sub(r"\1", report))
    if (runs / ENGINE).exists():
        shutil.copyfile(runs / ENGINE, files["replay"].parent / ENGINE)


def ticks(points):
    """The name of the axis and the label of each point: a key and its values, if all points have the same one."""
    pairs = [point.label.split(", ")[0].partition(" = ") for point in points]
    if len({key for key, _, _ in pairs}) == 1 and all(value for _, _, value in pairs):
        return pairs[0][0], [value for _, _, value in pairs]
    return "", [point.label or "all runs" for point in points]


def text(x, y, words, size=13, anchor="middle", color=DARK, rotated=False):
    turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if rotated else ""
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-family="sans-serif" font-size="{size}" text-anchor="{anchor}" fill="{color}"{turn}>'
            f"{escape(words)}</text>")


def line(x1, y1, x2, y2, color=DARK, width=1.0, dashes=""):
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{color}" stroke-width="{width}"{dashed}/>'


def square(x, y):
    return f'<rect x="{x - 5:.1f}" y="{y - 5:.1f}" width="10" height="10" fill="white" stroke="{CONTROL}" stroke-width="2"/>'


def height_of(deviation):
    """The vertical position of a deviation in tolerances, and whether it is beyond the border."""
    shown = min(max(deviation, -SCALE), SCALE)
    return (TOP + BOTTOM) / 2 - shown / SCALE * ((BOTTOM - TOP) / 2 - 14), shown != deviation


def signed(point):
    return (point.measured - point.exact) / point.tolerance


def marks(x, point, control):
    """A measured point with its error, and its control."""
    parts = []
    deviation = signed(point)
    # Without a statistical error, the bar is the deviation that is expected from the method.
    bar = (point.expected if point.error is None else point.error) / point.tolerance
    (low, _), (high, _), (middle, _) = height_of(deviation - bar), height_of(deviation + bar), height_of(deviation)
    parts += [line(x, low, x, high, LAW, 1.6), line(x - 4, low, x + 4, low, LAW, 1.6), line(x - 4, high, x + 4, high, LAW, 1.6),
              f'<circle cx="{x:.1f}" cy="{middle:.1f}" r="4.5" fill="{LAW}"/>']
    y, is_beyond = height_of(signed(control))
    parts.append(square(x + 18, y))
    if is_beyond:
        parts.append(text(x + 28, y + 4, f"{'↑' if signed(control) > 0 else '↓'} {control.deviation():.3g}", 11, "start", CONTROL))
    return parts


def deviation_svg(result):
    """Measured minus exact in units of the tolerance, with error bars, the accepted band, and the control."""
    middle = (LEFT + RIGHT) / 2
    (top, _), (bottom, _) = height_of(1.0), height_of(-1.0)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>', text(middle, 20, "Measured − exact, in tolerances", 16),
             f'<circle cx="70" cy="44" r="4.5" fill="{LAW}"/>', text(80, 48, "law", anchor="start"), square(122, 44),
             text(134, 48, "control", anchor="start"), f'<rect x="200" y="37" width="20" height="14" fill="{ACCEPTED}"/>',
             text(226, 48, "accepted", anchor="start"), line(300, 44, 322, 44, CONTROL, 1.5, "5 3"),
             text(328, 48, "controls are beyond", anchor="start"),
             f'<rect x="{LEFT}" y="{top:.1f}" width="{RIGHT - LEFT}" height="{bottom - top:.1f}" fill="{ACCEPTED}"/>']
    for value in (-SMALLEST_CONTROL, SMALLEST_CONTROL):
        parts.append(line(LEFT, height_of(value)[0], RIGHT, height_of(value)[0], CONTROL, 1.0, "5 3"))
    parts += [line(LEFT, height_of(0.0)[0], RIGHT, height_of(0.0)[0]), line(LEFT, TOP, LEFT, BOTTOM), line(LEFT, BOTTOM, RIGHT, BOTTOM)]
    parts += [text(LEFT - 8, height_of(float(value))[0] + 4, f"{value}".replace("-", "−"), anchor="end") for value in (-5, -3, -1, 0, 1, 3, 5)]
    parts.append(text(18, (TOP + BOTTOM) / 2, "deviation / tolerance", rotated=True))
    name, labels = ticks(result.points)
    step = (RIGHT - LEFT) / len(result.points)
    for place, (point, control, label) in enumerate(zip(result.points, result.control_points, labels, strict=True)):
        x = LEFT + step * (place + 0.5) - 8
        parts += [*marks(x, point, control), text(x, BOTTOM + 18, label, 13 if len(label) < step / 7 else 10)]
    bars = "bars: expected deviation" if result.points[0].error is None else "bars: standard error"
    parts += [text(middle, BOTTOM + 36, name), text(RIGHT, HEIGHT - 4, bars, 11, "end"), "</svg>"]
    return "\n".join(parts) + "\n"
