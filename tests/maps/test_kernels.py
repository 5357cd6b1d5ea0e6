"""Fast kernels and boxes: what they decide is what exact arithmetic decides, and bounds hold."""

from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from spectrum_oracle import exact_codes, random_points, truth

import stability as st
from stability.algebra.real_factors import Factors, enclose, improve, settle, start
from stability.base.axis import Axis
from stability.base.verdict import CODES, Verdict
from stability.bodies.disk_polynomials import INPUT
from stability.maps.boxes import prove_boxes
from stability.maps.engine import slice_cells
from stability.maps.surfaces import Window
from stability.maps.verdicts import SliceVerdicts, slice_verdicts
from stability.spectra.certificate import certify, verdict
from stability.spectra.problem import disk_problem

FAMILIES = ["rolling", "spinning", "tumbling"]
SI = st.Disk(mass=0.3, radius=0.013, gravity=9.81, k=0.27)


def judge(asked: Any, x: str, y: str, xs: Any, ys: Any) -> SliceVerdicts:
    """Verdicts over the smallest map with these values."""
    ends = [Axis(n, float(v[0]), float(v[-1]), len(v)) for n, v in ((x, xs), (y, ys))]
    found = slice_verdicts(asked, (ends[0], ends[1]))
    assert found is not None
    return found


def grid(asked: Any, x: str, y: str, xs: Any, ys: Any) -> tuple[Any, int]:
    return judge(asked, x, y, xs, ys)(xs, ys)


def question(family: str, disk: Any = None, law: Any = None) -> Any:
    return disk_problem(family, disk or st.Disk(), law or st.Viscous(1.0), 1.0)


@pytest.mark.parametrize("family", FAMILIES)
def test_exact_verdicts_are_those_of_the_graph_in_200_digits(family: str) -> None:
    """The oracle of what follows, against one that shares nothing with it."""
    at, q = random_points(family, 40, seed=32)
    asked = question(family)
    codes = exact_codes(asked, dict(asked.values) | {"at": at[:, 0], "mu": q[:, 1], "k": q[:, 0]})
    for i, code in enumerate(codes):
        assert code == CODES[truth(family, float(at[i, 0]), float(q[i, 0]), float(q[i, 1]))]


@pytest.mark.parametrize(
    ("family", "edge"), [("rolling", 2**0.5), ("spinning", 2.0), ("tumbling", 0.0)]
)
def test_grids_packed_around_a_boundary_are_decided_rightly(family: str, edge: float) -> None:
    low, high = 0.5, 0.9
    if family == "tumbling":
        [found] = st.boundaries("tumbling", axis=("at", 0.9, 1.2, 9), contact=st.Viscous(1.5))
        edge, low, high = found.value, 1.5 * (1 - 1e-15), 1.5 * (1 + 1e-15)
    asked = question(family)
    xs = edge * (1 + np.linspace(-1, 1, 25) * 1e-14)
    ys = np.linspace(low, high, 9)
    codes, exact = grid(asked, "at", "mu", np.unique(xs), np.unique(ys))
    # pairs of doubles leave the boundary itself alone, on which a cell lies only at at = 2
    assert (exact > 0) == (family == "spinning")
    kinds = set()
    for (i, j), code in np.ndenumerate(codes):
        one = dict(asked.values) | {"at": float(np.unique(xs)[j]), "mu": float(np.unique(ys)[i])}
        found_verdict = verdict(asked, one)
        assert code == CODES[found_verdict]
        kinds.add(found_verdict)
    assert {Verdict.STABLE, Verdict.UNSTABLE} <= kinds


@pytest.mark.few(40)
@pytest.mark.parametrize("law", [None, st.LinearViscous(0.4), st.Rough(), st.Smooth()])
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("names", [("at", "k"), ("k", "at"), ("radius", "gravity"), ("at", "mass")])
def test_tiles_say_what_cells_say(family: str, names: tuple[str, str], law: Any) -> None:
    ends = {
        "at": (0.05, 1.5),
        "k": (0.01, 0.5),
        "radius": (0.3, 3.0),
        "gravity": (0.5, 20.0),
        "mass": (0.1, 4.0),
    }
    asked = question(family, law=law)
    xs, ys = (np.linspace(*ends[n], count) for n, count in zip(names, (70, 45), strict=True))
    codes, _ = grid(asked, *names, xs, ys)
    swept = dict(asked.values) | {names[0]: xs[None, :], names[1]: ys[:, None]}
    assert (codes == exact_codes(asked, swept)).all()


