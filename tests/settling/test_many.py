"""What the kernel calls settled is settled: by the flint test, and by independent motions."""

import math
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from disk_members import deviation
from flint import arb, ctx
from kane_disk import states_after

import stability as st
from stability.algebra.program import Program
from stability.settling import box, settling
from stability.settling import box_kernel as kernel
from stability.settling.body_lines import body_settling, disk_settling
from stability.settling.box import Balls, attraction
from stability.settling.settling import Nearest, settled
from stability.settling.surroundings import Surroundings
from stability.settling.system_lines import system_settling

RIGHT = math.pi / 2
WITHIN = 1e-3


def launches(count: int, seed: int, largest: float = -3.0) -> tuple[Any, Any, Any]:
    """Families, states within 10^largest of them, and (k, mu), all random."""
    rng = np.random.default_rng(seed)
    p = np.column_stack([rng.uniform(0.05, 0.5, count), 10 ** rng.uniform(-1.3, 1.0, count)])
    six, turned = np.zeros((count, 6)), rng.random(count) < 0.5
    sign = rng.choice([-1.0, 1.0], count)
    six[:, 0] = np.where(turned, RIGHT, rng.uniform(0.1, math.pi - 0.1, count))
    tumbling = sign / np.sqrt(p[:, 0] * np.sin(six[:, 0]))
    six[:, 2] = np.where(turned, sign * rng.uniform(0.2, 6, count), tumbling)
    off = rng.normal(size=(count, 6))
    size = 10 ** rng.uniform(-7, largest, count)
    six += off * (size / np.linalg.norm(off, axis=1))[:, None]
    return np.where(turned, "spinning", "tumbling"), six, p


def one(six: Any, p: Any, law: Any = st.Viscous) -> Any:
    """The proof in flint's balls for the nearest family of a state; None where there is none."""
    found = disk_settling(law).many(six[None], p, math.inf, alone=True).settled
    if not found.proved[0]:
        return None
    parts = found.limit[0], float(found.error[0]), float(found.rate[0])
    return SimpleNamespace(**dict(zip(("limit", "error", "rate"), parts, strict=True)))


def nearest(six: Any, law: Any, p: Any) -> Nearest:
    return disk_settling(law).nearest(six, p, WITHIN)


@pytest.fixture(autouse=True)
def _boxes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """These are tests of the box about a state; tests/settling/test_tube.py has those of tubes."""
    monkeypatch.setattr(settling, "_by_tubes", lambda _, y, *__: np.zeros(len(y.mid), dtype=bool))


def converges(found: Any, six: Any, p: Any, some: Any, lives: float = 12) -> Any:
    """Whether each motion ends within its stated error of its stated limit, after some e-folds."""
    good = []
    rate = found.settled.rate
    order = some[np.argsort(rate[some])]
    for part in np.array_split(order, math.ceil(len(order) / 12)):  # of nearly equal rates
        there = states_after(six[part], p[part], lives / rate[part].min())
        for i, state in zip(part, there, strict=True):
            at, e = deviation(state, float(p[i, 0]), found.names[found.family[i]])
            room = found.settled.error[i] + 3 * np.linalg.norm(e) + 1e-8
            good.append(abs(float(at) - found.settled.limit[i, 0]) <= room)
    return np.array(good)


def every_proof_is_true(count: int, seed: int) -> None:
    _, six, p = launches(count, seed)
    found = disk_settling(st.Viscous).many(six, p, WITHIN)
    proved = np.flatnonzero(found.settled.proved)
    assert len(proved) > 0.35 * count
    alone = np.array([i for i in proved if one(six[i], p[i]) is None], dtype=int)
    assert len(alone) < 0.01 * count
    if len(alone):
        assert converges(found, six, p, alone).all()


def test_every_proof_of_the_kernel_is_one_of_flint_or_of_an_independent_motion() -> None:
    every_proof_is_true(200, 1)


