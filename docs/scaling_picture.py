"""Draw docs/scaling.png from the shares that benchmarks/scaling.py has measured and simulated."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from stability.figures.canvas import save_figure
from stability.figures.styled_figure import drawing, key

DOCS = Path(__file__).resolve().parent
RECORD, PICTURE = DOCS / "scaling.json", DOCS / "scaling.png"


def main(path: Path = PICTURE) -> None:
    """Draw the figure.

    Parameters
    ----------
    path
        File to write.
    """
    found: dict[str, Any] = json.loads(RECORD.read_text(encoding="utf-8"))
    workers = found["workers"]
    with drawing(None, None, None, lambda width: 0.75 * width) as figure:
        axes = figure.subplots()
        lines = []
        for (name, values), style in zip(
            found["simulated"].items(), ("-", "--", ":", "-."), strict=False
        ):
            lines += axes.plot(workers, values, style, label=name)
        measured = found["measured with two workers"]
        for (name, value), mark in zip(measured.items(), "os", strict=False):
            lines += axes.plot(
                [2], [value], mark, ms=4, mfc="none", color="black", label=f"{name}, measured"
            )
        axes.set(
            xscale="log",
            xlim=(1, workers[-1]),
            xlabel="workers",
            ylim=(0, 1.05),
            ylabel="share of time in chunks",
        )
        key(axes, lines, f"Simulated, {found['chunks a worker']} chunks a worker")
    save_figure(figure, path)


if __name__ == "__main__":
    main()
    print(PICTURE)
