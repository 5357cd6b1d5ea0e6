"""Files that are whole or not there: written beside, then renamed; NetCDF out and in."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import FileError, shown

if TYPE_CHECKING:
    import xarray

ENGINE = "h5netcdf"
PARTS = "complex_part"
"""Dimension that holds the real and imaginary part of complex data in a file."""


def _path(path: str | os.PathLike[str]) -> Path:
    try:
        return Path(path)
    except TypeError:
        raise FileError(f"the file name is {shown(path)}; give a string or a path.") from None


def check_target(path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
    """A path that can be written, or a sentence why not; nothing is created.

    Parameters
    ----------
    path
        The file to write.
    overwrite
        Whether an existing file may be replaced.

    Returns
    -------
    Path

    Raises
    ------
    FileError
        If it exists, is a folder, or its folder is missing or not writable.
    """
    target = _path(path)
    try:
        if target.is_symlink():  # write where it points, and leave the link
            target = target.resolve()
        there = target.exists()
    except ValueError:
        raise FileError(f"{shown(str(target))} is no file name; leave out NUL.") from None
    except OSError as error:
        raise FileError(f"{str(target)[:60]} cannot be written: {error.strerror}.") from None
    if target.is_dir():
        raise FileError(f"{target} is a folder; give the name of a file.")
    if there and not target.is_file():
        raise FileError(f"{target} is not a regular file; give the name of one.")
    if there and not overwrite:
        raise FileError(
            f"{target} exists; choose another name, or replace it with --force (overwrite=True)."
        )
    folder = target.parent
    if not folder.is_dir():
        raise FileError(f"the folder {folder} does not exist; create it first.")
    if not os.access(folder, os.W_OK):
        raise FileError(f"the folder {folder} is not writable; choose another place.")
    return target


def check_folder(target: Path, taken: str = "") -> None:
    """See that a folder can be made or written into; nothing is created.

    Parameters
    ----------
    target
        The folder.
    taken
        The sentence for a folder that holds something already; none where that is no matter.

    Raises
    ------
    FileError
        If it is a file, is taken, or its place is missing or not writable.
    """
    if target.exists() and not target.is_dir():
        raise FileError(f"{target} is a file; give the name of a folder.")
    if taken and target.is_dir() and any(target.iterdir()):
        raise FileError(taken)
    if not target.parent.is_dir():
        raise FileError(f"the folder {target.parent} does not exist; create it first.")
    if not os.access(target if target.is_dir() else target.parent, os.W_OK):
        raise FileError(f"{target} cannot be written: its folder is not writable.")


@contextmanager
def whole(path: str | os.PathLike[str], *, overwrite: bool = False) -> Iterator[Path]:
    """A temporary name beside the target; renamed to it if all goes well, removed otherwise.

    Parameters
    ----------
    path
        The file to write.
    overwrite
        Whether an existing file may be replaced.

    Yields
    ------
    Path
        Where to write.

    Raises
    ------
    FileError
        If the target cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with whole(Path(folder) / "a.txt") as name:
    ...         _ = name.write_text("all of it")
    ...     (Path(folder) / "a.txt").read_text()
    'all of it'
    """
    target = check_target(path, overwrite=overwrite)
    try:
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix
        )
        os.close(handle)
    except OSError as error:
        raise FileError(f"{target} cannot be written: {error.strerror}.") from None
    beside = Path(name)
    mask = os.umask(0)
    os.umask(mask)
    try:
        yield beside
        beside.chmod(0o666 & ~mask)
        if overwrite:
            beside.replace(target)
        else:
            _name(beside, target)
    except OSError as error:
        raise FileError(f"{target} cannot be written: {error.strerror or error}.") from None
    finally:
        with suppress(FileNotFoundError):
            beside.unlink()


def _name(beside: Path, target: Path) -> None:
    """Give the file its name unless another has taken it meanwhile."""
    try:
        os.link(beside, target)
    except FileExistsError:
        raise FileError(f"{target} exists by now; choose another name.") from None
    except OSError:  # a file system without hard links
        beside.replace(target)


def write_map(
    dataset: xarray.Dataset, path: str | os.PathLike[str], *, overwrite: bool = False
) -> Path:
    """Write a map to NetCDF-4; complex variables keep their names.

    Parameters
    ----------
    dataset
        From `stability_map`.
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
        If it cannot be written; nothing is left half-written.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> m = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3), modes=True)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     back = read_map(write_map(m, Path(folder) / "map.nc"))
    >>> back.identical(m)
    True
    """
    import numpy as np
    import xarray

    if not isinstance(dataset, xarray.Dataset):
        raise FileError(f"dataset is {shown(dataset)}; give what stability_map returns.")
    encoded: xarray.Dataset = dataset.copy()
    for name, variable in dataset.variables.items():
        if np.iscomplexobj(variable.values):
            parts = np.stack([variable.values.real, variable.values.imag], axis=-1)
            attributes = dict(variable.attrs) | {"complex": "real and imaginary part, last axis"}
            encoded[name] = xarray.Variable((*variable.dims, PARTS), parts, attributes)
    compress: dict[Any, dict[str, Any]] = {
        str(n): {"zlib": True, "complevel": 4} for n, v in encoded.data_vars.items() if v.ndim > 1
    }
    # into memory first: a disk that fills up while HDF5 writes to it takes the process down
    with whole(path, overwrite=overwrite) as beside:
        beside.write_bytes(encoded.to_netcdf(engine="h5netcdf", encoding=compress))
    return Path(path)


def read_map(path: str | os.PathLike[str], *, lazy: bool = False) -> xarray.Dataset:
    """Read a map that `write_map` or `stream_map` wrote.

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
        If there is no such file, or it is not a NetCDF file, or not one of ours.
    """
    import xarray

    from .dataset import FORMAT

    dataset = opened(path, FORMAT, "a map", lazy=lazy)
    for name, variable in list(dataset.variables.items()):
        if PARTS in variable.dims:
            values = variable.values[..., 0] + 1j * variable.values[..., 1]
            attributes = {k: v for k, v in variable.attrs.items() if k != "complex"}
            dataset[name] = xarray.Variable(variable.dims[:-1], values, attributes)
    return dataset


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
        If there is no such file, or it is not a NetCDF file, or not of that format.
    """
    import xarray

    source = _path(path)
    try:
        there = source.is_file()
    except OSError as error:
        raise FileError(f"{str(source)[:60]} cannot be read: {error.strerror}.") from None
    if not there:
        raise FileError(f"{source} is not a file; give {what} written by stability.")
    try:
        if lazy:
            dataset = xarray.open_dataset(source, engine=ENGINE)
        else:
            with xarray.open_dataset(source, engine=ENGINE) as file:
                dataset = file.load()
    except (OSError, ValueError, KeyError, RuntimeError, TypeError) as error:
        raise FileError(
            f"{source} cannot be read as NetCDF ({str(error).splitlines()[0][:80]}); it may be "
            "damaged or of another format."
        ) from None
    marker = "outcome" if what == "a motion" else "verdict"
    if str(dataset.attrs.get("format")) != form or marker not in dataset.variables:
        dataset.close()
        raise FileError(f"{source} is a NetCDF file but not {what} written by stability.")
    return dataset


@contextmanager
def deaf() -> Iterator[None]:
    """Ignore Ctrl-C for a moment, in a way that processes started meanwhile inherit."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
