"""The page of the atlas, its bodies, ranges and captions."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..base.version import __version__
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES
from ..boundary.brackets import Crossing
from ..boundary.curves import KINDS
from ..spectra.labels import LIBRARIES
from ..storage.html import figure, head, unbroken

BODIES: dict[str, tuple[Callable[[], Disk], str, str]] = {
    "disk": (Disk.uniform, "uniform disk", "k = 1/4"),
    "annulus": (lambda: Disk.annulus(0.5), "annulus with inner radius R/2", "k = 5/16"),
    "hoop": (Disk.hoop, "hoop", "k = 1/2"),
}
"""The bodies of the atlas by key: function that makes the disk, name, inertia."""

FRICTION = (0.01, 100.0)
"""Interval of mu* = mu √(gR), on a logarithmic axis."""

LOCUS_FRICTION = (0.3, 3.0)
"""Values of mu* in the loci."""

DRAFT = 100
"""Fewer points along the axis of a family make a draft, unless the caller decides."""

CODE_KINDS = {code: crossing for crossing, code in KINDS.items()}


@dataclass(frozen=True)
class Picture:
    """One figure of the atlas."""

    stem: str
    """File name without suffix."""
    caption: str
    """What it shows, in two lines; a sentence in its place where nothing is drawn."""
    exact: str
    """Exact description of the computation."""
    alternative: str
    """The figure in a few words, for readers who cannot see it."""


@dataclass(frozen=True)
class Page:
    """Figures and rows of one job."""

    body: str
    """Key of `BODIES`."""
    family: str
    """Name of the family."""
    pictures: tuple[Picture, ...]
    """Figures, the diagram first."""
    rows: tuple[tuple[Any, ...], ...]
    """Rows of the CSV."""


def drawn() -> dict[str, tuple[float, float]]:
    """The dimensionless interval of `at` by family, for the families that the atlas draws."""
    return {name: family.drawn for name, family in FAMILIES.items() if family.drawn}


def _zeros(count: int) -> str:
    return "structural zero" if count == 1 else f"{count} structural zeros"


def _diagram_caption(
    family: str,
    name: str,
    inertia: str,
    dataset: Any,
    limits: list[str],
    strips: Sequence[Any],
    scale: tuple[float, float],
    where: str = "",
) -> tuple[str, str]:
    y, x = (str(name) for name in dataset.verdict.dims)
    count = {v.word: int((dataset.verdict == c).sum()) for v, c in CODES.items()}
    verdicts = ", ".join(f"{n:,} {word}".replace(",", "\u00a0") for word, n in count.items() if n)
    word = Verdict.UNDECIDED.word
    undecided = "" if count[word] else f"; none {word}"
    kinds = [CODE_KINDS[c] for c in np.unique(dataset.boundary_kind.values).tolist()]
    style = {
        Crossing.STATIC: "static (solid)",
        Crossing.FLUTTER: "flutter (dashed)",
        Crossing.TOUCHING: "touching (dotted)",
        Crossing.STATIC_AND_FLUTTER: "static and flutter (solid)",
    }
    curve = "No boundary between verdicts in this range."
    if kinds:
        size = np.where(
            dataset.boundary_axis == 0, dataset[f"boundary_{x}"], dataset[f"boundary_{y}"]
        )
        worst = float((dataset.boundary_error.values / np.abs(size)).max())
        curve = (
            f"Black: boundary of the verdict, {' and '.join(style[k] for k in kinds)}, "
            f"{dataset.sizes['boundary_point']} points, each a bracket of relative half-width at "
            f"most {worst:.0e} proved in ball arithmetic."
        )
    missing = int((dataset.verdict == NO_MEMBER).sum())
    verdicts += f", {missing} without a member, left blank" * bool(missing)
    strips_of = " Strips: the limit laws on the same axis and colours." * bool(limits)
    fit = dataset.attrs.get("approximation", "")
    said = "; ".join(limits)
    return (
        f"{_member(family, name, inertia)}{f' {where}' if where else ''}."
        f"{f' {said.capitalize()}.' if said else ''}",
        "Colour: largest real part of the eigenvalues other than the "
        f"{_zeros(dataset.attrs['structural_zeros'])}, on "
        f"{dataset.sizes[x]} × {dataset.sizes[y]} points, in √(g/R), "
        f"{_colours(dataset, strips, scale)}. "
        f"Verdicts: {verdicts}{undecided}. "
        f"{curve}{strips_of}{fit and f' All of this is {fit}.'}",
    )


def _member(family: str, name: str, inertia: str) -> str:
    """A family of a body, short enough for a caption of two lines."""
    brief = name.split(" with ")[0]
    return f"{family.capitalize()} of the {brief}{f' ({inertia})' if inertia else ''}"


def _colours(dataset: Any, strips: Sequence[Any], scale: tuple[float, float]) -> str:
    """The scale of the colours, and the hatching that the map or a strip has."""
    from ..figures.shading import hatching_words

    power = f"{math.log10(scale[0]):.0f}"
    raised = power.translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    codes = np.concatenate([dataset.verdict.values.ravel(), *(strip.codes for strip in strips)])
    hatched = "".join(f"; {words}" for words in hatching_words(codes))
    return f"linear below 10{raised} and logarithmic beyond{hatched}"


_STYLE = """
h2 { margin: 2.2rem 0 .3rem; font-size: 1.25rem; }
nav > * { margin-right: 1rem; } p.lead { max-width: 46rem; }
.row { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(20rem, 100%), 1fr));
       gap: 1.5rem; margin-bottom: 1.8rem; }
