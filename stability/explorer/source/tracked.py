"""Formulas as source that carry a bound on their rounding errors in double precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...algebra.number_types import Algebra
from ...algebra.running_error import TINY, UNIT, RunningError

WIDER = 1.01
"""Factor of a bound for its own roundings."""
ULPS = 2.0
"""Units in the last place, halved, by which a sine of a browser may be off, and one to spare."""


def tracked(algebra: Algebra) -> Algebra:
    """The number type whose numbers have a value and a bound, both of another number type.

    Source: stability/algebra/running_error.py; tests/explorer/test_bodies.py compares with balls.
    """
    plain = algebra.functions

    def apply(name: str, change: Callable[[Any, Any, Any], Any]) -> Callable[[Any], Any]:
        def found(x: Any) -> Any:
            given = x if isinstance(x, RunningError) else RunningError(x, 0.0)
            value = plain[name](given.value)
            own = 2 * ULPS * UNIT * abs(value) + TINY
            return RunningError(value, change(given.value, given.error, value) + own)

        return found

    def root(x: Any, e: Any, y: Any) -> Any:
        least = x - e
        return e / (y + plain["sqrt"]((least + abs(least)) / 2))

    def power(x: Any, n: Any) -> Any:
        out: Any = 1.0
        for _ in range(int(n)):
            out = x * out
        return out

    table: dict[str, Callable[..., Any]] = {
        "sin": apply("sin", lambda _, e, __: e),
        "cos": apply("cos", lambda _, e, __: e),
        "sqrt": apply("sqrt", root),
        "fabs": apply("fabs", lambda _, e, __: e),
        "pow": power,
    }
    return Algebra(f"tracked {algebra.name}", float, table, lasting=False)


def with_bounds(
    formula: Callable[..., list[Any]], algebra: Algebra, *inputs: Any
) -> list[tuple[Any, Any]]:
    """(value, bound) of each entry of a formula."""
    given = [[RunningError(v, 0.0) for v in some] for some in inputs]
    found = formula(tracked(algebra), *given)
    return [(v.value, WIDER * v.error) if isinstance(v, RunningError) else (v, 0.0) for v in found]
