"""Ten oscillating systems, written for CasADi and SymPy, with numbers by mpmath and SciPy.

Nothing here comes from the package but the family itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import scipy.optimize
import sympy as sp

import stability as st

Rates = Callable[[Any, Any, Any], list[Any]]
DIGITS = 40


def _gates(f: Any, v: Any) -> list[Any]:
    """Rates of opening and closing of Hodgkin and Huxley's three gates, depolarisation positive."""
    return [
        (25 - v) / (10 * (f.exp((25 - v) / 10) - 1)),
        4 * f.exp(-v / 18),
        7 * f.exp(-v / 20) / 100,
        1 / (f.exp((30 - v) / 10) + 1),
        (10 - v) / (100 * (f.exp((10 - v) / 10) - 1)),
        f.exp(-v / 80) / 8,
    ]


def _nerve(f: Any, x: Any, p: Any) -> list[Any]:
    v, m, h, n = x
    am, bm, ah, bh, an, bn = _gates(f, v)
    ionic = 120 * m**3 * h * (v - 115) + 36 * n**4 * (v + 12) + p[1] * (v - p[2])
    return [p[0] - ionic, am * (1 - m) - bm * m, ah * (1 - h) - bh * h, an * (1 - n) - bn * n]


@dataclass(frozen=True, eq=False)
class Known:
    """A system, a first member, and an axis with a flutter boundary on it."""

    name: str
    rates: Rates
    states: dict[str, float]
    """Names with a first guess."""
    parameters: dict[str, float]
    """Names with their values; the axis is the first."""
    axis: tuple[float, float]
    other: tuple[float, float]
    """Range of the second parameter on a map."""

    @cached_property
    def family(self) -> st.Family:
        """The family of steady motions, for the package."""
        x, p = ca.SX.sym("x", len(self.states)), ca.SX.sym("p", len(self.parameters))
        rates = self.rates(ca, ca.vertsplit(x), ca.vertsplit(p))
        system = st.System(
            self.name,
            x,
            p,
            ca.vertcat(*rates),
            states=tuple(self.states),
            parameters=tuple(self.parameters),
        )
        return system.steady(next(iter(self.parameters)), guess=self.states | self.parameters)

    @property
    def fixed(self) -> dict[str, float]:
        """Values of all parameters but the axis."""
        return dict(list(self.parameters.items())[1:])

    # --- by SymPy and mpmath ---

    @cached_property
    def _symbols(self) -> tuple[list[Any], list[Any], sp.Matrix]:
        x = list(sp.symbols(f"x:{len(self.states)}"))
        p = list(sp.symbols(f"p:{len(self.parameters)}"))
        return x, p, sp.Matrix(self.rates(sp, x, p))

    @cached_property
    def _numeric(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        x, p, rates = self._symbols
        return tuple(sp.lambdify([x, p], e, "numpy") for e in (rates, rates.jacobian(x)))  # type: ignore[return-value]

    def flow(self, x: Any, p: Any) -> Any:
        """Rates in doubles."""
        return np.asarray(self._numeric[0](x, p), dtype=float).ravel()

    def slope(self, x: Any, p: Any) -> Any:
        """Linearisation in doubles."""
        return np.asarray(self._numeric[1](x, p), dtype=float)

    def followed(self, p: list[float]) -> Any | None:
        """The steady motion at the end of a straight line from the first one; None at a fold."""
        start, x = list(self.parameters.values()), np.array(list(self.states.values()))
        x = scipy.optimize.root(self.flow, x, args=(start,), jac=self.slope, tol=1e-13).x
        share, step = 0.0, 1 / 32
        while share < 1 and step > 1e-6:
            then = min(share + step, 1.0)
            here = [a + then * (b - a) for a, b in zip(start, p, strict=True)]
            found = scipy.optimize.root(self.flow, x, args=(here,), jac=self.slope, tol=1e-13)
            near = np.abs(found.x - x).max() <= 0.1 * (1 + np.abs(x).max())
            if near and np.abs(self.flow(found.x, here)).max() <= 1e-9:
                share, x, step = then, found.x, 1.5 * step
            else:
                step /= 2
        return x if share == 1 else None

    def crossing(self, near: float) -> tuple[Any, Any, Any]:
        """Axis, frequency and first Lyapunov coefficient at the flutter boundary near a value.

        Kuznetsov, Elements of Applied Bifurcation Theory (3rd ed.), (5.39): ⟨p, q⟩ = ⟨q, q⟩ = 1.
        """
        x, p, rates = self._symbols
        with mp.workdps(DIGITS):
            place = [mp.mpf(v) for v in self.parameters.values()]
            fast = sp.lambdify([x, p], rates, "mpmath")
            slope = sp.lambdify([x, p], rates.jacobian(x), "mpmath")
            start = self.followed([near, *list(self.parameters.values())[1:]])
            assert start is not None

            def eigen(u: Any, at: Any) -> Any:
                values = mp.eig(slope(list(u), [at, *place[1:]]), left=False, right=False)
                return min((v for v in values if mp.im(v) > 0), key=lambda v: abs(mp.re(v)))

            def equations(*u: Any) -> list[Any]:
                rest = fast(list(u[:-1]), [u[-1], *place[1:]])
                return [*rest, mp.re(eigen(u[:-1], u[-1]))]

            found = mp.findroot(equations, [*map(mp.mpf, start.tolist()), mp.mpf(near)], tol=1e-55)
            state, at = list(found)[:-1], list(found)[-1]
            here = [at, *place[1:]]
            w = mp.im(eigen(state, at))
            return at, w, self._first(state, here, slope(state, here), w)

    def _first(self, state: list[Any], p: list[Any], a: Any, w: Any) -> Any:
        x, symbols, rates = self._symbols
        n = len(x)
        values = [*state, *p]

        def number(e: Any) -> Any:
            return sp.lambdify([*x, *symbols], e, "mpmath")(*values)

        two, three = (
            {
                key: number(sp.diff(rates[key[0]], *[x[j] for j in key[1:]]))
                for key in product(range(n), repeat=order + 1)
            }
            for order in (2, 3)
        )

        def b(u: Any, v: Any) -> Any:
            out = mp.zeros(n, 1)
            for (i, j, k), d in two.items():
                out[i] += d * u[j] * v[k]
            return out

        def c(u: Any, v: Any, t: Any) -> Any:
            out = mp.zeros(n, 1)
            for (i, j, k, m), d in three.items():
                out[i] += d * u[j] * v[k] * t[m]
            return out

        def null(matrix: Any) -> Any:
            """A null vector: one step of inverse iteration from a vector with no zero."""
            some = mp.matrix([1 + mp.mpf(i) / 7 for i in range(n)])
            v = some
            for _ in range(3):
                v = mp.lu_solve(matrix + mp.eye(n) * mp.mpf(10) ** (-DIGITS // 2), v)
                v = v / mp.norm(v)
            return v

        one = mp.mpc(0, 1)
        q = null(a - one * w * mp.eye(n))
        bar = q.apply(mp.conj)
        p_ = null(a.T + one * w * mp.eye(n))
        scale = mp.fsum(mp.conj(p_[i]) * q[i] for i in range(n))
        p_ = p_ / mp.conj(scale)

        def dot(u: Any, v: Any) -> Any:
            return mp.fsum(mp.conj(u[i]) * v[i] for i in range(n))

        mean = mp.lu_solve(a, b(q, bar))
        double = mp.lu_solve(2 * one * w * mp.eye(n) - a, b(q, q))
        total = dot(p_, c(q, q, bar)) - 2 * dot(p_, b(q, mean)) + dot(p_, b(bar, double))
        return mp.re(total) / (2 * w)


KNOWN = [
    Known(
        "Brusselator",
        lambda _, x, p: [
            p[1] - (p[0] + 1) * x[0] + x[0] ** 2 * x[1],
            p[0] * x[0] - x[0] ** 2 * x[1],
        ],
        {"x": 1.5, "y": 1.4},
        {"B": 2.1, "A": 1.5},
        (0.5, 8.0),
        (0.6, 2.0),
    ),
    Known(
        "stirred tank",
        lambda f, x, p: [
            -x[0] + p[0] * (1 - x[0]) * f.exp(x[1]),
            -x[1] + p[1] * p[0] * (1 - x[0]) * f.exp(x[1]) - 3 * x[1],
        ],
        {"x": 0.1, "T": 0.1},
        {"D": 0.02, "B": 14.0},
        (0.02, 1.0),
        (10.0, 15.0),
    ),
    Known(
        "FitzHugh-Nagumo",
        lambda _, x, p: [x[0] - x[0] ** 3 / 3 - x[1] + p[0], (x[0] + p[1] - p[2] * x[1]) * p[3]],
        {"v": -1.2, "w": -0.6},
        {"I": 0.0, "a": 0.7, "b": 0.8, "e": 0.08},
        (0.0, 2.0),
        (0.4, 0.9),
    ),
    Known(
        "Goodwin",
        lambda _, x, p: [
            1 / (1 + x[2] ** p[0]) - p[1] * x[0],
            x[0] - p[1] * x[1],
            x[1] - p[1] * x[2],
        ],
        {"x": 0.3, "y": 0.6, "z": 0.9},
        {"n": 6.0, "b": 0.5},
        (2.0, 20.0),
        (0.3, 0.7),
    ),
    Known(
        "prey and predator",
        lambda _, x, p: [
            x[0] * (1 - x[0] / p[0]) - x[0] * x[1] / (1 + x[0]),
            x[0] * x[1] / (1 + x[0]) - p[1] * x[1],
        ],
        {"x": 0.6, "y": 0.8},
        {"K": 2.0, "d": 0.375},
        (0.7, 5.0),
        (0.2, 0.4),
    ),
    Known(
        "nerve",
        _nerve,
        {"V": 0.01, "m": 0.05, "h": 0.6, "n": 0.32},
        {"I": 0.0, "g": 0.3, "E": 10.6},
        (5.0, 15.0),
        (0.25, 0.35),
    ),
    Known(
        "Bogdanov-Takens",
        lambda _, x, p: [x[1], p[0] + p[1] * x[0] + x[0] ** 2 - x[0] * x[1]],
        {"x": -1.0, "y": 0.0},
        {"b1": -2.0, "b2": -1.0},
        (-3.0, 0.2),
        (-1.5, -0.5),
    ),
    Known(
        "Lorenz",
        lambda _, x, p: [
            p[1] * (x[1] - x[0]),
            x[0] * (p[0] - x[2]) - x[1],
            x[0] * x[1] - p[2] * x[2],
        ],
        {"x": 6.0, "y": 6.0, "z": 14.0},
        {"r": 15.0, "s": 10.0, "b": 8 / 3},
        (10.0, 40.0),
        (8.0, 14.0),
    ),
    Known(
        "glycolysis",
        lambda _, x, p: [
            -x[0] + p[1] * x[1] + x[0] ** 2 * x[1],
            p[0] - p[1] * x[1] - x[0] ** 2 * x[1],
        ],
        {"x": 1.0, "y": 0.9},
        {"b": 1.0, "a": 0.08},
        (0.6, 1.2),
        (0.05, 0.1),
    ),
    Known(
        "governor",
        lambda f, x, p: [
            x[1],
            x[2] ** 2 * f.sin(x[0]) * f.cos(x[0]) - f.sin(x[0]) - p[0] * x[1],
            p[1] * (f.cos(x[0]) - p[2]),
        ],
        {"q": 0.7, "v": 0.0, "w": 1.1},
        {"e": 2.0, "a": 0.8, "c": 0.75},
        (0.3, 2.0),
        (0.4, 1.2),
    ),
]
"""The systems."""
