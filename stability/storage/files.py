"""Files that are whole or not there: written under a temporary name, then renamed together."""

from __future__ import annotations

import os
import shutil
import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import FileError
from .litter import clear, temporary
from .targets import check_same, check_target, path_text, refusing

if TYPE_CHECKING:
    from ..base.types import Overwrite

STOPS = tuple(getattr(signal, n) for n in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, n))
"""Signals that ask a command to stop."""


@dataclass(frozen=True)
class _Ready:
    """A file that is whole under its temporary name."""

    temporary: Path
    """Temporary path."""
    target: Path
    """Final path."""
    overwrite: bool
    """Whether it may replace a file."""
    result: bool
    """Whether the file is a result, not only a help for a later run."""

    def keep(self) -> Path | None:
        """Give the file that is replaced a second name, until all files are named."""
        if not self.overwrite or not self.target.exists():
            return None
        kept = self.target.parent / temporary()
        try:
            os.link(self.target, kept)
        except OSError:  # a file system without hard links
            shutil.copy2(self.target, kept)
        return kept

    def name(self) -> None:
        """Give the file its name, unless another file has taken that name meanwhile."""
        if self.overwrite:
            self.temporary.replace(self.target)
            return
        try:
            os.link(self.temporary, self.target)
        except FileExistsError:
            raise FileError(
                f"{path_text(self.target)} exists by now; choose another name."
            ) from None
        except OSError:  # a file system without hard links
            self.temporary.replace(self.target)

    def take_back(self, kept: Path | None) -> None:
        """Undo the naming."""
        with suppress(OSError):
            if kept is None:
                self.target.unlink()
            else:
                kept.replace(self.target)


_waiting: ContextVar[list[_Ready]] = ContextVar("files that wait for their names")
_named: list[Path] = []


def named() -> list[Path]:
    """The files and folders that this process has written so far, in order."""
    return list(_named)


def record(path: Path) -> None:
    """Add a file or folder to those that this process has written."""
    _named.append(path)


@contextmanager
def atomic_write(
    path: str | os.PathLike[str],
    *,
    overwrite: Overwrite = False,
    result: bool = True,
    durable: bool = False,
    origin: Mapping[str, str] | None = None,
) -> Iterator[Path]:
    """A temporary name in the target's folder; renamed if all goes well, removed otherwise.

    Within `together` the file is renamed with the others at the end.

    Parameters
    ----------
    path
        The file to write.
    overwrite
        Whether an existing file may be replaced; "same": where it is what the same call wrote.
    result
        Whether the file is a result, not only a help for a later run.
    durable
        Whether its bytes are on the disk before it has its name, for a file that proves another.
    origin
        The record of the call, which the file then carries: see `origin_of`.

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
    ...     with atomic_write(Path(folder) / "a.txt") as name:
    ...         _ = name.write_text("all of it")
    ...     (Path(folder) / "a.txt").read_text()
    'all of it'
    """
    from .origin import record_of, stamp  # here, so that a command starts without NumPy

    target = check_target(path, overwrite=overwrite, origin=origin)
    clear(target.parent)
    same = overwrite == "same" and target.exists()
    over = same or overwrite is True
    ready = _Ready(target.parent / temporary(target.suffix), target, over, result)
    group = _waiting.get(None)
    mask = os.umask(0)
    os.umask(mask)
    try:
        with refusing(target):
            os.close(os.open(ready.temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
            yield ready.temporary
            if origin is not None:
                stamp(ready.temporary, origin)
            elif same:
                check_same(target, record_of(ready.temporary))
            ready.temporary.chmod(0o666 & ~mask)
            if durable:
                with ready.temporary.open("rb+") as handle:
                    os.fsync(handle.fileno())
            if group is None:
                _name([ready])
            else:
                group.append(ready)
    finally:
        if group is None or ready not in group:
            with suppress(FileNotFoundError):
                ready.temporary.unlink()


def write_file(path: str | os.PathLike[str], content: str | bytes, **options: Any) -> None:
    """Write a text or bytes whole or not at all.

    Parameters
    ----------
    path
        The file to write.
    content
        What it holds; a text as UTF-8.
    **options
        As for `atomic_write`.

    Raises
    ------
    FileError
        If the target cannot be written.
    """
    with atomic_write(path, **options) as draft:
        draft.write_bytes(content.encode() if isinstance(content, str) else content)


@contextmanager
def together() -> Iterator[None]:
    """Write all files or none: each `atomic_write` inside gets its name at the end.

    Raises
    ------
    FileError
        If a file cannot get its name.  Files named before then lose their names, and the files
        that were replaced are restored.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with together():
    ...         for name in ("a.txt", "b.txt"):
    ...             with atomic_write(Path(folder) / name) as file:
    ...                 _ = file.write_text(name)
    ...         early = (Path(folder) / "a.txt").exists()
    ...     early, sorted(os.listdir(folder))
    (False, ['a.txt', 'b.txt'])
    """
    if _waiting.get(None) is not None:  # part of a larger group
        yield
        return
    group: list[_Ready] = []
    token = _waiting.set(group)
    try:
        yield
        _name(group)
    finally:
        _waiting.reset(token)
        for ready in group:
            with suppress(FileNotFoundError):
                ready.temporary.unlink()


def _name(group: list[_Ready]) -> None:
    """Give all files their names, or none; signals to stop wait until the end."""
    done: list[tuple[_Ready, Path | None]] = []
    with postponed():
        try:
            for ready in group:
                kept = None
                try:
                    with refusing(ready.target):
                        kept = ready.keep() if len(group) > 1 else None
                        ready.name()
                except BaseException:  # the target is unchanged
                    if kept is not None:
                        kept.unlink()
                    raise
                done.append((ready, kept))
        except BaseException:
            for ready, kept in reversed(done):
                ready.take_back(kept)
            raise
        for ready, kept in done:
            if ready.result:
                _named.append(ready.target)
            if kept is not None:
                with suppress(OSError):
                    kept.unlink()


@contextmanager
def postponed() -> Iterator[None]:
    """Let signals to stop wait for the end of a short piece of work."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {n: signal.getsignal(n) for n in STOPS}
    # a handler that is not Python's, or that ignores, stays as it is
    held = {n: h for n, h in before.items() if callable(h) or h is signal.SIG_DFL}
    try:
        for number in held:
            signal.signal(number, lambda n, _: came.append(n))
        yield
    finally:
        for number, handler in held.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


@contextmanager
def ignoring_signals() -> Iterator[None]:
    """Block signals to stop in processes started inside; this process gets them afterwards."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    from multiprocessing.resource_tracker import ensure_running

    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
    try:
        ensure_running()  # a helper of multiprocessing, whose start ends the blocking
        signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