@pytest.mark.long
def test_every_proof_of_twenty_thousand_launches_is_true() -> None:
    every_proof_is_true(25_000, 11)


@pytest.mark.long
def test_two_hundred_proved_motions_end_within_the_stated_error() -> None:
    _, six, p = launches(4000, 12)
    found = disk_settling(st.Viscous).many(six, p, WITHIN)
    wide = found.settled.error > 1e-7  # above the errors of the integration
    some = np.flatnonzero(found.settled.proved & (found.settled.rate > 0.02) & wide)
    assert converges(found, six, p, some[:200]).all()


@pytest.mark.parametrize("count", [60, pytest.param(200, marks=pytest.mark.long)])
def test_the_kernel_proves_what_flint_proves(count: int) -> None:
    _, six, p = launches(count, 2)
    found = disk_settling(st.Viscous).many(six, p, WITHIN)
    ours, theirs, bounds = [], [], found.settled
    for i in range(len(six)):
        near = nearest(six[i], st.Viscous, p[i])
        assert found.names[found.family[i]] == near.family
        assert found.at[i, 0] == pytest.approx(near.at, rel=1e-12)
        assert found.distance[i] == pytest.approx(near.distance, rel=1e-9, abs=1e-14)
        ours.append(bool(found.settled.proved[i]))
        theirs.append(near.settled)
        exact = one(six[i], p[i]) if ours[-1] and near.settled else None
        if exact is not None:  # not smaller than by another basis
            assert bounds.error[i] >= 0.9 * exact.error
            assert bounds.rate[i] <= 1.1 * exact.rate
            assert abs(bounds.limit[i, 0] - exact.limit[0]) <= bounds.error[i] + exact.error
    assert sum(theirs) > 0.3 * count
    assert ours == theirs


@pytest.mark.parametrize(
    ("count", "followed"), [(300, 1), pytest.param(3000, 16, marks=pytest.mark.long)]
)
def test_proved_motions_end_within_the_stated_error_of_the_stated_limit(
    count: int, followed: int
) -> None:
    _, six, p = launches(count, 3)
    found = disk_settling(st.Viscous).many(six, p, WITHIN)
    wide = found.settled.error > 1e-7  # above the errors of the integration
    fast = np.flatnonzero(found.settled.proved & (found.settled.rate > 0.12) & wide)
    assert len(fast) >= followed
    if followed < 16:  # the fastest are the shortest
        fast = fast[np.argsort(-found.settled.rate[fast])]
    assert converges(found, six, p, fast[:followed], 8 if followed < 16 else 12).all()


@pytest.mark.parametrize(("family", "size"), [("spinning", 5.4e-4), ("tumbling", 3.1e-4)])
def test_the_reach_is_that_of_the_test_in_flint(family: str, size: float) -> None:
    # the reach of the flint test for these members, in directions seen to be proved there
    direction = np.array(
        [1, 0.7, 0, 0.8, 0.6, -0.9] if family == "spinning" else [0, 1, 0, 0, 0, 0]
    )
    six = np.array([RIGHT, 0, 2.5, 0, 0, 0])
    if family == "tumbling":
        six = np.array([0.7, 0, 1 / math.sqrt(0.25 * math.sin(0.7)), 0, 0, 0])
    six = (six + size * direction / np.linalg.norm(direction))[None]
    p = np.array([0.25, 0.3])
    assert one(six[0], p) is not None
    assert disk_settling(st.Viscous).many(six, p, WITHIN).settled.proved.all()


@pytest.mark.skipif(find_spec("numba") is None, reason="no numba")
@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("count", [12, pytest.param(5000, marks=pytest.mark.long)])
def test_without_numba_the_same_launches_are_proved_with_the_same_bounds(
    shared: bool, count: int
) -> None:
    _, six, p = launches(count, 4)
    p = np.array([0.25, 0.3]) if shared else p
    both = [disk_settling(st.Viscous).many(six, p, WITHIN, plain=v).settled for v in (False, True)]
    assert both[0].proved.sum() > 0.08 * count
    for name in ("proved", "limit", "error", "rate", "reach"):
        assert np.array_equal(*(getattr(v, name) for v in both), equal_nan=True), name


