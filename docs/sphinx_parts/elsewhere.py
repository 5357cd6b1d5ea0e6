"""Names of other projects that the reference links to: a short list, for a build without network.

`elsewhere.txt` has one line for each: project, role, name, address within that project's pages.
With DOCS_ONLINE set, the whole inventories are read from there instead.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

LIST = Path(__file__).with_name("elsewhere.txt")
ADDRESSES = {
    "python": "https://docs.python.org/3/",
    "numpy": "https://numpy.org/doc/stable/",
    "scipy": "https://docs.scipy.org/doc/scipy/",
    "xarray": "https://docs.xarray.dev/en/stable/",
    "matplotlib": "https://matplotlib.org/stable/",
}
"""Public documentation of other projects."""


def inventory(project: str, lines: list[list[str]]) -> bytes:
    """An inventory in the format of Sphinx, version 2."""
    head = f"# Sphinx inventory version 2\n# Project: {project}\n# Version: \n"
    head += "# The remainder of this file is compressed using zlib.\n"
    body = "".join(f"{name} {role} 1 {place} -\n" for role, name, place in lines)
    return head.encode() + zlib.compress(body.encode())


def mapping(folder: Path, *, online: bool) -> dict[str, Any]:
    """Setting `intersphinx_mapping`: from the list, or from the network.

    Parameters
    ----------
    folder
        Where inventories are written.
    online
        Whether to read whole inventories from the network.
    """
    if online:
        return {name: (address, None) for name, address in ADDRESSES.items()}
    rows: dict[str, list[list[str]]] = {name: [] for name in ADDRESSES}
    for line in LIST.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            project, *rest = line.split()
            rows[project].append(rest)
    folder.mkdir(parents=True, exist_ok=True)
    for name, lines in rows.items():
        (folder / f"{name}.inv").write_bytes(inventory(name, lines))
    return {n: (a, str(folder / f"{n}.inv")) for n, a in ADDRESSES.items()}
