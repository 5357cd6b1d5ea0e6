"""The table of benchmarks: known values from closed forms and long arithmetic, rows, both sides."""

import json
from collections.abc import Iterable
from functools import cache
from typing import Any

import mpmath
import pytest
import sympy
from mpmath import mpf

import stability as st
from stability.base.checks import chosen
from stability.base.errors import NameUnknownError
from stability.cli.commands import main
from stability.tables.benchmarks import catalogue
from stability.tables.benchmarks.bicycle import EIGENVALUES, ENTRIES, EXACT, SPEEDS
from stability.tables.benchmarks.catalogue import CASES, benchmark_rows
from stability.tables.benchmarks.row import AGREES, BenchmarkRow, Source, benchmark_notes, compared
from stability.tables.registry import definition

QUICK = {
    "railway wheelset",
    "Ziegler column",
    "Lagrange top",
    "mass on a belt",
    "Jeffcott rotor",
    "rotating saddle",
    "gyropendulum",
    "Routh's sphere",
    "body in a liquid",
}
"""Systems that take a tenth of a second or two."""
LATER = {"nonlinear bicycle"}
"""Systems that take some seconds: they are asked in the long tests."""
OPEN = {"triangular points"}
"""Systems with a test of their own."""


@cache
def rows(system: str) -> dict[str, BenchmarkRow]:
    return {row.quantity: row for row in benchmark_rows([system])}


# --- each value has an oracle that shares no code with the package ---


def roots(*coefficients: Any) -> list[Any]:
    """Roots to 40 digits by real, then imaginary part; the highest power first."""
    found = mpmath.polyroots(list(coefficients), maxsteps=300, extraprec=300)
    return sorted((mpmath.mpc(r) for r in found), key=lambda r: (float(r.real), float(r.imag)))


def wheelset(v: Any) -> list[Any]:
    """Coefficients of the wheelset's characteristic polynomial, highest first, by hand."""
    d, R, Rr, f, k, r0, m = (mpf(t) for t in (".72", ".23", ".2", "1e6", "13e3", ".46", "1000"))
    cone, N, d1 = mpmath.pi / 180, mpf(20000), mpf(".36")
    inertia = m * d**2
    lam = R * cone / (R - Rr)
    a, b, c = 2 * k / m + 2 * N / (m * (R - Rr)), 2 * f / m, 2 * f / (v * m)
    e, g, h = (
        2 * f * lam * d / (r0 * inertia),
        2 * k * d1**2 / inertia,
        2 * f * d**2 / (v * inertia),
    )
    # (L² + c L + a)(L² + h L + g) + b e
    return [mpf(1), c + h, g + c * h + a, c * g + a * h, a * g + b * e]


def flutter(coefficients: list[Any]) -> Any:
    a4, a3, a2, a1, a0 = coefficients
    return a3 * a2 * a1 - a4 * a1**2 - a0 * a3**2


def soft_until(a: Any) -> Any:
    """Sotomayor, Mello & Braga: 3 + (a² - 5) b² + a⁴ b⁶ = 0."""
    return mpmath.findroot(lambda b: 3 + (a**2 - 5) * b**2 + a**4 * b**6, 0.8)


def firing(v: Any) -> Any:
    """FitzHugh's nerve: the current at rest at v, where v² = 1 - slow b gives the trace 0."""
    return v**3 / 3 - v + (v + mpf(".7")) / mpf(".8")


def gates(v: Any) -> tuple[list[Any], list[Any]]:
    """Rates at which the squid axon's gates m, h, n open and close: Hodgkin & Huxley (1952)."""
    opens = [
        mpf(".1") * (25 - v) / mpmath.expm1((25 - v) / 10),
        mpf(".07") * mpmath.exp(-v / 20),
        mpf(".01") * (10 - v) / mpmath.expm1((10 - v) / 10),
    ]
    closes = [
        4 * mpmath.exp(-v / 18),
        1 / (mpmath.exp((30 - v) / 10) + 1),
        mpf(".125") * mpmath.exp(-v / 80),
    ]
    return opens, closes


