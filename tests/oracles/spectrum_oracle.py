"""Spectra of the disk's families by mpmath, from the graph with its constants exact."""

from collections.abc import Mapping
from typing import Any

import mpmath
import numpy as np

import stability as st
from stability.algebra.program import Program
from stability.base.verdict import CODES, Verdict
from stability.spectra.certificate import verdict

DIGITS = 200


def truth_matrix(family: st.Family, a: float, q: list[float]) -> Any:
    """The linearisation at a member as an mpmath matrix: the graph with its constants exact."""
    functions = {n: getattr(mpmath, n) for n in ("sin", "cos", "sqrt")}
    algebra: Any = type(
        "Numbers",
        (),
        {"name": "mpmath", "constant": mpmath.mpf, "functions": functions, "lasting": True},
    )
    values = [mpmath.mpf(v) for v in q]
    if family.name == "tumbling":
        unknown = [1 / mpmath.sqrt(values[0] * mpmath.sin(mpmath.mpf(a)))]
    else:
        unknown = [mpmath.mpf(v) for v in family.unknown.values()]
    program: Program = family.graph.matrix
    return mpmath.matrix(program.dense(algebra, [[mpmath.mpf(a)], unknown, values]))


def reduced_truth(family: str, law: str, at: Any, k: float, mu: float) -> list[Any]:
    """Coefficients of det(λ - A) / λ^zeros by Faddeev-LeVerrier in mpmath, lowest first."""
    resolved = st.disk_family(family, law)
    matrix = truth_matrix(resolved, at, [k, mu][: len(resolved.parameters)])
    n = matrix.rows
    coefficients, power = [mpmath.mpf(1)], mpmath.eye(n)
    for i in range(1, n + 1):
        power = matrix * (power + (coefficients[-1] * mpmath.eye(n) if i > 1 else 0 * power))
        coefficients.append(-sum(power[j, j] for j in range(n)) / i)
    zeros = {"rolling": 2, "spinning": 1, "tumbling": 1}[family]
    return coefficients[::-1][zeros if law == "viscous" else 2 :]


def truth(family: str, at: Any, k: float, mu: float) -> Verdict:
    """The verdict by Routh's array in 200-digit arithmetic."""
    with mpmath.workdps(DIGITS):
        rows = reduced_truth(family, "viscous", at, k, mu)[::-1]
        here, following = rows[::2], rows[1::2]
        while following:
            if following[0] <= 0:
                return Verdict.UNSTABLE
            ratio = here[0] / following[0]
            padded = [*following[1:], mpmath.mpf(0)][: len(here) - 1]
            here, following = (
                following,
                [x - ratio * y for x, y in zip(here[1:], padded, strict=True)],
            )
        return Verdict.STABLE


def random_points(
    family: str, count: int, seed: int
) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    random = np.random.default_rng(seed)
    k = np.exp(random.uniform(np.log(1e-3), np.log(0.5), count))
    mu = 10 ** random.uniform(-6, 6, count)
    if family == "tumbling":
        at = np.exp(random.uniform(np.log(1e-4), np.log(np.pi / 2), count))
    else:
        at = 10 ** random.uniform(-3, 3, count)
    return at[:, None], np.column_stack([k, mu])


def exact_codes(asked: Any, values: Mapping[str, Any]) -> Any:
    """Verdict flags by exact arithmetic, point by point, of the broadcast shape."""
    arrays = dict(zip(values, np.broadcast_arrays(*values.values()), strict=True))
    shape = next(iter(arrays.values())).shape
    codes = np.zeros(shape, dtype=np.int8)
    for place in np.ndindex(shape):
        codes[place] = CODES[verdict(asked, {n: float(v[place]) for n, v in arrays.items()})]
    return codes
