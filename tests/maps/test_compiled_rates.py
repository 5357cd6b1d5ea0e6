"""Compiled loops: within the same bounds as exact arithmetic, mpmath and the NumPy route."""

from fractions import Fraction
from importlib.util import find_spec
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
from spectrum_oracle import DIGITS, exact_codes, reduced_truth

import stability as st
from stability.algebra.kernels import pairs
from stability.algebra.kernels.compiled import compiled
from stability.algebra.real_factors import Factors, enclose, settle, start
from stability.base.axis import Axis
from stability.base.verdict import CODES, Verdict
from stability.maps.compiled import factors, loops
from stability.maps.compiled.rates import CompiledRates, of_coefficients
from stability.maps.engine import SliceCells, slice_cells
from stability.maps.rates import PROVED, WANTED, Rates, rates
from stability.spectra.certificate import certify
from stability.spectra.problem import disk_problem
from stability.tables.benchmarks.bicycle import BENCHMARK, bicycle

SIDE = loops.SIDE
FAMILIES = ["rolling", "spinning", "tumbling"]
RANGES = {"rolling": (0.1, 4.0), "spinning": (0.3, 6.0), "tumbling": (0.01, 1.57)}
LAWS = [st.Viscous(0.7), st.LinearViscous(0.7), st.Rough(), st.Smooth()]
CASES = [(f, law) for f in FAMILIES for law in LAWS]
CASES += [("circling", st.Rough()), ("precession", st.Smooth())]
needs_long = pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long double is double")
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")


