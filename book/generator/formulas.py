"""Formulas of the book: LaTeX, which is converted to MathML when the book is built, so that pages need neither a script nor a network.

The package is pinned in `book/generator/requirements.txt`; `python3 book/generator --law ID` works without it.
"""

import re

INLINE = re.compile(r"\$([^$]+)\$")
# The converter puts no space around the names of functions.
FUNCTION = re.compile(r"(<mi>(?:sin|cos|tan|ln|exp|arccos)</mi>)")
THIN = '<mspace width="0.167em" />'


class FormulaError(Exception):
    """A formula that cannot be converted, with the reason."""


def mathml(latex, display="inline"):
    """A formula as MathML."""
    try:
        from latex2mathml.converter import convert
    except ImportError as error:
        raise FormulaError(f"{error}; `pip install -r book/generator/requirements.txt` installs what writes the formulas") from error
    try:
        text = convert(latex, display=display)
    except Exception as error:
        raise FormulaError(f"`{latex}`: {error}") from error
    # The converter keeps what it does not know as text.
    if unknown := re.findall(r"\\[a-zA-Z]+", text):
        raise FormulaError(f"`{latex}` has unknown commands: {', '.join(unknown)}")
    text = FUNCTION.sub(rf"{THIN}\1{THIN}", text.replace("<mo>&#x0002F;</mo>", '<mo lspace="0" rspace="0">/</mo>'))
    return text.replace(' xmlns="http://www.w3.org/1998/Math/MathML"', "")


def at_equals(latex):
    """A formula in parts, each of which but the first begins with an equals sign outside of braces and of \\left ... \\right."""
    depth, start = 0, 0
    for found in re.finditer(r"\\left|\\right|\\[{}]|[{}=]", latex):
        depth += {"\\left": 1, "{": 1, "\\right": -1, "}": -1}.get(found[0], 0)
        if found[0] == "=" and depth == 0 and latex[start:found.start()].strip():
            yield latex[start:found.start()]
            start = found.start()
    yield latex[start:]


def with_formulas(text):
    """A text in which each `$...$` is MathML. Browsers break no formula, so that a long one is several, with an equals sign at each border."""
    return INLINE.sub(lambda found: " ".join(map(mathml, at_equals(found[1]))), text)
