"""A store of chunks in a Zarr folder: one file for each variable of each chunk."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .chunks import Arrays, Block, Layout, Variable, Writer

if TYPE_CHECKING:
    import xarray


class ZarrStore:
    """A store in a Zarr folder, readable by `xarray.open_zarr`, created or resumed.

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
        What the numbers depend on, as JSON: a store of another question is refused.
    overwrite
        Whether a store of another question may be replaced.
    """

    def __init__(
        self, path: str | PathLike[str], layout: Layout, variables: tuple[Variable, ...],
        coords: Mapping[str, Any] | None = None, attrs: Mapping[str, Any] | None = None,
        question: Mapping[str, Any] | None = None, *, overwrite: bool = False,
    ) -> None:  # fmt: skip
        raise NotImplementedError

    layout: Layout
    variables: tuple[Variable, ...]
    folder: Path | None
    writer: Writer | None

    def missing(self) -> list[Block]:
        """Chunks that are not there, in row-major order."""
        raise NotImplementedError

    def write(self, block: Block, arrays: Arrays) -> None:
        """Add a whole chunk, the marker last."""
        raise NotImplementedError

    def dataset(self) -> xarray.Dataset:
        """The dataset, read when it is used."""
        raise NotImplementedError
