"""Printed values of other codes: the recomputed ones against hand-written equations, in mpmath."""

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath as mp
import pytest

from stability.tables import peers
from stability.tables.benchmarks.row import PUBLISHED, BenchmarkRow
from stability.tables.printed import printed_row
from stability.tables.registry import definition
from stability.tables.table import Standing


@pytest.fixture(autouse=True)
def forty_digits() -> Iterator[None]:
    """The oracles of this file count in 40 digits."""
    with mp.workdps(40):
        yield


@cache
def rows(case: Callable[[], list[BenchmarkRow]]) -> list[BenchmarkRow]:
    return case()


def number(text: str) -> mp.mpf:
    return mp.mpf(text)


# --- the equations, by hand ---


def reaction() -> list[mp.mpf]:
    """Folds u(1 - u) = 3/14, and zero trace 14u² - 17u + 4 = 0."""
    root = mp.sqrt(mp.mpf(1) / 7)
    members = [(1 - root) / 2, (1 + root) / 2, (17 + mp.sqrt(65)) / 28]
    return [u * mp.exp(-14 * u / 3) / (1 - u) for u in members]


def control() -> list[mp.mpf]:
    """Routh: α β = 1; the coefficient by the invariant formula at the vectors of the pair."""
    A = mp.matrix([[0, 1, 0], [0, 0, 1], [-1, -1, -1]])
    q = mp.matrix([1, 1j, -1]) / mp.sqrt(3)
    p = mp.matrix([1, 1 + 1j, 1j])  # Aᵀp = -ip, checked below
    assert mp.norm(A.T * p + 1j * p) < number("1e-35")
    inner = lambda a, b: sum(mp.conj(x) * y for x, y in zip(a, b, strict=True))  # noqa: E731
    p = p / mp.conj(inner(p, q))
    both = lambda a, b: mp.matrix([0, 0, 2 * a[0] * b[0]])  # noqa: E731
    bar = q.apply(mp.conj)
    slow = mp.lu_solve(A, both(q, bar))
    fast = mp.lu_solve(2j * mp.eye(3) - A, both(q, q))
    return [mp.mpf(1), mp.mpf(1), mp.re(inner(p, -2 * both(q, slow) + both(bar, fast))) / 2]


def rates(x: Any, y: Any, s: Any, q: Any, k: Any) -> list[Any]:
    z = 1 - x - y - s
    return [
        5 * z**2 - 2 * x**2 - 10 * x * y,
        q * z - y / 10 - 10 * x * y,
        number("0.0675") * (z - k * s),
    ]


def slopes(x: Any, y: Any, s: Any, q: Any, k: Any) -> Any:
    z, slow = 1 - x - y - s, number("0.0675")
    return mp.matrix(
        [
            [-10 * z - 4 * x - 10 * y, -10 * z - 10 * x, -10 * z],
            [-q - 10 * y, -q - mp.mpf(1) / 10 - 10 * x, -q],
            [-slow, -slow, -slow * (1 + k)],
        ]
    )


def coefficients(J: Any) -> tuple[Any, Any, Any]:
    """Coefficients a, b, c of λ³ + aλ² + bλ + c."""
    minors = sum(J[i, i] * J[j, j] - J[i, j] * J[j, i] for i, j in ((0, 1), (0, 2), (1, 2)))
    return -(J[0, 0] + J[1, 1] + J[2, 2]), minors, -mp.det(J)


def newton(equations: Callable[..., list[Any]], *guess: float) -> Any:
    return mp.findroot(equations, tuple(map(mp.mpf, guess)), tol=number("1e-50"))


def oxidation() -> list[mp.mpf]:
    """Pairs: ab = c; double zeros: b = c = 0; the cusp: Jv = 0 and Jh + B(v, v) = 0."""
    k = mp.mpf(2) / 5

    def pair(x: Any, y: Any, s: Any, q: Any) -> list[Any]:
        a, b, c = coefficients(slopes(x, y, s, q, k))
        return [*rates(x, y, s, q, k), a * b - c]

    def double(*at: Any) -> list[Any]:
        return [*rates(*at), *coefficients(slopes(*at))[1:]]

    def cusp(x: Any, y: Any, s: Any, q: Any, k: Any, *rest: Any) -> list[Any]:
        v, h, J = mp.matrix(rest[:3]), mp.matrix(rest[3:]), slopes(x, y, s, q, k)
        dz = -(v[0] + v[1] + v[2])
        first = 10 * dz**2 - 4 * v[0] ** 2 - 20 * v[0] * v[1]
        curved = J * h + mp.matrix([first, -20 * v[0] * v[1], 0])
        unit = [(v.T * v)[0] - 1, (v.T * h)[0]]
        return [*rates(x, y, s, q, k), *(J * v), *curved, *unit]

    high = newton(pair, 0.02, 0.5, 0.35, 1.0516)
    low = newton(pair, 0.11, 0.18, 0.51, 1.0410)
    first = newton(double, 0.016, 0.638, 0.200, 1.161, 0.722)
    second = newton(double, 0.116, 0.315, 0.288, 1.418, 0.971)
    start = (0.0359, 0.352, 0.4514, 1.0064, 0.356, 0.1, -0.8, 0.55, 0.5, 0.1, 0.1)
    return [high[3], low[3], first[3], first[4], second[3], second[4], newton(cusp, *start)[4]]


