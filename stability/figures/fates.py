"""Fates: an outcome, with the family where a launch settled; its colours, hatching, and marks.

A map has a cell for each launch, a random sample a mark.
"""

from __future__ import annotations

from .styled_figure import entry  # isort: skip

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.looks import HATCHES
from ..basin.statistics.fractions import LEVEL, wilson
from ..basin.statistics.samples import LogUniform
from ..bodies.families import at_name
from ..motion.result import Outcome
from .shading import hatched_patch

if TYPE_CHECKING:
    import xarray


RAMPS = (
    (("#d3e6f5", "#3d84bd"), "", "plain"),
    (("#fdedc8", "#e89b0c"), *HATCHES["second family"]),
    (("#d6efe0", "#2f9d70"), *HATCHES["third family"]),
    (("#f3dbea", "#c46aa0"), *HATCHES["fourth family"]),
)
"""Lightest and darkest colour, hatching and its name, for families in the order of a dataset."""
PLAIN = {
    Outcome.MOVING: ("#f5f2b8", *HATCHES["moving"]),
    Outcome.FLAT: ("#b3b3b3", *HATCHES["flat"]),
    Outcome.LIFT_OFF: ("#e58a5e", *HATCHES["lift-off"]),
    Outcome.NO_CONTACT: ("#8f7fb8", *HATCHES["no-contact"]),
    Outcome.NON_UNIQUE: ("#a9c98f", *HATCHES["non-unique"]),
    Outcome.DOMAIN_END: ("#b3b3b3", *HATCHES["domain-end"]),
    Outcome.UNRESOLVED: ("#ffffff", *HATCHES["unresolved"]),
    Outcome.UNDETERMINED: ("#ffffff", *HATCHES["undetermined"]),
}
"""Colour, hatching and its name of every other outcome."""
FEW = 1e-9
"""Relative spread of members that counts as one member."""


@dataclass(frozen=True, eq=False)
class Fate:
    """One end of launches on a figure."""

    label: str
    """Words of the legend."""
    where: NDArray[np.bool_]
    """The launches that end so, in the dataset's shape."""
    colours: tuple[str, str]
    """Colours of the least and the largest member; twice the same where it has no members."""
    texture: str
    """Hatching, as Matplotlib takes it."""
    way: str
    """Name of the hatching."""
    family: str = ""
    """Family that is settled on; empty for other outcomes."""
    members: tuple[float, float] | None = None
    """Least and largest member that is settled on; None where no member is known."""

    @property
    def ramp(self) -> Any:
        """Colours by member."""
        return LinearSegmentedColormap.from_list(self.label, self.colours)

    @property
    def spread(self) -> bool:
        """Whether members differ, so that the ramp says something."""
        if self.members is None:
            return False
        low, high = self.members
        return high - low > FEW * max(abs(low), abs(high))

    def shades(self, members: NDArray[np.float64]) -> NDArray[np.float64]:
        """Colours of launches by their members, shape (n, 3)."""
        if not self.spread or self.members is None:
            return np.tile(to_rgb(self.ramp(0.5)), (len(members), 1))
        low, high = self.members
        share = np.where(np.isfinite(members), (members - low) / (high - low), 0.5)
        return np.asarray(self.ramp(share))[:, :3]

    @property
    def patch(self) -> Patch:
        """The entry of the legend."""
        return hatched_patch(self.ramp(0.5), self.texture, self.label)


def fates(dataset: xarray.Dataset) -> list[Fate]:
    """The ends of launches that occur in a dataset, settled ones first.

    Parameters
    ----------
    dataset
        Map from `basins`.
    """
    outcome, family = dataset.outcome.values, dataset.family.values
    member = dataset.member.values
    ends = []
    words = str(dataset.family.attrs["flag_meanings"]).split()
    settled = outcome == Outcome.SETTLED.code
    for code, name in enumerate(words):
        where = settled & (family == code)
        if not where.any():
            continue
        colours, texture, way = RAMPS[max(code - 1, 0) % len(RAMPS)]
        values = member[where & np.isfinite(member)]
        ends.append(
            Fate(
                f"settled: {name.replace('_', ' ')}",
                where,
                colours,
                texture,
                way,
                name.replace("_", " "),
                (float(values.min()), float(values.max())) if values.size else None,
            )
        )
    for end, (colour, texture, way) in PLAIN.items():
        where = outcome == end.code
        if where.any():
            ends.append(Fate(end.word, where, (colour, colour), texture, way))
    return ends


