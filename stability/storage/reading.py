"""Opening of NetCDF files: the checksum first; another process first reads a file without one."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import FileError
from .checksum import ATTRIBUTE, intact
from .netcdf import loaded
from .targets import path_text, place, refusing

if TYPE_CHECKING:
    import xarray


def opened(
    path: str | os.PathLike[str], form: str, what: str, *, lazy: bool = False
) -> xarray.Dataset:
    """Open a NetCDF file of this package as a dataset.

    Parameters
    ----------
    path
        File to read.
    form
        Required value of the attribute `format`.
    what
        Expected content, in words.
    lazy
        Whether to leave the data in the file.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    FileError
        If there is no such file, or it is damaged, or not a NetCDF file, or not of that format.
    """
    source = place(path)
    with refusing(source, "read"):
        if not source.is_file():
            raise FileError(f"{path_text(source)} is not a file; give {what} written by stability.")
        right = intact(source)
    if right is None:
        _check_head(source)
    if right is False:
        raise FileError(
            f"{path_text(source)} is damaged or was changed after it was written: its checksum is "
            "wrong."
        )
    if right is None:  # nothing in the file can be trusted, not even that HDF5 comes to an end
        from .inspection import inspect

        inspect(source, form, what, lazy=lazy)
    dataset = loaded(source, form, what, lazy=lazy)
    if right is None and (ATTRIBUTE in dataset.attrs or not (lazy or _plausible(dataset))):
        dataset.close()
        raise FileError(
            f"{path_text(source)} is damaged or was changed after it was written: its checksum is "
            "missing or a flag has no meaning."
        )
    dataset.attrs.pop(ATTRIBUTE, None)
    return dataset


def _check_head(source: Path) -> None:
    """Refuse at once a file that is not HDF5, or shorter than its superblock says.

    Source: HDF5 File Format Specification, version 3.0, II.A.
    """
    with source.open("rb") as handle:
        head = handle.read(48)
    if len(head) < 48 or not head.startswith(b"\x89HDF\r\n\x1a\n"):
        raise FileError(
            f"{path_text(source)} cannot be read as NetCDF (it is not HDF5); it may be damaged or "
            "of another format."
        )
    start = {0: 40, 1: 44}.get(head[8], 28)
    if int.from_bytes(head[start : start + 8], "little") > source.stat().st_size:
        raise FileError(f"{path_text(source)} is damaged: it is shorter than it says.")


def _plausible(dataset: xarray.Dataset) -> bool:
    """Whether every flag of a file without a checksum is one of those that the file lists."""
    import numpy as np

    return all(
        bool(np.isin(v.values, v.attrs["flag_values"]).all())
        for v in dataset.variables.values()
        if "flag_values" in v.attrs
    )
