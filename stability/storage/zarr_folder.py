"""Reading a Zarr folder of this package: whole, or refused."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

from ..base.errors import FileError, StabilityError
from .targets import path_text, place

if TYPE_CHECKING:
    import xarray

MARKER = "marker"
"""Attribute that names the variable whose chunk files say which chunks are there."""
MISSING = "a Zarr store needs the package zarr; `pip install stability[scale]`"


def opened_store(
    path: str | os.PathLike[str], form: str, what: str, *, lazy: bool = False
) -> xarray.Dataset:
    """A dataset from a Zarr folder, refused where chunks are missing.

    Parameters
    ----------
    path
        The folder.
    form
        Value that its attribute `format` must have.
    what
        Words for its content, such as "a map".
    lazy
        Whether to leave the data in the folder until it is used.

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
        dataset: xarray.Dataset = xarray.open_zarr(folder, chunks=None)
        ours = dataset.attrs.get("format") == form
        there, count = _chunks(folder, dataset) if ours else (0, 0)
        if there == count and not lazy:
            dataset.load()
    except Exception as error:  # zarr and its codecs raise any
        why = "there is none" if not folder.exists() else type(error).__name__
        raise FileError(
            f"{path_text(path)} cannot be read as a Zarr store ({why}); it may be damaged."
        ) from None
    if not ours:
        raise FileError(f"{path_text(path)} is not {what} of this package.")
    if there < count:
        raise FileError(
            f"{path_text(path)} holds {there} of {count} chunks; give the command that began it "
            "again to go on."
        )
    return dataset


def _chunks(folder: Any, dataset: xarray.Dataset) -> tuple[int, int]:
    """Number of chunks that are there, and of all."""
    name = dataset.attrs[MARKER]
    variable = dataset.variables[name]
    chunk = variable.encoding["chunks"]
    count = math.prod(-(-n // c) for n, c in zip(variable.shape, chunk, strict=True))
    return sum(entry.startswith("c.") for entry in os.listdir(folder / name)), count