def axon(v: Any) -> tuple[Any, Any]:
    """The current at rest at v, and the largest growth rate there, from the slopes by hand."""
    opens, closes = gates(v)
    m, h, n = (a / (a + b) for a, b in zip(opens, closes, strict=True))
    current = 120 * m**3 * h * (v - 115) + 36 * n**4 * (v + 12) + mpf(".3") * (v - mpf("10.6"))
    first = [
        -120 * m**3 * h - 36 * n**4 - mpf(".3"),
        -360 * m**2 * h * (v - 115),
        -120 * m**3 * (v - 115),
        -144 * n**3 * (v + 12),
    ]
    matrix = mpmath.matrix(4)
    for j, entry in enumerate(first):
        matrix[0, j] = entry
    for i, gate in enumerate((m, h, n)):
        a, b = (mpmath.diff(lambda x, k=k, i=i: gates(x)[k][i], v) for k in (0, 1))
        matrix[i + 1, 0], matrix[i + 1, i + 1] = a * (1 - gate) - b * gate, -opens[i] - closes[i]
    rates = mpmath.eig(matrix, left=False, right=False)
    return current, max(mpmath.re(rate) for rate in rates)


def axon_at(low: str, high: str) -> Any:
    """The current at which the largest growth rate vanishes, for a rest between two voltages."""
    v = mpmath.findroot(lambda x: axon(x)[1], (mpf(low), mpf(high)), solver="anderson", tol=1e-30)
    return axon(v)[0]


