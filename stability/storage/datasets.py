"""Datasets in files and folders, each in the format that the ending of its name says."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.citation import Citation, citation, citation_of_keys, keys_of
from ..base.errors import FileError, listed, shown
from ..base.types import Overwrite
from .files import atomic_write
from .formats import FORMATS, NETCDF, Format, format_named, formats_for
from .litter import temporary
from .origin import CALL, KEYS, LATER, VERSION, record_of
from .targets import check_folder, check_suffix, check_target, path_text, place, refusing

if TYPE_CHECKING:
    import xarray

Labelled = tuple[str | tuple[str, ...], Any, Mapping[str, Any]]
"""Dimensions, values and attributes of an array."""
PARTS = "complex_part"
"""Dimension that holds the real and imaginary part of complex data in a file."""


def labelled(
    variables: Mapping[str, Labelled],
    coordinates: Mapping[str, Labelled],
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """A dataset from arrays that are known to fit.

    xarray's constructor aligns and copies, and imports dask where that is installed.  For a small
    result this takes longer than the result.  Where its direct constructor is missing, the public
    one gives the same dataset (tests/storage/test_datasets.py).

    Parameters
    ----------
    variables, coordinates
        Dimensions, values and attributes by name.  A coordinate along its own name is an index.
    attributes
        Attributes of the dataset.
    """
    import numpy as np
    import xarray

    try:
        import pandas
        from xarray.core.indexes import PandasIndex

        make: Any = xarray.Variable
        every = {
            name: make(dims, np.asarray(values), dict(more), fastpath=True)
            for name, (dims, values, more) in {**variables, **coordinates}.items()
        }
        indexes: dict[Any, Any] = {
            name: PandasIndex(pandas.Index(v.values, name=name), name, coord_dtype=v.dtype)
            for name, v in every.items()
            if name in coordinates and v.dims == (name,)
        }
        for name, index in indexes.items():
            every |= index.create_variables({name: every[name]})
        sizes = {d: n for v in every.values() for d, n in zip(v.dims, v.shape, strict=True)}
        return xarray.Dataset._construct_direct(
            every, set(coordinates), sizes, dict(attributes), indexes
        )
    except (ImportError, AttributeError, TypeError):
        return xarray.Dataset(variables, coordinates, attributes)


def format_to_write(path: str | os.PathLike[str], *ways: str, option: str = "") -> Format:
    """The format of a dataset's name, which is refused where no such format writes in these ways.

    Parameters
    ----------
    path
        The file or folder.
    *ways
        As for `formats_for`; one of them is enough.
    option
        Name of the path's option on the command line, or empty.

    Examples
    --------
    >>> format_to_write("map.nc", "write").name, format_to_write("map.zarr", "chunks").name
    ('NetCDF', 'a Zarr store')
    """
    accepted = formats_for(*ways)
    if place(path).suffix or FORMATS[0] not in accepted:
        check_suffix(path, [ending for f in accepted for ending in f.endings], option)
    return format_named(path, FORMATS[0], *ways)


def dataset_target(
    path: str | os.PathLike[str], *ways: str, overwrite: Overwrite = False, option: str = ""
) -> Path:
    """Check that a dataset can be written, before anything is computed.

    Parameters
    ----------
    path, *ways, option
        As for `format_to_write`.
    overwrite
        Whether an existing file may be replaced; "same": if the same call wrote it.
    """
    storage_format = format_to_write(path, *ways, option=option)
    storage_format.check_installed()
    if not storage_format.folder:
        return check_target(path, overwrite=overwrite)
    target = check_folder(path)
    if target.is_dir():
        if storage_format.check is not None:
            storage_format.check(target)
    else:
        draft = target.parent / temporary(target.suffix)
        with refusing(target):
            draft.mkdir()
            draft.rmdir()
    return target


def write_dataset(
    dataset: xarray.Dataset, path: str | os.PathLike[str], *, overwrite: Overwrite = False
) -> Path:
    """Write a dataset whole; complex arrays as two real parts.

    Parameters
    ----------
    dataset
        The dataset.
    path
        File to write.
    overwrite
        Whether an existing file may be replaced; "same": if the same call wrote it.

    Raises
    ------
    FileError
        If it cannot be written; nothing is left half-written.
    """
    import numpy as np
    import xarray

    storage_format = format_to_write(path, "write")
    storage_format.check_installed()
    assert storage_format.write is not None
    encoded = dataset.copy()
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == "c":
            parts = np.stack([variable.values.real, variable.values.imag], axis=-1)
            attributes = dict(variable.attrs) | {"complex": "real and imaginary part, last axis"}
            dims = (*variable.dims, PARTS)
            encoded[name] = xarray.Variable(dims, parts, attributes, variable.encoding)
    with atomic_write(path, overwrite=overwrite) as draft:
        storage_format.write(encoded, draft)
    return Path(path)


def refuse_other(dataset: Any, form: str, source: str) -> None:
    """Refuse to write what is no dataset of a form, named by what returns one."""
    import xarray

    if not isinstance(dataset, xarray.Dataset) or dataset.attrs.get("format") != form:
        raise FileError(f"dataset is {shown(dataset)}; give what {source}.")


def read_dataset(
    path: str | os.PathLike[str],
    kinds: Mapping[str, str],
    *,
    lazy: bool = False,
    usual: Format = NETCDF,
) -> xarray.Dataset:
    """Read a dataset of this package.

    Parameters
    ----------
    path
        File or folder.
    kinds
        Accepted contents, in words, by the attribute `format` of each.
    lazy
        Whether to leave the data in the file until it is used.
    usual
        Format of a name with another ending.

    Raises
    ------
    FileError
        If there is no such file, or it is damaged, or holds something else.
    """
    import xarray

    storage_format = format_named(place(path), usual)
    storage_format.check_installed()
    dataset: xarray.Dataset = storage_format.read(path, lazy=lazy)
    if str(dataset.attrs.get("format")) not in kinds:
        dataset.close()
        what = listed([*kinds.values()], "or")
        raise FileError(
            f"{path_text(path)} is {storage_format.name} but not {what} written by stability."
        )
    for name, variable in list(dataset.variables.items()):
        if PARTS in variable.dims:
            values = variable.values[..., 0] + 1j * variable.values[..., 1]
            attributes = {k: v for k, v in variable.attrs.items() if k != "complex"}
            dataset[name] = xarray.Variable(variable.dims[:-1], values, attributes)
    return dataset


def file_citation(path: str | os.PathLike[str]) -> Citation:
    """What a file of this package says to cite, and of a figure, film or page what made it.

    Parameters
    ----------
    path
        File or folder.

    Raises
    ------
    FileError
        If it cannot be read, is damaged, or says nothing of what to cite.
    """
    target = place(path)
    nothing = FileError(
        f"{path_text(target)} says nothing of what to cite; give a figure, film, page or dataset "
        "that this package wrote."
    )
    if any(target.suffix.lower() in storage_format.endings for storage_format in FORMATS):
        storage_format = format_named(target, NETCDF)
        storage_format.check_installed()
        with storage_format.read(target, lazy=True) as dataset:
            if not keys_of(dataset):
                raise nothing
            return citation(dataset)
    with refusing(target, "read"):
        try:
            record = {name: json.loads(text) for name, text in record_of(target).items()}
        except FileError as error:
            raise FileError(f"{path_text(target)} says nothing of what to cite: {error}.") from None
    if not record.get(KEYS):
        raise nothing
    made = f"{target.name} was made by {record[CALL]} with stability {record[VERSION]}"
    for description in (value for value in record.values() if isinstance(value, dict)):
        made += (
            f" from {title}" if (title := description.get("attributes", {}).get("title")) else ""
        )
    made += ", and by code of the user." if f"its {LATER}" in record else "."
    return citation_of_keys(record[KEYS], record[VERSION], made)
