"""NetCDF files of the package: packed with a checksum, loaded after a check of their sizes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import FileError
from .checksum import ATTRIBUTE, STATEMENT, sealed
from .targets import path_text

if TYPE_CHECKING:
    import xarray


ENGINE = "h5netcdf"
DEFLATE = 1100
"""Most bytes that one byte of a compressed chunk can hold (zlib: 1032), with room for headers."""
SMALL = 2**22
"""Size up to which a variable is not checked [bytes]."""


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


def loaded(source: Path, form: str, what: str, *, lazy: bool) -> xarray.Dataset:
    """Load a NetCDF file; it is refused before its data are read where it declares too much.

    Parameters
    ----------
    source, form, what, lazy
        As for `stability.storage.reading.opened`.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    FileError
        If the file cannot be read, or is not of that format.
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
    # h5py, h5netcdf and xarray raise errors of any kind on a damaged part
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
        Whether the data stay in the file, so that free memory does not matter.

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
    """Names and variables of the file itself; the package's files have no groups."""
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