@cache
@mpmath.workdps(40)
def oracle() -> dict[str, dict[str, Any]]:
    """Every value of the table that a formula or long arithmetic gives, by system and quantity."""
    R = m = mpf(".02")
    a, g = mpf(".3"), mpf("9.82")
    I3, I1 = 2 * m * R**2 / 5, 131 * m * R**2 / 350
    # Jellett's integral is I3 spin R (1 + a) on the inverted top
    jellett = mpmath.sqrt(m * g * R**3 * I3 * a) * (1 + a) ** 2 / mpmath.sqrt(1 + a - I1 / I3)
    fast = jellett / (I3 * R * (1 + a))
    slow = mpmath.sqrt(m * g * R * a / I3) * (1 - a) / mpmath.sqrt(a + I1 / I3 - 1)
    frictions = [f"mu = {n} s/m" for n in ("0.3", "3", "30")] + ["every mu, exact condition"]
    speed = mpmath.findroot(lambda v: flutter(wheelset(v)), 48)
    a4, a3, a2, a1, a0 = wheelset(speed)
    pairs = roots(*wheelset(mpf(20)))
    third = 1 / mpf(3)
    height, trace = mpf("1.25"), mpmath.sqrt(1 - mpf(".08") * mpf(".8"))
    return {
        "tippe top": {
            **{f"spin below which upright is stable, {n}": slow for n in frictions},
            **{f"spin above which inverted is stable, {n}": fast for n in frictions},
            "Jellett's integral above which inverted is stable": jellett,
        },
        "railway wheelset": {
            "speed above which it hunts": speed,
            "frequency of hunting": mpmath.sqrt(a1 / a3),
            "real part of the fast pair at 20 m/s": pairs[0].real,
            "imaginary part of the fast pair at 20 m/s": pairs[1].imag,
            "real part of the slow pair at 20 m/s": pairs[2].real,
            "imaginary part of the slow pair at 20 m/s": pairs[3].imag,
        },
        "Watt governor": {
            "friction above which it is even, a = 0.5, b = 0.5": mpf(".5") ** 1.5,
            "friction above which it is even, a = 0.25, b = 0.64": 2 * mpf(".25") * mpf(".8") ** 3,
            **{
                f"b where the first Lyapunov coefficient is 0, a = {a}": soft_until(mpf(a))
                for a in ("0.25", "0.5", "0.8")
            },
        },
        "Ziegler column": {
            "load above which it flutters, undamped": mpf(7) / 2 - mpmath.sqrt(2),
            **{
                f"load above which it flutters, b = {b}": mpf(41) / 28 + mpf(b) ** 2 / 2
                for b in ("1", "0.1", "0.001")
            },
        },
        "Lagrange top": {
            "spin above which it sleeps": mpf(4),  # I3² W² = 4 I1 m g l
            "nutation at inclination 1, precession 0.7": mpmath.sqrt(
                mpf(".49") - 2 * mpmath.cos(1) + 1 / mpf(".49")
            ),
        },
        "triangular points": {
            "mass ratio below which they are neutral": (1 - mpmath.sqrt(69) / 9) / 2,
        },
        "Chaplygin sleigh": {
            "rate of attraction at speed 1": -mpf(".3") / mpf(".29"),
            "final speed from v = -1, w = 0.05": mpmath.sqrt(1 + mpf(".29") * mpf(".05") ** 2),
        },
        "mass on a belt": {
            "period of sticking and slipping": 5 + 2 * mpmath.pi - 2 * mpmath.atan(mpf("2.5")),
        },
        "Jeffcott rotor": {
            "rate above which it whirls, w0 = 100, de = 3, di = 2": mpf(100) * (1 + mpf(3) / 2),
        },
        "rotating saddle": {"rate above which it holds a ball, k = 3": mpmath.sqrt(3)},
        "SymPy's rolling disc": {
            "rate of rolling above which it is neutral": mpmath.sqrt(mpf("9.81") * third),
        },
        # z'' + (d - i G spin) z' - (k + i r spin) z = 0: d² k = r (d G - r) spin²
        "gyropendulum": {
            "rate above which damping that turns holds it": mpmath.sqrt(
                mpf(".5") / (mpf(".375") * mpf(".375"))
            ),
        },
        # (I1 + m H²) z'' - i (I3 + m R H) spin z' - m g a z = 0, H = R + a
        "Routh's sphere": {
            "spin above which its centre of mass stays on top": mpmath.sqrt(
                4 * (mpf(".5") + height**2) / 4
            )
            / (mpf(".375") + height),
        },
        # n = L - i spin: n (n - J3 spin/J1) = (m3/m1) (m3 - m1) v²/J1
        "body in a liquid": {
            "spin above which it keeps its course": mpmath.sqrt(mpf(16) / 3) * 2,
        },
        "vortices about a vortex": {  # (N² - 8 N + 8)/16 and (N - 1)²/4 for N = 4
            "circulation in the middle above which the square is neutral": mpf("-.5"),
            "circulation in the middle above which it is unstable": mpf("2.25"),
        },
        "FitzHugh-Nagumo nerve": {
            "current at which firing begins": firing(-trace),
            "current at which firing ceases": firing(trace),
        },
        "Hodgkin-Huxley axon": {
            "current at which firing begins": axon_at("5.2", "5.5"),
            "current at which firing ceases": axon_at("21.5", "22.2"),
        },
    }


def quick_first(systems: Iterable[str]) -> list[Any]:
    """The quick ones for the fast suite, the others for the long tests."""
    slow = pytest.mark.long
    return [pytest.param(s, marks=() if s in QUICK else slow) for s in systems]


COVERED = [
    name for name in CASES if name not in LATER | OPEN | {"linear bicycle"}
]  # the bicycles have their own test


@pytest.mark.parametrize("system", quick_first(COVERED))
def test_every_known_value_is_right_and_the_package_finds_all_its_digits(system: str) -> None:
    with mpmath.workdps(40):
        wanted = oracle()[system]
        found = rows(system)
        assert set(found) == set(wanted)
        for quantity, row in found.items():
            digits = mpf(10) ** -len(row.known.lower().split("e")[0].partition(".")[2])
            power = int((row.known.lower().split("e") + ["0"])[1])
            assert abs(mpf(row.known) - wanted[quantity]) <= digits * mpf(10) ** power
            assert row.status == AGREES, row
            assert row.recomputed == pytest.approx(float(wanted[quantity]), rel=1e-13)


