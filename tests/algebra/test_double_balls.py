"""Balls of doubles hold what balls of 200 bits hold; a tape agrees with its program."""

import math
from importlib.util import find_spec
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np
import pytest
from flint import arb, ctx

import stability as st
from stability.algebra.kernels import double_balls
from stability.algebra.kernels.compiled import compiled
from stability.algebra.kernels.tape import LANES, recorded
from stability.algebra.number_types import balls
from stability.algebra.program import Program
from stability.base.errors import StabilityError

COUNTS = [15_000, pytest.param(100_000, marks=pytest.mark.long)]
ENGINES = [
    pytest.param(False, marks=pytest.mark.skipif(find_spec("numba") is None, reason="no numba")),
    True,
]


def numbers(seed: int, count: int) -> tuple[Any, Any]:
    """Centres of all sizes and radii from 0 to their size and beyond."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(-4, 4, count) * rng.choice([1.0, 1.0, 1.0, 1.0, 75.0], count)
    m = rng.choice([-1.0, 1.0], count) * 10.0**size
    width = rng.choice([0.0, 1e-18, 1e-12, 1e-4, 0.3, 0.999999, 1.5], count)
    return m, np.abs(m) * width


def holds(m: Any, r: Any, true: Any) -> bool:
    """Whether [m - r, m + r] holds a point whose ball of 200 bits is far narrower than r."""
    if not (math.isfinite(m) and math.isfinite(r)):
        return True  # no comparison accepts it
    return bool(abs(true - arb(m)) <= arb(r))


def check(found: tuple[Any, Any], exact: Any, sides: Any) -> int:
    """Number of finite balls; every one must hold the value at corners of its arguments."""
    ctx.prec = 200
    try:
        finite = 0
        for i in range(len(sides)):
            m, r = float(found[0][i]), float(found[1][i])
            if not (math.isfinite(m) and math.isfinite(r)):
                continue
            finite += 1
            true = exact(i, sides[i])
            assert holds(m, r, true), (i, m, r, true)
        return finite
    finally:
        ctx.prec = 53


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", ["add", "multiply", "divide"])
def test_sums_products_and_quotients_hold_the_exact_ones(name: str, count: int) -> None:
    (a, ra), (b, rb) = numbers(1, count), numbers(2, count)
    with np.errstate(all="ignore"):
        found = getattr(compiled(double_balls, plain=True), name)(a, ra, b, rb)
    sides = np.random.default_rng(3).choice([-1.0, 0.0, 1.0], (count, 2))

    def exact(i: int, side: Any) -> Any:
        x = arb(float(a[i])) + arb(float(side[0])) * arb(float(ra[i]))
        y = arb(float(b[i])) + arb(float(side[1])) * arb(float(rb[i]))
        return {"add": x + y, "multiply": x * y, "divide": x / y}[name]

    assert check(found, exact, sides) > 0.5 * count


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", ["root", "sine", "cosine"])
def test_roots_sines_and_cosines_hold_the_exact_ones(name: str, count: int) -> None:
    a, ra = numbers(4, count)
    a = np.where(np.arange(count) % 3 == 0, np.rint(a % 1e4) * (math.pi / 2), a)  # hard to reduce
    if name == "root":
        a = np.abs(a)
    kernel = compiled(double_balls, plain=True)
    with np.errstate(all="ignore"):
        found = kernel.root(a, ra) if name == "root" else kernel.sines(a, ra)
        found = found[2:] if name == "cosine" else found[:2]
    sides = np.random.default_rng(5).choice([-1.0, 0.0, 1.0], count)

    def exact(i: int, side: float) -> Any:
        x = arb(float(a[i])) + arb(side) * arb(float(ra[i]))
        return {"root": x.sqrt, "sine": x.sin, "cosine": x.cos}[name]()

    assert check(found, exact, sides) > 0.5 * count


def test_the_error_of_sines_is_below_what_is_stated() -> None:
    a = np.concatenate(
        [
            np.random.default_rng(6).uniform(-1e5, 1e5, 20_000),
            np.random.default_rng(7).uniform(-7, 7, 20_000),
            np.arange(2000) * (math.pi / 4),
        ]
    )
    sine, _, cosine, _ = compiled(double_balls, plain=True).sines(a, np.zeros_like(a))
    ctx.prec = 120
    try:
        for x, s, c in zip(a.tolist(), sine.tolist(), cosine.tolist(), strict=True):
            worst = max(abs(arb(s) - arb(x).sin()), abs(arb(c) - arb(x).cos()))
            assert worst < double_balls.SINE / 2, x  # the bound of the docstring, proved there
    finally:
        ctx.prec = 53


def test_the_parts_of_a_right_angle_are_as_stated() -> None:
    ctx.prec = 300
    try:
        parts = [arb(v) for v in (double_balls.PI1, double_balls.PI2, double_balls.PI3)]
        assert abs(arb.pi() / 2 - sum(parts, arb(0))) < 2e-37
    finally:
        ctx.prec = 53
    for part in (double_balls.PI1, double_balls.PI2):
        m, _ = math.frexp(part)
        assert (m * 2**33).is_integer()


def arguments(rng: Any, tape: Any) -> tuple[Any, Any]:
    lanes = LANES + 37  # a full block and a part of one
    mid = rng.uniform(0.2, 1.2, (tape.inputs, lanes))
    return mid, rng.choice([0.0, 1e-9, 1e-5], (tape.inputs, lanes))


@pytest.mark.parametrize("law", ["viscous", "linear-viscous", "coulomb-regularised"])
@pytest.mark.parametrize("plain", ENGINES)
def test_a_tape_holds_the_points_of_its_program(law: str, plain: bool) -> None:
    system = st.disk_system(law)
    program = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
    n = program.inputs[0]
    tape = recorded(lambda a, t: program.run(t, [a[:n], a[n:]])[0], sum(program.inputs))
    rng = np.random.default_rng(8)
    mid, rad = arguments(rng, tape)
    m, r = tape.run(mid, rad, plain=plain)
    assert np.isfinite(r).mean() > 0.9
    side = rng.choice([-1.0, 0.0, 1.0], mid.shape)
    ctx.prec = 120
    try:
        for i in range(mid.shape[1]):
            rows = zip(mid[:, i], side[:, i], rad[:, i], strict=True)
            point = [arb(float(x)) + arb(float(s)) * arb(float(w)) for x, s, w in rows]
            values = program.run(balls(), [point[:n], point[n:]])[0]
            assert all(holds(*v) for v in zip(m[:, i], r[:, i], values, strict=True))
    finally:
        ctx.prec = 53


@pytest.mark.skipif(find_spec("numba") is None, reason="no numba")
def test_numpy_and_numba_agree_to_the_last_bit() -> None:
    system = st.disk_system("coulomb-regularised")
    program = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
    n = program.inputs[0]
    tape = recorded(lambda a, t: program.run(t, [a[:n], a[n:]])[0], sum(program.inputs))
    mid, rad = arguments(np.random.default_rng(9), tape)
    one, other = (tape.run(mid, rad, plain=plain) for plain in (False, True))
    assert all(np.array_equal(x, y, equal_nan=True) for x, y in zip(one, other, strict=True))


def test_a_product_of_matrices_holds_the_exact_one() -> None:
    rng = np.random.default_rng(10)
    a, b = rng.normal(size=(5, 5, 200)), rng.normal(size=(5, 5, 200)) * 10.0 ** rng.integers(-9, 9)
    rb = rng.choice([0.0, 1e-14, 1e-5], b.shape)
    c, rc = np.zeros_like(b), np.zeros_like(b)
    compiled(double_balls, plain=True).product(a, b, rb, c, rc)
    side = rng.choice([-1.0, 1.0], b.shape)
    ctx.prec = 200
    try:
        for i, j, lane in np.ndindex(c.shape):
            true = sum(
                (
                    arb(float(a[i, k, lane]))
                    * (
                        arb(float(b[k, j, lane]))
                        + arb(float(side[k, j, lane])) * arb(float(rb[k, j, lane]))
                    )
                    for k in range(5)
                ),
                arb(0),
            )
            assert holds(c[i, j, lane], rc[i, j, lane], true)
    finally:
        ctx.prec = 53


def test_a_radius_beyond_the_domain_is_never_finite() -> None:
    kernel: Any = compiled(double_balls, plain=True)
    with np.errstate(all="ignore"):
        for b, rb in ((1.0, 1.0), (0.0, 0.0), (0.5, 2.0), (1e-308, 1e-307)):
            assert not np.isfinite(kernel.divide(1.0, 0.0, np.array(b), np.array(rb))[1])
        for a, ra in ((1.0, 1.5), (-1.0, 0.0), (0.0, 1e-9)):
            assert not np.isfinite(kernel.root(a, ra)[1])
        for a in (1.1e5, 1e300, math.inf, math.nan):
            assert not np.isfinite(kernel.sines(a, 0.0)[1])


def test_powers_tangents_and_sizes_are_read_and_exp_is_refused() -> None:
    x = ca.SX.sym("x")
    program = Program(ca.Function("f", [x], [ca.vertcat(x**3, ca.tan(x), ca.fabs(x) * ca.sign(x))]))
    tape = recorded(lambda a, t: program.run(t, [a])[0], 1)
    m, r = tape.run(np.array([[-0.7, 0.3]]))
    true = [[-0.343, 0.027], [math.tan(-0.7), math.tan(0.3)], [-0.7, 0.3]]
    assert (np.abs(m - true) <= r + 1e-16).all()
    assert (r < 1e-14).all()
    for other in (ca.exp(x), x**0.5 + ca.log(x), ca.power(x, x)):
        strange = Program(ca.Function("f", [x], [other]))
        with pytest.raises(StabilityError, match="kernel"):
            recorded(lambda a, t: strange.run(t, [a])[0], 1)  # noqa: B023


BREAKS = [
    ("UP = 1.0 + 2.0**-47", "UP = 1.0 - 2.0**-47", "add"),
    ("U * np.abs(m)", "0.0 * np.abs(m)", "multiply"),
    ("ra * (np.abs(b) + rb)", "ra * np.abs(b)", "multiply"),
    ("np.sqrt(a - ra) + m", "m + m", "root"),
]


@pytest.mark.parametrize(("right", "wrong", "name"), BREAKS)
def test_a_broken_rounding_is_seen(
    right: str, wrong: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    import inspect

    source = inspect.getsource(double_balls)
    assert right in source
    broken = ModuleType("broken")
    exec(source.replace(right, wrong), broken.__dict__)
    monkeypatch.setattr(f"{__name__}.compiled", lambda *_, **__: broken, raising=True)
    test = (
        test_roots_sines_and_cosines_hold_the_exact_ones
        if name == "root"
        else test_sums_products_and_quotients_hold_the_exact_ones
    )
    with pytest.raises(AssertionError):
        test(name, 15_000)
