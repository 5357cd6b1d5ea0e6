"""The picture of the folders, `docs/house.svg`, drawn from the imports of today.

Run `python docs/house.py` after a change of folders, files or imports.  Rows are the floors of
`.importlinter`; lazy imports and imports for typing count.  An arrow that follows from others is
left out.
"""

from __future__ import annotations

import ast
import configparser
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "stability"
PICTURE = ROOT / "docs" / "house.svg"
FACE = ("__main__", "results", "statistics")
"""Entries of the package that are no folders."""
WIDTH, ROW = 7.0, 0.66
"""Width of the picture and height of a floor [inch]."""
BOX = 1.94, 0.42
"""Width and height of a folder [inch]."""
MARGIN = 0.07
"""Between the side of a folder and its words [inch]."""
LANE = 0.22
"""Room of an arrow that passes a floor [inch]."""
LINES, GENERAL, KNOWING, BODIES = "#4d4d4d", "#ffffff", "#dcebf7", "#f9e3bf"
"""Arrows; folders that know no body, folders that do, the bodies."""


@dataclass(frozen=True)
class House:
    """What the picture shows."""

    floors: tuple[tuple[str, ...], ...]
    """Folders by floor, the top first."""
    files: Mapping[str, int]
    """Modules of each folder, its subfolders included."""
    says: Mapping[str, str]
    """First sentence of each folder's docstring."""
    needs: Mapping[str, tuple[str, ...]]
    """The folders that each imports."""
    arrows: tuple[tuple[str, str], ...]
    """Imports that do not follow from others."""


# --- what there is ---


def house(package: Path = PACKAGE, contract: Path = ROOT / ".importlinter") -> House:
    """Read the folders, their imports and their floors.

    Parameters
    ----------
    package
        Folder of the package.
    contract
        File with the floors.

    Returns
    -------
    House

    Raises
    ------
    ValueError
        If a folder has no floor, or an import goes up or sideways.
    """
    folders = sorted(p.parent.name for p in package.glob("*/__init__.py"))
    needs = {name: needed(package / name, folders) for name in folders}
    floors = stated(contract)
    level = {name: i for i, floor in enumerate(floors) for name in floor}
    if set(level) != set(folders):
        raise ValueError(f"no floor, or no folder: {sorted(set(level) ^ set(folders))}")
    wrong = [(a, b) for a in folders for b in needs[a] if level[a] >= level[b]]
    if wrong:
        raise ValueError(f"these imports do not go down: {wrong}")
    files = {n: sum(p.stem != "__init__" for p in (package / n).rglob("*.py")) for n in folders}
    says = {n: first_sentence(package / n / "__init__.py") for n in folders}
    return House(floors, files, says, needs, reduced(needs))


def stated(contract: Path) -> tuple[tuple[str, ...], ...]:
    """The floors of the contract, the top first, each in alphabetical order."""
    rules = configparser.ConfigParser()
    rules.read_string(contract.read_text(encoding="utf-8"))
    lines = rules["importlinter:contract:floors"]["layers"].split("\n")
    rows = [sorted(re.findall(r"\w+", line)) for line in lines]
    return tuple(tuple(row) for row in rows if row and not set(row) <= set(FACE))


def needed(folder: Path, folders: Sequence[str]) -> tuple[str, ...]:
    """The other folders that a folder imports, wherever in its files it does."""
    found: set[str] = set()
    for path in folder.rglob("*.py"):
        package = ("stability", *path.relative_to(folder.parent).parts[:-1])
        for module in modules(ast.parse(path.read_text(encoding="utf-8")), package):
            if module[0] == "stability" and len(module) > 1:
                found.add(module[1])
    return tuple(sorted(found & set(folders) - {folder.name}))


def modules(tree: ast.AST, package: tuple[str, ...]) -> Iterable[tuple[str, ...]]:
    """Full names of what a file imports, as parts; `package` is the file's own."""
    for node in statements(tree):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            stem = (*base, *(node.module or "").split(".")) if node.module else base
            yield from ((*stem, alias.name) for alias in node.names)


