"""A body with three inclinations of rolling, two of them close; its zeros by SciPy, by hand."""

import casadi as ca
import numpy as np
from scipy.optimize import brentq

import stability as st

EDGE = 1e-4
"""Square of the width of the edge, over which the height bends sharply next to π/2."""


def edged(edge: float = EDGE) -> st.Body:
    """Three inclinations, two of them close; Newton's method goes from one to the other."""
    return st.Body(
        lambda t, bend: ca.sin(t) + bend * ca.sqrt(ca.cos(t) ** 2 + edge) - 0.05 * ca.cos(t),
        axial=0.5,
        transverse=0.3,
        shape={"bend": 0.25},
        name="edged",
    )


def slope(theta: float, bend: float, edge: float = EDGE) -> float:
    """The slope of its height, by hand."""
    s, c = np.sin(theta), np.cos(theta)
    return float(c - bend * c * s / np.sqrt(c * c + edge) + 0.05 * s)


def curvature(theta: float, bend: float, edge: float = EDGE) -> float:
    """The second derivative of its height, by central differences."""
    return (slope(theta + 1e-6, bend, edge) - slope(theta - 1e-6, bend, edge)) / 2e-6


def zeros(bend: float, edge: float = EDGE) -> list[float]:
    """All zeros of the slope, on a fine grid."""
    grid = np.linspace(1.0, 2.4, 14001)
    values = [slope(t, bend, edge) for t in grid]
    return [
        brentq(slope, a, b, (bend, edge), xtol=1e-15)
        for a, b, f, g in zip(grid, grid[1:], values, values[1:], strict=False)
        if f * g < 0
    ]
