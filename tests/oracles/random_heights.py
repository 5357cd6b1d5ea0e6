"""Bodies of revolution by random heights: polynomials, roots, exponentials and quotients.

A height is a function of the upward unit vector in axes of the body: the lowest point is minus its
gradient, once it is continued with degree 1.  So the surface needs no inclination, and is regular
at a pole where the height is.  One formula serves the package (CasADi) and this oracle (jets).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import mpmath as mp
import numpy as np
from convex_body import ConvexBody
from jets import Array, Jet, like, sqrt

Height = Callable[..., Any]
"""From cosine and sine of the inclination, functions by name, and numbers by name to a height."""


def exponential(value: Any) -> Any:
    """Exponential of a float, an mpmath number or a jet."""
    if isinstance(value, Jet):
        found = exponential(value.v)
        return value.through(found, found, found)
    return mp.exp(value) if isinstance(value, mp.mpf) else math.exp(value)


def _polynomial(c: Any, s: Any, _: Any, a: Any, b: Any, d: Any, edge: Any) -> Any:
    return 1 + a * c + b * c * c + d * c * c * c + s * edge


def _root(c: Any, s: Any, f: Any, a: Any, b: Any, d: Any, edge: Any) -> Any:
    return f["sqrt"](1 + b * c * c * 2) * (1 + d * c * c) + a * c + s * edge


def _power(c: Any, s: Any, f: Any, a: Any, b: Any, d: Any, edge: Any) -> Any:
    return f["sqrt"](f["sqrt"](2 + a * c + c * c * b) + d * c * c + 1) + s * edge


def _exponential(c: Any, s: Any, f: Any, a: Any, b: Any, d: Any, edge: Any) -> Any:
    return f["exp"](a * c + b * c * c) + d * c * c + s * edge


def _quotient(c: Any, s: Any, _: Any, a: Any, b: Any, d: Any, edge: Any) -> Any:
    return 1 / (1 + a * c + b * c * c) + d * c * c + s * edge


HEIGHTS: Mapping[str, Height] = {
    "polynomial": _polynomial,
    "root": _root,
    "power": _power,
    "exponential": _exponential,
    "quotient": _quotient,
}
JETS = {"sqrt": sqrt, "exp": exponential}


@dataclass(frozen=True)
class Support:
    """The surface of a height."""

    height: Height
    numbers: Mapping[str, float]

    def contact(self, up: Array) -> tuple[Array, Array]:
        """Lowest point and its derivatives: minus gradient and Hessian of the height."""
        gradient, hessian = 0 * up, np.zeros((3, 3), dtype=up.dtype) + 0 * up[0]
        for i, j in combinations(range(3), 2):
            u = [Jet(v) for v in up]
            u[i], u[j] = Jet(up[i], 1, 0), Jet(up[j], 0, 1)
            seen = self._continued(u)
            gradient[i], gradient[j] = seen.x, seen.y
            hessian[i, i], hessian[j, j] = seen.xx, seen.yy
            hessian[i, j] = hessian[j, i] = seen.xy
        return -gradient, -hessian

    def _continued(self, u: list[Jet]) -> Jet:
        square = u[0] * u[0] + u[1] * u[1]
        size = sqrt(square + u[2] * u[2])
        numbers = {n: like(v, u[0]) for n, v in self.numbers.items()}
        sine = sqrt(square) / size if self.numbers["edge"] else Jet(0 * u[0].v)
        return self.height(u[2] / size, sine, JETS, **numbers) * size


@dataclass(frozen=True)
class HeightBody:
    """A body by its height, in the oracle's terms, with what a twin by the package needs."""

    kind: str
    numbers: Mapping[str, float]
    """Numbers of the height; `edge` is 0 where it is smooth at the poles."""
    body: ConvexBody

    @property
    def even(self) -> bool:
        """Whether upper and lower half are alike."""
        return not self.numbers["a"] and (self.kind != "polynomial" or not self.numbers["d"])

    def at(self, theta: float) -> tuple[float, float, float]:
        """h, h' and h'' at an inclination."""
        angle = Jet(theta, 1)
        c = angle.through(math.cos(theta), -math.sin(theta), -math.cos(theta))
        s = angle.through(math.sin(theta), math.cos(theta), -math.sin(theta))
        found = HEIGHTS[self.kind](c, s, JETS, **self.numbers)
        return found.v, found.x, found.xx


def random_height(rng: np.random.Generator, kinds: Sequence[str]) -> HeightBody:
    """A convex body well above the plane, with random moments; m = g = 1."""
    while True:
        kind = str(rng.choice(list(kinds)))
        a, b, d = rng.uniform(-0.35, 0.35, 3)
        odd = rng.random() < 0.6
        edge = float(rng.uniform(0.05, 1.0)) if rng.random() < 0.35 else 0.0
        numbers = {
            "a": a if odd else 0.0,
            "b": b,
            "d": d if odd or kind != "polynomial" else 0.0,
            "edge": edge,
        }
        numbers = {n: round(float(v), int(rng.integers(1, 4))) for n, v in numbers.items()}
        transverse = round(float(rng.uniform(0.15, 0.9)), 3)
        axial = round(float(transverse * rng.uniform(0.3, 1.9)), 3)
        body = ConvexBody(kind, numbers, Support(HEIGHTS[kind], numbers), axial, transverse)
        found = HeightBody(kind, numbers, body)
        shape = np.array([found.at(t) for t in np.linspace(1e-3, math.pi - 1e-3, 301)])
        if shape[:, 0].min() > 0.2 and (shape[:, 0] + shape[:, 2]).min() > 0.02:
            return found