def test_upright_is_handed_to_exact_arithmetic() -> None:
    asked = disk_problem("tumbling", st.Disk(), st.Viscous(0.6), lean=0.0)
    for lean in (np.array([-1e-9, 0.0, 1e-30]), np.linspace(-1e-3, 1e-3, 41)):
        codes = exact_codes(asked, dict(asked.values) | {"lean": lean})
        wanted = np.where(lean == 0, CODES[Verdict.NEUTRAL], CODES[Verdict.STABLE])
        assert (codes == wanted).all()
        cells, _ = grid(asked, "lean", "mu", lean, np.array([0.6, 0.7]))
        assert (cells == wanted).all()


@pytest.mark.long
@pytest.mark.parametrize("ends", [(0, 1), (-1, 1)])
def test_a_map_over_the_lean_may_have_cells_exactly_upright(ends: tuple[float, float]) -> None:
    for certify_ in (False, True):
        found = st.stability_map(
            "tumbling", x=("lean", *ends, 5), y=("mu", 0.1, 2, 6), certify=certify_
        )
        upright = found.verdict.sel(lean=0.0).values
        wanted = [
            st.spectrum("tumbling", lean=0.0, contact=st.Viscous(float(m)), certify=True)
            for m in found.mu
        ]
        assert upright.tolist() == [int(w.codes) for w in wanted]
        assert found.sizes["boundary_point"] > 0


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("x", "y"),
    [
        (("at", 1, 1e300, 5), ("mu", 0.1, 2, 5)),
        (("at", 1, 4, 5), ("mu", 1e-300, 1e300, 7, "log")),
        (("at", 1, 4, 5), ("gravity", 1e-300, 1e300, 7, "log")),
    ],
)
def test_maps_over_hundreds_of_decades_end_in_an_answer(x: Any, y: Any) -> None:
    law = st.Viscous if y[0] == "mu" else st.Viscous(1.0)
    try:
        found = st.stability_map("rolling", x=x, y=y, contact=law, boundaries=False)
    except st.StabilityError as error:
        assert "overflow" in str(error) or "double precision" in str(error)
    else:
        assert np.isfinite(found.abscissa).all()
        assert (found.verdict > 0).all()


def test_circling_without_precession_has_no_member_and_no_verdict(tmp_path: Path) -> None:
    axes = {"x": ("theta", 0.5, 1.5, 5), "y": ("phi_dot", -1, 1, 5)}
    with pytest.raises(st.StabilityError, match="phi_dot = 0"):
        st.stream_map("circling", **axes, contact=st.Rough(), out=tmp_path / "c.nc")
    asked = disk_problem("circling", st.Disk(), st.Rough(), (1.0, 0.7))
    spans = {
        "theta": (np.array([0.5, 0.5]), np.array([0.6, 0.6])),
        "phi_dot": (np.array([-0.1, 0.9]), np.array([0.1, 1.0])),
    }
    judged = judge(asked, "theta", "phi_dot", np.array([0.5, 1.5]), np.array([-1.0, 1.0]))
    assert judged.boxes(spans).tolist() == [0, CODES[Verdict.NEUTRAL]]
    assert list(tmp_path.iterdir()) == []


def test_what_overflows_goes_to_exact_arithmetic() -> None:
    asked = question("spinning")
    mu = np.array([1e100, 1e-100])
    codes = exact_codes(asked, dict(asked.values) | {"mu": mu, "at": 5.0})
    assert codes.tolist() == [CODES[Verdict.UNSTABLE], CODES[Verdict.STABLE]]
    cells, exact = grid(asked, "at", "mu", np.array([4.0, 5.0]), mu[::-1])
    assert cells[:, 1].tolist() == codes[::-1].tolist()
    assert exact > 0


