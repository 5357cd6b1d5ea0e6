"""Checksums of files: a last line that is checked before anything else of the file is read."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

MARK = b"\nstability sha256 "
"""Beginning of the last line."""
LENGTH = len(MARK) + 64 + 1
"""Bytes of the last line with its mark."""
ATTRIBUTE = "checksum"
"""Attribute of a NetCDF file that says that there must be such a line."""
STATEMENT = "sha256 of what stands before the last line of the file"
"""Value of that attribute."""
BLOCK = 2**20
NEAR = 2**13
"""Bytes at the end of a file among which its last line is looked for."""


def sealed(content: bytes | memoryview, label: str = "") -> bytes:
    """Content followed by a line with its checksum; content of another label does not pass.

    Examples
    --------
    >>> unsealed(sealed(b"abc", "a"), "a"), unsealed(sealed(b"abc", "a"), "b")
    (b'abc', None)
    """
    digest = hashlib.sha256(label.encode() + bytes(1))
    digest.update(content)
    return bytes(content) + _line(digest.hexdigest())


def unsealed(content: bytes, label: str = "") -> bytes | None:
    """Content without its checksum, or None where it is missing or wrong."""
    body = content[:-LENGTH]
    return body if len(content) >= LENGTH and sealed(body, label) == content else None


def seal(path: Path) -> None:
    """Append a line with its checksum to a file."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as handle:
        handle.write(_line(digest))


def intact(path: Path) -> bool | None:
    """Whether a file is as it was written; None where it has no checksum."""
    size = path.stat().st_size
    if size < LENGTH:
        return None
    with path.open("rb") as handle:
        handle.seek(-LENGTH, os.SEEK_END)
        line = handle.read(LENGTH)
        handle.seek(max(0, size - NEAR))
        end = handle.read(NEAR)
    if not line.startswith(MARK):  # the line may be cut short, or bytes may follow it
        cut = any(end.endswith(MARK[:n]) for n in range(5, len(MARK)))
        return False if cut or MARK in end else None
    return line == _line(_digest(path, size - LENGTH))


def _line(digest: str) -> bytes:
    return MARK + digest.encode() + b"\n"


def _digest(path: Path, size: int) -> str:
    """Checksum of the first bytes of a file, without a label."""
    digest = hashlib.sha256(bytes(1))
    with path.open("rb") as handle:
        while size > 0 and (block := handle.read(min(size, BLOCK))):
            digest.update(block)
            size -= len(block)
    return digest.hexdigest()
