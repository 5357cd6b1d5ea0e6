"""Maps in files and folders."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.types import Overwrite
from ..spectra.labels import FORMAT
from ..storage.datasets import read_dataset, refuse_other, write_dataset

if TYPE_CHECKING:
    import xarray


MISSING = 15 * 2.0**119
"""Fill value of missing numbers in a file, NetCDF's own default."""


def write_map(
    dataset: xarray.Dataset, path: str | os.PathLike[str], *, overwrite: Overwrite = False
) -> Path:
    """Write a map to a file, usually NetCDF-4; complex variables keep their names.

    Parameters
    ----------
    dataset
        From `stability_map`, or from `Spectrum.to_xarray`.
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
        If it cannot be written; nothing is left half-written.

    Source: NetCDF-4 by h5netcdf, with a checksum of this package: tests/faults/test_damage.py.

    Examples
    --------
    >>> from pathlib import Path
    >>> import tempfile, stability as st
    >>> m = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3), modes=True)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     back = st.read_map(st.write_map(m, Path(folder) / "map.nc"))
    >>> back.identical(m)
    True
    """
    import numpy as np

    refuse_other(dataset, FORMAT, "stability_map returns, or Spectrum.to_xarray")
    encoded = dataset.copy()
    for name in dataset.data_vars:
        variable = encoded.variables[name]
        two_axes = variable.ndim + (variable.dtype.kind == "c") > 1
        encoding: dict[str, Any] = {"zlib": True, "complevel": 4} if two_axes else {}
        # cells of a map without a member
        if variable.dtype.kind in "fc" and np.isnan(variable.values).any():
            encoding["_FillValue"] = MISSING
        if encoding:
            variable.encoding = encoding
    return write_dataset(encoded, path, overwrite=overwrite)


def read_map(path: str | os.PathLike[str], *, lazy: bool = False) -> xarray.Dataset:
    """Read a map that `write_map` or `stream_map` wrote, its checksum first; `.zarr` a folder.

    Files of version 0.4.0 and before have no checksum: damage to numbers may go unnoticed.

    Parameters
    ----------
    path
        File to read.
    lazy
        Whether to leave the data in the file until it is used; then close the dataset afterwards.

    Returns
    -------
    xarray.Dataset
        In memory, and the file is closed, unless lazy.

    Raises
    ------
    FileError
        If there is no such file, or it is damaged, not a NetCDF file, or no map of this package.

    Source: NetCDF-4 by h5netcdf, with a checksum of this package: tests/faults/test_damage.py.

    Examples
    --------
    >>> import stability as st
    >>> import tempfile
    >>> from pathlib import Path
    >>> m = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.read_map(st.write_map(m, Path(folder) / "map.nc")).identical(m)
    True
    """
    return read_dataset(path, {FORMAT: "a map"}, lazy=lazy)
