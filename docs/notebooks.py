"""Run the notebooks, and keep each with its output and pictures as `notebooks/NAME.ipynb`.

Run by `make pictures`, after a change of `notebooks/NAME.py`.
"""

from __future__ import annotations

import base64
import io
import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
SHARP = ("--InlineBackend.figure_formats={'retina'}", "--InlineBackend.rc={'figure.dpi': 144}")
"""As figures of the package: 144 dots of the page for an inch, and twice as many pixels."""
COLOURS = 256
"""Colours of a stored picture: it is a third of the size then, and none is off by 3 %."""


def small(picture: str) -> str:
    """A PNG in base64 with few colours, and compressed as far as it goes."""
    from PIL import Image

    kept = io.BytesIO()
    with Image.open(io.BytesIO(base64.b64decode(picture))) as image:
        flat = image.convert("RGBA")
        page = Image.new("RGBA", flat.size, "white")
        page.alpha_composite(flat)
        few = page.convert("RGB").quantize(
            COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
        )
        few.save(kept, "PNG", optimize=True)
    return base64.b64encode(kept.getvalue()).decode()


def run(path: Path) -> dict[str, Any]:
    """A notebook in the format of Jupyter, run from top to bottom."""
    import jupytext
    from nbclient import NotebookClient

    page = jupytext.read(path)
    with TemporaryDirectory() as folder:  # a notebook may write files
        NotebookClient(
            page,
            timeout=600,
            resources={"metadata": {"path": folder}},
            record_timing=False,
            coalesce_streams=True,  # otherwise cut where the kernel happens to flush
            extra_arguments=list(SHARP),
        ).execute()
    for number, cell in enumerate(page.cells):
        cell.id = f"cell-{number}"  # otherwise random
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if "image/png" in data:
                data["image/png"] = small(data["image/png"])
    page.metadata["language_info"] = {"name": "python", "file_extension": ".py"}
    return page


def main() -> int:
    """Run the notebooks that are named, or all."""
    import nbformat

    path = (str(FOLDER), os.environ.get("PYTHONPATH", ""))  # for `proofs`
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, path))
    paths = [FOLDER / f"{Path(name).stem}.py" for name in sys.argv[1:]]
    for path in paths or sorted(FOLDER.glob("*.py")):
        target = path.with_suffix(".ipynb")
        nbformat.write(run(path), target)
        print(f"{target.relative_to(FOLDER.parent)}: {target.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
