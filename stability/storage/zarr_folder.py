"""A Zarr folder of this package: the question that it answers, and its content, whole or refused.

What the numbers of a store depend on is kept as texts, so that two questions can be compared.

Every file of a store has a checksum.  Those of the metadata and coordinates stand in its head, with
one of the head itself.  Those of a chunk are in a record, a file that is written last: a chunk is
there exactly if its record is, and whole if all its files are those of the record.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import FileError, ParameterError, StabilityError, shown, warned
from ..base.version import __version__
from .checksum import sealed, unsealed
from .targets import path_text, place, refusing

if TYPE_CHECKING:
    import xarray


HEAD = "zarr.json"
"""Name of the metadata of a group or array, by Zarr's format 3."""
MARKER = "marker"
"""Attribute that names the variable in whose folder the records of chunks are."""
FILES, ITSELF = "checksums", "checksum"
"""Attributes of the head: checksums of the files that are no chunks, and of the head."""
MISSING = "a Zarr store needs the package zarr; `pip install stability[scale]`"
AGAIN = "give the call that made it again, to compute it"
CHUNK = re.compile(r"([^/]+)/c((?:\.\d+)+)")
"""Name of a chunk's file in its store."""
UNREADABLE = (ValueError, LookupError, TypeError, AttributeError, RecursionError)
"""Errors of JSON that is another than was written."""
Block = tuple[int, ...]
FORMAT = CHECKED = 2
"""Version of the way in which stores are written, another one is another question; the first
version in which every file has a checksum."""
QUESTION, PRINT = "question", "fingerprint"
"""Attributes of a store: what its numbers depend on, and the checksum of that."""
ABSENT = "missing"
"""Text of an entry that one of two questions does not have; no JSON reads so."""
ASIDE = ("its citation", "attribute citation")
"""What a store says of itself, and its numbers do not depend on."""


def digest_of(content: bytes) -> str:
    """The checksum of a file."""
    return hashlib.sha256(content).hexdigest()


def content_of(path: Path) -> bytes | None:
    """Content of a file; None where there is none that can be read."""
    try:
        return path.read_bytes()
    except OSError:
        return None


def sealed_head(head: bytes, files: Mapping[str, bytes]) -> bytes:
    """Metadata of a store with the checksums of its files that are no chunks, and of itself."""
    record = json.loads(head)
    sums = {name: digest_of(content) for name, content in sorted(files.items())}
    record["attributes"][FILES] = json.dumps(sums)
    record["attributes"][ITSELF] = _itself(record)
    return json.dumps(record, indent=2).encode()


def _itself(record: Mapping[str, Any]) -> str:
    attributes = {n: v for n, v in record["attributes"].items() if n != ITSELF}
    whole = {**record, "attributes": attributes}
    return digest_of(json.dumps(whole, sort_keys=True).encode())


def damaged_files(folder: Path) -> list[str]:
    """Names of the files that are not as they were written, chunks left out."""
    try:
        record = json.loads((folder / HEAD).read_bytes())
        sums = json.loads(record["attributes"][FILES])
        if record["attributes"][ITSELF] != _itself(record):
            return [HEAD]
    except (OSError, *UNREADABLE):
        return [HEAD]
    return _unlike(folder, sums)


def _unlike(folder: Path, sums: Mapping[str, str]) -> list[str]:
    """Names of the files that are missing, or have another checksum."""
    return [
        name
        for name, digest in sums.items()
        if (content := content_of(folder / name)) is None or digest_of(content) != digest
    ]


