"""NetCDF files of the package: packed with a checksum, opened after it has been checked."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .checksum import ATTRIBUTE, STATEMENT, intact, sealed
from .errors import FileError
from .targets import path_text, place, refusing

if TYPE_CHECKING:
    import xarray

ENGINE = "h5netcdf"
DEFLATE = 1100
"""Bytes that a byte of a compressed chunk may hold at most (zlib: 1032), with room for heads."""
SMALL = 2**22
"""Bytes of a variable that are not worth a question."""


def packed(dataset: xarray.Dataset, compress: Mapping[str, Any] | None = None) -> bytes:
    """A dataset as the bytes of a NetCDF-4 file with a checksum as its last line.

    HDF5 and the NetCDF library ignore what follows the end that the file states.

    Parameters
    ----------
    dataset
        Real variables only.
    compress
        Encoding by variable.

    Returns
    -------
    bytes
    """
    marked = dataset.assign_attrs({ATTRIBUTE: STATEMENT})
    return sealed(marked.to_netcdf(engine="h5netcdf", encoding=dict(compress or {})))


def opened(
    path: str | os.PathLike[str], form: str, what: str, *, lazy: bool = False
) -> xarray.Dataset:
    """A NetCDF file of ours as a dataset, or a sentence why not.

    Parameters
    ----------
    path
        File to read.
    form
        What its attribute `format` must be.
    what
        What it should hold, in words.
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
    if right is None:  # nothing in it is to be trusted, the time that HDF5 takes for it included
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
    """Refuse at once what is not HDF5, or shorter than its superblock says.

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


def loaded(source: Path, form: str, what: str, *, lazy: bool) -> xarray.Dataset:
    """A NetCDF file as a dataset, refused before its data are read where it declares too much.

    Parameters
    ----------
    source, form, what, lazy
        As for `opened`.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    FileError
        If it cannot be read, or is not of that format.
    """
    import xarray

    try:
        check_sizes(source, lazy=lazy)
        file = xarray.open_dataset(source, engine=ENGINE)
        marker = "outcome" if what == "a motion" else "verdict"
        try:
            if str(file.attrs.get("format")) != form or marker not in file.variables:
                raise FileError(
                    f"{path_text(source)} is a NetCDF file but not {what} written by stability."
                )
            if not lazy:
                file.load()
        except BaseException:
            file.close()
            raise
        if not lazy:
            file.close()
    except FileError:
        raise
    except MemoryError:
        raise FileError(
            f"{path_text(source)} needs more memory than there is; read it with lazy=True."
        ) from None
    # h5py, h5netcdf and xarray raise whatever a damaged part leads them to
    except Exception as error:
        reason = (str(error) or type(error).__name__).partition("\n")[0][:80]
        raise FileError(
            f"{path_text(source)} cannot be read as NetCDF ({reason}); it may be damaged or of "
            "another format."
        ) from None
    return file


def check_sizes(source: Path, *, lazy: bool) -> int:
    """Compare what the variables declare with what the file holds and with the memory.

    Parameters
    ----------
    source
        The file.
    lazy
        Whether the data stay in the file, so that memory is no matter.

    Returns
    -------
    int
        Bytes of all variables.

    Raises
    ------
    FileError
        If a variable declares more than its part of the file can hold, or all together more than
        the memory that is free.
    """
    import h5py

    total = 0
    with h5py.File(source, "r") as file:
        for name, variable in _variables(file):
            size = variable.size * variable.dtype.itemsize
            total += size
            held = variable.id.get_storage_size()
            if size > SMALL and (size > DEFLATE * held or _twice(variable)):
                raise FileError(
                    f"{path_text(source)} is damaged: {path_text(name)} declares {size:.3g} bytes, "
                    f"and the file holds {held} for it."
                )
    free = available()
    if not lazy and free is not None and total > free:
        raise FileError(
            f"{path_text(source)} holds {total / 2**30:.3g} GiB, and {free / 2**30:.3g} GiB of "
            "memory are free; read it with lazy=True."
        )
    return total


def _variables(file: Any) -> Iterator[tuple[str, Any]]:
    """The variables that lie in the file itself; none of ours has groups."""
    import h5py

    for name in file:
        if file.get(name, getclass=True, getlink=True) is not h5py.HardLink:
            raise FileError(f"{path_text(name)} of the file leads elsewhere; it is none of ours.")
        found = file[name]
        if isinstance(found, h5py.Dataset):
            yield name, found


def _twice(variable: Any) -> bool:
    """Whether a variable is compressed more than once, which multiplies what a byte can hold."""
    import h5py

    pipeline = variable.id.get_create_plist()
    kinds = [pipeline.get_filter(i)[0] for i in range(pipeline.get_nfilters())]
    return (
        len([k for k in kinds if k not in (h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)])
        > 1
    )


def _plausible(dataset: xarray.Dataset) -> bool:
    """Whether every flag of a file without a checksum is one of those that it lists."""
    import numpy as np

    return all(
        bool(np.isin(v.values, v.attrs["flag_values"]).all())
        for v in dataset.variables.values()
        if "flag_values" in v.attrs
    )


def available() -> int | None:
    """Bytes of memory that are free for this process; None where the system does not tell.

    Returns
    -------
    int or None
    """
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
    return None
