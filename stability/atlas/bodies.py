"""The atlas of bodies: diagrams of the families of bodies of revolution, a page for each body.

Each figure is one job.  Finished figures are kept next to the target until the atlas is complete,
so that the same call goes on after an interruption.
"""

from __future__ import annotations

import html
import math
import os
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..base.checks import flag, whole_number
from ..base.errors import FileError, NoMemberError
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..base.version import __version__
from ..bodies.contact_laws import Contact, Rough, Smooth, Viscous
from ..bodies.families import FAMILIES
from ..bodies.round_body.body import Body
from ..bodies.round_body.inclinations import tumbling_ranges
from ..bodies.round_body.shapes.named import EccentricSphere, Spheroid, ThickDisk, Torus
from ..bodies.round_body.shapes.profile import Egg
from ..jobs.pipeline import Counted, check_run, resumable
from ..maps.stability_map import stability_map
from ..storage.pieces import Records, is_records
from ..storage.targets import check_folder, path_text, refusing
from .build import FINEST, figures, move
from .page import FRICTION, Picture, _diagram_caption, _figure, _foot, _head, drawn, sentence

RESOLUTION = 96
"""Points along the axis of the family, where none is asked for."""
MU = 0.3
"""Friction coefficient mu* of the viscous diagrams over a number of the body."""
CLOSE = 0.03
"""Distance of a diagram over the inclination from its ends [rad]."""
VERTICAL = (0.05, 8.0)
"""Interval of the angular velocity of vertical spin [√(g/R)]."""
TURNS = (0.02, 2.2)
"""Interval of the precession rate of circling and precession [√(g/R)]."""
POLES: dict[str, Any] = {"vertical": 0, "vertical-pi": "pi"}
"""Which end is up in vertical spin, by the name of the diagrams."""
PLANES = {"circling": "rough", "precession": "smooth"}
"""Families of two numbers, drawn over both of them, and the law under which they exist."""
ON = {
    "viscous": "under viscous friction",
    "rough": "on a rough plane, without slip",
    "smooth": "on a smooth plane, without friction",
}
"""A contact law in a caption."""
LAWS: dict[str, Any] = {"rough": Rough(), "smooth": Smooth()}
"""Laws without a coefficient by name."""
TITLE = "Stability atlas of bodies of revolution"
ABOUT = (
    "Each diagram shows one family of steady motions of one body: where small disturbances decay "
    "(blue), where they grow (vermilion, hatched), and where by linear approximation they do "
    "neither (neutral, dotted), with the boundary in between. Numbers are dimensionless "
    "(m = R = g = 1). A verdict without a proof is called undecided. The equations follow from the "
    "height of the centre of mass over the plane."
)
Key = tuple[str, str, str]
"""A diagram: key of the body, family (and pole), and `mu`, `own`, `rough`, `smooth` or `plane`."""


@dataclass(frozen=True)
class Shown:
    """A body of the atlas."""

    name: str
    """Name in captions."""
    make: Callable[[], Body]
    """The body of the diagrams at one shape."""
    swept: str
    """The number of the body on the upper axis of the other diagrams."""
    range: tuple[float, float]
    """Its interval."""
    profile: str
    """What the body and this number are, in words."""
    ends: tuple[str, ...] = ()
    """Words for vertical spin on either end, of a body whose ends differ."""

    @property
    def told(self) -> str:
        """The numbers of the shape as text."""
        body = self.make()
        return ", ".join(f"{n} = {v:g}" for n, v in (body.constants or body.shape).items())