def test_sines_are_as_exact_as_the_bound_assumes() -> None:
    random = np.random.default_rng(1)
    theta = np.exp(random.uniform(np.log(1e-6), np.log(np.pi / 2), 3000))
    with mpmath.workdps(40):
        for x, y, c in zip(theta, np.sin(theta), np.cos(theta), strict=True):
            for function, value in ((mpmath.sin, y), (mpmath.cos, c)):
                truth_ = function(mpmath.mpf(float(x)))
                assert abs((mpmath.mpf(float(value)) - truth_) / truth_) <= INPUT["s"] * 2.0**-53


def test_the_filter_can_be_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """With its bound taken away the filter says something false next to a boundary."""
    asked = question("tumbling")
    [found] = st.boundaries("tumbling", axis=("at", 0.9, 1.2, 9), contact=st.Viscous(1.5))
    at = found.value * (1 + np.linspace(-1, 1, 401) * 1e-15)
    judged = judge(asked, "at", "mu", at, np.array([1.4, 1.6]))
    for one in judged.surfaces:
        monkeypatch.setattr(one, "unit", 0.0)
        monkeypatch.setattr(one, "most", 0.0)
    monkeypatch.setattr(judged, "_exactly", lambda *_: 0)
    rows = np.zeros(len(at), dtype=int)
    codes, _ = judged.at(at, np.array([1.5]), rows, np.arange(len(at)))
    truths = [verdict(asked, dict(asked.values) | {"at": float(x), "mu": 1.5}) for x in at]
    assert any(code not in (0, CODES[t]) for t, code in zip(truths, codes, strict=True))


# --- growth rates ---


@pytest.mark.few(1)
@pytest.mark.parametrize("disk", [st.Disk(k=0.25), st.Disk.hoop(), SI], ids=["disk", "hoop", "si"])
@pytest.mark.parametrize("family", FAMILIES)
def test_growth_rates_of_a_map_are_right_to_1e_13(family: str, disk: Any) -> None:
    unit = 1.0 if family == "tumbling" else float(disk.rate)
    low, high = {"rolling": (0.1, 6), "spinning": (0.1, 6), "tumbling": (0.003, 1.5707)}[family]
    x = ("at", low * unit, high * unit, 61)
    mu = 1 / float(disk.speed)
    found = st.stability_map(
        family,
        x=x,
        y=("mu", 0.003 * mu, 300 * mu, 47, "log"),
        disk=disk,
        contact=st.Viscous,
        boundaries=False,
        modes=True,
    )
    asked = disk_problem(family, disk, st.Viscous(1.0), 1.0)
    random = np.random.default_rng(2)
    assert (found.verdict > 0).all()
    for _ in range(60):
        i, j = int(random.integers(47)), int(random.integers(61))
        one = dict(asked.values) | {"at": float(found["at"][j]), "mu": float(found.mu[i])}
        proved = certify(asked, {n: float(v) for n, v in one.items()})
        largest = max(abs(v) for v in proved.eigenvalues)
        off = abs(float(found.abscissa[i, j]) - proved.eigenvalues[-1].real)
        assert off <= 1e-13 * largest
        assert off <= float(found.abscissa_error[i, j]) + proved.abscissa_error
        near = np.abs(found.eigenvalues[i, j].values - np.array(proved.eigenvalues))
        assert near.max() <= 1e-11 * largest
        assert abs(found.frequency[i, j] - abs(proved.eigenvalues[-1].imag)) <= 1e-11 * largest
    signs = np.where(found.abscissa.values > 0, CODES[Verdict.UNSTABLE], CODES[Verdict.STABLE])
    assert (signs == found.verdict.values).all()
    assert (found.abscissa_error <= np.abs(found.abscissa)).all()


def test_conservative_maps_take_the_same_route() -> None:
    found = st.stability_map(
        "rolling", x=("at", 0.3, 2, 40), y=("k", 0.1, 0.5, 30), contact=st.Rough(), boundaries=False
    )
    threshold = 1 / (2 * (2 * found.k + 1))
    growing = found["at"] ** 2 < threshold
    square = ((1 - 2 * (2 * found.k + 1) * found["at"] ** 2) / (1 + found.k)).transpose("k", "at")
    assert ((found.verdict == CODES[Verdict.UNSTABLE]) == growing.transpose("k", "at")).all()
    wanted = np.where(square > 0, np.sqrt(np.abs(square)), 0.0)
    assert np.abs(found.abscissa - wanted).max() < 1e-14
    assert (found.abscissa_error.values[square < -1e-6] == 0).all()


