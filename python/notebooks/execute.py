"""Executes the notebooks in a temporary folder and checks that each displays its player and a plot.

Usage: python execute.py PROGRAMS     (the folder of the program kinetoscope)
"""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

import kinetoscope

HERE = Path(__file__).resolve().parent


def check_names(path: Path) -> None:
    """Checks that a notebook of twenty cells of code uses every public name, also of the types that it returns."""
    notebook = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    cells = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
    names = set(kinetoscope.__all__)
    for kind in (kinetoscope.Experiment, kinetoscope.Run, kinetoscope.Frames):
        names |= {name for name in vars(kind) if not name.startswith("_")}
    unused = sorted(name for name in names if not re.search(rf"\b{name}\b", "\n".join(cells)))
    if unused or len(cells) != 20:
        sys.exit(f"{path.name} has {len(cells)} cells of code, expected 20, and does not use {unused}")


def main() -> None:
    """Executes all notebooks of this folder."""
    os.environ["PATH"] = os.pathsep.join([os.path.abspath(sys.argv[1]), os.environ["PATH"]])
    notebooks = sorted(HERE.glob("*.ipynb"))
    if len(notebooks) != 5:
        sys.exit(f"expected one notebook per model and that of all names, found {len(notebooks)}")
    check_names(HERE / "every_name.ipynb")
    with tempfile.TemporaryDirectory() as folder:
        # The notebooks find the experiments as in the repository, and their recordings are removed.
        shutil.copytree(HERE.parent.parent / "experiments", Path(folder) / "experiments")
        work = Path(folder) / "python" / "notebooks"
        work.mkdir(parents=True)
        for path in notebooks:
            start = time.monotonic()
            notebook = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
            outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
            if outputs:
                sys.exit(f"{path.name} contains outputs: clear them before a commit")
            NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(work)}}).execute()
            data = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
            if not any("image/svg+xml" in content for content in data):
                sys.exit(f"{path.name} does not display a plot")
            pages = [content["text/html"] for content in data if "text/html" in content]
            if not any(page.startswith("<iframe") and "film" in page for page in pages):
                sys.exit(f"{path.name} does not display its player")
            print(f"{path.name}: executed, {time.monotonic() - start:.1f} s")


if __name__ == "__main__":
    main()
