"""The formats of datasets: one record for each, and the list that every command reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import PurePath
from typing import Any

from ..base.errors import ParameterError, StabilityError, shown
from ..base.version import install_line


@dataclass(frozen=True)
class Format:
    """A way to store datasets; a way in which it cannot write is None.

    To add a format: a module like `netcdf.py` in this folder, and its record in `FORMATS`.
    """

    name: str
    """Name in messages."""
    endings: tuple[str, ...]
    """Endings of file names, lower case, the usual one first."""
    read: Callable[..., Any]
    """(path, lazy=…) to the dataset, or an error that says why it cannot be read."""
    write: Callable[[Any, Any], None] | None = None
    """Writes a dataset of real arrays to a path, whole."""
    rows: Callable[..., Any] | None = None
    """Writes an array row by row: a context manager like `netcdf.rows`."""
    chunks: Callable[..., Any] | None = None
    """A `Store` of chunks that workers fill, made like `ZarrStore`."""
    check: Callable[[Any], object] | None = None
    """Refuses a folder that holds something else, which is not even replaced."""
    package: str = ""
    """Package that it needs beyond those of every installation."""
    extra: str = ""
    """Extra of this package that installs it."""

    def __post_init__(self) -> None:
        for ending in self.endings:
            if PurePath(f"a{ending}").suffix != ending or ending != ending.lower():
                raise ParameterError(
                    f"an ending of {self.name} is {shown(ending)}; give a dot and one word in "
                    "lower case, such as .nc."
                )

    @property
    def folder(self) -> bool:
        """Whether it is a folder, to which the same command goes on."""
        return self.chunks is not None

    def check_installed(self) -> None:
        """Refuse the format where its package is missing."""
        if self.package and find_spec(self.package) is None:
            raise StabilityError(
                f"{self.name} needs the package {self.package}; {install_line(self.extra)}, or "
                f"give a file that ends in {FORMATS[0].endings[0]}."
            )


def _deferred(module: str, name: str) -> Callable[..., Any]:
    """A function of a module of this folder, which is loaded at the first call."""

    def call(*arguments: Any, **options: Any) -> Any:
        return getattr(import_module(f".{module}", __package__), name)(*arguments, **options)

    return call


NETCDF = Format(
    "NetCDF",
    (".nc", ".nc4", ".netcdf", ".h5", ".hdf5"),
    read=_deferred("netcdf", "opened"),
    write=_deferred("netcdf", "write"),
    rows=_deferred("netcdf", "rows"),
)
ZARR = Format(
    "a Zarr store",
    (".zarr",),
    read=_deferred("zarr_store", "opened_store"),
    chunks=_deferred("zarr_store", "ZarrStore"),
    check=_deferred("zarr_store", "head_of"),
    package="zarr",
    extra="scale",
)
FORMATS = [NETCDF, ZARR]
"""Every format; a name without an ending is of the first."""


def formats_for(*ways: str) -> list[Format]:
    """Formats that write in at least one of these ways (`write`, `rows`, `chunks`), or all."""
    return [f for f in FORMATS if not ways or any(getattr(f, way) is not None for way in ways)]


def format_named(path: Any, usual: Format, *ways: str) -> Format:
    """The format with the ending of a path, of those for some ways; the usual one otherwise."""
    suffix = PurePath(path).suffix.lower()
    return next((f for f in formats_for(*ways) if suffix in f.endings), usual)
