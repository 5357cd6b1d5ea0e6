"""The figure and the counts of paper.md: `python paper/figures.py` draws one and prints the others.

The counts are those of `docs/report/failures.csv`, which `stability report` writes.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
REPORT = HERE.parent / "docs" / "report" / "failures.csv"
METHODS = {
    "central": "central differences, eigenvalues by LAPACK",
    "ad": "automatic differentiation, structural zeros removed, LAPACK",
    "sympy": "SymPy's Jacobian, LAPACK",
    "mpmath-50": "QR in 50 digits",
    "spectrum": "this package, double precision",
    "certified": "this package, certified",
    "dop853": "DOP853 by SciPy, with events",
    "heyoka": "heyoka, with events",
    "simulate": "this package's `simulate`",
}
"""Methods of the table in the paper, in words."""


def counts() -> dict[str, Counter[str]]:
    """Marks of each method over the hard cases that it was asked."""
    found: dict[str, Counter[str]] = {name: Counter() for name in METHODS}
    with REPORT.open(encoding="utf-8") as handle:
        for row in csv.DictReader(handle):
            if row["method"] in found and row["mark"]:
                found[row["method"]][row["mark"]] += 1
    return found


def rows() -> list[str]:
    """Lines of the table in the paper."""
    lines = []
    for name, words in METHODS.items():
        marks = counts()[name]
        honest = marks["undecided"] + marks["refused"]
        rest = marks["degraded"] + marks["late"] + marks["crashed"]
        total = sum(marks.values())
        lines.append(
            f"| {words} | {total} | {marks['right']} | {rest} | {honest} | {marks['wrong']} |"
        )
    return lines


def draw(folder: Path) -> Path:
    """The stability diagram of a disk that spins on its edge."""
    import stability as st

    diagram = st.stability_map("spinning", x=("at", 0.5, 4.0, 160), y=("mu", 0.01, 10, 120, "log"))
    figure = st.plot_map(diagram)
    path = folder / "spinning.png"
    figure.savefig(path, dpi=200)
    return path


def main() -> None:
    """Print the counts, and draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=HERE, help="folder of the figure")
    folder = parser.parse_args().out
    print("\n".join(rows()))
    print(draw(folder))


if __name__ == "__main__":
    main()
