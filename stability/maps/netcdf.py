"""Maps as NetCDF files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import FileError
from ..spectra.labels import FORMAT
from ..storage.files import atomic_write
from ..storage.targets import DATASETS, STORES, check_suffix, place

if TYPE_CHECKING:
    import xarray


MISSING = 15 * 2.0**119
"""Fill value of missing numbers in a file, NetCDF's own default."""
PARTS = "complex_part"
"""Dimension that holds the real and imaginary part of complex data in a file."""


def write_map(
    dataset: xarray.Dataset, path: str | os.PathLike[str], *, overwrite: bool = False
) -> Path:
    """Write a map to NetCDF-4 with a checksum; complex variables keep their names.

    Parameters
    ----------
    dataset
        From `stability_map`, or from `Spectrum.to_xarray`.
    path
        File to write; `.nc` or another ending of NetCDF.
    overwrite
        Whether an existing file may be replaced.

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
    import xarray

    from ..storage.netcdf import packed

    if not isinstance(dataset, xarray.Dataset) or dataset.attrs.get("format") != FORMAT:
        raise FileError(
            f"dataset is {type(dataset).__name__}; give what stability_map returns, or "
            "Spectrum.to_xarray."
        )
    check_suffix(path, DATASETS)
    encoded: xarray.Dataset = dataset.copy()
    for name, variable in dataset.variables.items():
        if np.iscomplexobj(variable.values):
            parts = np.stack([variable.values.real, variable.values.imag], axis=-1)
            attributes = dict(variable.attrs) | {"complex": "real and imaginary part, last axis"}
            encoded[name] = xarray.Variable((*variable.dims, PARTS), parts, attributes)
    compress: dict[Any, dict[str, Any]] = {
        str(n): {"zlib": True, "complevel": 4} for n, v in encoded.data_vars.items() if v.ndim > 1
    }
    for n, v in encoded.data_vars.items():  # cells of a map without a member
        if v.dtype.kind == "f" and np.isnan(v.values).any():
            compress.setdefault(str(n), {})["_FillValue"] = MISSING
    # into memory first: a disk that fills up while HDF5 writes to it ends the process
    with atomic_write(path, overwrite=overwrite) as draft:
        draft.write_bytes(packed(encoded, compress))
    return Path(path)


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
    import xarray

    from ..storage.netcdf import opened

    if place(path).suffix.lower() in STORES:
        from ..storage.zarr_folder import opened_store

        return opened_store(path, FORMAT, "a map", lazy=lazy)
    dataset = opened(path, FORMAT, "a map", lazy=lazy)
    for name, variable in list(dataset.variables.items()):
        if PARTS in variable.dims:
            values = variable.values[..., 0] + 1j * variable.values[..., 1]
            attributes = {k: v for k, v in variable.attrs.items() if k != "complex"}
            dataset[name] = xarray.Variable(variable.dims[:-1], values, attributes)
    return dataset