SIDES = {
    "tippe top": {"inverted": ("unstable", "stable"), "upright": ("stable", "unstable")},
    "railway wheelset": {"speed above": ("stable", "unstable")},
    "Watt governor": {"friction above": ("unstable", "stable")},
    "Ziegler column": {"b =": ("stable", "unstable"), "undamped": ("neutral", "unstable")},
    "Lagrange top": {"sleeps": ("unstable", "neutral")},
    "Jeffcott rotor": {"whirls": ("stable", "unstable")},
    "rotating saddle": {"holds": ("unstable", "neutral")},
    "SymPy's rolling disc": {"neutral": ("unstable", "neutral")},
    "gyropendulum": {"holds": ("unstable", "stable")},
    "Routh's sphere": {"stays": ("unstable", "neutral")},
    "body in a liquid": {"keeps": ("unstable", "neutral")},
    "vortices about a vortex": {
        "is neutral": ("unstable", "neutral"),
        "is unstable": ("neutral", "unstable"),
    },
    "FitzHugh-Nagumo nerve": {"begins": ("stable", "unstable"), "ceases": ("unstable", "stable")},
    "Hodgkin-Huxley axon": {"begins": ("stable", "unstable"), "ceases": ("unstable", "stable")},
    "linear bicycle": {"weave is": ("unstable", "stable"), "capsizes": ("stable", "unstable")},
}
"""Verdicts below and above each threshold, by words of the quantity."""


@pytest.mark.parametrize("system", quick_first(SIDES))
def test_both_sides_of_each_threshold_are_certified(system: str) -> None:
    seen = set()
    for quantity, row in rows(system).items():
        for word, sides in SIDES[system].items():
            if word in quantity and "integral" not in quantity and "every mu" not in quantity:
                assert (row.below, row.above) == sides, row
                seen.add(word)
    assert seen == set(SIDES[system])


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("middle", "neutral"),
    [
        ("-.500001", False),
        ("-.499999", True),
        ("2.249999", True),
        ("2.250001", False),
    ],
)
def test_the_vortex_square_is_neutral_between_its_thresholds(middle: str, neutral: bool) -> None:
    """Linear motions of five vortices z in complex numbers, in the frame that turns with them."""
    with mpmath.workdps(40):
        places = [mpmath.mpc(0, 1) ** k for k in range(4)] + [mpmath.mpc(0)]
        shares = [mpf(1)] * 4 + [mpf(middle)]
        matrix = mpmath.matrix(10)  # of (z, conj z): conj z' = i (spin conj z + sum …)
        for k, at in enumerate(places):
            matrix[5 + k, 5 + k] += 1j * (mpf(1.5) + mpf(middle))
            for j in (j for j in range(5) if j != k):
                pull = 1j * shares[j] / (at - places[j]) ** 2
                matrix[5 + k, k] += pull
                matrix[5 + k, j] -= pull
        for i in range(5):
            for j in range(10):
                matrix[i, j] = mpmath.conj(matrix[5 + i, (j + 5) % 10])
        growth = max(mpmath.re(v) for v in mpmath.eig(matrix, left=False, right=False))
    assert (growth < 1e-12) if neutral else (growth > 1e-4)


