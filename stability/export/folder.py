"""Files of an export: a few texts in one folder, all or none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..base.errors import FileError
from ..storage.files import atomic_write
from ..storage.targets import check_target, path_text, place, refusing


def write_folder(out: str | Path, files: Mapping[str, str], *, overwrite: bool) -> Path:
    """Write texts into a folder, which is made if needed.

    Parameters
    ----------
    out
        The folder.
    files
        Texts by the names of their files.
    overwrite
        Whether existing files may be replaced.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    FileError
        If a file exists, or the folder cannot be written.
    """
    folder = place(out)
    if folder.exists() and not folder.is_dir():
        raise FileError(f"{path_text(folder)} is a file; give a folder.")
    for name in files:  # before anything is written
        if (folder / name).exists() and not overwrite:
            raise FileError(f"{path_text(folder / name)} exists; allow overwriting, or move it.")
    with refusing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        target = check_target(folder / name, overwrite=overwrite)
        with atomic_write(target, overwrite=overwrite) as draft:
            draft.write_text(text, "utf-8")
    return folder
