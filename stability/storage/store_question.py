"""The question of a store: what its numbers depend on, as texts, and whether two are the same."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from ..base.errors import ParameterError, shown
from ..base.version import __version__

FORMAT = CHECKED = 2
"""Version of the way in which stores are written, another one is another question; the first
version in which every file has a checksum."""
QUESTION, PRINT = "question", "fingerprint"
"""Attributes of a store: what its numbers depend on, and the checksum of that."""
MISSING = "missing"
"""Text of an entry that one of two questions does not have; no JSON reads so."""
ASIDE = ("its citation", "attribute citation")
"""What a store says of itself, and its numbers do not depend on."""


def asked_of(
    cells: Sequence[Any],
    chunk: Sequence[int],
    arrays: Sequence[Any],
    coords: Mapping[str, Any],
    attrs: Mapping[str, Any],
    question: Mapping[str, Any],
) -> dict[str, str]:
    """Everything that the files of a store depend on, as texts by name.

    Parameters
    ----------
    cells, chunk
        Names and lengths of the grid's axes, and the lengths of a chunk.
    arrays
        Name, type, fill value, attributes and further axes of each array.
    coords, attrs, question
        As for `stability.jobs.zarr_store.ZarrStore`.

    Returns
    -------
    dict
        Without the citation, on which no number depends.
    """
    import xarray

    digest = hashlib.sha256()
    for name, values in sorted(xarray.Dataset(coords=dict(coords)).variables.items()):
        content = np.ascontiguousarray(values.values)
        text = content.astype(str) if content.dtype.kind in "OT" else content
        digest.update(f"{name} {values.dims} {content.shape} {content.dtype.kind}".encode())
        digest.update(plain_json(dict(values.attrs)).encode())
        digest.update(text.tobytes())
    found = {
        **{f"its {name}": plain_json(value) for name, value in question.items()},
        **{f"attribute {name}": plain_json(value) for name, value in attrs.items()},
        "the number of cells": plain_json(cells),
        "the chunk": plain_json(chunk),
        "the arrays": plain_json(arrays, allow_nan=True),
        "the coordinates": digest.hexdigest(),
        "the format": plain_json([FORMAT, __version__]),
    }
    return _kept(found)


def _kept(asked: Mapping[str, str]) -> dict[str, str]:
    """A question without what the numbers do not depend on."""
    return {name: text for name, text in asked.items() if name not in ASIDE}


def same_question(head: Mapping[str, Any], asked: Mapping[str, str]) -> bool:
    """Whether a store holds the question."""
    return bool(head[PRINT] == fingerprint_of(asked))


def plain_json(value: Any, *, allow_nan: bool = False) -> str:
    """A value as JSON with sorted names, arrays as lists; a value that does not fit is refused."""
    try:
        return json.dumps(value, default=_plain, allow_nan=allow_nan, sort_keys=True)
    except (TypeError, ValueError):
        raise ParameterError(f"{shown(value)} does not fit JSON, which a store needs.") from None


def _plain(value: Any) -> Any:
    """Arrays, numbers of NumPy and mappings as those of JSON."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError


def fingerprint_of(asked: Mapping[str, Any]) -> str:
    """The checksum of a question."""
    return hashlib.sha256(plain_json(asked).encode()).hexdigest()


def difference(head: Mapping[str, Any], asked: Mapping[str, str]) -> str:
    """The first difference between the question of a store and the one that is asked."""
    try:
        there = json.loads(head[QUESTION])
        names = _kept({**asked, **there})
        lacking = [n for n in names if n not in asked or n not in there]  # these say most
        name = next(n for n in (*lacking, *names) if asked.get(n) != there.get(n))
    except (ValueError, KeyError, TypeError, StopIteration):
        return "which cannot be read"
    if name == "the coordinates":
        return "the coordinates differ"
    name, *sides = _apart(name, there.get(name, MISSING), asked.get(name, MISSING))
    old, new = (t if len(t) <= 40 else f"{t[:18]} … {t[-18:]}" for t in sides)
    return f"{name.removeprefix('the ').removeprefix('its ')}: {old} there, {new} here"


def _apart(name: str, old: str, new: str) -> tuple[str, str, str]:
    """The first entry by name that differs between two texts of JSON; else the texts."""
    if MISSING in (old, new):
        return name, old, new
    one, other = json.loads(old), json.loads(new)
    if isinstance(one, str) and isinstance(other, str):  # a text that holds JSON itself
        with suppress(ValueError):
            one, other = json.loads(one), json.loads(other)
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return name, old, new
    pairs = {
        n: [plain_json(side[n], allow_nan=True) if n in side else MISSING for side in (one, other)]
        for n in {**one, **other}
    }
    entry = next((n for n, (a, b) in pairs.items() if a != b), None)
    return (name, old, new) if entry is None else _apart(f"{entry} of {name}", *pairs[entry])