def kinds(dataset: xarray.Dataset) -> NDArray[np.int16]:
    """A number for each launch, different where fates differ; -1 where nothing is computed yet."""
    numbers = np.full(dataset.outcome.shape, -1, dtype=np.int16)
    for i, fate in enumerate(fates(dataset)):
        numbers[fate.where] = i
    return numbers


LAUNCH = "launch"
"""Dimension of a sample."""
LATEST = "end_time"
"""What stands along y where a single number varies."""
MOST, PASSES = 3000, 6
"""Marks of a figure, the first launches of the sample; drawn in parts, so that no end hides all
others where ends mix."""
MARKS = {
    "plain": ("o", "circles"),
    "upright lines": ("s", "squares"),
    "upright lines and dots": ("^", "triangles"),
    "level lines and dots": ("v", "triangles on their tips"),
    "lines that fall": ("x", "slanted crosses"),
    "upright and falling lines": ("_", "dashes"),
    "small circles": ("D", "diamonds"),
    "large circles": ("P", "thick crosses"),
    "stars": ("*", "stars"),
    "falling lines and dots": ("_", "dashes"),
    "slanted lines and dots": ("p", "pentagons"),
    "crosses and dots": ("h", "hexagons"),
}
"""Mark and its name, by the hatching of the same end on a map."""
EDGE = 0.3
"""Width of a mark's outline [pt]."""
SIZE = (26.0, 5.0)
"""Largest and smallest area of a mark [pt²]."""


def is_sample(dataset: Any) -> bool:
    """Whether what `basins` returns is a random sample.

    Parameters
    ----------
    dataset
        What it returns.
    """
    return tuple(map(str, dataset.outcome.dims)) == (LAUNCH,)


def varied(dataset: xarray.Dataset) -> list[str]:
    """Names of the numbers that vary in a sample, in its order.

    Parameters
    ----------
    dataset
        A sample of `basins`.
    """
    return [str(n) for n, c in dataset.coords.items() if c.dims == (LAUNCH,) and n != LAUNCH]


def plane_of(dataset: xarray.Dataset, x: str, y: str) -> tuple[str, str]:
    """The two numbers over which a sample is drawn.

    Parameters
    ----------
    dataset
        A sample of `basins`.
    x, y
        Names, `at` for what names the members of a family; empty for the first two that vary.

    Raises
    ------
    StabilityError
        If a name is not known, or is given twice, or no launch is computed yet.
    """
    if not fates(dataset):
        raise ParameterError(
            f"none of the {dataset.outcome.size} launches is computed yet; continue the sample, "
            "then draw it."
        )
    names = [*varied(dataset), LATEST]
    launched = at_name(str(dataset.attrs.get("launched_near", "")).split(" ")[0])
    chosen: list[str] = []
    for asked, which in ((x, "x"), (y, "y")):
        name = launched if asked == "at" else asked
        if not name:
            other = x if which == "y" else y
            name = next(
                n for n in names if n not in (*chosen, launched if other == "at" else other)
            )
        elif name not in names:
            raise NameUnknownError(f"{which} is {shown(asked)}; give one of {', '.join(names)}.")
        chosen.append(name)
    if chosen[0] == chosen[1]:
        raise ParameterError(f"x and y are both {chosen[0]}; give two names.")
    return chosen[0], chosen[1]


