"""The journal of a comparison: a file of its finished cells, and of what they depend on."""

from __future__ import annotations

import contextlib
import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base.errors import FileError
from ..base.provenance import machine
from ..storage.files import atomic_write
from ..storage.json_text import marked, unmarked
from ..storage.litter import clear
from ..storage.targets import path_text, refusing

MARK = "fingerprint"
"""The first word of a journal."""
DONE, REFUSED, CRASHED, LATE = "done", "refused", "crashed", "time-out"
"""Ways in which a cell can end."""
ENDS = (DONE, REFUSED, CRASHED, LATE)
JOURNAL = "cells.jsonl"
"""Name of the journal in its folder."""
SHOWN = (
    "figures",
    "tables",
    "atlas",
    "cli",
    "compare/figures",
    "compare/report.py",
    "compare/page.py",
    "compare/plan.py",
)
"""Folders and files that only show results: a change in them leaves cells valid."""


@dataclass(frozen=True)
class Cell:
    """One cell that has ended."""

    key: str
    """Name of the cell's task."""
    status: str
    """done, refused, crashed or time-out."""
    value: Any
    """Result of the task; None unless done."""
    message: str
    """Message of the error or of the time limit; empty if done."""
    seconds: float
    """Time of the task [s], without the start of its process."""


class Journal:
    """Finished cells in a file of a folder.

    Parameters
    ----------
    folder
        Folder of the journal; created if it is missing.

    Raises
    ------
    FileError
        If the folder or its journal cannot be used.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.path = folder, folder / JOURNAL
        self.cells: dict[str, Cell] = {}
        head = json.dumps({MARK: fingerprint()})
        try:
            folder.mkdir(exist_ok=True)
            clear(folder, always=True)
            there = self.path.is_symlink() or self.path.exists()
            if there and not is_journal(self.path):
                raise FileError(
                    f"{path_text(self.path)} is not a journal of ours; choose another folder."
                )
            text = self.path.read_text(encoding="utf-8", errors="replace") if there else ""
            lines = text.splitlines()
            if lines and lines[0] == head:  # otherwise sources, versions or machine have changed
                self._read(lines[1:])
            kept = "".join(_line(cell) for cell in self.cells.values())
            if text != f"{head}\n{kept}":  # a line is cut short, or cells are no longer valid
                with atomic_write(self.path, overwrite=True, result=False) as draft:
                    draft.write_text(f"{head}\n{kept}", encoding="utf-8")
        except OSError as error:
            raise FileError(
                f"{path_text(self.path)} cannot be used: {error.strerror or error}."
            ) from None

    def _read(self, lines: list[str]) -> None:
        for line in lines:
            body, _, digest = line.rpartition("\t")
            if digest != _digest(body):  # cut short or damaged: the cell is computed again
                continue
            with contextlib.suppress(ValueError, TypeError, RecursionError):
                cell = Cell(**json.loads(body, object_hook=unmarked))
                if isinstance(cell.key, str) and cell.status in ENDS:
                    self.cells[cell.key] = cell

    def done(self, key: str) -> bool:
        """Whether a cell has ended."""
        return key in self.cells

    def get(self, key: str) -> Cell | None:
        """A cell that has ended, or None."""
        return self.cells.get(key)

    def add(self, key: str, value: Cell) -> None:
        """Write a cell at once."""
        self.cells[key] = value
        with refusing(self.path), self.path.open("a", encoding="utf-8") as handle:
            handle.write(_line(value))


def _line(cell: Cell) -> str:
    """A cell as JSON, a tab, and the beginning of the checksum of the JSON."""
    body = json.dumps(marked(vars(cell)), allow_nan=False)
    return f"{body}\t{_digest(body)}\n"


def _digest(body: str) -> str:
    return hashlib.sha256(body.encode()).hexdigest()[:16]


def is_journal(path: Path) -> bool:
    """Whether a file is a journal of a comparison.

    Parameters
    ----------
    path
        The file, which may be missing.

    Returns
    -------
    bool
    """
    if path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as handle:
        return handle.read(len(MARK) + 2) == f'{{"{MARK}'.encode()


def fingerprint() -> str:
    """Checksum of what cells depend on: sources of the package, versions and the machine.

    Returns
    -------
    str

    Examples
    --------
    >>> fingerprint() == fingerprint()
    True
    """
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for path in sorted([*root.rglob("*.py"), *root.rglob("*.json")]):
        place = path.relative_to(root).as_posix()
        if any(place == shown or place.startswith(f"{shown}/") for shown in SHOWN):
            continue
        digest.update(path.read_bytes())
    digest.update(json.dumps(machine(), sort_keys=True).encode())
    return digest.hexdigest()
