"""The notebooks of the project as pages, and plain pages whose Python is run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
TARGET = ROOT / "docs" / "notebooks"
HEAD = """---
file_format: mystnb
kernelspec:
  name: python3
  display_name: Python 3
---

"""


def written(path: Path, text: str) -> None:
    """Write a file, and leave one that holds the same text: Sphinx reads only newer pages again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def copy() -> None:
    """Write every notebook as a page, with its links seen from there."""
    import jupytext

    names = []
    for path in sorted((ROOT / "notebooks").glob("*.py")):
        page = jupytext.writes(jupytext.read(path), fmt="md:myst")
        page = page.replace("(../docs/", "(../").replace(".ipynb)", ".md)")
        written(TARGET / f"{path.stem}.md", page)
        names.append(path.stem)
    for old in TARGET.glob("*"):
        if old.stem not in names or old.suffix != ".md":
            old.unlink()


def executed(app: Any, docname: str, source: list[str]) -> None:  # noqa: ARG001
    """Have the Python of a plain page run as cells, so that the site shows what it prints."""
    text = source[0]
    if text.startswith("#") and "\n```python\n" in text:
        source[0] = HEAD + text.replace("\n```python\n", "\n```{code-cell} python\n")