@pytest.mark.parametrize("count", [400, pytest.param(4000, marks=pytest.mark.long)])
def test_shared_bases_prove_what_own_bases_prove(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(5)
    six = np.zeros((count, 6))
    six[:, 0] = rng.uniform(0.6, 0.8, count)
    six[:, 2] = 1 / np.sqrt(0.25 * np.sin(six[:, 0]))
    six += rng.normal(size=six.shape) * 1e-4
    p = np.array([0.25, 0.3])
    shared = disk_settling(st.Viscous).many(six, p, WITHIN).settled.proved
    monkeypatch.setattr(box, "STEP", 2.0**-40)
    own = disk_settling(st.Viscous).many(six, p, WITHIN).settled.proved
    assert own.sum() > count / 4
    assert not (own & ~shared).any()


def test_a_proof_that_misses_in_a_shared_basis_is_tried_in_the_launchs_own() -> None:
    # the end of a launch that the flint test proves, and a shared basis does not: 1 % is missing
    six = np.array(
        [0.620616445, 2.07832199e-05, -2.07307399, -4.99347477e-06, -2.59795893e-05, 2.42116199e-05]
    )
    p = np.array([0.4, 0.3])
    exact = one(six, p)
    found = disk_settling(st.Viscous).many(six[None], p, 0.05).settled
    assert exact is not None and found.proved[0]
    assert found.rate[0] == pytest.approx(exact.rate, rel=0.01)
    assert found.error[0] == pytest.approx(exact.error, rel=0.01)


def test_nothing_is_proved_where_nothing_settles() -> None:
    _, six, p = launches(400, 6)
    for law in (st.Smooth, st.Coulomb):
        assert not disk_settling(law).many(six, p, WITHIN).settled.proved.any()
    rolling = np.tile([RIGHT + 1e-6, 0, 0, 3.0, 0, 0], (4, 1))
    found = disk_settling(st.Viscous).many(rolling, np.array([0.25, 1.0]), WITHIN)
    assert (found.family == found.names.index("rolling")).all()
    assert not found.settled.proved.any()
    strange = np.array([[math.nan] * 6, [math.inf] * 6, [0.0] * 6, [1e300] * 6, [-1.0] * 6])
    assert (
        not disk_settling(st.Viscous).many(strange, np.array([0.25, 1.0]), 1.0).settled.proved.any()
    )
    none = disk_settling(st.Viscous).many(six[:0], p[:0], WITHIN)
    assert none.family.shape == none.settled.proved.shape == (0,)


def test_unstable_members_and_boundaries_prove_nothing() -> None:
    at = np.array([1.9, 2.0, 2.0 + 1e-12, 2.01])
    six = np.zeros((4, 6))
    six[:, 0], six[:, 2] = RIGHT, at
    found = disk_settling(st.Viscous).many(six, np.array([0.25, 0.3]), WITHIN)
    assert found.settled.proved.tolist() == [False, False, False, True]


@pytest.mark.parametrize("law", [st.LinearViscous, st.RegularisedCoulomb])
@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.long)])
def test_other_laws_agree_with_flint(law: Any, count: int) -> None:
    _, six, p = launches(count, 7, -4.0)
    if law is st.RegularisedCoulomb:
        p = np.column_stack([p, np.full(len(p), 0.05)])
    found = disk_settling(law).many(six, p, WITHIN)
    theirs = np.array([nearest(s, law, q).settled for s, q in zip(six, p, strict=True)])
    assert theirs.any()
    assert not (found.settled.proved & ~theirs).any()
    assert (theirs & ~found.settled.proved).sum() <= 0.03 * theirs.sum()


