"""Closed forms of a thin disk that rolls in a circle without slip, in balls.

Units m = R = g = 1; b is the lean from the vertical, rho the disk's radius over the circle's.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

BITS = 200
"""Working precision of the closed forms."""
SHOWN = 15
"""Significant digits of a known value."""


class Circle(NamedTuple):
    """A steady motion in a circle."""

    spin: arb
    """Spin relative to the turning frame, without sign."""
    precession: arb
    """Angular velocity about the vertical, without sign."""
    nodding: arb
    """Square of the frequency of nutation; negative where the motion is unstable."""


def circle(k: float, lean: arb, ratio: arb) -> Circle:
    """The motion at a lean, in a circle of a given size.

    Parameters
    ----------
    k
        Inertia factor [-].
    lean
        Angle b between the disk and the vertical [rad].
    ratio
        Radius of the disk over that of the contact point's circle [-].

    Returns
    -------
    Circle

    Source: spin and precession, Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005) 27-61,
    eq. (5.10)-(5.12); nutation, from the balance of moments about the contact point, below.

    Examples
    --------
    >>> float(circle(0.25, arb(0), arb(1)).spin)
    0.0
    """
    i, b = arb(k), lean
    square = b.tan() / (ratio * ((1 + 2 * i) - (1 + i) * ratio * b.sin()))
    precession = ratio * square.sqrt()
    return Circle(square.sqrt(), precession, nutation(k, b, precession))


def nutation(k: float, lean: arb, precession: arb) -> arb:
    """Square of the frequency of nutation about steady rolling in a circle.

    With s, c = cos b, sin b and z the square of the precession, the balance of moments
    (k + 1) theta'' = k phi'^2 s c - (2k + 1) phi' omega3 s - c, with
    phi'' = 2 (omega3 - phi' c) theta'/s and (2k + 1) omega3' = s phi' theta', has at a circle
    (k + 1) w^2 = (k + 1) z s^2 - 1/s + 2 c^2 (1 + k z s)(1 + (k + 1) z s) / ((2k + 1) s^2 z).

    Parameters
    ----------
    k, lean, precession
        As in `circle`.

    Examples
    --------
    >>> nutation(0.25, arb(0), (arb(4) / 5).sqrt()).contains(0)  # the threshold of spinning
    True
    """
    i, s, c, z = arb(k), lean.cos(), lean.sin(), precession**2
    across = 2 * c**2 * (1 + i * z * s) * (1 + (i + 1) * z * s) / ((2 * i + 1) * s**2 * z)
    return z * s**2 + (across - 1 / s) / (i + 1)


def edges(k: float, lean: arb) -> tuple[arb, arb]:
    """The precessions between which rolling in a circle is unstable: zeros of the nutation.

    Parameters
    ----------
    k, lean
        As in `circle`.

    Returns
    -------
    tuple of arb
        The lower and the upper one; not finite where every precession is neutral.

    Examples
    --------
    >>> [round(float(edge), 12) for edge in edges(0.25, arb("0.1"))]
    [0.117770189136, 0.882831191459]
    """
    i, s, c = arb(k), lean.cos(), lean.sin()
    two = (i + 1) * s**2 * ((2 * i + 1) * s**2 + 2 * i * c**2)
    one, zero = (2 * i + 1) * s * (2 * c**2 - 1), 2 * c**2
    root = (one**2 - 4 * two * zero).sqrt()
    lower, upper = (-one - root) / (2 * two), (-one + root) / (2 * two)
    return lower.sqrt(), upper.sqrt()


def digits(value: arb) -> str:
    """A ball as a decimal with `SHOWN` digits, all of them right.

    Parameters
    ----------
    value
        A ball with a small radius.

    Examples
    --------
    >>> digits(arb("0.25"))
    '0.250000000000000'
    """
    return str(value.str(SHOWN, radius=False))


def degrees(angle: float) -> arb:
    """An angle in degrees as a ball in radians.

    Parameters
    ----------
    angle
        The angle [°].

    Examples
    --------
    >>> round(float(degrees(180)), 9)
    3.141592654
    """
    return arb(angle) * arb.pi() / 180