.pairs { grid-template-columns: repeat(auto-fill, minmax(min(28rem, 100%), 1fr)); }
nav + .row { margin-top: 1.5rem; }
"""


def _head(title: str) -> list[str]:
    return head(title, _STYLE)


def _html(pages: list[Page], ends: Sequence[Picture], resolution: int, draft: bool) -> str:
    command = f"stability atlas --resolution {resolution}"
    parts = [
        *_head("Stability atlas of the rolling and sliding disk"),
        '<p class="lead">Which steady motions of a thin disk on a plane can be seen? Each diagram '
        "shows one family of steady motions of one body: where small disturbances decay (blue) and "
        "where they grow (vermilion, hatched), with the exact boundary in between. Numbers are "
        "dimensionless (m = R = g = 1). The equations are those of Przybylska &amp; "
        "Rauch-Wojciechowski, <cite>Regul. Chaotic Dyn.</cite> 21(2), 2016, 204–231; every result "
        'is recomputed. All boundaries: <a href="boundaries.csv">boundaries.csv</a>.</p>',
        "<nav>"
        + "".join(f'<a href="#{f}">{f}</a>' for f in (*drawn(), *["launches"] * bool(ends)))
        + "</nav>",
    ]
    if draft:
        parts.append(
            "<p><strong>Draft:</strong> the diagrams alone, as PNG. "
            f"<code>{command} --no-draft</code> adds the eigenvalue loci, the ends of launches and "
            "PDFs.</p>"
        )
    for family in drawn():
        mine = [p for p in pages if p.family == family]
        parts += [
            f'<h2 id="{family}">{family.capitalize()}</h2>',
            f"<p>{unbroken(FAMILIES[family].symbols)}</p>",
        ]
        for index in range(len(mine[0].pictures)):
            parts.append('<div class="row">')
            parts += [_figure(p.pictures[index], index == 0, draft) for p in mine]
            parts.append("</div>")
    if ends:
        parts += [
            '<h2 id="launches">Launches</h2>',
            "<p>Which launch ends where: the disk starts near a steady motion, its axis tilted, "
            "and moves until its end is proved. <code>make basins</code> draws large ones.</p>",
            '<div class="row">',
            *(_figure(p, True, True) for p in ends if p.exact),
            "</div>",
            *(sentence(p) for p in ends if not p.exact),
        ]
    other = (" --draft" if draft else " --no-draft") * (draft != (resolution < DRAFT))
    parts.append(_foot(command + other))
    return "\n".join(parts) + "\n"


def _foot(command: str) -> str:
    versions = ", ".join(f"{n} {version(n)}" for n in (*LIBRARIES, "matplotlib"))
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return (
        f"<footer><p>Made by <code>{command}</code>, stability "
        f"{__version__}, {now}; {html.escape(versions)}. The NetCDF files hold the numbers behind "
        "each diagram with units, error bounds and provenance.</p></footer></body></html>"
    )


def _figure(picture: Picture, diagram: bool, draft: bool = False) -> str:
    files = {"png": "PNG"} if draft else {"png": "PNG", "pdf": "PDF"}
    files |= {"nc": "NetCDF"} if diagram else {}
    return figure(picture.stem, picture.caption, picture.alternative, files, picture.exact)


def sentence(picture: Picture) -> str:
    """A sentence in place of a figure, with its data."""
    return f'<p>{html.escape(picture.caption)} <a href="{picture.stem}.nc">NetCDF</a></p>'


def summary(page: Path) -> dict[str, Any]:
    """Contents of an atlas, for JSON."""
    names = sorted(p.name for p in page.parent.iterdir())
    kinds = {s: sum(n.endswith(s) for n in names) for s in (".png", ".pdf", ".nc", ".csv")}
    out: dict[str, Any] = json.loads(json.dumps({"page": str(page), "files": kinds}))
    return out
