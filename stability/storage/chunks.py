"""Arrays in chunks: their grid, the variables of a result, and a store in memory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, shown
from .datasets import Labelled, labelled

if TYPE_CHECKING:
    import xarray

Block = tuple[int, ...]
"""Indices of a chunk in its grid."""
Arrays = Mapping[str, NDArray[Any]]
"""Arrays of some cells by variable: cells in row-major order, then the further axes."""


@dataclass(frozen=True)
class Layout:
    """A grid of chunks over an array of cells.

    Parameters
    ----------
    dims
        Names of the axes.
    shape
        Number of cells along each axis.
    chunk
        Number of cells of a chunk along each axis; the last chunk of an axis may be smaller.

    Raises
    ------
    ParameterError
        If the three differ in length, a number is below 1, or a name comes twice.

    Examples
    --------
    >>> layout = Layout(("y", "x"), (3, 5), (2, 5))
    >>> layout.blocks(), layout.sizes((1, 0)), layout.slices((1, 0))
    ([(0, 0), (1, 0)], (1, 5), (slice(2, 3, None), slice(0, 5, None)))
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]

    def __post_init__(self) -> None:
        alike = len(self.dims) == len(self.shape) == len(self.chunk) > 0
        if not alike or len(set(self.dims)) < len(self.dims):
            raise ParameterError(
                f"the chunks have axes {shown(self.dims)}, shape {shown(self.shape)} and chunk "
                f"{shown(self.chunk)}; give one number for each axis, and different names."
            )
        if min(*self.shape, *self.chunk) < 1:
            raise ParameterError(
                f"the chunks have shape {shown(self.shape)} and chunk {shown(self.chunk)}; the "
                "numbers must be at least 1."
            )

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of chunks along each axis."""
        return tuple(-(-n // c) for n, c in zip(self.shape, self.chunk, strict=True))

    @property
    def total(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    def blocks(self) -> list[Block]:
        """Indices of the chunks in row-major order."""
        return list(product(*map(range, self.counts)))

    def slices(self, block: Block) -> tuple[slice, ...]:
        """Cells of a chunk along each axis."""
        return tuple(
            slice(i * c, min((i + 1) * c, n))
            for i, c, n in zip(block, self.chunk, self.shape, strict=True)
        )

    def sizes(self, block: Block) -> tuple[int, ...]:
        """Number of cells of a chunk along each axis."""
        return tuple(s.stop - s.start for s in self.slices(block))

    def count(self, block: Block) -> int:
        """Number of cells of a chunk."""
        return math.prod(self.sizes(block))

    def number(self, block: Block, cell: int) -> int:
        """Number of a cell in the whole array, from its number in a chunk; both row-major.

        Examples
        --------
        >>> Layout(("y", "x"), (4, 5), (2, 3)).number((1, 1), 2)
        18
        """
        inside = np.unravel_index(cell, self.sizes(block))
        at = tuple(s.start + int(i) for s, i in zip(self.slices(block), inside, strict=True))
        return int(np.ravel_multi_index(at, self.shape))


def even_chunk(shape: tuple[int, ...], size: int) -> tuple[int, ...]:
    """A chunk of about `size` cells, as even as the axes allow.

    Examples
    --------
    >>> even_chunk((10, 1000), 400)
    (10, 40)
    """
    chunk, left = [1] * len(shape), float(size)
    for i, axis in enumerate(sorted(range(len(shape)), key=lambda a: shape[a])):
        side = left ** (1 / (len(shape) - i))
        chunk[axis] = max(1, min(shape[axis], round(side)))
        left /= chunk[axis]
    return tuple(chunk)


@dataclass(frozen=True)
class Variable:
    """One array of a result.

    The first variable of a store is its marker: a chunk exists exactly if its marker does.  The
    fill value of the marker is no result.
    """

    name: str
    """Name of the array."""
    dtype: str
    """NumPy's name of the type, such as `int8` or `float64`."""
    fill: Any
    """Value of cells that are not there yet."""
    attrs: Mapping[str, Any] = field(default_factory=dict)
    """Unit, flags, long name."""
    more: tuple[tuple[str, int], ...] = ()
    """Names and lengths of further axes after those of the layout."""
    coordinate: bool = False
    """Whether it says which cells these are, so that it is a coordinate of the dataset."""

    def checked(self, values: Any, cells: int) -> NDArray[Any]:
        """Values of some cells as an array of the variable."""
        array, shape = np.asarray(values), (cells, *(n for _, n in self.more))
        if array.shape != shape or not np.can_cast(array.dtype, self.dtype, "same_kind"):
            raise ParameterError(
                f"{self.name} of a chunk is {shown(array)}; the work must give shape {shape}, "
                f"{self.dtype}."
            )
        return array.astype(self.dtype, copy=False)