@dataclass(frozen=True)
class Seals:
    """Records of the chunks of a store: the checksum of each file of a chunk."""

    folder: Path
    """Folder of the store."""
    marker: str
    """Name of the variable in whose folder the records are."""
    axes: int
    """Number of axes of the grid of chunks."""
    label: str
    """Fingerprint of the question: a record of another store does not count."""

    def path(self, block: Block) -> Path:
        """The record of a chunk."""
        return self.folder / self.marker / ".".join(["whole", *map(str, block)])

    def written(self, block: Block, files: Mapping[str, bytes]) -> bytes:
        """A record of the files of a chunk, by name."""
        sums = {name: digest_of(content) for name, content in files.items()}
        return sealed(json.dumps(sums).encode(), f"{self.label} {block}")

    def record(self, block: Block) -> dict[str, str] | None:
        """Checksums by name of a chunk's files; None where the chunk is not there."""
        content = unsealed(content_of(self.path(block)) or b"", f"{self.label} {block}")
        return None if content is None else dict(json.loads(content))

    def damaged(self, block: Block) -> list[str] | None:
        """Names of the files of a chunk that are missing or damaged; None where it is not there."""
        record = self.record(block)
        return None if record is None else _unlike(self.folder, record)

    def count(self) -> int:
        """Number of records."""
        with refusing(self.folder, "read"):
            return sum(n.startswith("whole.") for n in os.listdir(self.folder / self.marker))

    def checked(self, name: str, content: bytes | None, *, complete: bool) -> bytes | None:
        """Content of a file of the store, or None where its chunk is not there."""
        found = CHUNK.fullmatch(name)
        if found is None:
            return content
        block = tuple(map(int, found[2].split(".")[1:]))[: self.axes]
        record = self.record(block)
        if record is None and not complete:
            return None
        if record is None or content is None or record.get(name) != digest_of(content):
            raise self.refusal(name)
        return content

    def others(self) -> dict[str, str]:
        """Checksums by name of the files that are no chunks."""
        return dict(json.loads(json.loads((self.folder / HEAD).read_bytes())["attributes"][FILES]))

    def refusal(self, name: str) -> FileError:
        """The error that names a damaged file."""
        return FileError(f"{path_text(self.folder)}: {named([name])} is damaged; {AGAIN}.")


def named(files: Iterable[str], most: int = 3) -> str:
    """Some files of a store in words: chunks by their variable and indices."""
    words = []
    for name in files:
        found = CHUNK.fullmatch(name)
        words.append(f"chunk {found[2][1:]} of {found[1]}" if found else name)
    rest = len(words) - most
    return ", ".join(words[:most]) + (f" and {rest} more" if rest > 0 else "")


@cache
def _checking() -> Any:
    """The class of Zarr stores that check what they read; zarr is optional."""
    from zarr.storage import LocalStore

    class Checking(LocalStore):  # type: ignore[misc]  # zarr has no types where it is missing
        """A folder whose chunks are compared with their records as they are read."""

        def __init__(self, seals: Seals, complete: bool) -> None:  # noqa: FBT001
            super().__init__(seals.folder, read_only=True)
            self.seals, self.complete, self.sums = seals, complete, seals.others()

        async def get(self, key: str, prototype: Any, byte_range: Any = None) -> Any:
            """Content of a file, whole chunks alone."""
            found = await super().get(key, prototype, byte_range)
            content = None if found is None else found.to_bytes()
            if key in self.sums and (content is None or digest_of(content) != self.sums[key]):
                raise self.seals.refusal(key)
            right = self.seals.checked(key, content, complete=self.complete)
            return None if right is None else found

        def __reduce__(self) -> Any:
            return _checking_store, (self.seals, self.complete)

    return Checking


def _checking_store(seals: Seals, complete: bool) -> Any:  # noqa: FBT001
    return _checking()(seals, complete)


def dataset_of(seals: Seals, *, complete: bool = False) -> xarray.Dataset:
    """The dataset of a store, read when it is used; each chunk is checked as it is read.

    Chunks that are not there are refused if it must be complete, and hold fill values otherwise.
    """
    import xarray

    found: xarray.Dataset = xarray.open_zarr(_checking_store(seals, complete), chunks=None)
    for name in (FILES, ITSELF):
        found.attrs.pop(name, None)
    return found


