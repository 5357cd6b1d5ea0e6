"""Compiled loops: within the same bounds as exact arithmetic, mpmath and the NumPy route."""

from collections.abc import Iterator
from fractions import Fraction
from importlib.util import find_spec
from typing import Any

import mpmath
import numpy as np
import pytest
from spectrum_oracle import DIGITS, reduced_truth

import stability as st
from stability.algebra.kernels.compiled import compiled
from stability.algebra.real_factors import Factors, enclose, settle, start
from stability.base.verdict import CODES, Verdict
from stability.bodies.disk_polynomials import INPUT, PLAIN
from stability.maps.compiled import factors, loops, rates
from stability.maps.growth_rates import HAS_LONG, GrowthKernel
from stability.maps.verdicts import FilteredVerdicts, point
from stability.spectra.certificate import certify
from stability.spectra.problem import disk_problem

SIDE = loops.SIDE
FAMILIES = ["rolling", "spinning", "tumbling"]
RANGES = {"rolling": (0.1, 4.0), "spinning": (0.3, 6.0), "tumbling": (0.01, 1.57)}
LAWS = [st.Viscous(0.7), st.LinearViscous(0.7), st.Rough(), st.Smooth()]
CASES = [(f, law) for f in FAMILIES for law in LAWS]
CASES += [("circling", st.Rough()), ("precession", st.Smooth())]
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")
needs_long = pytest.mark.skipif(not HAS_LONG, reason="long double is double")


def names(case: Any) -> str:
    return case if isinstance(case, str) else case.name


def loops_() -> Any:
    return compiled(factors, loops)


def question(family: str, law: Any, disk: Any = None) -> Any:
    at = (0.9, 0.7) if family in ("circling", "precession") else 1.0
    return disk_problem(family, disk or st.Disk(k=0.3), law, at)


def tile(asked: Any, family: str, columns: int = 150, rows: int = 40) -> dict[str, Any]:
    second = next(n for n in ("mu", "c", "k") if n in asked.values)
    low, high = (0.01, 0.5) if second == "k" else (0.01, 30.0)
    first, ends = ("theta", (0.1, 1.5)) if family not in RANGES else ("at", RANGES[family])
    return dict(asked.values) | {
        first: np.linspace(*ends, columns)[None, :],
        second: np.geomspace(low, high, rows)[:, None],
    }


@pytest.mark.few(1)
@needs_numba
@pytest.mark.parametrize(("family", "law"), CASES, ids=names)
def test_loops_and_numpy_agree_within_their_bounds(family: str, law: Any) -> None:
    asked = question(family, law)
    values = tile(asked, family)
    quick = GrowthKernel(asked, quick=True)
    assert quick.compiled
    found, wanted = quick(values), GrowthKernel(asked)(values)
    assert (np.abs(found.abscissa - wanted.abscissa) <= found.error + wanted.error).all()
    assert np.abs(found.frequency - wanted.frequency).max() <= 1e-10 * wanted.frequency.max()
    assert found.handed_on <= wanted.handed_on
    assert np.isfinite(found.error).all()
    codes = FilteredVerdicts(asked).codes(values)[0].ravel()
    assert (codes[found.abscissa > found.error] == CODES[Verdict.UNSTABLE]).all()
    assert (codes[found.abscissa < -found.error] == CODES[Verdict.STABLE]).all()
    # what is asked of a cell's bound; any other is as good as NumPy's
    modes = GrowthKernel(asked, modes=True)(values).values
    enough = loops.WANTED * (np.abs(modes.real) + np.abs(modes.imag)).max(axis=1)
    assert (found.error <= np.maximum(2 * wanted.error, 1.000001 * enough)).all()
    assert found.codes is not None
    assert ((found.codes == codes) | (found.codes == 0)).all()
    assert (found.codes == 0).mean() < 0.01


