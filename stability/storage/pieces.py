"""Finished pieces of a job by key, each there whole or not at all, so that the job can go on.

Arrays have a file each (`Checkpoint`); records are lines of one file (`Records`).
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..base.errors import FileError, shown
from .checksum import sealed, unsealed
from .files import write_file
from .litter import clear
from .targets import check_folder, path_text, place, refusing
from .text import marked, unmarked

T = TypeVar("T")
Key = TypeVar("Key", contravariant=True)
Chunk = dict[str, NDArray[Any]]
MARK = "fingerprint"
"""The first word of a file of records."""


class Pieces(Protocol[Key, T]):
    """Finished pieces in a folder, by key."""

    folder: Path
    """Folder of the pieces."""

    def done(self, key: Key) -> bool:
        """Whether a piece is there; it may still be damaged."""

    def get(self, key: Key) -> T | None:
        """A finished piece; None where it is missing or damaged."""

    def add(self, key: Key, value: T) -> None:
        """Write a finished piece at once."""


class Records(Generic[Key, T]):
    """Finished dataclasses as lines of a file, those of another question left out.

    Parameters
    ----------
    path
        The file; its folder is created if it is missing.
    question
        What the pieces depend on.
    read
        A piece from its record; a ValueError or TypeError if it is none.
    name
        Text of a key.

    Raises
    ------
    FileError
        If the folder cannot be used, or the file is another.
    """

    def __init__(
        self,
        path: Path,
        question: str,
        read: Callable[[dict[str, Any]], T],
        name: Callable[[Key], str] = str,
    ) -> None:
        self.folder, self.path, self._name = path.parent, path, name
        self.pieces: dict[str, T] = {}
        head = json.dumps({MARK: question})
        with refusing(path, "used"):
            self.folder.mkdir(parents=True, exist_ok=True)
            clear(self.folder, always=True)
            there = path.is_symlink() or path.exists()
            if there and not is_records(path):
                raise FileError(
                    f"{path_text(path)} is not a journal of ours; choose another folder."
                )
            text = path.read_text(encoding="utf-8", errors="replace") if there else ""
            first, *lines = text.splitlines() or [""]
            kept = [f"{head}\n"]
            for line in lines if first == head else []:
                body, _, digest = line.rpartition("\t")
                if digest != _digest(body):  # cut short or damaged: the piece is done again
                    continue
                with suppress(ValueError, TypeError, LookupError, RecursionError):
                    record = json.loads(body, object_hook=unmarked)
                    self.pieces[str(record["key"])] = read(record)
                    kept.append(f"{line}\n")
            if text != "".join(kept):  # a line is cut short, or pieces are no longer valid
                write_file(path, "".join(kept), overwrite=True, result=False)

    def done(self, key: Key) -> bool:
        """Whether a piece is there."""
        return self._name(key) in self.pieces

    def get(self, key: Key) -> T | None:
        """A finished piece, or None."""
        return self.pieces.get(self._name(key))

    def add(self, key: Key, value: T) -> None:
        """Write a finished piece at once."""
        record = {"key": self._name(key)} | asdict(value)  # type: ignore[call-overload]
        body = json.dumps(marked(record), allow_nan=False)
        self.pieces[self._name(key)] = value
        with refusing(self.path), self.path.open("a", encoding="utf-8") as handle:
            handle.write(f"{body}\t{_digest(body)}\n")


def _digest(body: str) -> str:
    return hashlib.sha256(body.encode()).hexdigest()[:16]


def is_records(path: Path) -> bool:
    """Whether a file is one of `Records`."""
    if path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as handle:
        return handle.read(len(MARK) + 2) == f'{{"{MARK}'.encode()


class Checkpoint:
    """Finished chunks in a folder, for a map that may be interrupted and resumed.

    Parameters
    ----------
    folder
        Folder of the chunks; created if it is missing.
    key
        Description of the map; a folder with the parts of another map is refused.
    fits
        Whether a chunk belongs to the map, from its first cell and its arrays.

    Raises
    ------
    FileError
        If the folder cannot be used, or belongs to another map.
    """

    NAME = "map.json"

    def __init__(
        self,
        folder: str | PathLike[str],
        key: dict[str, Any],
        fits: Callable[[int, Chunk], bool] = lambda *_: True,
    ) -> None:
        self._fits = fits
        if not isinstance(folder, (str, PathLike)) or not str(folder):
            raise FileError(f"the checkpoint folder is {shown(folder)}; give the name of a folder.")
        self.folder = check_folder(folder)
        wanted = json.dumps(key, sort_keys=True, indent=1)
        self.label = hashlib.sha256(wanted.encode()).hexdigest()
        note = self.folder / self.NAME
        words = f"the checkpoint folder {path_text(folder)}"
        with refusing(words, "used"):
            self.folder.mkdir(exist_ok=True)
            if note.is_file():
                if note.read_bytes() != wanted.encode():
                    raise FileError(
                        f"{words} belongs to another map, or is damaged; choose another folder or "
                        "remove it."
                    )
            elif any(self.folder.iterdir()):
                raise FileError(f"{words} holds other files; choose another.")
            else:
                write_file(note, wanted, result=False)

    def done(self, key: int) -> bool:
        """Whether a chunk is there; it may still be damaged."""
        return self._path(key).is_file()

    def get(self, key: int) -> Chunk | None:
        """A finished chunk, or None where it is missing, damaged or of another map."""
        with suppress(OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            content = unsealed(self._path(key).read_bytes(), f"{self.label} {key}")
            if content is not None:
                with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
                    chunk = dict(arrays)
                return chunk if self._fits(key, chunk) else None
        return None

    def add(self, key: int, value: Chunk) -> None:
        """Write a finished chunk with its checksum."""
        content = io.BytesIO()
        np.savez(content, allow_pickle=False, **value)
        whole = sealed(content.getbuffer(), f"{self.label} {key}")
        write_file(self._path(key), whole, overwrite=True, result=False)

    def _path(self, key: int) -> Path:
        return self.folder / f"{key}.npz"


def remove_parts(folder: str | PathLike[str]) -> None:
    """Remove the files that `Checkpoint` wrote, and the folder if nothing else is in it."""
    where = place(folder)
    with suppress(OSError):
        if not (where / Checkpoint.NAME).is_file():
            return
        clear(where, always=True)
        for path in where.glob("*.npz"):
            if path.stem.isdigit():
                path.unlink()
        (where / Checkpoint.NAME).unlink()
        where.rmdir()
