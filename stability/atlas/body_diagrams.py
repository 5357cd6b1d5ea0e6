"""Diagrams of bodies of revolution: the bodies, what is drawn of each, and one diagram."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base.errors import NoMemberError
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..bodies.contact import Contact
from ..bodies.contact_laws import Rough, Smooth, Viscous
from ..bodies.families import FAMILIES
from ..bodies.round_body.body import Body
from ..bodies.round_body.inclinations import tumbling_ranges
from ..bodies.round_body.shapes.named import EccentricSphere, Spheroid, ThickDisk, Torus
from ..bodies.round_body.shapes.profile import Egg
from ..maps.stability_map import stability_map
from .page import FRICTION, Picture, _diagram_caption, drawn

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
Key = tuple[str, str, str]
"""A diagram: key of the body, family (and pole), and `mu`, `own`, `rough`, `smooth` or `plane`."""


@dataclass(frozen=True)
class Shown:
    """A body of the atlas."""

    name: str
    """Name in captions."""
    make: Callable[[], Body]
    """The body of the diagrams at one shape."""
    own: str
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
        "A solid ring of uniform "
        "density. Tube: radius b of the tube over R, the radius of the circle of its "
        "centres.",
    ),
    "oblate": Shown(
        "oblate spheroid",
        lambda: Spheroid(0.5),
        "aspect",
        (0.05, 0.95),
        "A solid "
        "spheroid of uniform density. Aspect: half length a of the axis over R, the "
        "radius of the equator.",
    ),
    "prolate": Shown(
        "prolate spheroid",
        lambda: Spheroid(1.5),
        "aspect",
        (1.05, 3.0),
        "A solid "
        "spheroid of uniform density. Aspect: half length a of the axis over R, the "
        "radius of the equator.",
    ),
    "eccentric": Shown(
        "eccentric sphere",
        lambda: EccentricSphere(0.2),
        "offset",
        (0.02, 0.9),
        "A uniform ball with a point of mass on its surface, a tippe top without "
        "its stem. Offset: distance e of the centre of mass from the centre, over "
        "the radius R.",
        ("centre of mass below", "centre of mass above"),
    ),
    "thick": Shown(
        "thick disk",
        lambda: ThickDisk(0.3),
        "thickness",
        (0.05, 1.5),
        "A uniform "
        "cylinder that rolls on the rim of its lower face. Thickness: t over the radius "
        "R.",
    ),
    "egg": Shown(
        "egg",
        lambda: Egg(0.2),
        "axial",
        (0.25, 0.6),
        "A solid egg of uniform density, "
        "r = sin u (1 + taper cos u), z = −aspect cos u. Axial: moment of inertia about "
        "the axis, over mR², as other distributions of mass have it with the same centre "
        "of mass and the same moment across; the shape is the same in all diagrams.",
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
    """The diagrams of a family of a body.

    Parameters
    ----------
    shown
        The body.
    name
        Name of the family, with the pole of vertical spin.
    """
    return ("plane",) if name in PLANES else ("mu", shown.own, *LAWS)


def names(shown: Shown) -> list[str]:
    """Families of a body, with vertical spin on both ends where these differ.

    Parameters
    ----------
    shown
        The body.
    """
    return [*drawn(), *list(POLES)[: max(1, len(shown.ends))], *PLANES]


def absence(shown: Shown, name: str) -> str:
    """A sentence if a body has no such family; empty if it has.

    Parameters
    ----------
    shown, name
        As for `kinds`.
    """
    body, (family, pole) = shown.make(), family_of(name)
    try:
        body.family(family, LAWS.get(PLANES.get(name, ""), Viscous), pole=pole)
    except NoMemberError as error:
        return f"No {spoken(family)}: {error}"
    if family == "tumbling" and not tumbling_ranges(body):
        return f"No tumbling: at no inclination is the {shown.name} steady."
    return ""


def family_of(name: str) -> tuple[str, Any]:
    """The family of a diagram, and the pole of vertical spin.

    Parameters
    ----------
    name
        As for `kinds`.
    """
    return ("vertical", POLES[name]) if name in POLES else (name, None)


def spoken(family: str) -> str:
    """A family in a sentence.

    Parameters
    ----------
    family
        Its name.
    """
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
    return ("mu", *FRICTION, rows, "log") if kind == "mu" else (shown.own, *shown.range, rows)


def draw(key: str, name: str, kind: str, folder: str, resolution: int) -> Diagram:
    """One diagram: its map as NetCDF, and its figure.

    Parameters
    ----------
    key, name, kind
        The diagram, a `Key`.
    folder
        Where its files go.
    resolution
        Points along the horizontal axis.
    """
    from ..maps.netcdf import write_map

    shown, (family, pole) = BODIES[key], family_of(name)
    law = PLANES.get(name, kind if kind in LAWS else "viscous")
    contact: Contact | str = LAWS.get(law, "viscous" if kind == "mu" else Viscous(MU))
    x, y = _across(shown, name, resolution), _up(shown, kind, 3 * resolution // 4)
    given = {} if pole is None else {"pole": pole}
    dataset = stability_map(
        family, x=x, y=y, body=shown.make(), contact=contact, workers=1, **given
    )
    target, stem = Path(folder), f"{name}-{key}" if kind == "plane" else f"{name}-{key}-{kind}"
    write_map(dataset, target / f"{stem}.nc", overwrite=True)
    end = shown.ends[list(POLES).index(name)] if name in POLES and shown.ends else ""
    numbers = [end, _told(shown, kind), f"μ = {MU:g}/√(gR)" * (isinstance(contact, Viscous))]
    said = ", ".join(n for n in numbers if n)
    codes = dataset.verdict.values
    if ((codes == CODES[Verdict.NEUTRAL]) | (codes == NO_MEMBER)).all():
        return Diagram(Picture(stem, _neutral(shown, family, said, law, dataset, x, y), ""), False)
    title = f"{spoken(family)}: {shown.name}" + (f",\n{end}" if end else "")
    _save(dataset, title, target / stem)
    caption = _diagram_caption(spoken(family), shown.name, said, dataset, [], [], ON[law])
    over = {"mu": "friction", "plane": "inclination and precession rate"}.get(kind, shown.own)
    what = f"Stability diagram of {spoken(family)} of the {shown.name} {ON[law]}, over {over}"
    return Diagram(Picture(stem, caption, what), True)


def _save(dataset: Any, title: str, target: Path) -> None:
    from ..figures.canvas import save
    from ..figures.diagram import plot_map

    save(plot_map(dataset, title=title), target)


def _told(shown: Shown, kind: str) -> str:
    """The numbers of a body that no axis shows."""
    body = shown.make()
    own = body.constants or {n: v for n, v in body.shape.items() if kind in ("mu", "plane")}
    return ", ".join(f"{n} = {v:g}" for n, v in own.items())


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
