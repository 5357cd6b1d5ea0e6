"""Bodies of revolution by their geometry, and moments of inertia by quadrature of the meridian.

Every constructor returns a `ConvexBody` whose surface has the centre of mass as origin.  Lengths,
moments and mass in any consistent unit.  `solid` and `shell` integrate a meridian: independent of
any formula for a moment.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath as mp
from body_surfaces import Arc, Implicit, Profile, Surface
from convex_body import ConvexBody
from jets import cos, half_turns, like, sin, sqrt

HALF = 0.5
"""Parameters of arcs are angles in half turns: exact numbers at the poles."""


def _integral(arcs: Sequence[Arc], i: int, j: int, element: Callable[[Any, Any], Any]) -> Any:
    """Integral of r^i z^j along a meridian, for each element(dr, dz)."""

    def along(arc: Arc) -> Callable[[Any], Any]:
        def integrand(u: Any) -> Any:
            r, z = arc.at(u)
            return r.v**i * z.v**j * element(r.x, z.x)

        return integrand

    return mp.fsum(mp.quad(along(arc), mp.linspace(arc.start, arc.end, 3)) for arc in arcs)


def solid(arcs: Sequence[Arc]) -> tuple[Any, Any, Any]:
    """(I1/m, I3/m, z of the centre) of the uniform solid inside a closed meridian.

    The moments are for the centre.  The meridian runs counterclockwise in (r, z); parts on the
    axis may be left out.  By Green's theorem the integral of r^(i-1) z^j over the inside is that of
    r^i z^j / i dz along the curve.
    """
    return _moments([_integral(arcs, i, j, _rise) / i for i, j in ((2, 0), (2, 1), (2, 2), (4, 0))])


def shell(arcs: Sequence[Arc]) -> tuple[Any, Any, Any]:
    """(I1/m, I3/m, z of the centre) of the surface of a meridian with uniform mass per area."""
    return _moments([_integral(arcs, i, j, mp.hypot) for i, j in ((1, 0), (1, 1), (1, 2), (3, 0))])


def _rise(_: Any, dz: Any) -> Any:
    return dz


def _moments(integrals: Sequence[Any]) -> tuple[Any, Any, Any]:
    mass, first, second, about = integrals
    centre, axial = first / mass, about / mass
    return axial / 2 + second / mass - centre**2, axial, centre


# ------------------------------------------------------------------ meridians


def circle(radius: Any, r: Any = 0, z: Any = 0) -> Arc:
    """Half a circle about (r, z), its side away from the axis."""

    def curve(u: Any) -> tuple[Any, Any]:
        angle = half_turns(u)
        return r + radius * cos(angle), z + radius * sin(angle)

    return Arc(curve, -HALF, HALF)


def dome(radius: Any, angle: Any, rise: Callable[[Any], Any], side: int) -> Arc:
    """A cap of half opening `angle` about the lower (side -1) or upper (side 1) pole.

    rise(u): height of the middle of its sphere.
    """

    def curve(u: Any) -> tuple[Any, Any]:
        turn = like(angle, u) * u
        return -side * radius * sin(turn), rise(u) + side * radius * cos(turn)

    return Arc(curve, 0, 1) if side < 0 else Arc(curve, -1, 0)


def line(start: tuple[Any, Any], end: tuple[Any, Any]) -> Arc:
    """A straight piece."""

    def curve(u: Any) -> tuple[Any, Any]:
        return start[0] + (end[0] - start[0]) * u, start[1] + (end[1] - start[1]) * u

    return Arc(curve, 0, 1)


def ellipse(across: Any, along: Any) -> Arc:
    """Half an ellipse with semi-axes across and along the axis of symmetry."""

    def curve(u: Any) -> tuple[Any, Any]:
        angle = half_turns(u)
        return across * cos(angle), along * sin(angle)

    return Arc(curve, -HALF, HALF)


def polar(radius: Callable[[Any, Any], Any]) -> Arc:
    """A curve by its distance from the origin, radius(cos, sin) of the angle above the equator."""

    def curve(u: Any) -> tuple[Any, Any]:
        c, s = cos(half_turns(u)), sin(half_turns(u))
        rho = radius(c, s)
        return rho * c, rho * s

    return Arc(curve, -HALF, HALF)


# ------------------------------------------------------------------ bodies


def thin_disk(k: Any = 0.25, radius: Any = 1, mass: Any = 1, gravity: Any = 1) -> ConvexBody:
    """The package's disk: a sharp rim, transverse moment k m R^2 and axial moment twice that."""
    inertia = k * mass * radius**2
    rim = (radius, 0 * radius)
    surface = Profile([line(rim, rim)])
    return ConvexBody(
        "disk", {"k": k, "radius": radius}, surface, 2 * inertia, inertia, mass, gravity
    )


def torus(
    rim: Any, tube: Any, axial: Any, transverse: Any, mass: Any = 1, gravity: Any = 1
) -> ConvexBody:
    """A ring whose tube has its centre line at distance `rim` from the axis."""
    surface = Profile([circle(tube, rim)])
    given = {"rim": rim, "tube": tube}
    return ConvexBody("torus", given, surface, axial, transverse, mass, gravity)


def implicit_torus(rim: Any, tube: Any) -> Surface:
    """The same surface as an equation."""
    return Implicit(lambda q, z: (sqrt(q) - rim) ** 2 + z**2 - tube**2, [circle(tube, rim)])


