"""NetCDF files with a checksum: written whole or row by row, and checked when they are opened.

A file without a checksum is first read by another process, limited in time and memory: HDF5 follows
the links of a damaged file for ever, and allocates what the file declares.
"""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ..base.errors import FileError
from ..base.types import Overwrite
from .checksum import ATTRIBUTE, STATEMENT, intact, seal, sealed
from .chunks import Arrays, Layout, Variable
from .files import atomic_write, postponed
from .targets import path_text, place, refusing

if TYPE_CHECKING:
    import xarray


ENGINE: Final = "h5netcdf"
DEFLATE = 1100
"""Most bytes that one byte of a compressed chunk can hold (zlib: 1032), with room for headers."""
SMALL = 2**22
"""Size up to which a variable is not checked [bytes]."""
SECONDS = 5
"""Processor time for reading [s], in addition to a time in proportion to the size."""
RATE = 2e7
"""Lowest speed of reading [bytes of variables per second]."""
WALL = 600.0
"""Time after which the process is ended in any case, even on a busy machine [s]."""
MEMORY = 2**30
"""Memory for reading [bytes], in addition to three times the size of the variables."""
LONGEST = 300
"""Largest number of characters of the process's sentence in a message."""


def write(dataset: xarray.Dataset, path: Path) -> None:
    """Write a dataset of real variables to NetCDF-4 with a checksum as its last line.

    HDF5 and the NetCDF library ignore what follows the end that the file states.
    """
    marked = dataset.assign_attrs({ATTRIBUTE: STATEMENT})
    # into memory first: a disk that fills up while HDF5 writes to it ends the process
    path.write_bytes(sealed(marked.to_netcdf(engine=ENGINE)))


def loaded(source: Path, *, lazy: bool) -> xarray.Dataset:
    """Load a NetCDF file; it is refused before its data are read where it declares too much."""
    import xarray

    try:
        check_sizes(source, lazy=lazy)
        file = xarray.open_dataset(source, engine=ENGINE)
        try:
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
    """Compare what the variables declare with what the file holds and with the memory."""
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
        entry = file[name]
        if isinstance(entry, h5py.Dataset):
            yield name, entry


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
    """Bytes of memory that are free for this process; None where the system does not tell."""
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
    return None


def opened(path: str | os.PathLike[str], *, lazy: bool = False) -> xarray.Dataset:
    """Open a NetCDF file of this package as a dataset."""
    source = place(path)
    with refusing(source, "read"):
        if not source.is_file():
            raise FileError(f"{path_text(source)} is not a file; give one that stability wrote.")
        right = intact(source)
    if right is None:
        _check_head(source)
    if right is False:
        raise FileError(
            f"{path_text(source)} is damaged or was changed after it was written: its checksum is "
            "wrong."
        )
    if right is None:  # nothing in the file can be trusted, not even that HDF5 comes to an end
        _inspect(source, lazy=lazy)
    dataset = loaded(source, lazy=lazy)
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


