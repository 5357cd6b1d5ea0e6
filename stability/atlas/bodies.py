"""The atlas of bodies: diagrams of the families of bodies of revolution, and a page of bodies.

Each figure is one job.  Finished figures are kept next to the target until the atlas is complete,
so that the same call goes on after an interruption.
"""

from __future__ import annotations

import html
import json
import math
import os
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..base.checks import whole_number
from ..base.errors import FileError, NoMemberError
from ..base.version import __version__
from ..bodies.contact_laws import Viscous
from ..bodies.round_body.body import Body
from ..bodies.round_body.families import FAMILIES
from ..bodies.round_body.inclinations import tumbling_ranges
from ..bodies.round_body.shapes.named import EccentricSphere, Spheroid, ThickDisk, Torus
from ..jobs.following import processes
from ..jobs.pipeline import Counted, check_run, here, ordered, resumable
from ..maps.stability_map import stability_map
from ..storage.files import atomic_write
from ..storage.targets import path_text, refusing
from .build import FINEST, folder_for, move
from .page import FRICTION, Picture, _diagram_caption, _figure, _foot, _head, drawn

RESOLUTION = 48
"""Points along the axis of the family, where none is asked for."""
MU = 0.3
"""Friction coefficient mu* of the diagrams over a number of the shape."""
CLOSE = 0.03
"""Distance of a diagram of tumbling from flat and from upright [rad]."""
VERTICAL = (0.05, 8.0)
"""Interval of the angular velocity of vertical spin [√(g/R)]."""
POLES = {"vertical": 0, "vertical-pi": "pi"}
"""Which end is up in vertical spin, by the name of the diagrams."""
_Key = tuple[str, str, str]
"""A figure: key of the body, name of the diagrams, name of the upper axis."""


@dataclass(frozen=True)
class Shown:
    """A body of the atlas."""

    name: str
    """Name in captions."""
    make: Callable[[float], Body]
    """The body from the number of its shape."""
    number: float
    """That number in the diagrams over mu."""
    range: tuple[float, float]
    """Its interval in the other diagrams."""
    profile: str
    """What the number is, in words."""
    ends: tuple[str, ...] = ()
    """Words for vertical spin on either end, of a body whose ends differ."""


BODIES: dict[str, Shown] = {
    "torus": Shown("torus", Torus, 0.2, (0.02, 0.9), "tube radius b over R, the radius of the "
                   "circle of the tube's centres; solid, of uniform density"),
    "oblate": Shown("oblate spheroid", Spheroid, 0.5, (0.05, 0.95), "half length a of the axis "
                    "over R, the radius of the equator; solid, of uniform density"),
    "prolate": Shown("prolate spheroid", Spheroid, 1.5, (1.05, 3.0), "half length a of the axis "
                     "over R, the radius of the equator; solid, of uniform density"),
    "eccentric": Shown("eccentric sphere", EccentricSphere, 0.2, (0.02, 0.9), "distance e of the "
                       "centre of mass from the centre, over the radius R; a uniform ball with a "
                       "point of mass on its surface",
                       ("centre of mass below", "centre of mass above")),
    "thick": Shown("thick disk", ThickDisk, 0.3, (0.05, 1.5), "thickness t over the radius R; a "
                   "uniform cylinder that rolls on the rim of its lower face"),
}  # fmt: skip
"""The bodies of the atlas by key."""


