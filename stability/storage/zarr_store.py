"""A Zarr folder of this package: chunks that workers write, and the question that they answer.

Zarr's own writer is atomic, but a killed one leaves files that nothing removes, and it leaves out
chunks of fill values, by which a chunk could not be seen to be there.  So it makes the metadata
and the coordinates, in memory, and the chunks are written here, by its own codec: one file for
each variable of each chunk.

What the numbers of a store depend on is kept as texts, so that two questions can be compared.

Every file of a store has a checksum.  Those of the metadata and coordinates stand in its head, with
one of the head itself.  Those of a chunk are in a record, a file that is written last: a chunk is
there exactly if its record is, and whole if all its files are those of the record.
"""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..base.checks import overwriting
from ..base.errors import FileError, StabilityError, warned
from ..base.types import Overwrite
from ..base.version import __version__
from .checksum import sealed, unsealed
from .chunks import Arrays, Block, Layout, Variable, check_chunk
from .files import write_file
from .formats import ZARR
from .litter import clear, temporary
from .origin import (
    PRINT,
    QUESTION,
    counted,
    difference,
    digest_of,
    digest_of_arrays,
    fingerprint_of,
    plain_json,
)
from .targets import check_folder, path_text, place, refusing

if TYPE_CHECKING:
    import xarray

HEAD = "zarr.json"
"""Name of the metadata of a group or array, by Zarr's format 3."""
MARKER = "marker"
"""Attribute that names the variable in whose folder the records of chunks are."""
FILES, ITSELF = "checksums", "checksum"
"""Attributes of the head: checksums of the files that are no chunks, and of the head."""
AGAIN = "give the call that made it again, to compute it"
CHUNK = re.compile(r"([^/]+)/c((?:\.\d+)+)")
"""Name of a chunk's file in its store."""
UNREADABLE = (ValueError, LookupError, TypeError, AttributeError, RecursionError)
"""Errors of JSON that is another than was written."""
FORMAT = CHECKED = 2
"""Version of the way in which stores are written, another one is another question; the first
version in which every file has a checksum."""
LEVEL = 3
"""Level of compression."""
LARGEST = 2**22
"""Largest number of values in a chunk of a coordinate."""
RESUME = "; the finished chunks are kept: give the same command again to go on"


# --- what is whole ---


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
        match = CHUNK.fullmatch(name)
        if match is None:
            return content
        block = tuple(map(int, match[2].split(".")[1:]))[: self.axes]
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
        match = CHUNK.fullmatch(name)
        words.append(f"chunk {match[2][1:]} of {match[1]}" if match else name)
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

    dataset: xarray.Dataset = xarray.open_zarr(_checking_store(seals, complete), chunks=None)
    for name in (FILES, ITSELF):
        dataset.attrs.pop(name, None)
    return dataset