BODIES: dict[str, Shown] = {
    "torus": Shown(
        "torus",
        lambda: Torus(0.2),
        "tube",
        (0.02, 0.9),
        "A solid ring of uniform density. Tube: radius b of the tube over R, the radius of the "
        "circle of its centres.",
    ),
    "oblate": Shown(
        "oblate spheroid",
        lambda: Spheroid(0.5),
        "aspect",
        (0.05, 0.95),
        "A solid spheroid of uniform density. Aspect: half length a of the axis over R, the radius "
        "of the equator.",
    ),
    "prolate": Shown(
        "prolate spheroid",
        lambda: Spheroid(1.5),
        "aspect",
        (1.05, 3.0),
        "A solid spheroid of uniform density. Aspect: half length a of the axis over R, the radius "
        "of the equator.",
    ),
    "eccentric": Shown(
        "eccentric sphere",
        lambda: EccentricSphere(0.2),
        "offset",
        (0.02, 0.9),
        "A uniform ball with a point of mass on its surface, a tippe top without its stem. Offset: "
        "distance e of the centre of mass from the centre, over the radius R.",
        ("centre of mass below", "centre of mass above"),
    ),
    "thick": Shown(
        "thick disk",
        lambda: ThickDisk(0.3),
        "thickness",
        (0.05, 1.5),
        "A uniform cylinder that rolls on the rim of its lower face. Thickness: t over the radius "
        "R.",
    ),
    "egg": Shown(
        "egg",
        lambda: Egg(0.2),
        "axial",
        (0.25, 0.6),
        "A solid egg of uniform density, r = sin u (1 + taper cos u), z = −aspect cos u. Axial: "
        "moment of inertia about the axis, over mR², as other distributions of mass have it with "
        "the same centre of mass and the same moment across; the shape is the same in all "
        "diagrams.",
        ("blunt end below", "sharp end below"),
    ),
}
"""The bodies of the atlas by key."""


@dataclass(frozen=True)
class Diagram:
    """A finished diagram, or a sentence in its place."""

    picture: Picture
    """Figure and caption."""
    figure: bool
    """Whether there is a figure: a map that is neutral everywhere has none."""


def kinds(shown: Shown, name: str) -> tuple[str, ...]:
    """The diagrams of a family of a body, by the last word of a `Key`."""
    return ("plane",) if name in PLANES else ("mu", shown.swept, *LAWS)


def names(shown: Shown) -> list[str]:
    """Families of a body, with vertical spin on both ends where these differ."""
    return [*drawn(), *list(POLES)[: max(1, len(shown.ends))], *PLANES]


def absence(shown: Shown, name: str) -> str:
    """A sentence if a body has no such family; empty if it has."""
    body, (family, pole) = shown.make(), family_of(name)
    try:
        body.family(family, LAWS.get(PLANES.get(name, ""), Viscous), pole=pole)
    except NoMemberError as error:
        return f"No {spoken(family)}: {error}"
    if family == "tumbling" and not tumbling_ranges(body):
        return f"No tumbling: at no inclination is the {shown.name} steady."
    return ""


def family_of(name: str) -> tuple[str, Any]:
    """The family of a diagram, and the pole of vertical spin."""
    return ("vertical", POLES[name]) if name in POLES else (name, None)


def spoken(family: str) -> str:
    """A family in a sentence."""
    return "vertical spin" if family == "vertical" else family


def _lean(body: Body, *, ends: bool) -> tuple[float, float]:
    """Inclinations of a body; those beyond upright mirror the others where its ends are equal."""
    low, high = body.between
    return low + CLOSE, (high if ends else min(high, math.pi / 2)) - CLOSE


def _across(shown: Shown, name: str, resolution: int) -> tuple[Any, ...]:
    """The horizontal axis."""
    body, (family, _) = shown.make(), family_of(name)
    if family in PLANES:
        return "theta", *_lean(body, ends=bool(shown.ends)), resolution
    low, high = VERTICAL if family == "vertical" else drawn()[family]
    if family == "tumbling":
        ranges = tumbling_ranges(body)
        high = ranges[-1][1] if shown.ends else min(ranges[-1][1], math.pi / 2)
        low, high = ranges[0][0] + CLOSE, high - CLOSE
    return FAMILIES[family].at[0], low, high, resolution


def _up(shown: Shown, kind: str, rows: int) -> tuple[Any, ...]:
    """The vertical axis."""
    if kind == "plane":
        return "phi_dot", *TURNS, rows
    return ("mu", *FRICTION, rows, "log") if kind == "mu" else (shown.swept, *shown.range, rows)


