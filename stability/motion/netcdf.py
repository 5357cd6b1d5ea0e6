"""Motions as NetCDF files."""

from __future__ import annotations

import os
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from ..base.errors import FileError
from .dataset import FORMAT

if TYPE_CHECKING:
    import xarray


def write_motion(
    dataset: xarray.Dataset, path: str | os.PathLike[str], *, overwrite: bool = False
) -> FilePath:
    """Write a motion to NetCDF-4 with a checksum.

    Parameters
    ----------
    dataset
        Dataset from `simulate`.
    path
        File to write.
    overwrite
        Whether an existing file may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    FileError
        If the file cannot be written; no part of a file is left.

    Source: NetCDF-4 by h5netcdf, with a checksum of this package: tests/faults/test_damage.py.

    Examples
    --------
    >>> from pathlib import Path
    >>> import tempfile, stability as st
    >>> run = st.simulate(st.Disk(), st.Rough(), {"theta": 1.2, "phi_dot": 1.0}, [1.0, 2.0])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     back = st.read_motion(st.write_motion(run, Path(folder) / "run.nc"))
    >>> back.identical(run)
    True
    """
    import xarray

    from ..storage.files import atomic_write
    from ..storage.netcdf import packed
    from ..storage.targets import DATASETS, check_suffix

    if not isinstance(dataset, xarray.Dataset) or dataset.attrs.get("format") != FORMAT:
        raise FileError(f"dataset is {type(dataset).__name__}; give what simulate returns.")
    check_suffix(path, DATASETS)
    with atomic_write(path, overwrite=overwrite) as draft:
        draft.write_bytes(packed(dataset))
    return FilePath(path)


def read_motion(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read a motion that `write_motion` wrote.

    Parameters
    ----------
    path
        File to read.

    Returns
    -------
    xarray.Dataset
        Dataset in memory; the file is closed.

    Raises
    ------
    FileError
        If there is no such file, or it is damaged, not a NetCDF file, or not a motion.

    Source: NetCDF-4 by h5netcdf, with a checksum of this package: tests/faults/test_damage.py.

    Examples
    --------
    >>> import stability as st
    >>> import tempfile
    >>> from pathlib import Path
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5}, 1.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.read_motion(st.write_motion(run, Path(folder) / "run.nc")).identical(run)
    True
    """
    from ..storage.netcdf import opened

    return opened(path, FORMAT, "a motion")