def opened_store(
    path: str | os.PathLike[str], form: str, what: str, *, lazy: bool = False
) -> xarray.Dataset:
    """A dataset from a Zarr folder, refused where chunks are missing or damaged.

    Parameters
    ----------
    path
        The folder.
    form
        Value that its attribute `format` must have.
    what
        Words for its content, such as "a map".
    lazy
        Whether to leave the data in the folder until it is used; a damaged chunk is then refused
        when it is read.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    FileError
        If it is no such folder, damaged or not complete.
    StabilityError
        If the package zarr is missing.
    """
    folder = place(path)
    try:
        import xarray
        import zarr  # noqa: F401  # xarray needs it
    except ImportError:
        raise StabilityError(f"{MISSING}.") from None
    try:
        head = json.loads((folder / HEAD).read_bytes())["attributes"]
        asked = json.loads(head[QUESTION])
        ours = head.get("format") == form
        right = head[PRINT] == fingerprint_of(asked)
        checked = json.loads(asked["the format"])[0] >= CHECKED
        marker = str(head[MARKER])
        bad = damaged_files(folder) if checked and right else []
    except (OSError, *UNREADABLE) as error:
        why = "there is none" if not folder.exists() else type(error).__name__
        raise FileError(
            f"{path_text(path)} cannot be read as a Zarr store ({why}); it may be damaged."
        ) from None
    if bad or not right:
        raise FileError(f"{path_text(path)}: {named(bad or [HEAD])} is damaged; {AGAIN}.")
    if not ours:
        raise FileError(f"{path_text(path)} is not {what} of this package.")
    if not checked:
        warned(
            f"{path_text(path)} was written by an earlier version, without checksums, so that "
            "damage to it may go unnoticed; compute it again to have them."
        )
    try:
        plain: xarray.Dataset = xarray.open_zarr(folder, chunks=None)
        variable = plain.variables[marker]
        chunk = variable.encoding["chunks"]
        count = math.prod(-(-n // c) for n, c in zip(variable.shape, chunk, strict=True))
        seals = Seals(folder, marker, variable.ndim, head[PRINT])
        there = seals.count() if checked else _files(folder / marker)
        dataset = dataset_of(seals, complete=True) if checked else plain
        if there == count and not lazy:
            dataset.load()
    except StabilityError:
        raise
    except Exception as error:  # zarr and its codecs raise any
        raise FileError(
            f"{path_text(path)} cannot be read as a Zarr store ({type(error).__name__}); it may be "
            "damaged."
        ) from None
    if there < count:
        raise FileError(
            f"{path_text(path)} holds {there} of {count} chunks; give the command that began it "
            "again to go on."
        )
    return dataset


def _files(folder: Path) -> int:
    """Number of chunks of a store without records."""
    return sum(entry.startswith("c.") for entry in os.listdir(folder))


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
        As for `stability.storage.zarr_store.ZarrStore`.

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
    name, *sides = _apart(name, there.get(name, ABSENT), asked.get(name, ABSENT))
    old, new = (t if len(t) <= 40 else f"{t[:18]} … {t[-18:]}" for t in sides)
    return f"{name.removeprefix('the ').removeprefix('its ')}: {old} there, {new} here"


def _apart(name: str, old: str, new: str) -> tuple[str, str, str]:
    """The first entry by name that differs between two texts of JSON; else the texts."""
    if ABSENT in (old, new):
        return name, old, new
    one, other = json.loads(old), json.loads(new)
    if isinstance(one, str) and isinstance(other, str):  # a text that holds JSON itself
        with suppress(ValueError):
            one, other = json.loads(one), json.loads(other)
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return name, old, new
    pairs = {
        n: [plain_json(side[n], allow_nan=True) if n in side else ABSENT for side in (one, other)]
        for n in {**one, **other}
    }
    entry = next((n for n, (a, b) in pairs.items() if a != b), None)
    return (name, old, new) if entry is None else _apart(f"{entry} of {name}", *pairs[entry])