def opened_store(path: str | os.PathLike[str], *, lazy: bool = False) -> xarray.Dataset:
    """A dataset from a Zarr folder, refused where chunks are missing or damaged.

    Parameters
    ----------
    path
        The folder.
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
    import xarray

    try:
        head = json.loads((folder / HEAD).read_bytes())["attributes"]
        asked = json.loads(head[QUESTION])
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
    layout: Layout,
    variables: Sequence[Variable],
    coords: Mapping[str, Any],
    attrs: Mapping[str, Any],
    question: Mapping[str, Any],
) -> dict[str, str]:
    """Everything that the files of a store depend on, as texts by name, without the citation."""
    import xarray

    every = xarray.Dataset(coords=dict(coords)).variables
    arrays = [[v.name, v.dtype, v.fill, v.attrs, v.more] for v in variables]
    texts = {
        **{f"its {name}": plain_json(value) for name, value in question.items()},
        **{f"attribute {name}": plain_json(value) for name, value in attrs.items()},
        "the number of cells": plain_json([layout.dims, layout.shape]),
        "the chunk": plain_json(layout.chunk),
        "the arrays": plain_json(arrays, allow_nan=True),
        "the coordinates": digest_of_arrays(every),
        "the format": plain_json([FORMAT, __version__]),
    }
    return counted(texts)


def same_question(head: Mapping[str, Any], asked: Mapping[str, str]) -> bool:
    """Whether a store holds the question."""
    return bool(head[PRINT] == fingerprint_of(asked))


# --- writing ---


@dataclass(frozen=True)
class ChunkFiles:
    """Writes chunks of a store, in any process."""

    folder: Path
    """Folder of the store."""
    layout: Layout
    """The grid of chunks."""
    variables: tuple[Variable, ...]
    """The arrays, the marker first."""
    seals: Seals
    """Records of the chunks."""

    def done(self, block: Block) -> bool:
        """Whether a chunk is there, and whole."""
        return self.seals.damaged(block) == []

    def add(self, block: Block, arrays: Arrays) -> None:
        """Write the files of a chunk, its record last; each has its name when it is whole."""
        whole = check_chunk(self.variables, arrays, self.layout.count(block))
        marker, *others = self.variables
        files = {
            f"{v.name}/{file_name(v, block)}": self._encoded(v, block, whole[v.name])
            for v in (*others, marker)
        }
        for name, content in files.items():
            _write(self.folder / name, content)
        _write(self.seals.path(block), self.seals.written(block, files))

    def clean(self) -> None:
        """Remove what killed writers left."""
        for folder in (self.folder, *(self.folder / v.name for v in self.variables)):
            clear(folder, always=True)

    def _encoded(self, variable: Variable, block: Block, values: NDArray[Any]) -> bytes:
        """Bytes of a chunk file; a chunk at an edge is filled up, as Zarr asks."""
        from numcodecs.zstd import Zstd

        lengths = tuple(n for _, n in variable.more)
        sizes = self.layout.sizes(block)
        kind = np.dtype(variable.dtype).newbyteorder("<")
        array = np.full((*self.layout.chunk, *lengths), variable.fill, kind)
        array[tuple(map(slice, sizes))] = values.reshape(*sizes, *lengths)
        return bytes(Zstd(level=LEVEL, checksum=True).encode(array))


@contextmanager
def _resumable(path: Path) -> Iterator[None]:
    try:
        with refusing(path):
            yield
    except FileError as error:
        raise FileError(f"{str(error).rstrip('.')}{RESUME}.") from None


def _write(path: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    with _resumable(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, content, overwrite=True, result=False, durable=True)


def file_name(variable: Variable, block: Block) -> str:
    """Name of a chunk's file in the folder of its array.

    Examples
    --------
    >>> file_name(Variable("last", "float64", 0.0, more=(("state", 6),)), (2, 0))
    'c.2.0.0'
    """
    return ".".join(["c", *map(str, block), *("0" for _ in variable.more)])


class ZarrStore:
    """A store in a Zarr folder, readable by `xarray.open_zarr`, created or resumed.

    A folder has its name once every coordinate and attribute is in it.  A chunk is there exactly
    if its record is, and all its files are those of the record; a damaged one is named and counts
    as missing.  Several runs may fill one store at the same time: each file is whole and all write
    the same bytes.

    Parameters
    ----------
    path
        Folder of the store; resumed where it holds the same question.
    layout
        The grid of chunks.
    variables
        The arrays, the marker first.
    coords
        Coordinates by name, as `xarray.Dataset` takes them.
    attrs
        Attributes of the dataset; they must fit JSON.
    question
        What the numbers depend on, as JSON: a store that was made with other arguments is refused.
    overwrite
        Whether a store that was made with other arguments may be replaced; "same": it may
        not, as False.

    Raises
    ------
    FileError
        If the folder cannot be used, or was made with other arguments, or holds other files.
    StabilityError
        If the package zarr is missing.

    Source: Zarr core specification, version 3; tests/jobs/test_stores.py.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     layout = Layout(("x",), (3,), (2,))
    ...     parts = (layout, (Variable("outcome", "int8", -1),), {"x": [0.1, 0.2, 0.3]})
    ...     store = ZarrStore(Path(folder) / "a.zarr", *parts)
    ...     store.add((1,), {"outcome": np.array([5], dtype=np.int8)})
    ...     again = ZarrStore(Path(folder) / "a.zarr", *parts)
    ...     again.missing(), again.dataset().outcome.values.tolist()
    ([(0,)], [-1, -1, 5])
    """

    def __init__(
        self,
        path: str | PathLike[str],
        layout: Layout,
        variables: tuple[Variable, ...],
        coords: Mapping[str, Any] | None = None,
        attrs: Mapping[str, Any] | None = None,
        question: Mapping[str, Any] | None = None,
        *,
        overwrite: Overwrite = False,
    ) -> None:
        ZARR.check_installed()
        self.layout, self.variables = layout, tuple(variables)
        overwrite = overwriting(overwrite)
        self.folder: Path = check_folder(path).resolve()
        if Path.cwd().is_relative_to(self.folder):  # a new store would take its place
            raise FileError(
                f"{path_text(self.folder)} is the current folder or holds it; give the name of a "
                "folder for the store."
            )
        self._given = coords or {}, attrs or {}
        asked = asked_of(layout, self.variables, *self._given, question or {})
        self._asked = asked
        head = head_of(self.folder)
        if head is not None and not same_question(head, asked):
            if overwrite is not True:
                raise FileError(
                    f"{path_text(path)} was made with other arguments ({difference(head, asked)}); "
                    "choose another name, or replace it with --overwrite (overwrite=True)."
                )
            self._remove()
            head = None
        if head is None:
            self._create(self._files(), asked)
        elif bad := damaged_files(self.folder):
            self._warn_damaged(bad, "written")
            files = self._files()
            for name in sorted(files, key=lambda name: name == HEAD):
                _write(self.folder / name, files[name])
        seals = Seals(self.folder, self.variables[0].name, len(layout.dims), fingerprint_of(asked))
        self.writer = ChunkFiles(self.folder, layout, self.variables, seals)
        self.writer.clean()

    def missing(self) -> list[Block]:
        """Chunks that are not there or damaged, in row-major order; damaged ones are named."""
        blocks, bad = [], []
        for block in self.layout.blocks():
            damaged = self.writer.seals.damaged(block)
            if damaged != []:
                blocks.append(block)
                bad += damaged or []
        if bad:
            self._warn_damaged(bad, "computed")
        return blocks

    def _warn_damaged(self, bad: list[str], how: str) -> None:
        """Name the damaged files, which are made again."""
        warned(f"{path_text(self.folder)}: {named(bad)} is damaged, and is {how} again.")

    def add(self, block: Block, arrays: Arrays) -> None:
        """Add a whole chunk, the marker last."""
        self.writer.add(block, arrays)

    def attach(self, frame: xarray.Dataset) -> None:
        """Add whole arrays on axes of their own, in place of those that were attached before.

        The metadata of the store name them last; until then the store is one without them.
        """
        bare, whole, head = self._files(), self._files(frame), self.folder / HEAD
        more = [n for n in sorted(whole, key=lambda n: (n.endswith(HEAD), n)) if n not in bare]
        if head.read_bytes() == whole[HEAD] and not damaged_files(self.folder):
            return
        _write(head, bare[HEAD])
        for name in {Path(n).parts[0] for n in more}:
            shutil.rmtree(self.folder / name, ignore_errors=True)
        for name in more:
            _write(self.folder / name, whole[name])
        _write(head, whole[HEAD])

    def _files(self, more: xarray.Dataset | None = None) -> dict[str, bytes]:
        return _skeleton(self.layout, self.variables, *self._given, self._asked, more)

    def dataset(self) -> xarray.Dataset:
        """The dataset, read when it is used; a damaged chunk is refused then."""
        return dataset_of(self.writer.seals)

    def _create(self, files: Mapping[str, bytes], asked: Mapping[str, Any]) -> None:
        """Write a folder under a temporary name, and rename it."""
        draft = self.folder.parent / temporary(self.folder.suffix)
        clear(self.folder.parent)
        try:
            with refusing(self.folder):
                for name, content in files.items():
                    (draft / name).parent.mkdir(parents=True, exist_ok=True)
                    (draft / name).write_bytes(content)
                try:
                    if self.folder.is_dir():
                        self.folder.rmdir()
                    draft.rename(self.folder)
                except OSError:  # another run has made it meanwhile
                    head = head_of(self.folder)
                    if head is None or not same_question(head, asked):
                        raise
        finally:
            shutil.rmtree(draft, ignore_errors=True)

    def _remove(self) -> None:
        """Take the name from a store at once, then remove its files."""
        old = self.folder.parent / temporary(self.folder.suffix)
        with refusing(self.folder):
            self.folder.rename(old)
            shutil.rmtree(old)


def head_of(folder: Path) -> dict[str, Any] | None:
    """Attributes of a store that is there; None where there is no folder, or an empty one."""
    path = folder / HEAD
    with refusing(folder, "used"):
        if not folder.is_dir() or not any(folder.iterdir()):
            return None
        text = path.read_bytes() if path.is_file() else b""
    with suppress(ValueError, KeyError, TypeError):
        attributes = json.loads(text)["attributes"]
        if isinstance(attributes[PRINT], str):
            return dict(attributes)
    raise FileError(f"{path_text(folder)} is no store of ours, or is damaged; choose another name.")


# --- metadata ---


def _skeleton(
    layout: Layout,
    variables: tuple[Variable, ...],
    coords: Mapping[str, Any],
    attrs: Mapping[str, Any],
    asked: Mapping[str, str],
    more: xarray.Dataset | None = None,
) -> dict[str, bytes]:
    """Files of a store without chunks, by path, and those of further whole arrays."""
    import xarray
    import zarr
    from zarr.codecs import ZstdCodec
    from zarr.storage import MemoryStore

    files: dict[str, Any] = {}
    memory = MemoryStore(files)
    frame = xarray.Dataset(coords=dict(coords))
    texts = [name for name, values in frame.coords.items() if values.dtype.kind in "UO"]
    # of variable length, since Zarr specifies no others
    frame = frame.assign_coords(
        {n: frame[n].astype(np.dtypes.StringDType(), keep_attrs=True) for n in texts}
    )
    frame.attrs = json.loads(plain_json(dict(attrs)))
    if more is not None:
        frame = frame.assign(more.variables)
        frame.attrs |= json.loads(plain_json(dict(more.attrs)))
    frame.attrs |= {MARKER: variables[0].name, QUESTION: plain_json(dict(asked))}
    frame.attrs[PRINT] = fingerprint_of(asked)
    chunks = {
        n: {"chunks": tuple(min(s, LARGEST) for s in c.shape)}
        for n, c in frame.coords.items()
        if c.size > LARGEST
    }
    with warnings.catch_warnings():
        # consolidated metadata and strings are extensions of the format
        warnings.filterwarnings("ignore", module=r"(zarr|xarray)\b")
        frame.to_zarr(memory, zarr_format=3, consolidated=False, encoding=chunks)
        group = zarr.open_group(memory, mode="r+", zarr_format=3)
        coordinate_names = [v.name for v in variables if v.coordinate]
        if coordinate_names:  # CF's way to say which arrays are coordinates
            before = group.attrs.get("coordinates", "").split()
            group.attrs["coordinates"] = " ".join([*before, *coordinate_names])
        for variable in variables:
            group.create_array(
                **_array(layout, variable, frame),
                filters=None,
                compressors=ZstdCodec(level=LEVEL, checksum=True),
            )
        zarr.consolidate_metadata(memory)
    contents = {name: value.to_bytes() for name, value in sorted(files.items())}
    head = contents.pop(HEAD)
    return contents | {HEAD: sealed_head(head, contents)}


def _array(layout: Layout, variable: Variable, frame: xarray.Dataset) -> dict[str, Any]:
    """Metadata of an array, with the coordinates that lie on its axes."""
    lengths, kind = tuple(n for _, n in variable.more), np.dtype(variable.dtype).newbyteorder("<")
    dims = (*layout.dims, *(n for n, _ in variable.more))
    near = sorted(
        str(name)
        for name, values in frame.coords.items()
        if name not in frame.dims and set(values.dims) <= set(dims)
    )
    attributes = json.loads(plain_json(dict(variable.attrs)))
    return {
        "name": variable.name,
        "dtype": kind,
        "fill_value": variable.fill,
        "shape": (*layout.shape, *lengths),
        "chunks": (*layout.chunk, *lengths),
        "attributes": attributes | ({"coordinates": " ".join(near)} if near else {}),
        "dimension_names": dims,
        "chunk_key_encoding": {"name": "default", "separator": "."},
    }