def bicycle() -> tuple[Any, Any, Any, Any]:
    """M, C1, K0, K2 of the linear bicycle to 40 digits: Meijaard et al. (2007), appendix A."""
    text = """w 1.02 c .08 g 9.81 rR .3 mR 2 IRxx .0603 IRyy .12 xB .3 zB -.9 mB 85 IBxx 9.2
        IBzz 2.8 IBxz 2.4 xH .9 zH -.7 mH 4 IHxx .05892 IHzz .00708 IHxz -.00756 rF .35 mF 3
        IFxx .1405 IFyy .28""".split()  # noqa: SIM905
    p = {n: mpf(v) for n, v in zip(text[::2], text[1::2], strict=True)}
    w, c, rR, rF, xB, zB, xH, zH = (p[n] for n in "w c rR rF xB zB xH zH".split())  # noqa: SIM905
    mR, mB, mH, mF = (p[f"m{n}"] for n in "RBHF")
    sin, cos = mpmath.sin(mpmath.pi / 10), mpmath.cos(mpmath.pi / 10)
    mT, mA = mR + mB + mH + mF, mH + mF
    xT = (xB * mB + xH * mH + w * mF) / mT
    zT = (-rR * mR + zB * mB + zH * mH - rF * mF) / mT
    ITxx = p["IRxx"] + p["IBxx"] + p["IHxx"] + p["IFxx"]
    ITxx += mR * rR**2 + mB * zB**2 + mH * zH**2 + mF * rF**2
    ITxz = p["IBxz"] + p["IHxz"] - mB * xB * zB - mH * xH * zH + mF * w * rF
    ITzz = p["IRxx"] + p["IBzz"] + p["IHzz"] + p["IFxx"] + mB * xB**2 + mH * xH**2 + mF * w**2
    xA, zA = (xH * mH + w * mF) / mA, (zH * mH - rF * mF) / mA
    IAxx = p["IHxx"] + p["IFxx"] + mH * (zH - zA) ** 2 + mF * (rF + zA) ** 2
    IAxz = p["IHxz"] - mH * (xH - xA) * (zH - zA) + mF * (w - xA) * (rF + zA)
    IAzz = p["IHzz"] + p["IFxx"] + mH * (xH - xA) ** 2 + mF * (w - xA) ** 2
    uA = (xA - w - c) * cos - zA * sin
    IAll = mA * uA**2 + IAxx * sin**2 + 2 * IAxz * sin * cos + IAzz * cos**2
    IAlx = -mA * uA * zA + IAxx * sin + IAxz * cos
    IAlz = mA * uA * xA + IAxz * sin + IAzz * cos
    mu, SF = c / w * cos, p["IFyy"] / rF
    ST, SA = p["IRyy"] / rR + SF, mA * uA + mu * mT * xT
    mass = [[ITxx, IAlx + mu * ITxz], [IAlx + mu * ITxz, IAll + 2 * mu * IAlz + mu**2 * ITzz]]
    damp = [
        [mpf(0), mu * ST + SF * cos + ITxz / w * cos - mu * mT * zT],
        [-(mu * ST + SF * cos), IAlz / w * cos + mu * (SA + ITzz / w * cos)],
    ]
    still = [[mT * zT, -SA], [-SA, -SA * sin]]
    fast = [[mpf(0), (ST - mT * zT) / w * cos], [mpf(0), (SA + SF * sin) / w * cos]]
    return mass, damp, still, fast


def quartic(v: Any) -> list[Any]:
    """det(M L² + v C1 L + g K0 + v² K2), highest power first."""
    mass, damp, still, fast = bicycle()
    out = [mpf(0)] * 5
    for sign, left, right in ((1, (0, 0), (1, 1)), (-1, (0, 1), (1, 0))):
        entries = [
            [mass[i][j], v * damp[i][j], mpf("9.81") * still[i][j] + v**2 * fast[i][j]]
            for i, j in (left, right)
        ]
        for i, a in enumerate(entries[0]):
            for j, b in enumerate(entries[1]):
                out[i + j] += sign * a * b
    return out


def test_values_behind_the_published_digits_are_those_of_long_arithmetic() -> None:
    with mpmath.workdps(40):
        pair = roots(*quartic(mpf(5)))
        exact = {
            "castering eigenvalue at 5 m/s": pair[0].real,
            "weave at 5 m/s, real part": pair[1].real,
            "weave": mpmath.findroot(lambda v: flutter(quartic(v)), mpf("4.29")),
            "capsize": mpmath.findroot(lambda v: quartic(v)[-1], mpf("6.02")),
        }
        assert set(EXACT) == set(exact)
        for name, value in exact.items():
            assert abs(mpf(EXACT[name]) - value) < mpf("0.5e-14")
            published = (EIGENVALUES | SPEEDS)[name]
            assert mpf("0.5e-14") < abs(mpf(published) - value) < mpf("5e-14")
        for name, printed in ENTRIES.items():
            k, (i, j) = ("M", "C1", "K0", "K2").index(name[:-3]), map(int, name[-2:])
            assert abs(mpf(printed) - bicycle()[k][i][j]) < mpf("1e-14")


