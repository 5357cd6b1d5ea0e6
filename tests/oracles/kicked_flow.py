"""A flow whose border between two falls is the graph of Weierstrass' function."""

from typing import Any

import casadi as ca
import numpy as np

import stability as st

WIDE, HIGH, KICKS, WIDTH = 3, 1.5, 12, 0.08
"""Ratio of the kicks' frequencies over x, growth of y in a unit of time, kicks, and their width."""
EDGE = 12.0
"""Depth below which no kick brings y back: ln(HIGH) times it is more than the strongest push."""
DIMENSION = 2 - np.log(HIGH) / np.log(WIDE)
"""Of the graph of Σ HIGH⁻ⁿ cos(2π WIDEⁿ x) (Shen, Math. Z. 289, 2018, proves Hausdorff's; that of
boxes is older)."""


def kicked() -> Any:
    """An upside-down pendulum of one state y, kicked by cos(2π WIDEⁿ x) near the time n + 1/2.

    y grows by HIGH in a unit of time, so it falls on the side of y(0) + ∫ HIGH⁻ᵗ (kicks) dt: the
    border of the two falls is the graph of Weierstrass' function.
    """
    s = ca.SX.sym("s", 3)
    x, y, clock = s[0], s[1], s[2]
    push = sum(
        ca.exp(-((clock - n - 0.5) ** 2) / (2 * WIDTH**2)) * ca.cos(2 * np.pi * WIDE**n * x)
        for n in range(KICKS)
    )
    size = ca.SX.sym("size")
    return st.System(
        "kicked",
        s,
        size,
        ca.vertcat(0, np.log(HIGH) * y + size * push, 1),
        states=("x", "y", "clock"),
        parameters=("size",),
        conditions=(st.Condition(y + EDGE, "y + 12 = {value:.3g} is not positive"),),
    )


def side(points: np.ndarray) -> np.ndarray:
    """y(0) less the border, by the sum alone."""
    b, first = np.log(HIGH), 4.0 * WIDTH * np.sqrt(2 * np.pi)
    first *= np.exp(-b / 2 + b**2 * WIDTH**2 / 2)  # of a Gaussian kick, in closed form
    waves = [HIGH**-n * np.cos(2 * np.pi * WIDE**n * points[:, 0]) for n in range(KICKS)]
    return np.asarray(points[:, 1] + first * np.sum(waves, axis=0))
