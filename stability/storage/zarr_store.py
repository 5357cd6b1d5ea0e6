"""A store of chunks in a Zarr folder: one file for each variable of each chunk.

Zarr's own writer is atomic, but a killed one leaves files that nothing removes, and it leaves out
chunks of fill values, by which a chunk could not be seen to be there.  So it makes the metadata
and the coordinates, in memory, and the chunks are written here, by its own codec.
"""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..base.checks import flag
from ..base.errors import FileError, StabilityError, warned
from .chunks import Arrays, Block, Layout, Variable, check_chunk
from .files import write_file
from .litter import clear, temporary
from .targets import check_folder, path_text, refusing
from .zarr_folder import (
    HEAD,
    MARKER,
    MISSING,
    PRINT,
    QUESTION,
    Seals,
    asked_of,
    damaged_files,
    dataset_of,
    difference,
    fingerprint_of,
    named,
    plain_json,
    same_question,
    sealed_head,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray

LEVEL = 3
"""Level of compression."""
LARGEST = 2**22
"""Largest number of values in a chunk of a coordinate."""
RESUME = "; the finished chunks are kept: give the same command again to go on"


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
        Whether a store that was made with other arguments may be replaced.

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
        overwrite: bool = False,
    ) -> None:
        self.layout, self.variables = layout, tuple(variables)
        overwrite = flag("overwrite", overwrite)
        self.folder: Path = check_folder(path).resolve()
        if Path.cwd().is_relative_to(self.folder):  # a new store would take its place
            raise FileError(
                f"{path_text(self.folder)} is the current folder or holds it; give the name of a "
                "folder for the store."
            )
        self._given = coords or {}, attrs or {}
        arrays = [[v.name, v.dtype, v.fill, v.attrs, v.more] for v in self.variables]
        asked = self._asked = asked_of(
            [layout.dims, layout.shape],
            layout.chunk,
            arrays,
            coords or {},
            attrs or {},
            question or {},
        )
        head = head_of(self.folder)
        if head is not None and not same_question(head, asked):
            if not overwrite:
                raise FileError(
                    f"{path_text(path)} was made with other arguments ({difference(head, asked)}); "
                    "choose another name, or replace it with --overwrite (overwrite=True)."
                )
            self._remove()
            head = None
        if head is None:
            self._create(self._files(), asked)
        elif bad := damaged_files(self.folder):
            self._told(bad, "written")
            files = self._files()
            for name in sorted(files, key=lambda name: name == HEAD):
                _write(self.folder / name, files[name])
        seals = Seals(self.folder, self.variables[0].name, len(layout.dims), fingerprint_of(asked))
        self.writer = ChunkFiles(self.folder, layout, self.variables, seals)
        self.writer.clean()

    def missing(self) -> list[Block]:
        """Chunks that are not there or damaged, in row-major order; damaged ones are named."""
        found, bad = [], []
        for block in self.layout.blocks():
            damaged = self.writer.seals.damaged(block)
            if damaged != []:
                found.append(block)
                bad += damaged or []
        if bad:
            self._told(bad, "computed")
        return found

    def _told(self, bad: list[str], how: str) -> None:
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
    try:
        import xarray
        import zarr
        from zarr.codecs import ZstdCodec
        from zarr.storage import MemoryStore
    except ImportError:
        raise StabilityError(f"{MISSING}, or give a NetCDF file.") from None
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
        own = [v.name for v in variables if v.coordinate]
        if own:  # CF's way to say which arrays are coordinates
            before = group.attrs.get("coordinates", "").split()
            group.attrs["coordinates"] = " ".join([*before, *own])
        for variable in variables:
            group.create_array(
                **_array(layout, variable, frame),
                filters=None,
                compressors=ZstdCodec(level=LEVEL, checksum=True),
            )
        zarr.consolidate_metadata(memory)
    found = {name: value.to_bytes() for name, value in sorted(files.items())}
    head = found.pop(HEAD)
    return found | {HEAD: sealed_head(head, found)}


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