def statements(node: ast.AST) -> Iterable[ast.AST]:
    """All statements below a node; expressions, which are most of a tree, are not entered."""
    for part in ("body", "orelse", "finalbody", "handlers", "cases"):
        for child in getattr(node, part, ()):
            yield child
            yield from statements(child)


def first_sentence(path: Path) -> str:
    """The first sentence of a module's docstring, without its full stop."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return text.split("\n\n")[0].replace("\n", " ").split(".")[0]


def below(needs: Mapping[str, Sequence[str]], name: str) -> set[str]:
    """The folders that one imports, directly or through others."""
    return set(needs[name]).union(*(below(needs, other) for other in needs[name]))


def reduced(needs: Mapping[str, Sequence[str]]) -> tuple[tuple[str, str], ...]:
    """The imports that no chain of other imports implies."""
    return tuple(
        (a, b)
        for a in sorted(needs)
        for b in needs[a]
        if not any(b in below(needs, other) for other in needs[a])
    )


# --- where it is drawn ---

Item = tuple[str, ...]
"""A folder, as (name,), or an arrow that passes a floor, as (from, to)."""


def chains(shown: House) -> list[list[Item]]:
    """Each arrow as the items that it joins, one a floor."""
    level = {name: i for i, floor in enumerate(shown.floors) for name in floor}
    return [[(a,), *[(a, b)] * (level[b] - level[a] - 1), (b,)] for a, b in shown.arrows]


def arranged(shown: House) -> list[list[Item]]:
    """The items of every floor from left to right, with few crossings.

    Sweeps down and up put each item at the mean place of those it is joined with; the arrangement
    with the fewest crossings is kept.
    """
    level = {name: i for i, floor in enumerate(shown.floors) for name in floor}
    rows: list[list[Item]] = [[(name,) for name in floor] for floor in shown.floors]
    for a, b in shown.arrows:
        for i in range(level[a] + 1, level[b]):
            rows[i].append((a, b))
    best, least = rows, crossings(rows, shown)
    for sweep in range(40):
        order = range(1, len(rows)) if sweep % 2 == 0 else range(len(rows) - 2, -1, -1)
        rows = [list(row) for row in rows]
        for i in order:
            other = rows[i - 1 if sweep % 2 == 0 else i + 1]
            place = {item: (j + 0.5) / len(other) for j, item in enumerate(other)}
            wish = {n: (j + 0.5) / len(rows[i]) for j, n in enumerate(rows[i])}
            wish = {n: mean(n, [place], shown, own) for n, own in wish.items()}
            rows[i].sort(key=wish.__getitem__)
        if (count := crossings(rows, shown)) < least:
            best, least = rows, count
    return best


def joined(a: Item, b: Item, shown: House) -> bool:
    """Whether an arrow leads from an item to one on the floor below."""
    if len(a) == len(b) == 2:
        return a == b
    if len(a) == len(b) == 1:
        return (a[0], b[0]) in shown.arrows
    return b[0] == a[0] if len(a) == 1 else a[1] == b[0]


def mean(item: Item, floors: Sequence[Mapping[Item, float]], shown: House, own: float) -> float:
    """Mean place of the items that one is joined with; its own where there are none."""
    near = [
        x
        for floor in floors
        for other, x in floor.items()
        if joined(other, item, shown) or joined(item, other, shown)
    ]
    return sum(near) / len(near) if near else own


def crossings(rows: Sequence[Sequence[Item]], shown: House) -> int:
    """How many pairs of arrows cross."""
    count = 0
    for above, below in zip(rows, rows[1:], strict=False):
        pairs = [
            (i, j) for i, a in enumerate(above) for j, b in enumerate(below) if joined(a, b, shown)
        ]
        count += sum((a - c) * (b - d) < 0 for k, (a, b) in enumerate(pairs) for c, d in pairs[:k])
    return count


def placed(shown: House) -> list[dict[Item, float]]:
    """Abscissa of every item of every floor [inch]."""
    rows = arranged(shown)
    size = {item: BOX[0] + 0.1 if len(item) == 1 else LANE for row in rows for item in row}
    spots = [spread(row, size, {item: WIDTH / 2 for item in row}) for row in rows]
    for sweep in range(60):
        for i in range(len(rows)) if sweep % 2 else reversed(range(len(rows))):
            near = [spots[k] for k in (i - 1, i + 1) if 0 <= k < len(rows)]
            wish = {item: mean(item, near, shown, own) for item, own in spots[i].items()}
            spots[i] = spread(rows[i], size, wish)
    return spots


def spread(
    row: Sequence[Item], size: Mapping[Item, float], wish: Mapping[Item, float]
) -> dict[Item, float]:
    """Places near the wished ones, as order, sizes and the width allow.

    Each item is put right of the one before and then left of the one after; the mean of both keeps
    every distance.
    """
    right: dict[Item, float] = {}
    left: dict[Item, float] = {}
    end = 0.0
    for i, item in enumerate(row):
        rest = WIDTH - sum(size[n] for n in row[i:])
        right[item] = max(min(wish[item] - size[item] / 2, rest), end) + size[item] / 2
        end = right[item] + size[item] / 2
    end = WIDTH
    for i, item in reversed(list(enumerate(row))):
        rest = sum(size[n] for n in row[: i + 1])
        left[item] = min(max(wish[item] + size[item] / 2, rest), end) - size[item] / 2
        end = left[item] - size[item] / 2
    return {item: (left[item] + right[item]) / 2 for item in row}


# --- how it is drawn ---


def draw(shown: House) -> Figure:
    """The picture.

    Parameters
    ----------
    shown
        What it shows.

    Returns
    -------
    Figure
    """
    from matplotlib.figure import Figure

    spots = placed(shown)
    height = ROW * len(shown.floors) + 0.42
    figure = Figure(figsize=(WIDTH + 0.3, height))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.28, WIDTH + 0.02), ylim=(0, height))
    axes.axis("off")
    levels = [height - 0.08 - ROW * (i + 0.5) for i in range(len(spots))]
    for i, (row, y) in enumerate(zip(spots, levels, strict=True)):
        if i % 2 == 0:
            axes.axhspan(y - ROW / 2, y + ROW / 2, color="#f5f5f5", lw=0)
        axes.text(
            -0.14, y, str(len(spots) - 1 - i), ha="center", va="center", fontsize=7, color=LINES
        )
        for item, x in row.items():
            if len(item) == 1:
                _folder(axes, shown, item[0], x, y)
    for chain in chains(shown):
        points = [(spots[k][item], levels[k]) for item, k in _levels(chain, shown)]
        _arrow(
            axes,
            points,
            _port(shown, spots, chain, first=True),
            _port(shown, spots, chain, first=False),
        )
    _legend(axes)
    return figure


def _levels(chain: Sequence[Item], shown: House) -> list[tuple[Item, int]]:
    """The items of an arrow, each with its floor counted from the top."""
    top = next(i for i, floor in enumerate(shown.floors) if chain[0][0] in floor)
    return [(item, top + k) for k, item in enumerate(chain)]


def _port(
    shown: House, spots: Sequence[Mapping[Item, float]], chain: Sequence[Item], *, first: bool
) -> float:
    """Offset from the middle of a folder at which an arrow leaves or arrives."""
    own = chain[0] if first else chain[-1]
    rivals = []
    for other in chains(shown):
        if other[0 if first else -1] == own:
            item, level = _levels(other, shown)[1 if first else -2]
            rivals.append((spots[level][item], other))
    rivals.sort()
    index = [other for _, other in rivals].index(list(chain))
    return (index - (len(rivals) - 1) / 2) * min(0.3, 0.8 * BOX[0] / len(rivals))


def _folder(axes: Axes, shown: House, name: str, x: float, y: float) -> None:
    """One folder: name, number of files, first sentence."""
    from matplotlib.patches import FancyBboxPatch

    colour = KNOWING if "bodies" in below(shown.needs, name) else GENERAL
    colour = BODIES if name == "bodies" else colour
    width, height = BOX
    axes.add_patch(
        FancyBboxPatch(
            (x - width / 2, y - height / 2),
            width,
            height,
            boxstyle="round,pad=0,rounding_size=0.05",
            facecolor=colour,
            edgecolor="#1a1a1a",
            linewidth=0.7,
            zorder=3,
        )
    )
    count = f"{shown.files[name]} file" + "s" * (shown.files[name] != 1)
    style: dict[str, Any] = {"va": "center", "zorder": 4}
    axes.text(
        x - width / 2 + MARGIN,
        y + 0.09,
        f"{name}/",
        ha="left",
        fontsize=8.5,
        fontweight="bold",
        **style,
    )
    axes.text(
        x + width / 2 - MARGIN, y + 0.09, count, ha="right", fontsize=6.5, color=LINES, **style
    )
    axes.text(x - width / 2 + MARGIN, y - 0.1, shown.says[name], ha="left", fontsize=6.8, **style)


def _arrow(axes: Axes, points: Sequence[tuple[float, float]], start: float, end: float) -> None:
    """One arrow; `start` and `end` are the offsets of its ends from the middle of their folders."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.path import Path as Curve

    (x0, y0), (x1, y1) = points[0], points[-1]
    half = BOX[1] / 2
    vertices, codes = [(x0 + start, y0 - half)], [Curve.MOVETO]
    # straight past the folders of a floor, curved between floors
    for x, y in [*points[1:-1], (x1 + end, y1)]:
        (xa, ya), top = vertices[-1], y + half
        vertices += [(xa, (ya + top) / 2), (x, (ya + top) / 2), (x, top), (x, y - half)]
        codes += [Curve.CURVE4] * 3 + [Curve.LINETO]
    vertices, codes = vertices[:-1], codes[:-1]
    axes.add_patch(
        FancyArrowPatch(
            path=Curve(vertices, codes),
            arrowstyle="-|>,head_length=2.6,head_width=1.5",
            color=LINES,
            linewidth=0.8,
            zorder=2,
            shrinkA=0,
            shrinkB=0,
            capstyle="butt",
        )
    )


