"""Fates: an outcome, with the family where a launch settled, and their colours and hatching."""

from __future__ import annotations

from ..canvas import figure_style  # isort: skip  # noqa: F401  # before Matplotlib

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ...motion.result import Outcome

if TYPE_CHECKING:
    import xarray

RAMPS = (
    (("#d3e6f5", "#3d84bd"), "", "plain"),
    (("#fdedc8", "#e89b0c"), "....", "dots"),
    (("#d6efe0", "#2f9d70"), "----", "level lines"),
    (("#f3dbea", "#c46aa0"), "||||", "upright lines"),
)
"""Lightest and darkest colour, hatching and its name, for families in the order of a dataset."""
PLAIN = {
    Outcome.MOVING: ("#f5f2b8", "////", "lines that rise"),
    Outcome.FLAT: ("#b3b3b3", r"\\\\", "lines that fall"),
    Outcome.LIFT_OFF: ("#e58a5e", "xxxx", "crosses"),
    Outcome.NO_CONTACT: ("#8f7fb8", "++++", "upright crosses"),
    Outcome.NON_UNIQUE: ("#a9c98f", "oo", "small circles"),
    Outcome.DOMAIN_END: ("#b3b3b3", r"\\\\", "lines that fall"),
    Outcome.UNRESOLVED: ("#ffffff", "OO", "large circles"),
    Outcome.UNDETERMINED: ("#ffffff", "**", "stars"),
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
        return Patch(
            facecolor=self.ramp(0.5),
            edgecolor=matplotlib.rcParams["hatch.color"],
            linewidth=0.3,
            hatch=self.texture and self.texture + self.texture[:2],
            label=self.label,
        )


def fates(dataset: xarray.Dataset) -> list[Fate]:
    """The ends of launches that occur in a dataset, settled ones first.

    Parameters
    ----------
    dataset
        Map from `basins`.
    """
    outcome, family = dataset.outcome.values, dataset.family.values
    member = dataset.member.values
    found = []
    words = str(dataset.family.attrs["flag_meanings"]).split()
    settled = outcome == Outcome.SETTLED.code
    for code, name in enumerate(words):
        where = settled & (family == code)
        if not where.any():
            continue
        colours, texture, way = RAMPS[max(code - 1, 0) % len(RAMPS)]
        own = member[where & np.isfinite(member)]
        found.append(
            Fate(
                f"settled: {name.replace('_', ' ')}",
                where,
                colours,
                texture,
                way,
                name.replace("_", " "),
                (float(own.min()), float(own.max())) if own.size else None,
            )
        )
    for one, (colour, texture, way) in PLAIN.items():
        where = outcome == one.code
        if where.any():
            found.append(Fate(one.word, where, (colour, colour), texture, way))
    return found


def kinds(dataset: xarray.Dataset) -> NDArray[np.int16]:
    """A number for each launch, different where fates differ; -1 where nothing is computed yet."""
    found = np.full(dataset.outcome.shape, -1, dtype=np.int16)
    for i, fate in enumerate(fates(dataset)):
        found[fate.where] = i
    return found