@needs_numba
@pytest.mark.parametrize(("family", "law"), CASES, ids=names)
def test_random_cells_hold_against_balls(family: str, law: Any) -> None:
    asked = question(family, law)
    values = tile(asked, family)
    found = GrowthKernel(asked, quick=True)(values)
    assert found.codes is not None
    for cell in np.random.default_rng(9).choice(found.abscissa.size, 12, replace=False):
        one = {n: float(np.broadcast_to(v, (40, 150)).ravel()[cell]) for n, v in values.items()}
        exact = certify(asked, one)
        off = abs(exact.eigenvalues[-1].real - found.abscissa[cell])
        assert off <= found.error[cell] + exact.abscissa_error
        assert found.codes[cell] in (0, exact.verdict.code)


@needs_numba
@pytest.mark.parametrize("law", [st.Viscous, st.Smooth()], ids=["viscous", "smooth"])
def test_verdicts_of_compiled_maps_are_those_of_the_conditions(
    law: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.maps.cells as module

    # a boundary runs along the middle column, where only exact arithmetic decides
    y = ("k", 0.1, 0.5, 40) if isinstance(law, st.Smooth) else ("mu", 0.2, 3, 40)
    axes = {"x": ("at", 0.4, 3.6, 121), "y": y, "contact": law, "boundaries": False}
    by_conditions = st.stability_map("spinning", **axes)
    monkeypatch.setattr(module, "COMPILED_FROM", 2000)
    by_loops = st.stability_map("spinning", **axes)
    assert "compiled" in by_loops.method and "compiled" not in by_conditions.method
    np.testing.assert_array_equal(by_loops.verdict, by_conditions.verdict)
    assert len(np.unique(by_loops.verdict)) > 1


@needs_numba
@pytest.mark.parametrize("family", FAMILIES)
def test_bounds_of_the_loops_hold_against_mpmath(family: str) -> None:
    asked = question(family, st.Viscous(1.0), st.Disk(k=0.3))
    values = tile(asked, family, 61, 30)
    found = GrowthKernel(asked, quick=True)(values)
    closest = 0.0
    for cell in np.random.default_rng(4).choice(found.abscissa.size, 4, replace=False):
        row, column = divmod(int(cell), 61)
        at, mu = float(values["at"][0, column]), float(values["mu"][row, 0])
        with mpmath.workdps(DIGITS):
            coefficients = reduced_truth(family, "viscous", at, 0.3, mu)
            roots = mpmath.polyroots(coefficients[::-1], maxsteps=3000, extraprec=3000)
            off = abs(max(mpmath.re(r) for r in roots) - mpmath.mpf(float(found.abscissa[cell])))
            assert off <= found.error[cell] <= 1.01e-13 * max(abs(r) for r in roots)
            closest = max(closest, float(off / found.error[cell]))
    assert closest > 1e-4  # not idle


@needs_numba
@pytest.mark.parametrize("family", ["rolling", "spinning"])
def test_tiles_over_a_boundary_are_right_on_both_sides(family: str) -> None:
    edge = {"rolling": (1 / 1.2) ** 0.5, "spinning": (1 / 0.3) ** 0.5}[family]
    for width in (1e-3, 1e-8, 1e-13):
        asked = question(family, st.Viscous(1.0), st.Disk(k=0.3))
        at = np.unique(edge * (1 + width * np.linspace(-1, 1, 41)))
        values = dict(asked.values) | {"at": at[None, :], "mu": np.linspace(0.5, 0.9, 9)[:, None]}
        found = GrowthKernel(asked, quick=True)(values)
        codes = FilteredVerdicts(asked).codes(values)[0].ravel()
        signs = np.where(found.abscissa > 0, CODES[Verdict.UNSTABLE], CODES[Verdict.STABLE])
        proved = np.abs(found.abscissa) > found.error
        assert (signs == codes)[proved].all()
        assert proved.mean() > 0.99
        cell = int(np.random.default_rng(1).integers(codes.size))
        one = {n: float(np.broadcast_to(v, (9, len(at))).ravel()[cell]) for n, v in values.items()}
        exact = certify(asked, one)
        off = abs(exact.eigenvalues[-1].real - found.abscissa[cell])
        assert off <= found.error[cell] + exact.abscissa_error


def block(roots: list[complex], error: float) -> Any:
    """A page on which every cell has the polynomial of these roots, and factors near them."""
    w, n = np.zeros(loops.PAGE), len(roots)
    for i, c in enumerate(np.poly(roots).real[::-1][:-1]):
        w[loops.A + i * SIDE : loops.A + (i + 1) * SIDE] = c
        w[loops.E + i * SIDE : loops.E + (i + 1) * SIDE] = error
    near, z = np.full(n, np.nan), np.zeros(n, dtype=complex)
    for j in range(SIDE):
        loops_().rescue(n, j, near, z, w)
    return w


POLYNOMIALS = [
    [-3, -2, -1, 2, 5],
    [-1, -1 + 2j, -1 - 2j, 3j, -3j],
    [4, -1, -2, 1 + 1j, 1 - 1j],
    [-0.25, 0.5 + 8j, 0.5 - 8j],
    [-3, 1, 2],
    [-4096, -64, -1, 0.125, 8],
]


@needs_numba
@pytest.mark.parametrize("roots", POLYNOMIALS, ids=str)
def test_discs_of_the_loops_hold_known_roots(roots: list[complex]) -> None:
    w, n = block(roots, 0.0), len(roots)
    loops_().discs(n, 0, w)
    lines = [
        w[at : at + n * SIDE].reshape(n, SIDE) for at in (loops.REAL, loops.IMAG, loops.RADIUS)
    ]
    real, imag, radius = (line[:, 7] for line in lines)
    assert radius.max() < 1e-11 * max(map(abs, roots))
    distance = np.abs(
        real[:, None]
        + 1j * imag[:, None]
        - np.array([complex(r.real, abs(r.imag)) for r in map(complex, roots)])
    )
    assert (distance <= radius[:, None]).any(axis=1).all()
    assert (distance <= radius[:, None]).any(axis=0).all()
    a = [np.array([c]) for c in np.poly(roots).real[::-1][:-1]]
    plain = np.sort(np.ravel(enclose(a, [0 * c for c in a], settle(a, start(a))).radius))
    assert radius.sum() < 10 * plain.sum() + 1e-13 * max(map(abs, roots))


@needs_numba
@pytest.mark.parametrize("roots", POLYNOMIALS, ids=str)
def test_discs_are_as_large_as_those_of_numpy(roots: list[complex]) -> None:
    w, n = block(roots, 1e-9), len(roots)
    loops_().discs(n, 0, w)
    some = [w[at : at + n * SIDE : SIDE] for at in (loops.A, loops.F, loops.RADIUS)]
    a, f = ([v.reshape(1) for v in line.copy()] for line in some[:2])
    known = Factors(f[0], list(zip(f[1::2], f[2::2], strict=True)))
    plain = enclose(a, [np.array([1e-9]) for _ in a], known)
    assert np.allclose(some[2], np.ravel(plain.radius), rtol=1e-4)


@needs_numba
@pytest.mark.parametrize("roots", [[-1, -1, -2, -3, -4], [-1, 1j, -1j, 1j, -1j], [2, -1, -1]])
def test_clusters_get_no_bound(roots: list[complex]) -> None:
    w = block(roots, 1e-16)
    loops_().discs(len(roots), 0, w)
    assert np.isinf(w[loops.RADIUS : loops.RADIUS + len(roots) * SIDE]).any()
    loops_().rate(len(roots), w)
    assert np.isinf(w[loops.ERROR : loops.ERROR + SIDE]).all()


@needs_numba
@pytest.mark.parametrize("degree", [3, 5])
def test_distances_that_overflow_give_no_bound(degree: int) -> None:
    roots = [-(1e78 if degree == 3 else 1e39) * (i + 1) for i in range(degree)]
    w = np.zeros(loops.PAGE)
    known = [roots[0]]
    for one, two in zip(roots[1::2], roots[2::2], strict=True):
        known += [-(one + two), one * two]
    for i, (c, f) in enumerate(zip(np.poly(roots)[::-1], known, strict=False)):
        w[loops.A + i * SIDE : loops.A + (i + 1) * SIDE] = c
        w[loops.F + i * SIDE : loops.F + (i + 1) * SIDE] = f
    loops_().discs(degree, 0, w)
    assert not (w[loops.RADIUS : loops.RADIUS + degree * SIDE] < np.inf).any()
    a = [np.array([c]) for c in np.poly(roots)[::-1][:-1]]
    pairs = [(np.array([p]), np.array([q])) for p, q in zip(known[1::2], known[2::2], strict=True)]
    with np.errstate(all="ignore"):
        plain = enclose(a, [0 * c for c in a], Factors(np.array([roots[0]]), pairs))
    assert not (np.array(plain.radius) < np.inf).any()


@needs_numba
@pytest.mark.parametrize("place", [loops.A, loops.E, loops.F, loops.F + SIDE])
def test_what_is_no_number_gets_no_bound(place: int) -> None:
    w = block(POLYNOMIALS[0], 0.0)
    w[place + 3] = np.nan
    loops_().discs(5, 0, w)
    loops_().rate(5, w)
    error = w[loops.ERROR : loops.ERROR + SIDE]
    assert not error[3] < np.inf
    assert (np.delete(error, 3) < 1e-10).all()


def exact_pages(family: str, behind: Any, random: Any) -> Iterator[tuple[Any, ...]]:
    """Tables, a page with random variables, and each factor's monic coefficients over Q."""
    asked = question(family, st.Viscous(1.0))
    tables = rates.tables(asked.exact, behind)
    assert tables is not None
    w = np.zeros(loops.PAGE)
    ends = {"k": (0.01, 0.5), "M": (1e-3, 1e3), "z": (0.01, 20.0), "s": (0.01, 1.0)}
    variables = asked.exact.known.variables
    point = {n: np.exp(random.uniform(*np.log(ends[n]), SIDE)) for n in variables}
    low = {n: v * random.uniform(-1, 1, SIDE) * 2.0**-54 for n, v in point.items()}
    for level, i in enumerate(tables.order):
        at = loops.VARIABLE + level * SIDE
        w[at : at + SIDE] = point[variables[i]]
        at += loops.LOW_VARIABLE
        w[at : at + SIDE] = low[variables[i]]
    for factor in sorted(asked.exact.known.factors, key=len, reverse=True):
        row = tables.factors[[len(factor) - 1 == n for n in tables.factors[:, 1]].index(True)]
        yield tables, row, w, factor, [point[n] for n in variables], [low[n] for n in variables]


@needs_numba
@pytest.mark.parametrize("long", [False, True])
@pytest.mark.parametrize("family", FAMILIES)
def test_bounds_of_coefficients_hold_over_q_and_are_not_idle(family: str, long: bool) -> None:
    closest, worst = 0.0, Fraction(0)
    for tables, (first, count), w, factor, high, low in exact_pages(
        family, PLAIN, np.random.default_rng(6)
    ):
        run = loops_().long_coefficients if long else loops_().coefficients
        run(*tables[:4], first, count, *(() if long else (False,)), w)
        for j in range(0, SIDE, 4):
            at = [
                Fraction(h[j]) + (Fraction(x[j]) if long else 0)
                for h, x in zip(high, low, strict=True)
            ]
            truth = [c(*at) for c in factor]
            for i in range(count):
                exact = Fraction(truth[i]) / truth[-1]
                off = abs(Fraction(float(w[loops.A + i * SIDE + j])) - exact)
                bound = Fraction(float(w[loops.E + i * SIDE + j]))
                assert off <= bound
                closest = max(closest, float(off / bound) if bound else 0.0)
                if exact:
                    worst = max(worst, bound / abs(exact))
    assert closest > 0.02
    if long:  # five roundings, where the cancellation leaves ten digits at most
        assert worst < Fraction(1, 10**12)


def worst_quotients(long: bool, random: Any) -> tuple[Any, Any]:
    """Of millions of numbers x and y, pairs for which x·(1/y) is farthest from their quotient.

    For pairs of doubles x and y are rounded before; shape (high and low part, cells).
    """
    found: list[Any] = []
    for _ in range(40):
        high = 1 + random.uniform(0, 2.0**-4 if long else 1, (2, 100_000))
        low = random.uniform(-1, 1, high.shape) * 2.0**-53 * long
        high, low = high + low, low - ((high + low) - high)  # what rounding leaves
        x, y = high
        (u, v), (a, b) = high.astype(np.longdouble), low.astype(np.longdouble)
        truth = (u + a) / (v + b)
        off = np.abs(((x * (1 / y)).astype(np.longdouble) - truth) / truth).astype(float)
        best = np.argsort(off)[-SIDE:]
        found.append((off[best], high[:, best], low[:, best]))
    off, high, low = (np.concatenate(v, axis=-1) for v in zip(*found, strict=True))
    best = np.argsort(off)[-SIDE:]
    return high[:, best], low[:, best]


@pytest.mark.few(1)
@needs_numba
@pytest.mark.parametrize(
    ("long", "units"),
    [(False, 2), pytest.param(True, 4, marks=needs_long)],
    ids=["doubles", "pairs"],
)
def test_the_bound_counts_each_rounding_of_a_quotient_by_one_inverse(
    long: bool, units: int
) -> None:
    """Exact coefficients: their quotient's roundings alone are in the bound, and are all needed."""
    w = np.zeros(loops.PAGE)
    high, low = worst_quotients(long, np.random.default_rng(3))
    for v in range(2):
        at = loops.VARIABLE + v * SIDE
        w[at : at + SIDE] = high[v]
        w[at + loops.LOW_VARIABLE : at + loops.LOW_VARIABLE + SIDE] = low[v]
    steps = np.array(
        [[loops.SCALE, 1, 0], [loops.SET, 1, 0], [loops.SCALE, 1, 1], [loops.SET, 1, 0]]
    )
    numbers, parts = np.array([1.0, 0.0, 1.0, 0.0]), np.array([[0, 1, 2], [2, 3, 4]])
    run = loops_().long_coefficients if long else loops_().coefficients
    run(steps, numbers, parts, np.zeros(2), 0, 1, *(() if long else (False,)), w)
    shares = []
    for j in range(SIDE):
        x, y = (Fraction(float(high[v, j])) + Fraction(float(low[v, j])) for v in range(2))
        off = abs(Fraction(float(w[loops.A + j])) - x / y)
        bound = Fraction(float(w[loops.E + j]))
        assert off <= bound
        shares.append(off / bound)
    # with one rounding less the bound would be broken
    assert max(shares) > Fraction(units - 1, units)


@needs_numba
@needs_long
def test_pairs_of_doubles_spare_the_slow_route() -> None:
    asked = question("tumbling", st.Viscous(1.0))
    kernel = GrowthKernel(asked, quick=True)
    values = dict(asked.values) | {
        "at": np.linspace(0.8, 1.5, 200)[None, :],
        "mu": np.linspace(0.2, 0.5, 60)[:, None],
    }
    _, poor, _, _ = kernel._quick(values, (60, 200))
    assert len(poor) < 20
    known = kernel._loops
    assert known is not None
    unrefined = known(point(asked, values), kernel._unit(values), (60, 200))
    assert unrefined is not None
    assert len(unrefined.poor) > 500


def test_without_numba_numpy_computes_the_map(monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.maps.growth_rates as module

    asked = question("rolling", st.Viscous(1.0))
    values = tile(asked, "rolling", 30, 20)
    wanted = GrowthKernel(asked)(values)
    monkeypatch.setattr(module, "numba_found", lambda: False)
    without = GrowthKernel(asked, quick=True)
    assert not without.compiled
    assert (without(values).abscissa == wanted.abscissa).all()


@needs_numba
@pytest.mark.parametrize("extreme", [1e-200, 1e-160, 1e-20, 1e25, 1e160])
def test_what_may_under_or_overflow_goes_to_numpy(extreme: float) -> None:
    asked = question("rolling", st.Viscous(1.0))
    kernel = GrowthKernel(asked, quick=True)
    values = dict(asked.values) | {"at": np.array([[0.7, 1.0]]), "mu": np.array([[extreme]])}
    with np.errstate(all="ignore"):
        assert kernel._quick(values, (1, 2)) is None


@needs_numba
def test_a_large_map_says_that_loops_computed_it(monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.maps.cells as module

    axes = {"x": ("at", 0.5, 5, 50), "y": ("mu", 0.1, 3, 41, "log")}
    small = st.stability_map("spinning", **axes, boundaries=False)
    monkeypatch.setattr(module, "COMPILED_FROM", 2000)
    large = st.stability_map("spinning", **axes, boundaries=False)
    assert "compiled loops" in large.attrs["method"]
    assert "compiled loops" not in small.attrs["method"]
    assert (large.verdict == small.verdict).all()
    bound = large.abscissa_error + small.abscissa_error
    assert (np.abs(large.abscissa - small.abscissa) <= bound).all()
    with_modes = st.stability_map("spinning", **axes, boundaries=False, modes=True)
    assert "compiled loops" not in with_modes.attrs["method"]


@needs_numba
def test_a_tile_is_the_same_in_pieces_of_rows_within_bounds_and_in_any_width() -> None:
    """Blocks that are cut off by the end of a row hold the same numbers."""
    asked = question("tumbling", st.Viscous(1.0))
    kernel = GrowthKernel(asked, quick=True)
    at, mu = np.linspace(0.1, 1.5, 2 * SIDE + 5), np.linspace(0.1, 1.0, 12)
    whole = kernel(dict(asked.values) | {"at": at[None, :], "mu": mu[:, None]})
    for count in (1, 2, SIDE - 1, SIDE, SIDE + 1):
        some = kernel(dict(asked.values) | {"at": at[None, :count], "mu": mu[5:, None]})
        wanted = whole.abscissa.reshape(12, -1)[5:, :count].ravel()
        bound = some.error + whole.error.reshape(12, -1)[5:, :count].ravel()
        assert (np.abs(some.abscissa - wanted) <= bound).all()


def test_schemes_have_the_steps_of_the_polynomials_source() -> None:
    """Steps run one by one over integers give the polynomial."""
    asked = question("tumbling", st.Viscous(1.0))
    for part in (p for c in asked.exact.known.factors[0] for p in c.parts):
        steps, numbers = rates.scheme(part)
        lines: dict[int, int] = {}
        at = [3, 5, 7]
        for (what, level, variable), number in zip(steps, numbers, strict=True):
            own, below, one = lines.get(level, 0), lines.get(level - 1, 0), at[variable]
            lines[level] = {
                loops.SET: int(number),
                loops.PLUS: own + int(number),
                loops.ADD: own + below,
                loops.COPY: below,
                loops.TIMES: own * one,
                loops.SCALE: int(number) * one,
                loops.PRODUCT: below * one,
            }[what]
        assert lines[level] == part(*at)  # on the line of the last step
        assert part.roundings(INPUT) >= part.roundings(PLAIN)
