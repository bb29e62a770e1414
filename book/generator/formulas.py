"""Formulas of the book: LaTeX, which is converted to MathML when the book is built, so that pages need neither a script nor a network.

The package is pinned in `book/generator/requirements.txt`; `python3 book/generator --law ID` works without it.
"""

import re

INLINE = re.compile(r"\$([^$]+)\$")


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
    # Browsers stretch the delimiters of functions such as f(x) only if this is not said otherwise.
    return text.replace(' xmlns="http://www.w3.org/1998/Math/MathML"', "")


def with_formulas(text):
    """A text in which each `$...$` is MathML."""
    return INLINE.sub(lambda found: mathml(found[1]), text)
