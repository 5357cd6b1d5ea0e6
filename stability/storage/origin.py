"""The origin of a file: a record of the call that made it and of its arguments, without a date.

A figure, film or page carries its record in its own bytes, in a place that readers of its format
skip, with the checksum of all other bytes.  A dataset is its own record.  Of any other file the
bytes are compared.  So `overwrite="same"` replaces what the same call wrote, and nothing else.
"""

from __future__ import annotations

import hashlib
import json
import re
import struct
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import FileError, ParameterError, shown
from ..base.version import __version__
from .formats import NETCDF

QUESTION, PRINT = "question", "fingerprint"
"""Attributes of a store: what its numbers depend on, and the checksum of that."""
ABSENT = "missing"
"""Text of an entry that one of two questions does not have; no JSON reads so."""
ASIDE = ("its citation", "attribute citation")
"""What a file says of itself, and its numbers do not depend on."""
DATED = ("created",)
"""Attributes of datasets that differ between two runs of a call."""
CALL, VERSION, KEYS, LATER = "the call", "the version", "its citation", "later changes"
"""Entries of a record that are no arguments; of figures the checksum where a user has drawn."""
PACKAGE = __name__.partition(".")[0]
MARK = b"stability origin "
LONGEST = 400
"""Largest length of a text, or of an array, that a record holds; of others it holds a checksum."""


# --- the record of a call ---


def origin_of(call: str, arguments: Mapping[str, Any], keys: str = "") -> dict[str, str] | None:
    """The record of a call as texts by name; None where an argument cannot be described.

    Parameters
    ----------
    call
        Name of the public call.
    arguments
        What the file depends on, by name.
    keys
        Keys of the works to cite.

    Examples
    --------
    >>> origin_of("plot_map", {"title": "A map"})["its title"]
    '"A map"'
    """
    record = {CALL: call, VERSION: __version__, KEYS: keys}
    return with_arguments({n: json.dumps(text) for n, text in record.items()}, arguments)


def with_arguments(
    origin: Mapping[str, str] | None, arguments: Mapping[str, Any]
) -> dict[str, str] | None:
    """A record with further arguments; None where one cannot be described."""
    try:
        more = {n: plain_json(_described(v), allow_nan=True) for n, v in arguments.items()}
    except ParameterError:
        return None
    return None if origin is None else {**origin, **{f"its {n}": text for n, text in more.items()}}


def _described(value: Any) -> Any:
    """A value as JSON holds it; of large ones the checksum."""
    if hasattr(value, "to_xarray") and not hasattr(value, "data_vars"):
        value = value.to_xarray()
    if hasattr(value, "data_vars"):
        attributes = {n: v for n, v in value.attrs.items() if n not in DATED}
        constants = {n: v.values for n, v in value.variables.items() if not v.ndim}
        summary = {"attributes": attributes, "constants": constants}
        return _described(summary) | {"numbers": digest_of_arrays(value.variables)}
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, np.ndarray) and value.size > LONGEST and value.dtype.kind != "O":
        return f"{value.shape} {value.dtype} {digest_of(value.tobytes())}"
    if isinstance(value, (np.ndarray, np.generic)):
        return _described(value.tolist())
    if isinstance(value, complex):
        return [value.real, value.imag]
    # what a class of the user computes is not seen in its fields
    if is_dataclass(value) and type(value).__module__.startswith(f"{PACKAGE}."):
        held = {f.name: _described(getattr(value, f.name)) for f in fields(value) if f.compare}
        return {"class": type(value).__name__} | held
    if isinstance(value, Mapping):
        return {str(n): _described(v) for n, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_described(v) for v in value]
    if isinstance(value, str) and len(value) > LONGEST:
        return digest_of(value.encode())
    if value is None or isinstance(value, (str, bool, int, float)):
        return value
    raise ParameterError(f"{shown(value)} has no description.")


def digest_of(content: bytes) -> str:
    """The checksum of a file."""
    return hashlib.sha256(content).hexdigest()


def digest_of_arrays(variables: Mapping[Any, Any]) -> str:
    """The checksum of labelled arrays: their names, dimensions, values and attributes."""
    digest = hashlib.sha256()
    for name, values in sorted(variables.items()):
        content = np.ascontiguousarray(values.values)
        text = content.astype(str) if content.dtype.kind in "OT" else content
        digest.update(f"{name} {values.dims} {content.shape} {content.dtype.kind}".encode())
        digest.update(plain_json(dict(values.attrs)).encode())
        digest.update(text.tobytes())
    return digest.hexdigest()


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


# --- two records ---


def counted(asked: Mapping[str, str]) -> dict[str, str]:
    """A record without what the numbers do not depend on."""
    return {name: text for name, text in asked.items() if name not in ASIDE}


def fingerprint_of(asked: Mapping[str, Any]) -> str:
    """The checksum of a question."""
    return digest_of(plain_json(asked).encode())


def difference(head: Mapping[str, Any], asked: Mapping[str, str]) -> str:
    """The first difference between the question of a store and the one that is asked."""
    try:
        there = json.loads(head[QUESTION])
        names = counted({**asked, **there})
        lacking = [n for n in names if n not in asked or n not in there]  # these say most
        name = next(n for n in (*lacking, *names) if asked.get(n) != there.get(n))
    except (ValueError, KeyError, TypeError, StopIteration):
        return "which cannot be read"
    name, *sides = _apart(name, there.get(name, ABSENT), asked.get(name, ABSENT))
    name = name.removeprefix("the ").removeprefix("its ")
    if all(re.fullmatch('"?[0-9a-f]{64}"?', text) for text in sides):
        return f"the {name} differ"
    old, new = (t if len(t) <= 40 else f"{t[:18]} … {t[-18:]}" for t in sides)
    return f"{name}: {old} there, {new} here"


