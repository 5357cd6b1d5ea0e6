"""Named bodies of revolution, each with its moments of inertia derived from its shape.

Source: moments by elementary integrals; tests/bodies/test_named_bodies.py integrates the bodies
numerically, from their surfaces.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import casadi as ca
from numpy.typing import ArrayLike

from ....base.checks import flag, known
from ....base.errors import ParameterError
from ..body import Body
from ..shape import MOMENTS, SCALES
from .profile import Egg


def Torus(tube: ArrayLike, *, solid: bool = True, **scales: Any) -> Body:  # noqa: N802
    """A ring with a round cross-section: a bicycle tyre, a coin with a rounded rim without a face.

    Parameters
    ----------
    tube
        Radius of the tube over that of the circle of its centres, which is `length`; in (0, 1] [-].
    solid
        Whether the tube is filled with uniform density; otherwise its surface alone has mass.
    **scales
        `mass`, `gravity`, `length`, as for `Body`.

    Returns
    -------
    Body
        The ring as a body of revolution.

    Raises
    ------
    ParameterError
        If a number is outside its range, or a keyword is unknown.

    Source: docs/explanation/bodies.md; quadratures of the solid: tests/bodies/test_named_bodies.py.

    Examples
    --------
    >>> import stability as st
    >>> tyre = st.Torus(0.1, solid=False)
    >>> [round(float(m), 4) for m in tyre.moments()]
    [1.015, 0.5125]
    """
    share = 1 if flag("solid", solid) else 2
    return Body(
        lambda theta, tube: ca.sin(theta) + tube,
        axial=lambda tube: 1 + 3 * share * tube**2 / 4,
        transverse=lambda tube: (4 + 5 * share * tube**2) / 8,
        shape={"tube": tube},
        limits={"tube": (0.0, 1.0)},
        name="torus" if share == 1 else "hollow torus",
        **_scales(scales),
    )


def Spheroid(aspect: ArrayLike, **scales: Any) -> Body:  # noqa: N802
    """A solid ellipsoid of revolution of uniform density.

    Parameters
    ----------
    aspect
        Half length along the axis over the radius of the equator, which is `length` [-].
    **scales
        `mass`, `gravity`, `length`, as for `Body`.

    Returns
    -------
    Body
        The ellipsoid as a body of revolution.

    Raises
    ------
    ParameterError
        If a number is outside its range, or a keyword is unknown.

    Source: docs/explanation/bodies.md; quadratures of the solid: tests/bodies/test_named_bodies.py.

    Examples
    --------
    >>> import stability as st
    >>> st.Spheroid(1.0).moments()
    (0.4, 0.4)
    """
    # the double 1/5 in both, since CasADi makes a double of 2/5: a ball has two equal moments
    return Body(
        lambda theta, aspect: ca.sqrt(ca.sin(theta) ** 2 + (aspect * ca.cos(theta)) ** 2),
        axial=lambda aspect: 2 * ca.SX(1 / 5) + 0 * aspect,
        transverse=lambda aspect: (1 + aspect**2) * (1 / 5),
        shape={"aspect": aspect},
        limits={"aspect": (0.0, math.inf)},
        name="spheroid",
        **_scales(scales),
    )


def EccentricSphere(  # noqa: N802
    offset: ArrayLike,
    *,
    axial: ArrayLike | None = None,
    transverse: ArrayLike | None = None,
    **scales: Any,
) -> Body:
    """A ball whose centre of mass lies off its centre: a tippe top without its stem.

    At θ = 0 the centre of mass is at its lowest.

    Parameters
    ----------
    offset
        Distance of the centre of mass from the centre, over the radius, which is `length`; in
        (0, 1) [-].
    axial, transverse
        Moments of inertia about the centre of mass, over mass times radius² [-]; both or none.
        Without them the ball is uniform with a point of mass on its surface, as heavy as the offset
        asks.
    **scales
        `mass`, `gravity`, `length`, as for `Body`.

    Returns
    -------
    Body
        The ball as a body of revolution.

    Raises
    ------
    ParameterError
        If a number is outside its range, or a keyword is unknown.

    Source: docs/explanation/bodies.md; quadratures of the solid: tests/bodies/test_named_bodies.py.

    Examples
    --------
    >>> import stability as st
    >>> top = st.EccentricSphere(0.1)
    >>> [round(float(m), 4) for m in top.moments()]
    [0.36, 0.45]
    """
    stated = [m for m in (axial, transverse) if m is not None]
    if len(stated) == 1:
        raise ParameterError("of axial and transverse one is given; give both or none.")
    moments: dict[str, Any] = {"axial": axial, "transverse": transverse}
    if not stated:
        moments = {
            "axial": lambda offset: 2 * (1 - offset) / 5,
            "transverse": lambda offset: (1 - offset) * (2 + 5 * offset) / 5,
        }
    return Body(
        lambda theta, offset: 1 - offset * ca.cos(theta),
        shape={"offset": offset},
        limits={"offset": (0.0, 1.0)},
        name="eccentric sphere",
        **moments,
        **_scales(scales),
    )


def ThickDisk(thickness: ArrayLike, **scales: Any) -> Body:  # noqa: N802
    """A solid cylinder of uniform density that rolls on the rim of its lower face.

    The height holds for θ below π/2, where the lower rim is the one that the axis points away from.
    Upright, the cylinder stands on a line, and no rim is lower.

    Parameters
    ----------
    thickness
        Thickness over the radius, which is `length` [-].
    **scales
        `mass`, `gravity`, `length`, as for `Body`.

    Returns
    -------
    Body
        The cylinder as a body of revolution.

    Raises
    ------
    ParameterError
        If a number is outside its range, or a keyword is unknown.

    Source: docs/explanation/bodies.md; quadratures of the solid: tests/bodies/test_named_bodies.py.

    Examples
    --------
    >>> import stability as st
    >>> coin = st.ThickDisk(0.1)
    >>> [round(float(m), 6) for m in coin.moments()]
    [0.5, 0.250833]
    """
    return Body(
        lambda theta, thickness: ca.sin(theta) + thickness * ca.cos(theta) / 2,
        axial=lambda thickness: ca.SX(1) / 2 + 0 * thickness,
        transverse=lambda thickness: (3 + thickness**2) / 12,
        shape={"thickness": thickness},
        limits={"thickness": (0.0, math.inf)},
        name="thick disk",
        between=(0.0, math.pi / 2),
        **_scales(scales),
    )


def _scales(scales: dict[str, Any]) -> dict[str, Any]:
    for name in scales:
        if name in MOMENTS:
            raise ParameterError(f"{name} is given, but the body has its own; leave it out.")
        known("keyword", name, SCALES)
    return scales


NAMED: dict[str, Callable[..., Body]] = {
    "torus": Torus,
    "spheroid": Spheroid,
    "eccentric-sphere": EccentricSphere,
    "thick-disk": ThickDisk,
    "egg": Egg,
}
"""Named bodies, for the command line."""