@pytest.mark.parametrize("compiled", [False, True])
def test_a_cell_that_is_proved_neutral_grows_by_exactly_nothing(
    compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk that spins at Ω = 2 lies on its static boundary; 2 is a double."""
    if compiled:
        pytest.importorskip("numba")
        monkeypatch.setattr("stability.maps.engine.COMPILED_FROM", 0)
    found = st.stability_map("spinning", x=("at", 1, 3, 33), y=("mu", 0.1, 3, 20), boundaries=False)
    neutral = found.verdict.values == CODES[Verdict.NEUTRAL]
    assert neutral.sum(axis=0).nonzero()[0].tolist() == [16]
    assert (found.abscissa.values[neutral] == 0).all()
    assert (found.abscissa_error.values[neutral] == 0).all()
    assert found.abscissa.values[~neutral].all()
    assert "(0 of 660 cells" not in found.method  # their verdicts are exact


def test_error_discs_of_factors_hold_known_roots() -> None:
    """Polynomials with known roots, coefficients exact in doubles; and clusters get no bound."""
    cases = [
        [-3, -2, -1, 2, 5],
        [-1, -1 + 2j, -1 - 2j, 3j, -3j],
        [4, -1, -2, 1 + 1j, 1 - 1j],
        [-0.25, 0.5 + 8j, 0.5 - 8j],
    ]
    for roots in cases:
        a = [np.array([c]) for c in np.poly(roots).real[::-1][:-1]]
        factors = settle(a, start(a))
        found = enclose(a, [0 * c for c in a], factors)
        values = np.array([x + 1j * y for x, y in zip(found.real, found.imag, strict=True)])[:, 0]
        radius = np.array(found.radius)[:, 0]
        assert radius.max() < 1e-12
        distance = np.abs(values[:, None] - np.array(roots)[None, :])
        assert (distance <= radius[:, None]).any(axis=1).all()
        assert (distance <= radius[:, None]).any(axis=0).all()
    double = [np.array([c]) for c in np.poly([-1, -1, -2, -3, -4])[::-1][:-1]]
    assert np.isinf(
        enclose(double, [1e-16 + 0 * c for c in double], settle(double, start(double))).radius
    ).any()


@pytest.mark.parametrize("kind", [None, np.longdouble], ids=str)
def test_bounds_of_coefficients_hold_and_are_not_idle(kind: Any) -> None:
    """Monic coefficients against exact rationals: inside their bounds, not far in."""
    from fractions import Fraction

    from stability.maps.engine import _coefficients, _coefficients_twice
    from stability.maps.surfaces import powers

    random = np.random.default_rng(9)
    closest, widest = 0.0, 0.0
    for family in ("spinning", "rolling"):
        asked = question(family)
        xs, ys = np.sort(random.uniform(0.2, 4, 20)), np.sort(10 ** random.uniform(-3, 3, 20))
        axes = Axis("at", 0.1, 4.5, 9), Axis("mu", 1e-3, 1e3, 9, True)
        cells = slice_cells(asked, axes, False)
        assert cells is not None
        rows, columns = (v.ravel() for v in np.indices((20, 20)))
        for (surfaces, _, _), factor in zip(cells._factors, asked.exact.known.factors, strict=True):
            if kind is None:
                lines = [powers(w(v), 6) for w, v in zip(cells.windows, (xs, ys), strict=True)]
                found = _coefficients(surfaces, *lines)
            else:
                pairs = [w.pairs(v) for w, v in zip(cells.windows, (xs, ys), strict=True)]
                found = _coefficients_twice(surfaces, (pairs[0], pairs[1]), rows, columns)
            for cell in range(400):
                at, mu = Fraction(float(xs[columns[cell]])), Fraction(float(ys[rows[cell]]))
                truth_ = [Fraction(c(Fraction(1, 4), mu * mu, at * at)) for c in factor]
                for value, error, c in zip(*found, truth_, strict=False):
                    high = Fraction(float(value[cell]))
                    low = Fraction(float(value[cell] - value.dtype.type(float(value[cell]))))
                    off = abs(high + low - c / truth_[-1])
                    bound = float(error[cell])
                    assert off <= Fraction(bound) * (1 + Fraction(1, 2**50))
                    closest = max(closest, float(off) / bound if bound else 0.0)
                    if c:
                        widest = max(widest, bound / abs(float(c / truth_[-1])))
    assert closest > 0.02
    if kind is not None:  # a few roundings, however much cancels
        assert widest < 1e-14


def test_corrections_of_factors_converge_quadratically() -> None:
    roots = [-2.0, -1 + 2j, -1 - 2j, 0.5 + 1j, 0.5 - 1j]
    a = [np.array([c]) for c in np.poly(roots).real[::-1][:-1]]
    factors = Factors(
        np.array([-2.01]),
        [(np.array([2.01]), np.array([5.02])), (np.array([-0.99]), np.array([1.26]))],
    )
    errors = []
    for _ in range(4):
        assert factors.r is not None
        errors.append(abs(factors.r[0] + 2) + abs(factors.pairs[0][1][0] - 5))
        factors, _ = improve(a, factors)
    orders = np.diff(np.log(errors[1:])) / np.diff(np.log(errors[:-1]))
    assert orders[0] > 1.7


# --- boxes ---


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("family", "x", "y", "law"),
    [
        ("rolling", ("at", 0.2, 3.0), ("mu", 0.01, 10.0), None),
        ("spinning", ("at", 0.5, 6.0), ("mu", 0.1, 3.0), None),
        ("tumbling", ("at", 0.02, 1.57), ("mu", 0.01, 10.0), None),
        ("tumbling", ("at", 1.0, 2.5), ("k", 0.01, 0.5), None),
        ("spinning", ("k", 0.01, 0.5), ("radius", 0.1, 5.0), st.LinearViscous(0.6)),
        ("rolling", ("at", -2.0, 2.0), ("k", 0.05, 0.5), st.Rough()),
        ("tumbling", ("lean", -0.5, 0.7), ("mu", 0.3, 2.0), None),
    ],
)
def test_no_box_holds_a_point_of_another_verdict(family: str, x: Any, y: Any, law: Any) -> None:
    """An attempt to refute: random points of random boxes, their corners, in exact arithmetic."""
    lean = 0.1 if "lean" in (x[0], y[0]) else None
    asked = disk_problem(family, st.Disk(), law or st.Viscous(1.0), None if lean else 1.0, lean)
    axes = Axis(*x, 9), Axis(*y, 9)
    boxes = prove_boxes(asked, axes, 6)
    assert boxes.proved > 0.5
    random = np.random.default_rng(7)
    area = np.diff(boxes.x, axis=1)[:, 0] * np.diff(boxes.y, axis=1)[:, 0]
    assert boxes.proved == pytest.approx(area[boxes.codes != 0].sum() / area.sum())
    assert area.sum() == pytest.approx((axes[0].high - axes[0].low) * (axes[1].high - axes[1].low))
    proved = np.flatnonzero(boxes.codes)
    assert len(set(boxes.codes[proved].tolist())) == (1 if family == "tumbling" and law else 2)
    for box in random.choice(proved, 60):
        for u, v in [*random.uniform(0, 1, (3, 2)), (0, 0), (0, 1), (1, 0), (1, 1)]:
            ends = boxes.x[box], boxes.y[box]
            at = [
                float(np.clip(e[0] + t * (e[1] - e[0]), *e))
                for e, t in zip(ends, (u, v), strict=True)
            ]
            one = dict(asked.values) | {x[0]: at[0], y[0]: at[1]}
            found = verdict(asked, {n: float(w) for n, w in one.items()})
            assert CODES[found] == boxes.codes[box]


def test_the_strip_encloses_every_boundary_point() -> None:
    found = st.stability_map(
        "spinning", x=("at", 0.5, 5, 60), y=("mu", 0.1, 3, 50, "log"), certify=True, levels=7
    )
    strip = found.box_verdict.values == 0
    x, y = found.box_at.values[strip], found.box_mu.values[strip]
    for a, m in zip(found.boundary_at.values, found.boundary_mu.values, strict=True):
        inside = (x[:, 0] <= a) & (a <= x[:, 1]) & (y[:, 0] <= m) & (m <= y[:, 1])
        assert inside.any()
    widths = np.diff(x, axis=1)[:, 0]
    assert widths.max() == pytest.approx(4.5 / 2**7)
    assert np.diff(np.log(y), axis=1).max() == pytest.approx(np.log(30) / 2**7)
    assert found.box_proved > 0.98
    assert "2^-7" in found.box_comment


def test_a_users_family_is_boxed_in_wide_balls() -> None:
    import casadi as ca

    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    system = st.System(
        "damped",
        x,
        p,
        ca.vertcat(x[1], -p[1] * ca.sin(x[0]) - p[0] * x[1]),
        states=("angle", "rate"),
        parameters=("drag", "pull"),
    )
    rest = st.Family(system, "rest", at=("drag",), held={"angle": 0, "rate": 0})
    found = st.stability_map(
        rest, x=("drag", -1.03, 1, 9), y=("pull", -1.01, 1, 9), certify=True, levels=5
    )
    for code, a, b in zip(
        found.box_verdict.values, found.box_drag.values, found.box_pull.values, strict=True
    ):
        good = a[0] > 0 and b[0] > 0
        bad = a[1] < 0 or b[1] < 0
        assert code in (0, 1 if good else 2 if bad else 0)
    assert found.box_proved > 0.85
    assert (found.verdict > 0).all()


def test_a_box_over_the_right_angle_is_left_open() -> None:
    asked = disk_problem("tumbling", st.Disk(), st.Viscous(0.5), 1.0)
    spans = {
        "at": (np.array([1.5, 1.5]), np.array([1.57, 1.58])),
        "mu": (np.array([0.5, 0.5]), np.array([0.5, 0.5])),
    }
    judged = judge(asked, "at", "mu", np.array([1.4, 1.6]), np.array([0.4, 0.6]))
    assert judged.boxes(spans).tolist() == [CODES[Verdict.STABLE], 0]


@pytest.mark.parametrize("function", ["sin", "cos"])
def test_windows_of_angles_hold_every_sine_between_their_ends(function: str) -> None:
    """Also where the sine turns inside, and to a hundred bits in pairs of doubles."""
    window = Window(Axis("at", -1.0, 3.0, 9), function)
    true = getattr(mpmath, function)
    random = np.random.default_rng(5)
    middle = np.pi / 2 if function == "sin" else 0.0
    low = middle - random.uniform(-0.5, 1, 60)
    high = low + random.uniform(0, 1, 60)
    least, most = window.ends(low, high)
    with mpmath.workdps(60):
        for a, b, u, v in zip(low, high, least, most, strict=True):
            for share in (0.0, 0.3, 0.5, 0.9, 1.0):
                value = true(mpmath.mpf(float(a)) + share * (mpmath.mpf(float(b)) - float(a)))
                assert u * (1 - 4e-16) <= value / window.unit <= v * (1 + 4e-16)
        first, second = window.pairs(low)
        for x, u, v in zip(low, first, second, strict=True):
            value = true(mpmath.mpf(float(x))) / window.unit
            assert abs(mpmath.mpf(float(u)) + mpmath.mpf(float(v)) - value) < 2.0**-100


def test_tiles_on_which_a_variable_turns_are_right() -> None:
    """The cosine of a lean and the square of a speed turn inside a tile of cells."""
    asked = disk_problem("tumbling", st.Disk(), st.Viscous(0.6), lean=0.1)
    xs, ys = np.linspace(-0.5, 0.7, 121), np.linspace(0.3, 2.0, 80)
    assert xs[50] == 0
    codes, _ = grid(asked, "lean", "mu", xs, ys)
    swept = dict(asked.values) | {"lean": xs[None, :], "mu": ys[:, None]}
    assert (codes == exact_codes(asked, swept)).all()
    assert {Verdict.NEUTRAL.code} <= set(codes[:, 50].tolist())
    asked = question("rolling", law=st.Rough())
    xs, ys = np.linspace(-2, 2, 121), np.linspace(0.05, 0.5, 80)
    codes, _ = grid(asked, "at", "k", xs, ys)
    swept = dict(asked.values) | {"at": xs[None, :], "k": ys[:, None]}
    assert (codes == exact_codes(asked, swept)).all()


@pytest.mark.parametrize("levels", [-1, 17, 2.5, True])
def test_levels_out_of_range_are_refused(levels: Any) -> None:
    with pytest.raises(st.StabilityError, match="levels is"):
        st.stability_map(
            "rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3), certify=True, levels=levels
        )


@pytest.mark.parametrize("law", [None, st.LinearViscous(0.4), st.Rough(), st.Smooth()])
@pytest.mark.parametrize("family", [*FAMILIES, "circling", "precession"])
def test_a_line_has_one_polynomial_by_both_routes(family: str, law: Any) -> None:
    from stability.algebra.number_types import precision
    from stability.boundary.brackets import AxisScan

    only = {"circling": st.Rough, "precession": st.Smooth}.get(family)
    if only is not None and not isinstance(law, only):
        return
    at = (0.9, 0.7) if only is not None else 0.9
    asked = disk_problem(family, st.Disk(k=0.3), law or st.Viscous(0.6), at)
    line = AxisScan(asked, "k", {n: float(v) for n, v in asked.values.items()})
    with precision(128):
        graph, exact_ = line.enclosed(0.3, 128), line._exact(0.3)
        assert exact_ is not None
        assert len(graph) == len(exact_)
        for one, other in zip(graph, exact_, strict=True):
            off = one / graph[-1] - other / exact_[-1]
            assert off.contains(0)
            assert float(off.abs_upper()) < 1e-25


# --- streaming ---


def test_a_streamed_map_is_the_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.maps.stream as module

    monkeypatch.setattr(module, "BAND", 300)
    axes = {"x": ("at", 0.5, 5, 50), "y": ("mu", 0.1, 3, 41, "log")}
    done: list[int] = []
    path = st.stream_map(
        "spinning", **axes, out=tmp_path / "v.nc", progress=lambda a, _: done.append(a)
    )
    back = st.read_map(path)
    whole = st.stability_map("spinning", **axes, boundaries=False)
    assert (back.verdict == whole.verdict).all()
    assert back["at"].identical(whole["at"])
    assert done[-1] == 50 * 41 and len(done) > 3
    with st.read_map(path, lazy=True) as lazy:
        assert lazy.verdict.sizes == {"mu": 41, "at": 50}
    assert "exact stability conditions" in back.attrs["method"]


def test_an_interrupted_stream_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.maps.stream as module

    monkeypatch.setattr(module, "BAND", 300)

    def stop(*_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        st.stream_map(
            "spinning",
            x=("at", 0.5, 5, 50),
            y=("mu", 0.1, 3, 41),
            out=tmp_path / "v.nc",
            progress=stop,
        )
    assert list(tmp_path.iterdir()) == []


def test_streams_that_cannot_be_are_refused(tmp_path: Path) -> None:
    axes = {"x": ("at", 0.5, 5, 5), "y": ("mu", 0.1, 3, 4)}
    with pytest.raises(st.StabilityError, match="at most 1e"):
        st.stream_map(
            "spinning", x=("at", 1, 2, 10**6), y=("mu", 1, 2, 10**6), out=tmp_path / "a.nc"
        )
    with pytest.raises(st.StabilityError, match="'k' is missing; spinning needs"):
        st.stream_map(st.disk_family("spinning", "viscous"), **axes, out=tmp_path / "a.nc")
    with pytest.raises(st.StabilityError, match="does not exist"):
        st.stream_map("spinning", **axes, out=tmp_path / "none" / "a.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="no long doubles here")
def test_cells_that_are_computed_again_have_the_bounds_of_long_doubles() -> None:
    x, y = Axis("at", 0.02, 1.5, 120), Axis("mu", 0.01, 3.0, 90)
    cells = slice_cells(question("tumbling"), (x, y), False)
    assert cells is not None
    poor = cells.rates(x.values, y.values).poor
    _, _, growth = cells.judged(x.values, y.values)
    assert poor.sum() > 20
    assert growth.error[poor].max() < 1e-15  # the rounding of the rates to doubles