def bare(rhs: Any, *names: str, parameters: tuple[str, ...] = ()) -> st.System:
    x, p = ca.SX.sym("x", len(names)), ca.SX.sym("p", len(parameters))
    rates = ca.SX(ca.vertcat(*rhs(x, p)))
    return st.System("bare", x, p, rates, states=names, parameters=parameters)


@pytest.mark.few(1)
@pytest.mark.parametrize("pull", [ca.sin, lambda q: ca.exp(q) - 1])
def test_a_system_of_ones_own_agrees_with_the_single_test(pull: Any) -> None:
    # exp has no kernel: those launches are tested one by one in flint's balls
    system = bare(lambda x, p: (x[1], -pull(x[0]) - p[0] * x[1]), "q", "v", parameters=("c",))
    held = ({"q": 0.0, "v": 0.0}, {"q": math.pi, "v": 0.0})
    families = [
        st.Family(system, n, at=("c",), held=v) for n, v in zip(("rest", "top"), held, strict=True)
    ]
    settling = system_settling(tuple(families[: 2 if pull is ca.sin else 1]))
    rng = np.random.default_rng(8)
    states = rng.normal(size=(60, 2)) * 10 ** rng.uniform(-6, 0.3, (60, 1))
    p = rng.uniform(0.2, 1.5, (60, 1))
    found = settling.many(states, p, 0.5)
    single = [settling.nearest(s, q, 0.5) for s, q in zip(states, p, strict=True)]
    assert [found.names[i] for i in found.family] == [n.family for n in single]
    assert sum(n.settled for n in single) > 18
    assert [n.settled for n in single] == found.settled.proved.tolist()


def _bump(theta: Any) -> Any:
    return 1 + 0.05 * ca.exp(-(ca.cos(theta) ** 2))


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "body",
    [
        st.EccentricSphere(0.15, axial=0.4, transverse=0.4),
        st.Body(_bump, axial=0.4, transverse=0.4),
    ],
)
def test_a_body_agrees_with_the_single_test(body: Any) -> None:
    # exp has no kernel here either
    settling = body_settling(body, st.Viscous, tuple(st.Viscous(0.3).given))
    own = {"mu": 0.3, "axial": 0.4, "transverse": 0.4, "offset": 0.15}
    p = np.array([own[n] for n in settling.lines[0].system.parameters])
    rng = np.random.default_rng(14)
    six = np.zeros((24, 6))
    six[:12, 0], six[:12, 3] = math.pi - 1e-5 * rng.random(12), rng.uniform(-4, 4, 12)
    six[12:, 0], six[12:, 2] = RIGHT + 1e-5, rng.uniform(1, 5, 12)
    found = settling.many(six, p, WITHIN)
    single = [settling.nearest(s, p, WITHIN) for s in six]
    assert [found.names[i] for i in found.family] == [n.family for n in single]
    assert [n.settled for n in single] == found.settled.proved.tolist()
    assert found.settled.proved.any()


def test_the_chart_at_a_pole_is_enclosed_and_not_rounded() -> None:
    # the chart has sines and products: a proof about rounded ones is about another state
    body = st.EccentricSphere(0.15, axial=0.4, transverse=0.4)
    settling = body_settling(body, st.Viscous, tuple(st.Viscous(0.3).given))
    line = settling.lines[-1]
    p = np.array([0.15, 0.4, 0.4, 0.3])
    rng = np.random.default_rng(15)
    six = rng.normal(size=(300, 6))
    six[:, 0] = math.pi - 1e-3 * rng.random(300)
    y, e = line.enclosed(six, np.tile(p, (300, 1)), plain=True)
    m, r = np.hstack([y.mid, e.mid]), np.hstack([y.rad, e.rad])
    ctx.prec = 200
    try:
        for i, row in enumerate(six.tolist()):
            theta, theta_dot, phi_dot, omega3, *slip = (arb(v) for v in row)
            spin = omega3 - phi_dot * theta.cos()
            exact = [
                phi_dot + spin * theta.cos(),
                theta.sin(),
                arb(0),
                spin * theta.sin(),
                theta_dot,
                *slip,
            ]
            assert all(
                abs(v - arb(float(a))) <= arb(float(b))
                for v, a, b in zip(exact, m[i], r[i], strict=True)
            )
    finally:
        ctx.prec = 53
    assert r.max() < 1e-13


