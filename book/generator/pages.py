"""Pages of the book of laws: one per law, and the table of all."""

import html
import math
import re

from formulas import mathml, with_formulas
from laws import SMALLEST_CONTROL, WIDEST_TOLERANCE, read_mutations
from pictures import kinds

MODELS = {"dem": "DEM", "gas": "Gas", "orbit": "Orbit", "packing": "Packing"}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value, digits=7):
    """A number with a power of ten where it is far from 1."""
    if value is None or math.isnan(value):
        return ""
    if value == 0:
        return "0"
    size = abs(value)
    if 1e-3 <= size < 1e6:
        places = max(0, digits - 1 - math.floor(math.log10(size)))
        text = f"{value:.{places}f}"
        return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPTS)}".replace("-", "−")


def key_text(keys):
    """The first eight digits of run keys, as in the names of recordings."""
    return f"<code>{keys[0][:8]}</code>" if len(keys) == 1 else f"<code>{keys[0][:8]}</code> and {len(keys) - 1} more"


def html_table(names, rows):
    """A table whose rows are cards on a phone, where each cell repeats the name of its column."""
    head = "".join(f"<th>{name}</th>" for name in names)
    body = "\n".join("<tr>" + "".join(f'<td data-label="{name}">{cell}</td>' for name, cell in zip(names, row, strict=True)) + "</tr>" for row in rows)
    return f'<table class="cards">\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>'


def table(points):
    """The comparison of every point of a sweep."""
    names = ("runs", "measured", "standard error", "exact", "deviation", "tolerance", "deviation / tolerance", "run keys")
    rows = []
    for point in points:
        deviation = point.measured - point.exact
        rows.append((html.escape(point.label) or "all runs", number(point.measured), number(point.error, 2), number(point.exact),
                     number(deviation, 2), number(point.tolerance, 2), number(point.deviation(), 2), key_text(point.run_keys)))
    # A quantity without scatter has no standard error.
    shown = [place for place, name in enumerate(names) if name != "standard error" or any(row[place] for row in rows)]
    return html_table([names[place] for place in shown], [[row[place] for place in shown] for row in rows])


def quantity(law, unit):
    """What is measured, with its unit."""
    unit = "" if unit in ("1", "") else f", in {unit}"
    return f"`{law.get('metric') or law['measured']}`{unit}"


def compared(law):
    """The expression with which a measurement is compared."""
    text = law.get("exact", "theory")
    return "the theoretical value of the analysis" if text == "theory" else f"`{text}`"


def tolerance_text(points):
    """How much wider than the expected deviation the tolerance is."""
    ratios = [number(point.tolerance / point.expected, 2) for point in points]
    ratios = list(dict.fromkeys(ratios))
    least, largest = min(ratios, key=float), max(ratios, key=float)
    return f"{least} times that" if least == largest else f"{least} to {largest} times that"


def relative_tolerance(points):
    """The largest tolerance in units of the exact value; of quantities that vanish within it, the tolerance itself."""
    if any(abs(point.exact) < point.tolerance for point in points):
        widest = max(points, key=lambda point: point.tolerance)
        return f"{number(widest.tolerance, 2)} (of {number(widest.exact, 2)})"
    return number(max(point.tolerance / abs(point.exact) for point in points), 2)


def noticed_change(factors):
    """The smallest change of a line that violates a law, as text; nothing if no line of it is changed."""
    if not factors:
        return ""
    return "none of 10 %" if math.isinf(min(factors)) else f"{number(100 * (min(factors) - 1), 2)} %"


def mutations_text(law):
    """Which changes of the program violate a law."""
    lines = []
    for mutation in read_mutations():
        factor = mutation["laws"].get(law["id"])
        if factor is not None:
            found = "even a factor of 1.1 does not violate it" if math.isinf(factor) else f"a factor of {factor} violates it"
            lines.append(f"- {mutation['name']} (`{mutation['file']}`): {found}")
    return f"\n\n{section('Changes of the program')}\n\n" + "\n".join(lines) if lines else ""


def introduction(law):
    """The law, its formula and its derivation."""
    steps = "\n".join(f"{place}. {with_formulas(step)}" for place, step in enumerate(law["derivation"], 1))
    # What follows a wide space has a line of its own, because browsers break no formula.
    formulas = "".join(mathml(part, "block") for part in re.split(r"\\q?quad", law["formula"]))
    return f"""# {law['title']}

{law['statement']}

<div class="formula">{formulas}</div>

{section("Derivation")}

{steps}
"""


def section(title):
    """The title of a part of a law page. It is no heading of Markdown, so that the search lists the page once and not each of its parts."""
    return f'<div class="part" role="heading" aria-level="2">{title}</div>'


def figures(law, points):
    """The plots of the quantity and of its deviations."""
    files = kinds(law)
    largest = number(max(point.deviation() for point in points), 2)
    quantity_alt = f"Plot of the measured quantity: {law['title']}"
    deviation_alt = f"Plot of measured minus exact with error bars: at most {largest} tolerances; the controls are beyond {SMALLEST_CONTROL:g}"
    return f"""<div class="plots">
<figure><img src="{files['quantity']}" alt="{html.escape(quantity_alt)}"></figure>
<figure><img src="{files['deviation']}" alt="{html.escape(deviation_alt)}"></figure>
</div>"""