def test_the_linear_bicycle_has_every_published_entry() -> None:
    """Meijaard et al. print 15 digits; the last digits of four values are not right."""
    found = rows("linear bicycle")
    entries = [row for q, row in found.items() if "[" in q]
    assert len(entries) == 11
    assert {row.status for row in entries} == {AGREES}
    assert all(row.status.startswith("agrees to all digits") for row in found.values())
    assert found["speed above which weave is stable"].known == "4.29238253634111"
    assert found["speed above which weave is stable"].recomputed == 4.292382536341104


@pytest.mark.long
def test_the_nonlinear_bicycle_has_the_published_accelerations_and_spectrum() -> None:
    found = rows("nonlinear bicycle")
    assert len(found) == 15
    assert all(row.status.startswith("agrees") for row in found.values())
    for quantity, row in found.items():
        bound = 2e-12 if quantity.startswith("acceleration") else 5e-14
        assert row.difference is not None
        assert abs(row.difference) < bound
    linear = rows("linear bicycle")
    for quantity in (q for q in linear if "[" not in q):
        assert found[quantity].recomputed == pytest.approx(linear[quantity].recomputed, rel=1e-13)
        assert (found[quantity].below, found[quantity].above) == (
            linear[quantity].below,
            linear[quantity].above,
        )


def test_the_triangular_points_are_decided() -> None:
    (row,) = rows("triangular points").values()
    with mpmath.workdps(40):
        (ratio,) = oracle()["triangular points"].values()
        assert abs(mpf(row.known) - ratio) < mpf(10) ** -18
    assert row.status == AGREES
    assert (row.below, row.above) == ("neutral", "unstable")


@pytest.mark.long
def test_the_tippe_top_flutters_at_one_spin_for_every_friction() -> None:
    """The linear tippe top by hand, in complex numbers: at the threshold the contact does not slip.

    With n = (ζ, σ), spin (Ω, w), velocity v of the centre of mass, m = R = g = 1, h = 1 - σ a:
    ζ' = i w ζ - i σ Ω, (I1 Ω + (I3 - I1) σ w ζ)' = -i a ζ - i h F,
    v' = F = -mu (v + i w a ζ + i h Ω).
    """
    mu, lam = sympy.symbols("mu lambda")
    w, s = sympy.symbols("w sigma")
    a, I1, I3 = sympy.Rational(3, 10), sympy.Rational(131, 350), sympy.Rational(2, 5)
    h, i = 1 - s * a, sympy.I
    slip = sympy.Matrix([[i * w * a, i * h, 1]])  # of ζ, Ω, v
    kinematic = sympy.Matrix([[lam - i * w, i * s, 0]])
    moment = sympy.Matrix([[lam * (I3 - I1) * s * w + i * a, lam * I1, 0]]) - i * h * mu * slip
    newton = sympy.Matrix([[0, 0, lam]]) + mu * slip
    det = sympy.expand(sympy.Matrix.vstack(kinematic, moment, newton).det())
    thresholds = {
        1: a / I3 * (1 - a) ** 2 / (a + I1 / I3 - 1),
        -1: a / I3 * (1 + a) ** 2 / (1 + a - I1 / I3),
    }
    for sign, square in thresholds.items():
        spin = sympy.sqrt(square)
        at = {s: sign, w: spin, lam: i * spin / (1 - sign * a)}
        assert sympy.simplify(det.subs(at)) == 0  # for every mu
        assert sympy.simplify(det.subs(at | {w: spin * 2})) != 0
        package = rows("tippe top")
        way = "upright" if sign == 1 else "inverted"
        (row,) = [r for q, r in package.items() if way in q and "every mu" in q]
        physical = float(spin) * (9.82 / 0.02) ** 0.5
        assert row.recomputed == pytest.approx(physical, rel=1e-14)


