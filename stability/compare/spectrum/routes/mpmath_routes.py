"""Routes with many digits: the AD Jacobian and its eigenvalues in mpmath's arithmetic."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from ....algebra.number_types import Algebra
from ....algebra.upright import UPRIGHT
from ....base.types import Floats
from ....base.verdict import CODES, Verdict
from ....bodies.families import FAMILIES
from ..points import Points
from .jacobians import jacobian_program
from .route import Answer, Route


class ManyDigits(Route):
    """The AD Jacobian's graph and a QR iteration in mpmath's arithmetic."""

    name, title = "mpmath-30", "automatic differentiation; eigenvalues by mpmath, 30 digits"
    arrays = False
    digits: ClassVar[int] = 30

    def answer(self, points: Points) -> Answer:
        """Eigenvalues and verdicts, point by point."""
        import mpmath

        rows = []
        with mpmath.workdps(self.digits):
            for x, p in zip(self._states(points), points.parameters, strict=True):
                rows.append(self._spectrum(points, x, p))
        values = np.array([[complex(v) for v in row] for row in rows])
        tops = np.array([float(max(v.real for v in row)) for row in rows])
        codes = [CODES[self._verdict(row)] for row in rows]
        return Answer(np.array(codes, dtype=np.int8), values, tops)

    def _states(self, points: Points) -> list[list[Any]]:
        """The states to all digits, upright and solved values included."""
        import mpmath

        record, rows = FAMILIES[points.family], []
        for i, row in enumerate(points.states):
            found: list[Any] = [float(v) for v in row]
            if points.given is None:
                at = mpmath.mpf(float(points.at[i]))
                if points.lean is not None:
                    at = mpmath.pi / 2 - mpmath.mpf(float(points.lean[i]))
                member = record.member(mpmath, at, mpmath.mpf(float(points.k[i])))
                found = [member[name] for name in points.member.system.states]
            rows.append([mpmath.pi / 2 if v is UPRIGHT else mpmath.mpf(v) for v in found])
        return rows

    def _spectrum(self, points: Points, x: list[Any], p: Floats) -> list[Any]:
        import mpmath

        program = jacobian_program(points.law)
        q = [mpmath.mpf(float(v)) for v in p]
        matrix = mpmath.matrix(program.dense(_mpmath_algebra(), [x, q]))
        values = sorted(mpmath.eig(matrix, left=False, right=False), key=abs)
        return list(values[points.zeros :])

    def _verdict(self, values: list[Any]) -> Verdict:
        top = max(v.real for v in values)
        # the distance by which rounding may split a double root
        small = 10.0 ** (-self.digits // 2 + 3)
        if abs(top) <= small * max(1, max(abs(v) for v in values)):
            return Verdict.NEUTRAL
        return Verdict.UNSTABLE if top > 0 else Verdict.STABLE


class MoreDigits(ManyDigits):
    """`ManyDigits` with 50 digits."""

    name, title = "mpmath-50", "automatic differentiation; eigenvalues by mpmath, 50 digits"
    digits = 50


class MostDigits(ManyDigits):
    """`ManyDigits` with 100 digits."""

    name, title = "mpmath-100", "automatic differentiation; eigenvalues by mpmath, 100 digits"
    digits = 100


@lru_cache(maxsize=1)
def _mpmath_algebra() -> Algebra:
    import mpmath

    return Algebra(
        "mpmath",
        lambda v: mpmath.mpf(v),
        {
            "sin": mpmath.sin,
            "cos": mpmath.cos,
            "tan": mpmath.tan,
            "sqrt": mpmath.sqrt,
            "exp": mpmath.exp,
            "pow": mpmath.power,
            "fabs": mpmath.fabs,
        },
        lasting=False,  # a constant has the digits of one route
    )
