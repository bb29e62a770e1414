"""The page of a report in a cell of a notebook."""

from __future__ import annotations

import html
import sys
from pathlib import Path

from ._errors import KinetoscopeError

# The page without everything except the player and, at its right from the width of a narrow cell on, the plot of the question.
PLAYER_ONLY = (
    "<style>main > :not(.replay) { display: none !important } "
    "main { max-width: none !important } body, main, .replay { margin: 0; padding: 4px; border: 0 } "
    "@media (min-width: 560px) { .split:has(.deck):has(.adjacent) "
    "{ grid-template-columns: minmax(0, 11fr) minmax(0, 9fr) } }</style>"
)


def is_notebook() -> bool:
    """Whether the code runs in a kernel of Jupyter."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")


class Page:
    """A page in a frame of its own, without access to the notebook."""

    def __init__(self, page: str, height: int) -> None:
        self.page = page
        self.height = height

    def _repr_html_(self) -> str:
        return (
            f'<iframe sandbox="allow-scripts" style="width: 100%; height: {self.height}px; border: 0" '
            f'srcdoc="{html.escape(self.page)}"></iframe>'
        )


def player(report: Path) -> str:
    """The page of a report with nothing but its player."""
    page = report.read_text(encoding="utf-8")
    if 'class="film"' not in page or "</head>" not in page:
        raise KinetoscopeError(
            "this recording has no replay", "the state must be recorded; `record.channels` must not exclude it"
        )
    return page.replace("</head>", f"{PLAYER_ONLY}</head>", 1)


def display(page: str, height: int) -> None:
    """Shows a page in the current cell."""
    if not is_notebook():
        raise KinetoscopeError(
            "a page can only be shown in a notebook",
            "elsewhere, `analyze-recordings --open FOLDER` opens the report in the browser",
        )
    from IPython.display import display as show

    show(Page(page, height))  # type: ignore[no-untyped-call]