def test_a_basin_is_never_claimed_beyond_its_known_border() -> None:
    """ẋ = x (x - h): 0 attracts from below h alone."""
    system = bare(lambda x, p: (x[0] * (x[0] - p[0]),), "x", parameters=("h",))
    rng = np.random.default_rng(9)
    gap, share = 10.0 ** rng.uniform(-6, -2, (5000, 1)), rng.uniform(-2, 2, (5000, 1))
    rest = st.Family(system, "rest", at=("h",), held={"x": 0.0})
    found = system_settling((rest,)).many(gap * share, gap, 0.1)
    assert (share[found.settled.proved] < 1).all()
    assert found.settled.proved[np.abs(share[:, 0]) < 0.2].all()  # well within


@pytest.mark.parametrize(
    ("count", "singly"), [(2000, 40), pytest.param(20_000, 400, marks=pytest.mark.long)]
)
def test_a_member_that_is_not_known_exactly_exists_within_the_error(
    count: int, singly: int
) -> None:
    """ė = d - c e + e² with 4 d < c²: the lower root attracts from below the upper one."""
    given, e = ca.SX.sym("given", 2), ca.SX.sym("e")
    c, d = given[0], given[1]
    slots = [ca.SX(0, 1), given, e]
    g = d - c * e + e**2

    def program(value: ca.SX) -> Program:
        return Program(ca.Function("g", slots, [ca.densify(value)]))

    around = Surroundings(
        0, 1, program(ca.jacobian(g, e)), program(ca.SX(1)), program(ca.substitute(g, e, 0))
    )
    rng = np.random.default_rng(13)
    pull = rng.uniform(0.5, 2, count)
    push = pull**2 / 4 * 10 ** rng.uniform(-3, 0.3, count)
    off = rng.uniform(-1, 1.5, count) * pull
    none = np.zeros((count, 0))
    found = settled(
        around,
        Balls(none, none),
        np.column_stack([pull, push]),
        Balls(off[:, None], 0 * off[:, None]),
    )
    some = found.proved
    assert 0.05 * count < some.sum() < 0.95 * count
    inside = pull[some] ** 2 - 4 * push[some]
    assert (inside > 0).all()
    assert (off[some] < (pull[some] + np.sqrt(inside)) / 2).all()
    assert ((pull[some] - np.sqrt(inside)) / 2 <= found.error[some]).all()
    for i in range(singly):
        alone = attraction(around, [pull[i], push[i]], [], [arb(float(off[i]))])
        assert some[i] <= (alone is not None)


def test_members_that_are_solved_for_attract_and_those_along_a_state_do_not() -> None:
    cube = bare(lambda x, p: (p[0] - x[0] ** 3, x[0] - x[1]), "x", "y", parameters=("p",))
    unknown = {"x": 1.0, "y": 1.0}
    rest = st.Family(cube, "rest", at=("p",), unknown=unknown, equations=("x", "y"))
    p = np.linspace(0.5, 4, 50)[:, None]
    found = system_settling((rest,)).many(np.cbrt(p) + [1e-3, -1e-3], p, 1e-2)
    assert found.settled.proved.all()
    assert (found.settled.error < 1e-12).all()
    assert found.distance == pytest.approx(math.sqrt(2) * 1e-3, rel=1e-9)
    slide = bare(lambda x, _: (0 * x[0], x[0] ** 2 + 1 - x[1]), "x", "y")
    floor = st.Family(slide, "floor", at=("x",), unknown={"y": 1.0}, equations=("y",))
    states = np.array([[0.5, 1.25 + 1e-6]])
    found = system_settling((floor,)).many(states, np.zeros(0), 1e-2)
    assert not found.settled.proved.any()
    assert found.distance == pytest.approx(1e-6, rel=1e-3)