def draw_sample(
    axes: Axes, dataset: xarray.Dataset, present: list[Fate], x: str, y: str
) -> list[Line2D]:
    """Draw a mark for each of the first launches.

    Parameters
    ----------
    axes
        The panel.
    dataset
        A sample of `basins`.
    present
        Its ends.
    x, y
        Names of the numbers along the axes.

    Returns
    -------
    list of Line2D
        Entries of the legend, each with the fraction of its end.
    """
    count = min(dataset.outcome.size, MOST)
    across, along = (dataset[n].values for n in (x, y))
    size = float(np.clip(2e3 / max(count, 1) ** 0.75, SIZE[1], SIZE[0]))
    outline = matplotlib.rcParams["hatch.color"]
    for part in np.array_split(np.arange(count), PASSES):
        for fate in present:
            mine = part[fate.where[part]]
            mark, colours = MARKS[fate.way][0], fate.shades(dataset.member.values[mine])
            look: dict[str, Any] = {"c": colours, "edgecolors": outline, "linewidths": EDGE}
            if mark in "x_":  # lines alone, which no outline shows
                look = {"c": outline, "linewidths": 2 * EDGE}
            axes.scatter(
                across[mine], along[mine], s=size, marker=mark, rasterized=count > 500, **look
            )
    for name, values, scale, limits in (
        (x, across, axes.set_xscale, axes.set_xlim),
        (y, along, axes.set_yscale, axes.set_ylim),
    ):
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        if f"{name!r}: {LogUniform.__name__}(" in str(dataset.attrs.get("sample")) and high > low:
            scale("log")
            limits(low / (high / low) ** 0.03, high * (high / low) ** 0.03)
        else:
            room = 0.03 * (high - low) or 0.5
            limits(low - room, high + room)
    words = shares(present)
    return [_entry(fate, words[i], outline) for i, fate in enumerate(present)]


def _entry(fate: Fate, share: str, outline: Any) -> Line2D:
    mark = MARKS[fate.way][0]
    return entry(
        f"{fate.label}, {share}",
        linestyle="none",
        marker=mark,
        markersize=4.5,
        markerfacecolor=fate.ramp(0.5),
        markeredgecolor=outline,
        markeredgewidth=2 * EDGE if mark in "x_" else EDGE,
    )


def shares(present: list[Fate]) -> list[str]:
    """Percentage of each end with its interval of confidence, in words.

    Parameters
    ----------
    present
        The ends of a sample; launches that are not computed yet count in none.

    Examples
    --------
    >>> one = Fate("lift-off", np.array([True] * 3 + [False] * 7), ("k", "k"), "", "small circles")
    >>> other = Fate("moving", ~one.where, ("k", "k"), "", "lines that fall")
    >>> shares([one, other])
    ['30 % (11–60)', '70 % (40–89)']
    """
    counts = [int(fate.where.sum()) for fate in present]
    low, high = wilson(counts, np.full(len(counts), sum(counts)))
    widest = float(np.max(high - low, initial=0.0))
    digits = 0 if widest > 0.02 else 1 if widest > 0.002 else 2
    every = zip(counts, low, high, strict=True)
    return [
        f"{100 * k / sum(counts):.{digits}f} % ({100 * a:.{digits}f}–{100 * b:.{digits}f})"
        for k, a, b in every
    ]


def drawn(dataset: xarray.Dataset) -> str:
    """How many of the launches a figure shows, in words; empty where it shows all.

    Parameters
    ----------
    dataset
        A sample of `basins`.
    """
    total = dataset.outcome.size
    return f"the first {MOST} of {total} launches" if total > MOST else ""


def told_below(dataset: xarray.Dataset) -> str:
    """What the note below a figure adds for a sample; empty for a map.

    Parameters
    ----------
    dataset
        What `basins` returns.
    """
    if not is_sample(dataset):
        return ""
    some = f", {drawn(dataset)} shown" * bool(drawn(dataset))
    return f", fractions with {100 * LEVEL:g} % intervals{some}"


def sample_caption(dataset: xarray.Dataset, x: str, y: str, who: str) -> str:
    """What the diagram of a sample shows, but for how long each launch runs.

    Parameters
    ----------
    dataset
        A sample of `basins`.
    x, y
        Names of the numbers along the axes.
    who
        What is launched, in words.
    """
    present: list[Fate] = fates(dataset)
    marks = "; ".join(f"{MARKS[f.way][1]}: {f.label}" for f in present)
    lightness = "  Lightness: the steady motion that is settled on." * any(
        f.spread for f in present
    )
    each = ", ".join(f"{f.label} {s}" for f, s in zip(present, shares(present), strict=True))
    some = f" ({drawn(dataset)} are drawn)" * bool(drawn(dataset))
    missing = dataset.outcome.size - sum(int(f.where.sum()) for f in present)
    each += f"; {missing} launches are not computed yet" * bool(missing)
    return (
        f"Ends of {dataset.outcome.size} launches of {who}, drawn at random over "
        f"{', '.join(varied(dataset))}, shown over {x} and {y}{some}.  Marks: {marks}.{lightness}"
        f"  Fractions, each with Wilson's interval at {100 * LEVEL:g} %: {each}."
    )