def replay(law):
    """The picture of the first run, which links to the report with the replay."""
    files = kinds(law)
    return f"""<figure class="replay"><a href="{files['replay']}"><img src="{files['poster']}" alt="Last frame of the first run: {html.escape(law['title'])}"></a>
<figcaption><a href="{files['replay']}">Play the replay</a>: every run of the law, with all plots and metrics. Where the program that wrote this book
carries the engine, the button “Verify in this browser” repeats the runs on your machine.</figcaption></figure>"""


def law_page(result, manifest):
    """The page of a law."""
    law, control = result.law, result.law["control"]
    commands = "\n".join(result.commands)
    changes = "".join(f"\n\nIn the manifest, `{new}` replaces `{old}`." for old, new in control.get("replace", {}).items())
    repeat = f"{changes}\n\n```console\n{chr(10).join(result.control_commands)}\n```"
    return f"""{introduction(law)}
{section("Measured and exact")}

{law['setup']} {quantity(law, result.unit)}, compared with {compared(law)}:

{figures(law, result.points)}

{table(result.points)}

{section("Replay")}

{replay(law)}

{section("Tolerance")}

**Expected deviation:** {f'`{law["expected"]}`' if 'expected' in law else 'the standard error, `error`'}. **Tolerance:** `{law['tolerance']}`, {tolerance_text(result.points)}.
{law['tolerance_reason']}

{section("The control that fails")}

{control['text']} The same quantity, compared with the exact value and the tolerance of the law; the deviation must be at least {SMALLEST_CONTROL:g} tolerances:

{table(result.control_points)}{repeat}{mutations_text(law)}

{section("Source")}

{law['source']}

{section("Repeat it")}

Save [the manifest]({law['id']}.toml), then:

```console
{commands}
```

```toml
{manifest.strip()}
```

The run key is a hash of everything that affects the result: runs with the same key have the same bytes on every machine.
"""


def unmeasured_page(law):
    """The page of a law that a quick build does not measure."""
    return f"""{introduction(law)}
{section("Source")}

{law['source']}

This book was built with `--quick`, which measures one law per model only.
"""


def incomplete_pages(laws, results, folder):
    """What law pages lack: a typeset formula, a derivation and, if they were measured, plots and a replay."""
    found, measured = [], {result.law["id"] for result in results}
    for law in laws:
        text = (folder / f"{law['id']}.md").read_text()
        wanted = {"formula": '<div class="formula"><math', "derivation": f"{section('Derivation')}\n\n1. "}
        if law["id"] in measured:
            wanted |= kinds(law)
            found += [f"{law['id']}: {file} is missing" for file in kinds(law).values() if not (folder / file).is_file()]
        found += [f"the page of {law['id']} has no {name}" for name, part in wanted.items() if part not in text]
    return found


def index_page(results, seconds):
    """The table of all laws."""
    parts = [f"""# The book of laws

Each page compares a measurement with an exact value. The same command that wrote these pages ran the {len(results)} laws and their
controls, in {seconds:.0f} s. It fails if a law is violated, and also if a control is not rejected clearly, because a comparison that cannot fail
is no test. Each control is a run of its own, of a changed system or by another method.

No result on these pages was typed: measurements come from `metrics.json`, exact values from the formulas and manifests in
`book/laws/`. These columns list how tight each law is:

- **tolerance / exact**: the tolerance in units of the exact value, the largest of the law's points. A quantity whose exact value is 0
  or smaller than the tolerance has its tolerance itself. A tolerance is at most {WIDEST_TOLERANCE:g} times the expected deviation: the standard
  error, or a bound of the numerical error. The page of the law contains both, and states if the margin was chosen after the deviation was known.
- **over expected**: the tolerance in units of the expected deviation, the largest of the law's points.
- **deviation**: the deviation of the measurement in units of the tolerance, the largest of the law's points. Above 1, the law is violated.
- **control**: the deviation of the control in the same units, the smallest of its points. It must be at least {SMALLEST_CONTROL:g}.
- **noticed**: the smallest change of a line of the program, 0.1, 1 or 10 %, that violates the law, from `book/mutations.toml`. Laws without an
  entry have no such line: several lines together make their result, or a factor does not change it.
"""]
    factors = {}
    for mutation in read_mutations():
        for law, factor in mutation["laws"].items():
            factors.setdefault(law, []).append(factor)
    for model, title in MODELS.items():
        chosen = [result for result in results if result.law["model"] == model]
        if not chosen:
            continue
        rows = []
        for result in chosen:
            law = result.law
            largest = max(point.deviation() for point in result.points)
            least = min(point.deviation() for point in result.control_points)
            widest = max(point.tolerance / point.expected for point in result.points)
            rows.append((f'<a href="{law["id"]}.html">{html.escape(law["title"])}</a>', mathml(law["formula"]), len(result.points),
                         relative_tolerance(result.points), number(widest, 2), number(largest, 2), number(least, 2),
                         noticed_change(factors.get(law["id"]))))
        names = ("law", "formula", "points", "tolerance / exact", "over expected", "deviation", "control", "noticed")
        parts.append(f"\n## {title}\n\n{html_table(names, rows)}")
    return "\n".join(parts) + "\n"
