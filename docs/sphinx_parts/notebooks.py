"""The notebooks of the project as pages: copied next to the pages, and read by jupytext."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
TARGET = ROOT / "docs" / "notebooks"
OWN = ("## ", "`make notebooks` opens this page")


def read(text: str) -> Any:
    """A script in cells as a notebook; links of the folder `notebooks` become those of the site.

    Parameters
    ----------
    text
        The script.
    """
    import jupytext

    return jupytext.reads(text, fmt="py:percent")


def written(path: Path, text: str) -> None:
    """Write a file, and leave one that holds the same text: Sphinx reads only newer pages again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def copy() -> list[str]:
    """Copy every notebook; returns their names."""
    names = []
    for path in sorted((ROOT / "notebooks").glob("*.py")):
        text = re.sub(r"\(\.\./docs/", "(../", path.read_text(encoding="utf-8"))
        written(TARGET / path.name, text)
        names.append(path.stem)
    for old in TARGET.glob("*.py"):
        if old.stem not in names:
            old.unlink()
    return names


HEAD = """---
kernelspec:
  name: python3
  display_name: Python 3
---

"""


def executed(app: Any, docname: str, source: list[str]) -> None:  # noqa: ARG001
    """Have the Python of a plain page run as cells, so that the site shows what it prints."""
    text = source[0]
    if text.startswith("#") and "\n```python\n" in text:
        source[0] = HEAD + text.replace("\n```python\n", "\n```{code-cell} python\n")
