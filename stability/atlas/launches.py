"""The atlas' basin diagrams: which launch near rolling or spinning ends where, for each body."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .page import BODIES, Picture

LAUNCHED = ("rolling", "spinning")
"""Families near which launches start."""
MU = 0.3
"""Friction coefficient of the launches, over 1/√(gR)."""
AT, TILT = (0.1, 3.0), (0.01, 1.2)
"""Angular velocity of the steady motion [√(g/R)], and the tilt from it [rad]."""
TIME = 200.0
"""Last time [√(R/g)]."""
FINEST, COARSEST = 16, 6
"""Most and fewest launches along the angular velocity."""


def launches_along(resolution: int) -> tuple[int, int]:
    """Launches along the angular velocity and along the tilt, small next to a map of verdicts.

    Examples
    --------
    >>> launches_along(400), launches_along(16)
    ((16, 11), (6, 4))
    """
    count = min(max(COARSEST, resolution // 14), FINEST)
    return count, round(5 * count / 7)


def basin_diagrams(folder: Path, resolution: int) -> tuple[Picture, ...]:
    """Draw every body and family as PNG, with the numbers next to it, in one process.

    A process compiles the integrators once, which takes as long as four of these maps.

    Parameters
    ----------
    folder
        Folder of the atlas.
    resolution
        Points of the diagrams along their axes.
    """
    from ..figures.canvas import FORMATS, save

    found = []
    for family in LAUNCHED:
        for body in BODIES:
            figure, picture = _diagram(folder, body, family, resolution)
            save(figure, folder / picture.stem, FORMATS[:1])
            found.append(picture)
    return tuple(found)


def _diagram(folder: Path, body: str, family: str, resolution: int) -> tuple[Any, Picture]:
    """The figure of one body and family."""
    from ..basin.basins import basins
    from ..bodies.contact_laws import Viscous
    from ..figures.basin.basins import basins_caption, plot_basins
    from ..storage.files import atomic_write
    from ..storage.netcdf import packed

    make, name, inertia = BODIES[body]
    along, across = launches_along(resolution)
    dataset = basins(
        make(),
        Viscous(MU),
        family=family,
        x=("at", *AT, along),
        y=("tilt", *TILT, across),
        horizon=TIME,
        workers=1,
    )
    stem = f"basins-{family}-{body}"
    with atomic_write(folder / f"{stem}.nc", overwrite=True) as draft:
        draft.write_bytes(packed(dataset))
    figure = plot_basins(dataset, title=f"launches near {family}: {name}")
    caption = f"{name[:1].upper()}{name[1:]} ({inertia}), μ = {MU:g} /√(gR).  "
    caption += basins_caption(dataset).replace("  ", " ")
    return figure, Picture(stem, caption, f"Ends of launches near {family} of the {name}")