def _apart(name: str, old: str, new: str) -> tuple[str, str, str]:
    """The first entry by name that differs between two texts of JSON; else the texts."""
    if ABSENT in (old, new):
        return name, old, new
    first, second = json.loads(old), json.loads(new)
    if isinstance(first, str) and isinstance(second, str):  # a text that holds JSON itself
        with suppress(ValueError):
            first, second = json.loads(first), json.loads(second)
    if not (isinstance(first, dict) and isinstance(second, dict)):
        return name, old, new
    pairs = {
        n: [
            plain_json(side[n], allow_nan=True) if n in side else ABSENT for side in (first, second)
        ]
        for n in {**first, **second}
    }
    entry = next((n for n, (a, b) in pairs.items() if a != b), None)
    return (name, old, new) if entry is None else _apart(f"{entry} of {name}", *pairs[entry])


# --- the record in a file ---


@dataclass(frozen=True)
class _Kind:
    """A format whose files have a place for a record."""

    begins: str
    """Pattern of the first bytes."""
    wrapped: Callable[[bytes], bytes]
    """The record as readers of the format skip it."""
    before: bytes = b""
    """What stands behind the record, the last of its kind in the file; empty for the end."""


def _png(record: bytes) -> bytes:
    """A chunk of text: PNG specification, third edition, 11.3.3."""
    content = b"tEXtstability\0" + record
    return struct.pack(">I", len(content) - 4) + content + struct.pack(">I", zlib.crc32(content))


def _gif(record: bytes) -> bytes:
    """An application extension that ends, however it is read, as that of XMP does.

    Source: GIF89a specification, 26; XMP specification, part 3, 1.1.2.
    """
    return b"\x21\xff\x0bstabilityV1" + record + bytes([1, *range(255, -1, -1), 0])


def _mp4(record: bytes) -> bytes:
    """A box of free space: ISO/IEC 14496-12, 8.1.2."""
    return struct.pack(">I", len(record) + 8) + b"free" + record


_KINDS = (
    _Kind(r"\x89PNG\r\n\x1a\n", _png, b"\0\0\0\0IEND"),
    _Kind("%PDF-", lambda record: b"%" + record, b"startxref"),
    _Kind("GIF8", _gif, b";"),
    _Kind("....ftyp", _mp4),
    _Kind(r"\s*<(\?xml|svg|!doctype|html)", lambda record: b"<!-- " + record + b"-->\n"),
)


def _kind_of(content: bytes) -> _Kind | None:
    start = content[:64].decode("latin-1")
    return next((k for k in _KINDS if re.match(k.begins, start, re.I | re.S)), None)


def stamp(path: Path, origin: Mapping[str, str]) -> None:
    """Put a record into a file whose format has a place for it."""
    content = path.read_bytes()
    kind = _kind_of(content)
    if kind is None:
        return
    # what could end a comment or begin a tag is written as JSON also can
    text = json.dumps(origin, sort_keys=True).replace("--", "-\\u002d")
    text = text.replace("<", "\\u003c").replace(">", "\\u003e")
    digest = digest_of(content + text.encode())
    record = MARK + f"{digest} {text}\n".encode()
    place = content.rindex(kind.before)
    path.write_bytes(content[:place] + kind.wrapped(record) + content[place:])


def record_of(path: Path) -> dict[str, str]:
    """What a file says of its origin; of one without a place for a record what it holds.

    Raises
    ------
    FileError
        If it has been changed since it was written, or is damaged.
    """
    content = path.read_bytes()
    if content.startswith(b"\x89HDF"):
        try:
            dataset = NETCDF.read(path)
        except FileError:
            raise FileError("it is damaged") from None
        ours = str(dataset.attrs.get("format")).startswith("stability ")
        return {"its dataset": plain_json(_described(dataset), allow_nan=True)} if ours else {}
    kind, (_, mark, rest) = _kind_of(content), content.rpartition(MARK)
    if kind is not None and not mark:
        return {}
    if kind is None:
        return {"the bytes": plain_json(digest_of(content))}
    line = rest.partition(b"\n")[0]
    body = content.replace(kind.wrapped(mark + line + b"\n"), b"", 1)
    digest, _, text = line.partition(b" ")
    if digest != digest_of(body + text).encode():
        raise FileError("it has been changed since it was written")
    return dict(json.loads(text))


def unlike(path: Path, asked: Mapping[str, str] | None = None) -> str:
    """Why a file is not what a call with this record wrote; empty where it is.

    Parameters
    ----------
    path
        The file.
    asked
        The record; without it a reason is stated only if no call can have written the file.
    """
    try:
        there = record_of(path)
    except FileError as error:
        return str(error)
    if not path.stat().st_size:
        return "it is empty"
    if asked == {}:
        return "an argument of this call cannot be compared"
    if not there or (asked and not asked.keys() & there.keys()):
        return "it has no record of a call of this package"
    if asked is None or counted(there) == counted(asked):
        return ""
    return difference({QUESTION: json.dumps(there)}, asked)