def atlas_of_bodies(
    out: str | os.PathLike[str],
    *,
    resolution: int = RESOLUTION,
    overwrite: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write the atlas of bodies into a folder: figures (PNG, PDF), maps (NetCDF), a page.

    Parameters
    ----------
    out
        Folder to write.  Finished figures are kept in the folder `OUT.parts` until all are done; a
        call that was interrupted goes on from there.
    resolution, overwrite, workers, executor, progress
        As for `stability.atlas.build.atlas`.

    Returns
    -------
    Path
        The page, `index.html` in the folder.

    Raises
    ------
    FileError
        If the folder is not empty and `overwrite` is off, or if it cannot be written.
    ParameterError
        If the resolution is below 8 or above `FINEST`.
    """
    resolution = whole_number("resolution", resolution, 8, FINEST)
    check_run(workers, progress, executor)
    target = folder_for(out, overwrite=overwrite)
    jobs, absent = _jobs()
    keep = _Figures(target, resolution)
    counted = Counted(progress, len(jobs))
    counted.add(0)
    count = min(workers or os.cpu_count() or 1, len(jobs))
    with resumable(keep.folder, counted, said="figures are kept in"), closing(ordered(
        jobs, lambda job: partial(_job, *job, str(keep.folder), resolution), executor=executor,
        workers=count, own=here if workers == 1 else processes, keep=keep, progress=counted,
    )) as results:  # fmt: skip
        found = dict(results)
    (keep.folder / "index.html").write_text(_page(found, absent, resolution), encoding="utf-8")
    keep.release()
    move(keep.folder, target)
    shutil.rmtree(keep.folder, ignore_errors=True)
    return target / "index.html"


def _jobs() -> tuple[list[_Key], dict[tuple[str, str], str]]:
    """Every figure, and a sentence for each family that a body does not have."""
    jobs: list[_Key] = []
    absent = {}
    for key, shown in BODIES.items():
        body = shown.make(shown.number)
        for name in _names(shown):
            family, pole = _family(name)
            try:
                body.family(family, Viscous, pole=pole)
            except NoMemberError as error:
                absent[key, name] = f"No {_spoken(family)}: {error}"
                continue
            if family == "tumbling" and not tumbling_ranges(body):
                absent[key, name] = f"No tumbling: at no inclination is the {shown.name} steady."
                continue
            jobs += [(key, name, axis) for axis in ("mu", *body.shape)]
    return jobs, absent


def _names(shown: Shown) -> list[str]:
    """Names of a body's diagrams: its families, vertical spin on both ends where these differ."""
    return [*drawn(), *list(POLES)[: max(1, len(shown.ends))]]


def _family(name: str) -> tuple[str, Any]:
    """The family of a diagram, and the pole of vertical spin."""
    return ("vertical", POLES[name]) if name in POLES else (name, None)


def _spoken(family: str) -> str:
    return "vertical spin" if family == "vertical" else family


class _Figures:
    """Finished figures in a folder next to the target, until the atlas is complete."""

    NOTE = "atlas.json"

    def __init__(self, target: Path, resolution: int) -> None:
        self.folder = target.with_name(f"{target.name}.parts")
        self._label = [__version__, resolution]
        with refusing(self.folder, "used"):
            self.folder.mkdir(parents=True, exist_ok=True)
            if any(self.folder.iterdir()) and not (self.folder / self.NOTE).is_file():
                raise FileError(f"{path_text(self.folder)} holds other files; move it aside.")
            (self.folder / self.NOTE).write_text("figures of an unfinished atlas\n")

    def done(self, key: _Key) -> bool:
        """Whether a figure is there."""
        return self.get(key) is not None

    def get(self, key: _Key) -> Picture | None:
        """A finished figure; None where it is missing, or of another atlas."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            found = json.loads(self._path(key).read_text(encoding="utf-8"))
            picture = Picture(**found["picture"])
            files = [self.folder / f"{picture.stem}.{s}" for s in ("png", "pdf", "nc")]
            if found["label"] == self._label and all(f.is_file() for f in files):
                return picture
        return None

    def add(self, key: _Key, value: Picture) -> None:
        """State that a figure is finished."""
        with atomic_write(self._path(key), overwrite=True, result=False) as draft:
            text = json.dumps({"label": self._label, "picture": asdict(value)})
            draft.write_text(text, encoding="utf-8")

    def release(self) -> None:
        """Remove what is no part of the atlas."""
        for path in [*self.folder.glob("*.part.json"), self.folder / self.NOTE]:
            path.unlink()

    def _path(self, key: _Key) -> Path:
        return self.folder / f"{'-'.join(key)}.part.json"


# --- one job ---


def _range(family: str, body: Body) -> tuple[float, float]:
    """The interval of `at` of a diagram."""
    low, high = VERTICAL if family == "vertical" else drawn()[family]
    if family != "tumbling":
        return low, high
    ranges = tumbling_ranges(body)
    # beyond upright a body with two equal sides is mirrored
    high = ranges[-1][1] if "eccentric" in body.name else min(ranges[-1][1], math.pi / 2)
    return ranges[0][0] + CLOSE, high - CLOSE


def _job(key: str, name: str, axis: str, folder: str, resolution: int) -> Picture:
    """The diagram of a family over its member and an axis."""
    from ..figures.canvas import save
    from ..figures.diagram import plot_map
    from ..maps.netcdf import write_map

    shown, (family, pole) = BODIES[key], _family(name)
    body, stem = shown.make(shown.number), f"{name}-{key}-{axis}"
    [number] = body.shape
    rows = 3 * resolution // 4
    y = ("mu", *FRICTION, rows, "log") if axis == "mu" else (axis, *shown.range, rows)
    contact = "viscous" if axis == "mu" else Viscous(MU)
    x = (FAMILIES[family].at[0], *_range(family, body), resolution)
    given = {} if pole is None else {"pole": pole}
    dataset = stability_map(family, x=x, y=y, body=body, contact=contact, workers=1, **given)
    target = Path(folder)
    write_map(dataset, target / f"{stem}.nc", overwrite=True)
    end = shown.ends[list(POLES).index(name)] if name in POLES and shown.ends else ""
    spoken = _spoken(family)
    title = f"{spoken}: {shown.name}" + (f",\n{end}" if end else "")
    save(plot_map(dataset, title=title), target / stem)
    fixed = f"{number} = {shown.number:g}" if axis == "mu" else f"μ = {MU:g} /√(gR)"
    said = f"{end}, {fixed}" if end else fixed
    caption = _diagram_caption(spoken, shown.name, said, dataset, [], [])
    over = "friction" if axis == "mu" else axis
    return Picture(stem, caption, f"Stability diagram of {spoken} of the {shown.name} over {over}")


# --- page ---


def _page(
    found: Mapping[_Key, Picture], absent: Mapping[tuple[str, str], str], resolution: int
) -> str:
    title = "Stability atlas of bodies of revolution"
    parts = [
        *_head(title),
        '<p class="lead">Steady motions of round bodies on a plane under viscous friction. Each '
        "diagram shows one family of one body, over the number that names its members and over the "
        "friction coefficient, or over a number of the body's shape: where small disturbances "
        "decay (blue) and where they grow (vermilion, hatched), with the boundary in between. "
        "Numbers are dimensionless (m = R = g = 1). A verdict without a proof is called undecided. "
        "The equations follow from the height of the centre of mass over the plane.</p>",
        "<nav>" + "".join(f'<a href="#{k}">{s.name}</a>' for k, s in BODIES.items()) + "</nav>",
    ]
    for key, shown in BODIES.items():
        body = shown.make(shown.number)
        [name] = body.shape
        axial, transverse = body.moments()
        parts += [
            f'<h2 id="{key}">{shown.name.capitalize()}</h2>',
            f"<p>{name.capitalize()}: {shown.profile}. At {name} = {shown.number:g} the moments of "
            f"inertia are {axial:.4g} (about the axis) and {transverse:.4g} (across it) mR².</p>",
        ]
        for family in _names(shown):
            if (key, family) in absent:
                parts.append(f"<p>{html.escape(absent[key, family])}</p>")
                continue
            pictures = [found[key, family, axis] for axis in ("mu", name)]
            parts += ['<div class="row">', *(_figure(p, True) for p in pictures), "</div>"]
    parts.append(_foot(f"stability atlas --bodies --resolution {resolution}"))
    return "\n".join(parts) + "\n"
