"""Tables as Polars or pandas data frames, whichever is installed."""

from __future__ import annotations

import importlib
import importlib.util
from typing import TYPE_CHECKING, Any, Dict, List, Literal, Optional, Sequence, Union

from ._errors import KinetoscopeError

if TYPE_CHECKING:
    import pandas
    import polars

# A data frame of the library that is installed or chosen.
Table = Union["polars.DataFrame", "pandas.DataFrame"]
TableLibrary = Literal["polars", "pandas"]
# The first one that is installed is the default.
LIBRARIES: Sequence[TableLibrary] = ("polars", "pandas")


def library_module(library: Optional[TableLibrary]) -> Any:
    """The module of a library, or of the first one that is installed."""
    wanted = LIBRARIES if library is None else (library,)
    for name in wanted:
        if name not in LIBRARIES:
            raise KinetoscopeError(f"unknown table library `{name}`", "expected `polars` or `pandas`")
        if importlib.util.find_spec(name) is not None:
            return importlib.import_module(name)
    names = " nor ".join(wanted) if len(wanted) > 1 else wanted[0]
    raise KinetoscopeError(
        f"neither {names} is installed" if len(wanted) > 1 else f"{names} is not installed",
        f"`pip install 'kinetoscope[{wanted[0]}]'`",
    )


def frame_of_columns(columns: Dict[str, Any], library: Optional[TableLibrary]) -> Table:
    """A data frame from arrays of equal length."""
    table: Table = library_module(library).DataFrame(columns)
    return table


def frame_of_rows(rows: List[Dict[str, Any]], names: Sequence[str], library: Optional[TableLibrary]) -> Table:
    """A data frame from rows; a value that a row lacks is missing."""
    module = library_module(library)
    columns = {name: [row.get(name) for row in rows] for name in names}
    table: Table = module.DataFrame(columns, **({"strict": False} if module.__name__ == "polars" else {}))
    return table