def _legend(axes: Axes) -> None:
    """What colours and arrows mean."""
    from matplotlib.patches import Rectangle

    x = 0.0
    for colour, text in (
        (GENERAL, "knows no body"),
        (BODIES, "the bodies"),
        (KNOWING, "knows the bodies"),
    ):
        axes.add_patch(
            Rectangle((x, 0.11), 0.22, 0.12, facecolor=colour, edgecolor="#1a1a1a", linewidth=0.6)
        )
        axes.text(x + 0.28, 0.17, text, va="center", fontsize=6.8)
        x += 1.3
    axes.text(
        WIDTH,
        0.17,
        "arrow: imports, directly; what follows from other arrows is left out",
        ha="right",
        va="center",
        fontsize=6.8,
    )


# --- the file ---


def record(shown: House) -> str:
    """What the picture shows, as the text that the file carries."""
    return json.dumps(asdict(shown), sort_keys=True)


def recorded(path: Path = PICTURE) -> str:
    """The text that a picture carries, or nothing."""
    from html import unescape

    found = re.search(r"<dc:description>(.*?)</dc:description>", path.read_text("utf-8"), re.DOTALL)
    return unescape(found[1]).strip() if found else ""


def style() -> Any:
    """A context in which the picture looks the same everywhere."""
    import matplotlib

    return matplotlib.rc_context({"svg.hashsalt": "house", "font.family": "DejaVu Sans"})


def main(path: Path = PICTURE) -> None:
    """Draw the picture into its file."""
    shown = house()
    with style():
        draw(shown).savefig(path, metadata={"Date": None, "Description": record(shown)})


if __name__ == "__main__":
    main()
