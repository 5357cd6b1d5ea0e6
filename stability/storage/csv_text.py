"""CSV: every table of numbers is written in the same way."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import Any


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table as CSV; an empty cell is a value that does not exist.

    Parameters
    ----------
    header
        Names of the columns.
    rows
        Values of each row, in the order of the columns; None for one that does not exist.  A float
        has its shortest exact digits.

    Returns
    -------
    str

    Examples
    --------
    >>> csv_text(("a", "b", "c"), [(1, "x, y", None)]).splitlines()
    ['a,b,c', '1,"x, y",']
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue()