def _inspect(source: Path, *, lazy: bool) -> None:
    """Let another process read a file, and refuse the file if the process fails."""
    if not sys.executable:  # Python is embedded: no other process can be started
        return
    home = str(Path(__file__).resolve().parents[2])
    code = (
        f"import sys; sys.path.insert(0, {home!r}); "
        "from stability.storage.netcdf import read_apart; read_apart(*sys.argv[1:])"
    )
    how = "lazy" if lazy else "all"
    words = [sys.executable, "-c", code, os.fspath(source.absolute()), how]
    calm = {n: "1" for n in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    try:
        done = subprocess.run(
            words,
            env=os.environ | calm,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=WALL,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise FileError(_endless(source)) from None
    except OSError as error:
        raise FileError(
            f"{path_text(source)} has no checksum, and no process can be started to inspect it: "
            f"{error.strerror}."
        ) from None
    if done.returncode == 0:
        return
    if done.returncode == 2:
        raise FileError(done.stdout.decode("utf-8", "replace")[:LONGEST])
    if done.returncode == -getattr(signal, "SIGXCPU", 0):
        raise FileError(_endless(source))
    raise FileError(
        f"{path_text(source)} is damaged: the process that read it ended with code "
        f"{done.returncode}."
    )


def _endless(source: Path) -> str:
    return f"{path_text(source)} is damaged: reading it comes to no end."


def read_apart(path: str, how: str) -> None:
    """Read a file within bounds; for a refused file the process ends with code 2 and a sentence."""
    import h5netcdf  # noqa: F401  # before time and memory are counted
    import xarray  # noqa: F401

    source, lazy = Path(path), how == "lazy"
    try:
        _bound(SECONDS, MEMORY)
        total = 0 if lazy else check_sizes(source, lazy=False)
        _bound(SECONDS + int(total / RATE), MEMORY + 3 * total)
        loaded(source, lazy=lazy).close()
        answer = ""
    except FileError as error:
        answer = str(error)
    except MemoryError:
        answer = f"{path_text(source)} is damaged: reading it takes more memory than it declares."
    except Exception as error:
        answer = f"{path_text(source)} cannot be read as NetCDF ({type(error).__name__})."
    os.write(1, answer.encode("utf-8", "replace"))
    os._exit(2 if answer else 0)  # no clean-up, since HDF5 may be in disorder


def _bound(seconds: int, memory: int) -> None:
    """Limit this process from now on, where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    with suppress(OSError, ValueError, AttributeError):
        used = resource.getrusage(resource.RUSAGE_SELF)
        limit = int(used.ru_utime + used.ru_stime) + 1 + seconds
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, hard))
    with suppress(OSError, ValueError, AttributeError, IndexError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        has = pages * resource.getpagesize()
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (has + memory, hard))


# --- row by row ---


class NetcdfRows:
    """A NetCDF file that is written row by row.

    Parameters
    ----------
    file
        The file of h5netcdf.
    sink
        Where its bytes go.
    """

    def __init__(self, file: Any, sink: _Sink) -> None:
        self._file, self._sink = file, sink

    def add(self, first: int, arrays: Arrays) -> None:
        """Write whole rows from the row `first` on, by the names of their arrays."""
        # an exception within HDF5's calls of the sink, even Ctrl-C, would end the process
        with postponed():
            for name, values in arrays.items():
                self._file[name][first : first + len(values), :] = values
        self._sink.check()

    def note(self, attrs: Mapping[str, Any]) -> None:
        """Set attributes of the file."""
        with postponed():
            self._file.attrs.update(attrs)


@contextmanager
def rows(
    path: Path,
    layout: Layout,
    variables: tuple[Variable, ...],
    coords: Mapping[str, Any],
    attrs: Mapping[str, Any],
    *,
    overwrite: Overwrite = False,
) -> Iterator[NetcdfRows]:
    """Write a file row by row; it has its name, and a checksum, when all is there.

    Parameters
    ----------
    path
        The file.
    layout, variables, coords, attrs
        As for `stability.storage.zarr_store.ZarrStore`; the layout of two axes is that of chunks
        in the file.
    overwrite
        Whether an existing file may be replaced; "same": if the same call wrote it.
    """
    with atomic_write(path, overwrite=overwrite) as draft:
        with _Sink(draft) as sink:
            file = None
            try:
                with postponed():
                    file = _created(sink, layout, variables, coords, attrs)
                written = NetcdfRows(file, sink)
                yield written
                written.note({ATTRIBUTE: STATEMENT})
            finally:
                if file is not None:
                    with postponed():
                        file.close()
            sink.check()
        seal(draft)


def _created(
    sink: _Sink,
    layout: Layout,
    variables: tuple[Variable, ...],
    coords: Mapping[str, Any],
    attrs: Mapping[str, Any],
) -> Any:
    """A file with its coordinates and attributes, and empty arrays."""
    import h5netcdf

    file = h5netcdf.File(sink, "w")
    file.dimensions = {axis: len(values) for axis, values, _ in coords.values()}
    for name, (axis, values, attributes) in coords.items():
        file.create_variable(name, (axis,), float, data=values).attrs.update(attributes)
    second = [name for name in coords if name not in layout.dims]
    for variable in variables:
        array = file.create_variable(
            variable.name,
            layout.dims,
            variable.dtype,
            chunks=layout.chunk,
            compression="gzip",
            compression_opts=1,
        )
        array.attrs.update(variable.attrs)
        if second:
            array.attrs["coordinates"] = " ".join(second)
    file.attrs.update(attrs)
    return file


class _Sink(io.RawIOBase):
    """A file for HDF5 that never fails: `check` raises the first error afterwards.

    HDF5 ends the process when it closes a file that it could not write.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("r+b", buffering=0)
        self._error: OSError | None = None

    def check(self) -> None:
        """Raise the first error, if there is one."""
        if self._error is not None:
            raise self._error

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def truncate(self, size: int | None = None) -> int:
        with self._keeping_error():
            self._file.truncate(size)
        return size or 0

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        got = self._file.readinto(view) or 0
        view[got:] = bytes(len(view) - got)  # zeros for bytes that could not be written
        return len(view)

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        count = len(view)
        with self._keeping_error():
            while len(view) and self._error is None:
                view = view[self._file.write(view) or 0 :]
        return count

    def close(self) -> None:
        with self._keeping_error():
            self._file.close()
        super().close()

    @contextmanager
    def _keeping_error(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._error = self._error or error
