"""Checkpoints: a folder with the finished pieces of a job, until the job is done."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import FileError, shown
from .checksum import sealed, unsealed
from .files import atomic_write
from .litter import clear
from .targets import check_folder, path_text, place, refusing

Chunk = dict[str, NDArray[Any]]


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
                with atomic_write(note, result=False) as draft:
                    draft.write_text(wanted, encoding="utf-8")

    def done(self, key: int) -> bool:
        """Whether a chunk is there; it may still be damaged.

        Parameters
        ----------
        key
            First cell of the chunk.

        Returns
        -------
        bool
        """
        return self._path(key).is_file()

    def get(self, key: int) -> Chunk | None:
        """A finished chunk, or None where it is missing, damaged or of another map.

        Parameters
        ----------
        key
            First cell of the chunk.

        Returns
        -------
        dict of ndarray or None
        """
        with suppress(OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            content = unsealed(self._path(key).read_bytes(), f"{self.label} {key}")
            if content is not None:
                with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
                    chunk = dict(arrays)
                return chunk if self._fits(key, chunk) else None
        return None

    def add(self, key: int, value: Chunk) -> None:
        """Write a finished chunk with its checksum.

        Parameters
        ----------
        key
            First cell of the chunk.
        value
            Arrays of the chunk by name.
        """
        content = io.BytesIO()
        np.savez(content, allow_pickle=False, **value)
        with atomic_write(self._path(key), overwrite=True, result=False) as draft:
            draft.write_bytes(sealed(content.getbuffer(), f"{self.label} {key}"))

    def _path(self, key: int) -> Path:
        return self.folder / f"{key}.npz"


def remove_parts(folder: str | PathLike[str]) -> None:
    """Remove the files that `Checkpoint` wrote, and the folder if nothing else is in it.

    Parameters
    ----------
    folder
        The checkpoint folder.
    """
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