# --- words of a row, and the table ---


def test_a_wrong_or_missing_value_is_said_to_be_so() -> None:
    about = Source("body", "paper")
    right = compared(about, "size", "1.250", 1.2504)
    assert right.status == AGREES
    assert compared(about, "size", "1.250", 1.2506).status == "agrees to 3 digits of 4"
    assert compared(about, "size", "1.250", 2.5).status == "agrees to 0 digits of 4"
    none = compared(about, "size", "1.250", None, reason="no wind")
    assert (none.status, none.difference) == ("not covered: no wind", None)
    nan = compared(about, "size", "1.250", float("nan"), reason="no wind")
    assert nan.recomputed is None
    inexact = compared(about, "size", "1.250", 1.25071, inputs=1e-3)
    assert "within the rounding of the published inputs" in inexact.status
    typo = compared(about, "size", "1.250", 1.2511, exact="1.251")
    assert typo.status == "agrees to all digits of 1.251; the last published digits are not right"


@pytest.mark.parametrize(
    ("other", "count"),
    [("Ziegler column", 5), pytest.param("Watt governor", 6, marks=pytest.mark.long)],
)
def test_the_command_prints_rows_and_writes_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], other: str, count: int
) -> None:
    few = {n: CASES[n] for n in ("Jeffcott rotor", other)}
    monkeypatch.setattr(catalogue, "CASES", few)
    assert main(["table", "benchmarks"]) == 0
    text = capsys.readouterr().out
    assert "found 250 rad/s, difference 0.0e+00: agrees to all digits" in text
    assert "below stable, above unstable (certified)" in text
    assert text.count(f"{count} known values, {count} agree.") == 1
    assert main(["table", "benchmarks", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["rows"]
    assert found[0]["recomputed"] == 250.0
    assert found[0]["origin"] == "closed form"
    assert main(["table", "benchmarks", "--k", "0.3"]) == 2


def test_progress_counts_systems_and_unknown_ones_are_refused() -> None:
    seen: list[tuple[int, int]] = []
    definition("benchmarks").rows(
        systems=["Jeffcott rotor", "rotating saddle"],
        progress=lambda done, of: seen.append((done, of)),
    )
    assert seen == [(1, 2), (2, 2)]
    with pytest.raises(NameUnknownError, match="'pendulum'"):
        benchmark_rows(["pendulum"])
    assert "0 known values, 0 agree." in benchmark_notes([])


def test_a_subset_is_asked_by_names_or_parts_of_names(capsys: pytest.CaptureFixture[str]) -> None:
    found = st.table("benchmarks", systems=["rotor", "rotating saddle"])
    assert {row["system"] for row in found} == {"Jeffcott rotor", "rotating saddle"}
    assert main(["table", "benchmarks", "--systems", "Rotor,rotating saddle"]) == 0
    assert capsys.readouterr().out == f"{found.to_text()}\n"
    assert main(["table", "benchmarks", "--systems", "rotor,pendulum"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("stability: system is 'pendulum'; known are bicycle, top, wheelset")
    assert " … " not in said
    for word in said.rstrip(".\n").split("known are ")[1].split(", "):
        assert chosen("system", word, dict.fromkeys(CASES, "")), word
    assert main(["table", "drift", "--systems", "rotor"]) == 2
    assert "systems belongs to `table benchmarks` only" in capsys.readouterr().err


def test_a_further_column_stands_in_the_text() -> None:
    from stability.tables.benchmarks import row
    from stability.tables.table import Column

    column = Column("relative", "difference over the known value", "%", form="{:.1e}")
    record = dict.fromkeys(row.IN_SENTENCES, "") | {"recomputed": 1.0, "difference": 0.0}
    lines = row.benchmark_lines([record | {"relative": 0.5}], (*row.COLUMNS, column))
    assert lines[-1] == "        relative 5.0e-01 %"