def winds() -> list[mp.mpf]:
    """Vanishing rates and determinant."""
    quarter, one, other = mp.mpf(1) / 4, number("0.987"), number("1.04")

    def fold(x: Any, y: Any, z: Any, u: Any, F: Any) -> list[Any]:
        J = [
            [-quarter, -2 * y, -2 * z, -2 * one * u],
            [y - z, x - 1, -x, 0],
            [y + z, x, x - 1, 0],
            [one * u, 0, 0, one * x - other],
        ]
        return [
            -(y**2) - z**2 - x / 4 + F / 4 - one * u**2,
            x * y - x * z - y + quarter,
            x * y + x * z - z,
            -other * u + one * u * x + mp.mpf(1) / 25,
            mp.det(mp.matrix(J)),
        ]

    at = newton(fold, 1.3, -0.05, 0.18, -0.15, 1.5466)
    return [at[4], at[4]]


def bazykin() -> list[mp.mpf]:
    """100 a² - 99 a + 1 = 0."""
    return [(99 - mp.sqrt(9401)) / 200, (99 + mp.sqrt(9401)) / 200]


def skate() -> list[mp.mpf]:
    """Two point masses, no trail: the last Hurwitz determinant of the quartic."""
    masses = ((10, number("1.2"), number("-0.4")), (1, number("1.02"), number("-0.2")))
    lam, g = number("0.0872664626"), number("9.81")
    _, x, z = masses[1]
    arm, cos = (x - 1) * mp.cos(lam) - z * mp.sin(lam), mp.cos(lam)
    zz, xz, first = (sum(f(*m) for m in masses) for f in (_zz, _xz, _z))

    def hurwitz(v: Any) -> Any:
        a, b, c = zz, -arm * z, arm**2
        d, e = -xz * cos * v, arm * x * cos * v
        f, h = g * first, -g * arm
        i, j = h - v**2 * first * cos, h * mp.sin(lam) + v**2 * arm * cos
        p4, p3 = a * c - b * b, a * e - b * d
        p2, p1, p0 = a * j + f * c - b * (h + i), f * e - h * d, f * j - i * h
        return p3 * p2 * p1 - p4 * p1**2 - p3**2 * p0

    return [mp.findroot(hurwitz, number("2.84"), tol=number("1e-50"))]


def _zz(m: Any, _: Any, z: Any) -> Any:
    return m * z * z


def _xz(m: Any, x: Any, z: Any) -> Any:
    return m * x * z


def _z(m: Any, _: Any, z: Any) -> Any:
    return m * z


def lorenz() -> list[mp.mpf]:
    """σ (σ + β + 3)/(σ - β - 1)."""
    return [mp.mpf(470) / 19]


def section() -> list[mp.mpf]:
    """Two frequencies meet where (0.2784 - 0.4 L)² = 0.1472 (0.24 - 0.3 L), L = V²/10."""
    a, b, c = number("0.16"), number("-0.17856"), number("0.04217856")
    lift = (-b - mp.sqrt(b * b - 4 * a * c)) / (2 * a)
    return [mp.sqrt(10 * lift), mp.sqrt(8)]


ORACLES = {
    peers.reaction: reaction,
    peers.control: control,
    peers.lorenz: lorenz,
    peers.winds: winds,
    peers.bazykin: bazykin,
    peers.skate: skate,
    peers.section: section,
    peers.oxidation: oxidation,
}
SLOW = [
    pytest.param(c, marks=pytest.mark.long if c is peers.oxidation else (), id=c.__name__)
    for c in ORACLES
]


@pytest.mark.parametrize("case", SLOW)
def test_each_value_is_that_of_the_equations_by_hand(case: Any) -> None:
    """Within the stated bound and twice the rounding of the model's decimals to doubles."""
    values = ORACLES[case]()
    for row, value in zip(rows(case), values, strict=True):
        off = abs(mp.mpf(row.recomputed) - value)
        assert off <= row.bound + mp.mpf(2) ** -51 * abs(value), row
        agrees = abs(value - mp.mpf(row.known)) <= mp.mpf(10) ** -decimals(row.known) / 2
        if "bracket" not in row.quantity:
            assert row.status.startswith("agrees" if agrees else "differs"), row


def decimals(text: str) -> int:
    return len(text.partition(".")[2])


def test_the_fold_of_lorenz_84_lies_outside_its_printed_bracket() -> None:
    lower, upper = rows(peers.winds)
    assert not number(lower.known) < winds()[0] < number(upper.known)
    assert {row.status for row in (lower, upper)} == {"differs: outside the printed bracket"}


def test_a_wrong_printed_value_is_said_to_differ() -> None:
    row = printed_row(peers.LORENZ, "r", "24.7369", (24.736842105263158, 4e-15))
    assert row.status == "differs: agrees to 5 digits of 6"
    assert Fraction(row.difference) < 0 < row.bound < 1e-14


def test_the_largest_difference_and_the_standing_are_those_of_the_rows() -> None:
    """The largest is the cusp's."""
    about = definition("peers").about
    assert about is not None and about.largest is not None
    printed = number("0.35665351")
    cusp = abs(number("0.3559912732086766") / printed - 1)
    assert about.largest / 2 < cusp <= about.largest and about.standing is Standing.PARTLY
    origins = {row.origin for case in list(ORACLES)[:-1] for row in rows(case)}
    assert origins > {PUBLISHED, peers.RECALLED}
