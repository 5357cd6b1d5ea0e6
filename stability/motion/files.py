"""Motions in files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.types import Overwrite
from ..storage.datasets import read_dataset, refuse_other, write_dataset
from .dataset import FORMAT

if TYPE_CHECKING:
    import xarray


def write_motion(
    dataset: xarray.Dataset, path: str | os.PathLike[str], *, overwrite: Overwrite = False
) -> Path:
    """Write a motion to a file, usually NetCDF-4.

    Parameters
    ----------
    dataset
        Dataset from `simulate`.
    path
        File to write, in the format of its ending; `.nc` or none is NetCDF.
    overwrite
        Whether an existing file may be replaced; "same": if it holds the same dataset, up to
        its date.

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
    refuse_other(dataset, FORMAT, "simulate returns")
    return write_dataset(dataset, path, overwrite=overwrite)


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
    return read_dataset(path, {FORMAT: "a motion"})