def test_a_line_of_members_of_a_system_has_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    system = bare(lambda x, p: (x[1], -p[0] * x[1]), "x", "v", parameters=("c",))
    settling = system_settling((st.Family(system, "stopped", at=("x",), held={"v": 0.0}),))
    states = np.array([[1.0, 0.01], [-2.0, -0.02]])
    p = np.array([[0.5], [2.0]])
    found = settling.many(states, p, 0.1)
    assert found.settled.proved.all()
    stop = states[:, 0] + states[:, 1] / p[:, 0]  # solved by hand
    assert (np.abs(found.settled.limit[:, 0] - stop) <= found.settled.error).all()
    assert (found.settled.error < 1e-12).all()
    monkeypatch.setattr(box, "MOST", 0)  # too many states: one by one in balls
    box.tapes.cache_clear()
    again = settling.many(states, p, 0.1)
    box.tapes.cache_clear()
    assert again.settled.proved.all()
    assert again.settled.limit == pytest.approx(found.settled.limit, abs=1e-12)
    assert not np.array_equal(again.settled.error, found.settled.error)


def test_a_bound_left_out_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    import inspect

    # the rate without the coupling of the states
    source = inspect.getsource(kernel).replace("from ..algebra", "from stability.algebra")
    right = "s = s + 0.5 * (both + loose[i] + loose[k])"
    assert right in source
    broken: dict[str, Any] = {}
    exec(source.replace(right, "s = s - 9.0 * both"), broken)
    monkeypatch.setattr(box, "compiled", lambda *_, **__: SimpleNamespace(**broken))
    with pytest.raises(AssertionError):
        every_proof_is_true(200, 1)


def test_a_bad_basis_proves_nothing_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    # any basis is sound: the inverse is enclosed, however poor
    _, six, p = launches(300, 9)
    rng = np.random.default_rng(10)
    true = box._modal

    def bent(a: Any) -> Any:
        stable, z, x, rate = true(a)
        return stable, z, x * (1 + 1e-4 * rng.normal(size=x.shape)), rate

    good = disk_settling(st.Viscous).many(six, p, WITHIN)
    monkeypatch.setattr(box, "_modal", bent)
    found = disk_settling(st.Viscous).many(six, p, WITHIN)
    assert 20 < found.settled.proved.sum() <= good.settled.proved.sum()
    both = found.settled.proved & good.settled.proved
    apart = np.abs(found.settled.limit - good.settled.limit)[both, 0]
    assert (apart <= (found.settled.error + good.settled.error)[both]).all()
    assert (found.settled.rate[both] <= good.settled.rate[both] * (1 + 1e-3)).all()


def test_balls_that_are_wide_are_kept_in_the_bound() -> None:
    around = disk_settling(st.Viscous).lines[1].around
    assert isinstance(around, Surroundings)
    y, e = np.full((3, 1), 2.5), np.full((3, 5), 1e-6)
    given = np.tile([1.0, 0.25, 0.3], (3, 1))
    wide = np.array([[0.0], [1e-5], [1e-3]])
    found = settled(around, Balls(y, wide), given, Balls(e, 0.1 * wide + 0 * e))
    assert found.proved[:2].all()
    assert found.error[1] > 1e-5 > found.error[0]
    exact = attraction(around, given[0].tolist(), [arb(2.5, 1e-5)], [arb(1e-6, 1e-6)] * 5)
    assert exact is not None
    assert found.error[1] == pytest.approx(exact.error, rel=0.05)