def eccentric_sphere(
    offset: Any, axial: Any, transverse: Any, radius: Any = 1, mass: Any = 1, gravity: Any = 1
) -> ConvexBody:
    """A sphere whose middle lies at height `offset` along the axis from the centre of mass.

    Positive: the centre of mass is below the middle while theta = 0 (the tippe top at rest).
    """
    surface = Implicit(
        lambda q, z: q + (z - offset) ** 2 - radius**2, [circle(radius, 0 * offset, offset)]
    )
    given = {"offset": offset, "radius": radius}
    return ConvexBody("eccentric sphere", given, surface, axial, transverse, mass, gravity)


def spheroid(
    across: Any, along: Any, axial: Any, transverse: Any, mass: Any = 1, gravity: Any = 1
) -> ConvexBody:
    """An ellipsoid of revolution."""
    surface = Implicit(lambda q, z: q / across**2 + z**2 / along**2 - 1, [ellipse(across, along)])
    given = {"across": across, "along": along}
    return ConvexBody("spheroid", given, surface, axial, transverse, mass, gravity)


def thick_disk_arcs(radius: Any, half: Any) -> list[Arc]:
    """The meridian of a cylinder of height twice `half`, closed on the axis."""
    zero = 0 * radius
    corners = [(zero, -half), (radius, -half), (radius, half), (zero, half)]
    return [line(a, b) for a, b in zip(corners, corners[1:], strict=False)]


def thick_disk(
    radius: Any, half: Any, axial: Any, transverse: Any, mass: Any = 1, gravity: Any = 1
) -> ConvexBody:
    """A cylinder that touches with an edge: theta off 0, pi/2, pi."""
    surface = Profile(thick_disk_arcs(radius, half))
    given = {"radius": radius, "half": half}
    return ConvexBody("thick disk", given, surface, axial, transverse, mass, gravity)


def egg_radius(blunt: Any, long: Any) -> Callable[[Any, Any], Any]:
    """Distance from the origin: 1 + blunt s + long s^2 at the sine s of the angle."""
    return lambda _, s: 1 + blunt * s + long * s**2


def egg(
    blunt: Any, long: Any, centre: Any, axial: Any, transverse: Any, mass: Any = 1, gravity: Any = 1
) -> ConvexBody:
    """The curve `egg_radius`, with the centre of mass at height `centre`; convex if mildly bent."""
    arc = polar(egg_radius(blunt, long)).shift(centre)

    def function(q: Any, z: Any) -> Any:
        height = z + centre
        rho = sqrt(q + height**2)
        return rho - 1 - blunt * height / rho - long * (height / rho) ** 2

    given = {"blunt": blunt, "long": long, "centre": centre}
    return ConvexBody("egg", given, Implicit(function, [arc]), axial, transverse, mass, gravity)


def lens_arcs(radius: Any, angle: Any) -> list[Arc]:
    """Two caps of spheres of `radius`, each of half opening `angle`, joined at a sharp edge."""

    def rise(u: Any) -> Any:
        return radius * cos(like(angle, u))

    return [dome(radius, angle, rise, -1), dome(radius, angle, lambda u: -rise(u), 1)]


def lens(
    radius: Any, angle: Any, axial: Any, transverse: Any, mass: Any = 1, gravity: Any = 1
) -> ConvexBody:
    """A lens: it touches with a face while theta < angle or pi - theta < angle, else its edge."""
    surface = Profile(lens_arcs(radius, angle))
    given = {"radius": radius, "angle": angle}
    return ConvexBody("lens", given, surface, axial, transverse, mass, gravity)


def cap_arcs(radius: Any, angle: Any) -> list[Arc]:
    """A cap of a sphere, dome down, closed by a flat disc; the sphere's middle is the origin."""

    def lid(u: Any) -> tuple[Any, Any]:
        rim = like(angle, u)
        return radius * sin(rim) * (1 - u), -radius * cos(rim) + 0 * u

    return [dome(radius, angle, lambda _: 0 * radius, -1), Arc(lid, 0, 1)]


def cap(
    radius: Any,
    angle: Any,
    centre: Any,
    axial: Any,
    transverse: Any,
    mass: Any = 1,
    gravity: Any = 1,
) -> ConvexBody:
    """A spherical cap with centre of mass at height `centre` (negative) from the sphere's middle.

    It touches with its dome while theta < angle, and with its rim up to theta = pi.
    """
    surface = Profile([arc.shift(centre) for arc in cap_arcs(radius, angle)])
    given = {"radius": radius, "angle": angle, "centre": centre}
    return ConvexBody("cap", given, surface, axial, transverse, mass, gravity)


def superellipse(across: Any, along: Any, power: Any) -> Arc:
    """Half of |r/across|^p + |z/along|^p = 1, by an angle."""

    def radius(c: Any, s: Any) -> Any:
        return ((c * c) ** (power / 2) + (s * s) ** (power / 2)) ** (-1 / power)

    unit = polar(radius).curve

    def curve(u: Any) -> tuple[Any, Any]:
        r, z = unit(u)
        return across * r, along * z

    return Arc(curve, -HALF, HALF)


def superellipsoid(
    across: Any,
    along: Any,
    power: Any,
    axial: Any,
    transverse: Any,
    mass: Any = 1,
    gravity: Any = 1,
) -> ConvexBody:
    """|r/across|^p + |z/along|^p = 1; for p > 2 its poles and equator are flat: keep off them."""

    def function(q: Any, z: Any) -> Any:
        return (q / across**2) ** (power / 2) + (z * z / along**2) ** (power / 2) - 1

    surface = Implicit(function, [superellipse(across, along, power)])
    given = {"across": across, "along": along, "power": power}
    return ConvexBody("superellipsoid", given, surface, axial, transverse, mass, gravity)
