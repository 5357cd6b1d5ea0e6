"""Names of files and folders to write: checked before anything is computed."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import FileError, listed, one_line, shown
from .formats import FORMATS
from .litter import clear

if TYPE_CHECKING:
    from ..base.types import Overwrite

LONGEST = 120
"""Largest number of characters of a path in a message."""
PICTURES = (".png", ".pdf", ".svg")
"""Endings of a figure."""
FILMS = (".gif", ".mp4", ".html")
"""Endings of a film."""
OTHER = (".csv", ".json", ".txt", ".md", ".py", ".jpg", ".jpeg", ".webp", ".zip")
"""Endings of other formats: no command writes such a file alone."""


def path_text(path: Any) -> str:
    """A path for a message: one line, its middle left out where it is long.

    Examples
    --------
    >>> path_text("maps/a.nc")
    'maps/a.nc'
    """
    return one_line(str(path), LONGEST)


def place(path: Any) -> Path:
    """A path from a user's value, refused where it cannot name a file."""
    try:
        target = Path(path)
    except TypeError:
        raise FileError(f"the file name is {shown(path)}; give a string or a path.") from None
    text = str(target)
    try:
        os.fsencode(text)
    except UnicodeEncodeError as error:
        odd = f"U+{ord(text[error.start]):04X}"
        raise FileError(f"{path_text(text)} is no file name; leave out {odd}.") from None
    if "\0" in text:
        raise FileError(f"{path_text(text)} is no file name; leave out NUL.")
    return target


@contextmanager
def refusing(path: Any, what: str = "written") -> Iterator[None]:
    """Turn an error of the operating system into a sentence: a path cannot be `what`, and why."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error).partition("\n")[0][:100]
        raise FileError(f"{path_text(path)} cannot be {what}: {reason}.") from None


def check_suffix(path: Any, endings: Sequence[str], option: str = "") -> Path:
    """A path with an ending that fits the content.

    Examples
    --------
    >>> check_suffix("map.png", PICTURES).name
    'map.png'
    """
    target = place(path)
    if target.suffix.lower() in endings:
        return target
    subject = f"{option} is {shown(str(path))}" if option else path_text(path)
    raise FileError(f"{subject}; the name must end in {listed(endings, 'or')}.")


def check_same(target: Path, origin: Mapping[str, str] | None = None) -> None:
    """Refuse to replace a file that another call wrote, or without a record, that none did."""
    from .origin import unlike

    with refusing(target, "read"):
        why = unlike(target, origin)
    if why:
        raise FileError(
            f"{path_text(target)} is not what this call wrote ({why}); choose another name, or "
            "replace it with --overwrite (overwrite=True)."
        )


def check_target(
    path: str | os.PathLike[str],
    *,
    overwrite: Overwrite = False,
    origin: Mapping[str, str] | None = None,
) -> Path:
    """Check that a file can be written, and resolve links; nothing is created."""
    from ..base.checks import overwriting  # here, so that a command starts without NumPy

    overwrite = overwriting(overwrite)
    target = place(path)
    with refusing(target):
        there = os.path.lexists(target)
        if target.is_symlink():  # write where it points, and leave the link
            try:
                target.stat()
            except FileNotFoundError:
                there = False
            target = Path(os.path.realpath(target))
        if target.is_dir():
            raise FileError(f"{path_text(target)} is a folder; give the name of a file.")
        if there and not target.is_file():
            raise FileError(f"{path_text(target)} is not a regular file; give the name of one.")
        if there and not overwrite:
            raise FileError(
                f"{path_text(target)} exists; choose another name, or replace it with "
                "--overwrite (overwrite=True)."
            )
        folder = target.parent
        if not folder.is_dir():
            raise FileError(no_folder(folder))
        if not os.access(folder, os.W_OK | os.X_OK):
            raise FileError(
                f"the folder {path_text(folder)} is not writable; choose another place."
            )
        if len(os.fsencode(target.name)) > 255:
            raise FileError(f"{path_text(target)} cannot be written: the name is too long.")
    if there and overwrite == "same":
        check_same(target, origin)
    return target


def no_folder(place: Path) -> str:
    """That a place is no folder, for a message."""
    if place.exists():
        return f"{path_text(place)} is a file, and no folder; choose another place."
    return f"the folder {path_text(place)} does not exist; create it first."


def check_folder(path: str | os.PathLike[str], *, empty: bool = False) -> Path:
    """Check that a folder can be created or written into; nothing is created, litter is removed."""
    target = place(path)
    with refusing(target):
        if target.is_symlink() and not target.is_dir():
            target.stat()  # a loop
            raise FileError(
                f"{path_text(target)} is a link that leads nowhere; choose another name."
            )
        there = target.is_dir()
        if target.exists() and not there:
            raise FileError(f"{path_text(target)} is a file; give the name of a folder.")
        files = [ending for f in FORMATS if not f.folder for ending in f.endings]
        if not there and target.suffix.lower() in (*files, *PICTURES, *FILMS, *OTHER):
            raise FileError(f"{path_text(target)} is named like a file; give the name of a folder.")
        if there:
            clear(target, always=True)
        if empty and there and any(target.iterdir()):
            raise FileError(
                f"{path_text(target)} is not empty and holds other files; choose another folder, "
                "or use --overwrite (overwrite=True)."
            )
        if not target.parent.is_dir():
            raise FileError(no_folder(target.parent))
        if not os.access(target if there else target.parent, os.W_OK | os.X_OK):
            raise FileError(f"{path_text(target)} cannot be written: its folder is not writable.")
    return target