def draw(key: str, name: str, kind: str, folder: str, resolution: int) -> Diagram:
    """One diagram in a folder: its map as NetCDF, and its figure; `resolution` points across."""
    from ..maps.files import write_map

    shown, (family, pole) = BODIES[key], family_of(name)
    law = PLANES.get(name, kind if kind in LAWS else "viscous")
    contact: Contact | str = LAWS.get(law, "viscous" if kind == "mu" else Viscous(MU))
    x, y = _across(shown, name, resolution), _up(shown, kind, 3 * resolution // 4)
    where = {} if pole is None else {"pole": pole}
    dataset = stability_map(
        family, x=x, y=y, body=shown.make(), contact=contact, workers=1, **where
    )
    target, stem = Path(folder), f"{name}-{key}" if kind == "plane" else f"{name}-{key}-{kind}"
    write_map(dataset, target / f"{stem}.nc", overwrite=True)
    end = shown.ends[list(POLES).index(name)] if name in POLES and shown.ends else ""
    numbers = [end, _told(shown, kind), f"μ = {MU:g}/√(gR)" * (isinstance(contact, Viscous))]
    said = ", ".join(n for n in numbers if n)
    codes = dataset.verdict.values
    if ((codes == CODES[Verdict.NEUTRAL]) | (codes == NO_MEMBER)).all():
        return Diagram(
            Picture(stem, _neutral(shown, family, said, law, dataset, x, y), "", ""), False
        )
    from ..figures.diagram import colour_scale

    title = f"{spoken(family)}: {shown.name}" + (f",\n{end}" if end else "")
    _save(dataset, title, target / stem)
    caption = _diagram_caption(
        spoken(family), shown.name, said, dataset, [], [], colour_scale(dataset), ON[law]
    )
    over = {"mu": "friction", "plane": "inclination and precession rate"}.get(kind, shown.swept)
    what = f"Stability diagram of {spoken(family)} of the {shown.name} {ON[law]}, over {over}"
    return Diagram(Picture(stem, *caption, what), True)


def _save(dataset: Any, title: str, target: Path) -> None:
    from ..figures.canvas import save
    from ..figures.diagram import plot_map

    save(plot_map(dataset, title=title), target)


def _told(shown: Shown, kind: str) -> str:
    """The numbers of a body that no axis shows."""
    body = shown.make()
    numbers = body.constants or {n: v for n, v in body.shape.items() if kind in ("mu", "plane")}
    return ", ".join(f"{n} = {v:g}" for n, v in numbers.items())


def _neutral(
    shown: Shown,
    family: str,
    said: str,
    law: str,
    dataset: Any,
    x: tuple[Any, ...],
    y: tuple[Any, ...],
) -> str:
    """The sentence in place of a map without a boundary and without a colour."""
    missing = int((dataset.verdict == NO_MEMBER).sum())
    blank = f", but for {missing} without a member" * bool(missing)
    of = f" ({said})" * bool(said)
    return (
        f"{spoken(family).capitalize()} of the {shown.name}{of} {ON[law]}: neutral at all "
        f"{x[3]} × {y[3]} points of {x[0]} from {x[1]:.3g} to {x[2]:.3g} and {y[0]} from {y[1]:g} "
        f"to {y[2]:g}{blank}: by proof no eigenvalue has a positive real part, and some lie on the "
        "imaginary axis."
    )


def pages(
    bodies: Mapping[str, Shown],
    diagrams: Mapping[Key, Diagram],
    absent: Mapping[tuple[str, str], str],
    resolution: int,
) -> dict[str, str]:
    """The text of every page by its file name; a sentence for each family that is absent."""
    foot = _foot(f"stability atlas --bodies --resolution {resolution}")
    texts = {"index.html": _index(bodies, diagrams)}
    texts |= {f"{key}.html": _page(key, bodies, diagrams, absent) for key in bodies}
    return {name: "\n".join([*lines, foot]) + "\n" for name, lines in texts.items()}


def _links(bodies: Mapping[str, Shown], here: str = "") -> str:
    index = "" if not here else '<a href="index.html">all bodies</a>'
    others = (
        f'<a href="{k}.html">{s.name}</a>' if k != here else f"<strong>{s.name}</strong> "
        for k, s in bodies.items()
    )
    return f"<nav>{index}{''.join(others)}</nav>"


def _index(bodies: Mapping[str, Shown], diagrams: Mapping[Key, Diagram]) -> list[str]:
    """The page with one picture of each body."""
    lines = [*_head(TITLE), f'<p class="lead">{ABOUT}</p>', _links(bodies), '<div class="row">']
    for key, shown in bodies.items():
        mine = [d for (body, _, _), d in diagrams.items() if body == key]
        drawn = [d.picture for d in mine if d.figure]
        count = f"{len(drawn)} diagrams" if len(drawn) != 1 else "1 diagram"
        picture = (
            f'<img src="{drawn[0].stem}.png" alt="{html.escape(drawn[0].alternative)}" '
            'loading="lazy">'
            if drawn
            else ""
        )
        lines.append(
            f'<figure><a href="{key}.html">{picture}</a><figcaption><a href="{key}.html">'
            f"<strong>{shown.name.capitalize()}</strong></a> ({shown.told}): {count}. "
            f"{html.escape(shown.profile)}</figcaption></figure>"
        )
    return [*lines, "</div>"]


def _page(
    key: str,
    bodies: Mapping[str, Shown],
    diagrams: Mapping[Key, Diagram],
    absent: Mapping[tuple[str, str], str],
) -> list[str]:
    """The page of one body."""
    shown = bodies[key]
    axial, transverse = shown.make().moments()
    lines = [
        *_head(f"Stability atlas: {shown.name}"),
        _links(bodies, key),
        f'<p class="lead">{html.escape(shown.profile)} At {shown.told} the moments of inertia are '
        f"{axial:.4g} (about the axis) and {transverse:.4g} (across it) mR². {ABOUT}</p>",
    ]
    for name in names(shown):
        family, _ = family_of(name)
        end = shown.ends[name.endswith("-pi")] if family == "vertical" and shown.ends else ""
        head = spoken(family).capitalize() + (f", {end}" if end else "")
        lines.append(f'<h2 id="{name}">{head}</h2>')
        if (key, name) in absent:
            lines.append(f"<p>{html.escape(absent[key, name])}</p>")
            continue
        alike = " Both ends are alike." * (name in POLES and not shown.ends)
        motion = FAMILIES[family].motion
        lines.append(f"<p>{motion[0].upper()}{motion[1:]}.{alike}</p>")
        mine = [diagrams[key, name, kind] for kind in kinds(shown, name)]
        drawn = [_figure(d.picture, True) for d in mine if d.figure]
        lines += ['<div class="row pairs">', *drawn, "</div>"] if drawn else []
        lines += [sentence(d.picture) for d in mine if not d.figure]
    return lines


def atlas_of_bodies(
    out: str | os.PathLike[str],
    *,
    resolution: int = RESOLUTION,
    overwrite: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write the atlas of bodies into a folder: figures (PNG, PDF), maps (NetCDF), a page a body.

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
        The page with a link to that of each body, `index.html` in the folder.

    Raises
    ------
    FileError
        If the folder is not empty and `overwrite` is off, or if it cannot be written.
    ParameterError
        If the resolution is below 8 or above `FINEST`.
    """
    resolution = whole_number("resolution", resolution, 8, FINEST)
    check_run(workers, progress, executor)
    target = check_folder(out, empty=not flag("overwrite", overwrite))
    jobs, absent = _jobs()
    keep = _figures(target, resolution)
    counted = Counted(progress, len(jobs))
    with resumable(keep.folder, counted, said="figures are kept in"):
        diagrams = figures(
            jobs,
            lambda job: partial(draw, *job, str(keep.folder), resolution),
            counted,
            workers,
            executor,
            keep,
        )
    for name, text in pages(BODIES, diagrams, absent, resolution).items():
        (keep.folder / name).write_text(text, encoding="utf-8")
    keep.path.unlink()
    move(keep.folder, target)
    shutil.rmtree(keep.folder, ignore_errors=True)
    return target / "index.html"


def _jobs() -> tuple[list[Key], dict[tuple[str, str], str]]:
    """Every diagram, and a sentence for each family that a body does not have."""
    jobs: list[Key] = []
    absent = {}
    for key, shown in BODIES.items():
        for name in names(shown):
            missing = absence(shown, name)
            if missing:
                absent[key, name] = missing
            else:
                jobs += [(key, name, kind) for kind in kinds(shown, name)]
    return jobs, absent


def _figures(target: Path, resolution: int) -> Records[Key, Diagram]:
    """Finished figures in a folder next to the target, until the atlas is complete."""
    folder = target.with_name(f"{target.name}.parts")
    journal = folder / "atlas.jsonl"
    with refusing(folder, "used"):
        if folder.exists() and any(folder.iterdir()) and not is_records(journal):
            raise FileError(f"{path_text(folder)} holds other files; move it aside.")

    def read(record: dict[str, Any]) -> Diagram:
        diagram = Diagram(Picture(**record["picture"]), record["figure"] is True)
        suffixes = ("png", "pdf", "nc") if diagram.figure else ("nc",)
        if not all((folder / f"{diagram.picture.stem}.{s}").is_file() for s in suffixes):
            raise ValueError
        return diagram

    return Records(journal, f"{__version__} {resolution}", read, "-".join)