def pendula() -> st.Family:
    """Two coupled pendula with exponential forces: no polynomial in the axes exists."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    pull = ca.exp(-p[0]) * (ca.sin(x[0] + p[1]) - ca.sin(p[1]))
    first = -pull - 0.3 * ca.tanh(p[0] * x[2]) + 0.1 * x[1]
    second = -ca.sinh(x[1]) * ca.cos(p[1]) - 0.1 * p[1] * x[3] + 0.1 * x[0]
    names = {"states": ("q1", "q2", "v1", "v2"), "parameters": ("a", "b")}
    system = st.System("pendula", x, p, ca.vertcat(x[2], x[3], first, second), **names)
    return st.Family(system, "rest", at=("a",), held=dict.fromkeys(system.states, 0.0))


MAPS: list[tuple[str, Any, dict[str, Any], bool]] = [
    (
        "torus",
        "tumbling",
        {"body": st.Torus(0.2), "x": ("at", 0.05, 1.55, 150), "y": ("mu", 0.05, 3, 40)},
        True,
    ),
    (
        "egg",
        "rolling",
        {"body": st.Egg(0.2), "x": ("at", 0.2, 3.0, 150), "y": ("mu", 0.05, 3, 40)},
        True,
    ),
    (
        "bicycle",
        bicycle(),
        {"x": ("v", 0.1, 10, 150), "y": ("g", 1, 20, 40)}
        | {n: float(v) for n, v in BENCHMARK.items() if n != "g"},
        True,
    ),
    ("pendula", pendula(), {"x": ("a", -1, 2, 150), "y": ("b", -1, 1.4, 40)}, False),
]
"""Name, family, what is asked, and whether the method of the map names the loops."""


def names(case: Any) -> str:
    return case if isinstance(case, str) else case.name


def loops_() -> Any:
    return compiled(pairs, factors, loops)


def question(family: str, law: Any, disk: Any = None) -> Any:
    at = (0.9, 0.7) if family in ("circling", "precession") else 1.0
    return disk_problem(family, disk or st.Disk(k=0.3), law, at)


def tile(asked: Any, family: str, columns: int = 150, rows: int = 40) -> dict[str, Any]:
    """Values of two axes by name, x first."""
    second = next(n for n in ("mu", "c", "k") if n in asked.values)
    low, high = (0.01, 0.5) if second == "k" else (0.01, 30.0)
    first, ends = ("theta", (0.1, 1.5)) if family not in RANGES else ("at", RANGES[family])
    return {first: np.linspace(*ends, columns), second: np.geomspace(low, high, rows)}


def cells(asked: Any, lines: dict[str, Any], *, quick: bool, modes: bool = False) -> SliceCells:
    axes = [Axis(n, float(v.min()), float(v.max()), max(2, len(v))) for n, v in lines.items()]
    found = slice_cells(asked, (axes[0], axes[1]), modes)
    assert found is not None
    if quick:
        rows = [row for row, _, _ in found._factors]
        found.loops = CompiledRates.of(rows, even=found.verdicts.slice.even)
        assert found.loops is not None
    return found


def computed(asked: Any, lines: dict[str, Any], *, quick: bool, modes: bool = False) -> Rates:
    codes, _, found = cells(asked, lines, quick=quick, modes=modes).judged(*lines.values())
    return found._replace(codes=codes)


def swept(asked: Any, lines: dict[str, Any]) -> dict[str, Any]:
    """Values of all cells by name, flat."""
    x, y = lines.values()
    some = dict(zip(lines, (v.ravel() for v in np.meshgrid(x, y)), strict=True))
    return dict(asked.values) | some


def one(asked: Any, lines: dict[str, Any], cell: int) -> dict[str, float]:
    return {n: float(v[cell]) if np.ndim(v) else float(v) for n, v in swept(asked, lines).items()}


@pytest.mark.few(1)
@needs_numba
@pytest.mark.parametrize(("family", "law"), CASES, ids=names)
def test_loops_and_numpy_agree_within_their_bounds(family: str, law: Any) -> None:
    asked = question(family, law)
    lines = tile(asked, family)
    found, wanted = (computed(asked, lines, quick=quick) for quick in (True, False))
    assert (np.abs(found.abscissa - wanted.abscissa) <= found.error + wanted.error).all()
    assert np.abs(found.frequency - wanted.frequency).max() <= 1e-10 * wanted.frequency.max()
    assert np.isfinite(found.error).all()
    codes = exact_codes(asked, swept(asked, lines))
    assert (found.codes == codes).all() and (wanted.codes == codes).all()
    assert (codes[found.abscissa > found.error] == CODES[Verdict.UNSTABLE]).all()
    assert (codes[found.abscissa < -found.error] == CODES[Verdict.STABLE]).all()
    # what is asked of a cell's bound; any other is as good as NumPy's
    modes = computed(asked, lines, quick=False, modes=True).values
    assert modes is not None
    enough = PROVED * (np.abs(modes.real) + np.abs(modes.imag)).max(axis=1)
    assert (found.error <= np.maximum(2 * wanted.error, 1.000001 * enough)).all()
    alone = cells(asked, lines, quick=True)._swept(*lines.values(), None)
    assert alone is not None
    assert ((alone.codes == codes) | (alone.codes == 0)).all()
    assert (alone.codes == 0).mean() < 0.01


@needs_numba
@pytest.mark.parametrize(("family", "law"), CASES, ids=names)
def test_random_cells_hold_against_balls(family: str, law: Any) -> None:
    asked = question(family, law)
    lines = tile(asked, family)
    found = computed(asked, lines, quick=True)
    for cell in np.random.default_rng(9).choice(found.abscissa.size, 12, replace=False):
        exact = certify(asked, one(asked, lines, cell))
        off = abs(exact.eigenvalues[-1].real - found.abscissa[cell])
        assert off <= found.error[cell] + exact.abscissa_error
        assert found.codes[cell] == exact.verdict.code


@needs_numba
@pytest.mark.parametrize("law", [st.Viscous, st.Smooth()], ids=["viscous", "smooth"])
def test_verdicts_of_compiled_maps_are_those_of_the_conditions(
    law: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.maps.engine as module

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
    lines = tile(asked, family, 61, 30)
    found = computed(asked, lines, quick=True)
    closest = 0.0
    for cell in np.random.default_rng(4).choice(found.abscissa.size, 4, replace=False):
        row, column = divmod(int(cell), 61)
        at, mu = float(lines["at"][column]), float(lines["mu"][row])
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
        lines = {"at": at, "mu": np.linspace(0.5, 0.9, 9)}
        found = computed(asked, lines, quick=True)
        codes = exact_codes(asked, swept(asked, lines))
        signs = np.where(found.abscissa > 0, CODES[Verdict.UNSTABLE], CODES[Verdict.STABLE])
        proved = np.abs(found.abscissa) > found.error
        assert (signs == codes)[proved].all()
        assert proved.mean() > 0.99
        cell = int(np.random.default_rng(1).integers(codes.size))
        exact = certify(asked, one(asked, lines, cell))
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
    [-1 + 2j, -1 - 2j, 3j, -3j],
    [-3, -1, 2, 5],
    [-0.25, 4, 0.5 + 8j, 0.5 - 8j],
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
    known = Factors.of(f)
    plain = enclose(a, [np.array([1e-9]) for _ in a], known)
    assert np.allclose(some[2], np.ravel(plain.radius), rtol=1e-4)


@needs_numba
@pytest.mark.parametrize("degree", [3, 4, 5])
def test_loops_over_coefficients_hold_against_mpmath_and_leave_what_is_none(degree: int) -> None:
    """Smooth coefficients over a grid, rounded, of which some cells have none."""
    columns, random = SIDE + 37, np.random.default_rng(degree)
    x, y = np.meshgrid(np.linspace(-1, 1, columns), np.linspace(-1, 1, 30))
    a = np.array(
        [
            v @ [1 + 0 * x.ravel(), x.ravel(), y.ravel(), (x * y).ravel()]
            for v in random.normal(size=(degree, 4))
        ]
    )
    e = 1e-15 * np.abs(a)
    a[0, 7 * columns : 7 * columns + 50] = np.nan
    found = of_coefficients((a, e), columns, WANTED)
    none = np.isnan(a[0])
    assert found.poor[none].all() and found.poor.mean() < 0.1 + none.mean()
    with np.errstate(all="ignore"):
        wanted = rates([((a, e), False, 1)], x.shape, modes=False)
    good = ~(found.poor | wanted.poor)
    assert (np.abs(found.abscissa - wanted.abscissa) <= found.error + wanted.error)[good].all()
    assert (found.codes == wanted.codes)[good & (wanted.codes != 0)].all()
    for cell in random.choice(np.flatnonzero(~found.poor), 40, replace=False):
        with mpmath.workdps(40):
            roots = mpmath.polyroots(
                [1, *map(mpmath.mpf, a[::-1, cell].tolist())], 500, extraprec=500
            )
            top = max(roots, key=lambda root: (root.real, abs(root.imag)))
            assert abs(top.real - float(found.abscissa[cell])) <= found.error[cell]
            assert abs(abs(top.imag) - float(found.frequency[cell])) <= 1e-9 * abs(top)


@needs_numba
@pytest.mark.parametrize("asked", MAPS, ids=lambda asked: asked[0])
def test_maps_by_loops_over_coefficients_are_those_of_numpy(
    asked: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.maps.engine as module

    _, family, axes, method = asked
    small = st.stability_map(family, **axes, boundaries=False)
    monkeypatch.setattr(module, "COMPILED_FROM", 2000)
    taken: list[int] = []
    plain = module.of_coefficients

    def counted(some: Any, *more: Any) -> Rates:
        taken.append(len(some[0][0]))
        return plain(some, *more)

    monkeypatch.setattr(module, "of_coefficients", counted)
    large = st.stability_map(family, **axes, boundaries=False)
    assert sum(taken) >= 0.9 * large.verdict.size
    assert ("compiled loops" in large.attrs["method"]) == method
    assert (large.verdict == small.verdict).all() and len(np.unique(large.verdict)) > 1
    bound = large.abscissa_error + small.abscissa_error
    off = np.abs(large.abscissa - small.abscissa)
    assert ((off <= bound) | np.isnan(off)).all()


@needs_numba
@pytest.mark.parametrize(
    "roots",
    [[-1, -1, -2, -3, -4], [-1, 1j, -1j, 1j, -1j], [2, -1, -1], [1j, -1j, 1j, -1j], [-1, -1, 2, 3]],
)
def test_clusters_get_no_bound(roots: list[complex]) -> None:
    w = block(roots, 1e-16)
    loops_().discs(len(roots), 0, w)
    assert np.isinf(w[loops.RADIUS : loops.RADIUS + len(roots) * SIDE]).any()
    loops_().rate(len(roots), w)
    assert np.isinf(w[loops.ERROR : loops.ERROR + SIDE]).all()


@needs_numba
@pytest.mark.parametrize("degree", [3, 4, 5])
def test_distances_that_overflow_give_no_bound(degree: int) -> None:
    roots = [-{3: 1e78, 4: 1e52, 5: 1e39}[degree] * (i + 1) for i in range(degree)]
    w, odd = np.zeros(loops.PAGE), degree % 2
    known = roots[:odd]
    for one, two in zip(roots[odd::2], roots[odd + 1 :: 2], strict=True):
        known += [-(one + two), one * two]
    for i, (c, f) in enumerate(zip(np.poly(roots)[::-1], known, strict=False)):
        w[loops.A + i * SIDE : loops.A + (i + 1) * SIDE] = c
        w[loops.F + i * SIDE : loops.F + (i + 1) * SIDE] = f
    loops_().discs(degree, 0, w)
    assert not (w[loops.RADIUS : loops.RADIUS + degree * SIDE] < np.inf).any()
    a = [np.array([c]) for c in np.poly(roots)[::-1][:-1]]
    with np.errstate(all="ignore"):
        plain = enclose(a, [0 * c for c in a], Factors.of([np.array([v]) for v in known]))
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


@needs_numba
@pytest.mark.parametrize("family", FAMILIES)
def test_bounds_of_coefficients_hold_over_q_and_are_not_idle(family: str) -> None:
    asked = question(family, st.Viscous(1.0), st.Disk(k=0.25))
    random, closest = np.random.default_rng(6), 0.0
    # of spinning and rolling both variables are exact; tumbling has the sine of a double
    lines = {"at": np.sort(random.uniform(*RANGES[family], SIDE)), "mu": np.geomspace(0.01, 30, 9)}
    known = cells(asked, lines, quick=True)
    assert known.loops is not None
    high, degrees, bounds, starts = known.loops.table
    t, s = (w(v) for w, v in zip(known.windows, lines.values(), strict=True))
    line, sizes, w = np.zeros(high.shape[:2]), np.zeros(high.shape[:2]), np.zeros(loops.PAGE)
    w[loops.PLACE : loops.PLACE + SIDE] = t
    for row in range(0, 9, 2):
        loops_().along(high, degrees, s[row], line, sizes)
        for (first, count), place in zip(starts, known.loops.order, strict=True):
            factor = asked.exact.known.factors[place]
            loops_().coefficients(line, sizes, degrees, bounds, first, count, False, w)
            for j in range(0, SIDE, 8):
                mu = Fraction(float(lines["mu"][row]))
                with mpmath.workdps(60):
                    number = Fraction(float(lines["at"][j])) ** 2
                    if family == "tumbling":
                        number = Fraction(int(mpmath.sin(lines["at"][j]) * 2**180), 2**180)
                    truth = [Fraction(c(Fraction(1, 4), mu * mu, number)) for c in factor]
                for i in range(count):
                    exact = truth[i] / truth[-1]
                    off = abs(Fraction(float(w[loops.A + i * SIDE + j])) - exact)
                    bound = Fraction(float(w[loops.E + i * SIDE + j]))
                    assert off <= bound
                    closest = max(closest, float(off / bound))
    assert closest > 0.02


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
    w[loops.A : loops.A + SIDE], w[loops.LEAD : loops.LEAD + SIDE] = high
    loops_().invert(loops.DIVIDED + (loops.EPS if long else 0.0), w)
    loops_().monic(1, w)
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
def test_pairs_of_doubles_spare_the_slow_route() -> None:
    asked = question("tumbling", st.Viscous(1.0))
    lines = {"at": np.linspace(0.8, 1.5, 200), "mu": np.linspace(0.2, 0.5, 60)}
    known = cells(asked, lines, quick=True)
    assert known.loops is not None
    swept_ = known._swept(*lines.values(), None)
    assert swept_ is not None and swept_.poor.sum() < 20
    table, rest = known.loops.table, known.loops.rest
    known.loops.rest = rest * np.nan  # no cell is better for it
    unrefined = known._swept(*lines.values(), None)
    assert unrefined is not None and unrefined.poor.sum() > 200
    assert table is known.loops.table
    refined = ~swept_.poor & unrefined.poor
    for cell in np.random.default_rng(2).choice(np.flatnonzero(refined), 9, replace=False):
        exact = certify(asked, one(asked, lines, cell))
        off = abs(exact.eigenvalues[-1].real - swept_.abscissa[cell])
        assert off <= swept_.error[cell] + exact.abscissa_error


def test_without_numba_numpy_computes_the_map(monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.maps.engine as module

    axes: dict[str, Any] = {"x": ("at", 0.5, 5, 30), "y": ("mu", 0.1, 3, 20), "boundaries": False}
    wanted = st.stability_map("rolling", **axes)
    monkeypatch.setattr(module, "COMPILED_FROM", 0)
    monkeypatch.setattr(module, "numba_found", lambda: False)
    without = st.stability_map("rolling", **axes)
    assert without.drop_attrs().identical(wanted.drop_attrs())


@needs_numba
@pytest.mark.parametrize("least", [1e-200, 1e-40])
def test_what_may_underflow_goes_to_numpy_or_is_poor(least: float) -> None:
    asked = question("rolling", st.Viscous(1.0))
    lines = {"at": np.array([0.7, 1.0]), "mu": np.array([least, 1.0])}
    with np.errstate(all="ignore"):
        found = cells(asked, lines, quick=True)._swept(*lines.values(), None)
    assert (found is None) == (least == 1e-40)
    assert found is None or found.poor.tolist() == [True, True, False, False]
    assert np.isfinite(computed(asked, lines, quick=True).error).all()


@needs_numba
def test_a_large_map_says_that_loops_computed_it(monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.maps.engine as module

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
    at, mu = np.linspace(0.1, 1.5, 2 * SIDE + 5), np.linspace(0.1, 1.0, 12)
    known = cells(asked, {"at": at, "mu": mu}, quick=True)
    _, _, whole = known.judged(at, mu)
    for count in (1, 2, SIDE - 1, SIDE, SIDE + 1):
        _, _, some = known.judged(at[:count], mu[5:])
        wanted = whole.abscissa.reshape(12, -1)[5:, :count].ravel()
        bound = some.error + whole.error.reshape(12, -1)[5:, :count].ravel()
        assert (np.abs(some.abscissa - wanted) <= bound).all()