def check_chunk(variables: tuple[Variable, ...], arrays: Arrays, cells: int) -> Arrays:
    """Arrays of a chunk, checked: every variable, the right shapes, a result in every cell."""
    names = [v.name for v in variables]
    if set(arrays) != set(names):
        raise ParameterError(f"the work gave {shown(sorted(arrays))}; it must give {names}.")
    checked = {v.name: v.checked(arrays[v.name], cells) for v in variables}
    marker = variables[0]
    if bool((checked[marker.name] == marker.fill).any()):
        raise ParameterError(
            f"{marker.name} holds {marker.fill}, which marks cells that are not there yet; give "
            "another value."
        )
    return checked


class Writer(Protocol):
    """What a worker writes chunks with; picklable."""

    def done(self, block: Block) -> bool:
        """Whether a chunk is there."""

    def add(self, block: Block, arrays: Arrays) -> None:
        """Write a whole chunk, the marker last."""

    def clean(self) -> None:
        """Remove what workers that ended left."""


class Store(Protocol):
    """Chunks of a result, each there whole or not at all."""

    @property
    def layout(self) -> Layout:
        """The grid of chunks."""

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The arrays, the marker first."""

    @property
    def folder(self) -> Path | None:
        """Folder that survives this process; None for memory."""

    @property
    def writer(self) -> Writer | None:
        """What a worker writes with, in any process; None where only this process can write."""

    def missing(self) -> list[Block]:
        """Chunks that are not there, in row-major order."""

    def add(self, block: Block, arrays: Arrays) -> None:
        """Add a whole chunk, the marker last."""

    def attach(self, frame: xarray.Dataset) -> None:
        """Add whole arrays on axes of their own, in place of those that were attached before."""

    def dataset(self) -> xarray.Dataset:
        """All arrays with their coordinates and attributes; cells not there hold fill values."""


class Memory:
    """A store in memory.

    Parameters
    ----------
    layout
        The grid of chunks.
    variables
        The arrays, the marker first.
    coords
        Dimensions, values and attributes of coordinates by name.
    attrs
        Attributes of the dataset.

    Examples
    --------
    >>> store = Memory(Layout(("x",), (3,), (2,)), (Variable("outcome", "int8", -1),))
    >>> store.add((0,), {"outcome": np.array([5, 6], dtype=np.int8)})
    >>> store.missing(), store.dataset().outcome.values.tolist()
    ([(1,)], [5, 6, -1])
    """

    folder: Path | None = None
    writer: Writer | None = None

    def __init__(
        self,
        layout: Layout,
        variables: tuple[Variable, ...],
        coords: Mapping[str, Labelled] | None = None,
        attrs: Mapping[str, Any] | None = None,
    ) -> None:
        self.layout, self.variables = layout, tuple(variables)
        self.coords, self.attrs = dict(coords or {}), dict(attrs or {})
        self._there: set[Block] = set()
        self._attached: xarray.Dataset | None = None
        self._arrays = {
            v.name: np.full((*layout.shape, *(n for _, n in v.more)), v.fill, v.dtype)
            for v in self.variables
        }

    def missing(self) -> list[Block]:
        """Chunks that are not there, in row-major order."""
        return [block for block in self.layout.blocks() if block not in self._there]

    def add(self, block: Block, arrays: Arrays) -> None:
        """Add a whole chunk."""
        sizes = self.layout.sizes(block)
        whole = check_chunk(self.variables, arrays, math.prod(sizes))
        for variable in self.variables:
            values = whole[variable.name]
            self._arrays[variable.name][self.layout.slices(block)] = values.reshape(
                *sizes, *values.shape[1:]
            )
        self._there.add(block)

    def attach(self, frame: xarray.Dataset) -> None:
        """Add whole arrays on axes of their own."""
        self._attached = frame

    def dataset(self) -> xarray.Dataset:
        """All arrays with their coordinates and attributes, without a copy."""
        variables: dict[str, Labelled] = {}
        coordinates: dict[str, Labelled] = {}
        for v in self.variables:
            dims = (*self.layout.dims, *(n for n, _ in v.more))
            kind = coordinates if v.coordinate else variables
            kind[v.name] = dims, self._arrays[v.name], v.attrs
        dataset = labelled(variables, coordinates | self.coords, self.attrs)
        more = self._attached
        return dataset if more is None else dataset.assign(more.variables).assign_attrs(more.attrs)
