"""JSON and CSV: every command encodes numbers without bound, every table is written, in one way."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

HELP = "print one JSON object; null means a number without bound, or one that is not known"
"""Help text of --json."""
NUMBER = "number"
"""Only key of a marked number."""


def strict(value: Any) -> Any:
    """A value in the types of JSON; a number that is not finite is None.

    Examples
    --------
    >>> strict({"mu": [0.5, float("inf")]})
    {'mu': [0.5, None]}
    """
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): strict(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [strict(entry) for entry in value]
    if hasattr(value, "tolist"):  # of NumPy
        return strict(value.tolist())
    return str(value)


def json_text(record: Any) -> str:
    """A record as strict JSON.

    Examples
    --------
    >>> print(json_text({"mu_high": float("inf")}))
    {
      "mu_high": null
    }
    """
    return json.dumps(strict(record), indent=2, allow_nan=False)


def marked(value: Any) -> Any:
    """A value for a file that is read again: a number that is not finite as `{"number": "inf"}`.

    Examples
    --------
    >>> text = json.dumps(marked([1.5, float("inf")]), allow_nan=False)
    >>> text, json.loads(text, object_hook=unmarked)
    ('[1.5, {"number": "inf"}]', [1.5, inf])
    """
    if isinstance(value, float) and not math.isfinite(value):
        return {NUMBER: str(float(value))}
    if isinstance(value, Mapping):
        return {key: marked(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [marked(entry) for entry in value]
    return value


def unmarked(entry: dict[str, Any]) -> Any:
    """Decode an object of `marked`; for `object_hook` of `json.loads`."""
    return float(entry[NUMBER]) if entry.keys() == {NUMBER} else entry


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table as CSV; an empty cell is a value that does not exist.

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
