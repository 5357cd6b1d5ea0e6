"""Families found from the equations: members by closed forms, refusals where none exists."""

import math
import pickle
from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import system_of

import stability as st

B = 8 / 3


@pytest.fixture(scope="module")
def lorenz() -> Any:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    rates = ca.vertcat(p[0] * (x[1] - x[0]), x[0] * (p[1] - x[2]) - x[1], x[0] * x[1] - p[2] * x[2])
    return st.System("Lorenz", x, p, rates, states=("x", "y", "z"), parameters=("sigma", "r", "b"))


@pytest.fixture(scope="module")
def plus(lorenz: Any) -> Any:
    guess = {"x": 8.0, "y": 8.0, "z": 27.0, "r": 28.0}
    return lorenz.steady(("r",), guess=guess, sigma=10, b=B, name="C+")


def scalar(rate: Any, *names: str) -> tuple[Any, Any]:
    """The system x' = rate(x, p), p with these names."""
    x, p = ca.SX.sym("x"), ca.SX.sym("p", len(names))
    return st.System("scalar", x, p, rate(x, p), states=("x",), parameters=names), p


def test_the_fixed_point_of_lorenz_is_followed_from_2_to_60_in_one_call(plus: Any) -> None:
    """C+ = (√(b(r-1)), √(b(r-1)), r-1); Hopf at r = σ(σ+b+3)/(σ-b-1) = 24.7368… (Lorenz 1963)."""
    r = np.linspace(2, 60, 59)
    x = np.sqrt(B * (r - 1))
    members = plus.member(r[:, None], [10.0, B])
    assert np.abs(members - np.column_stack([x, x, r - 1])).max() < 1e-13
    found = st.spectrum(plus, at=r, sigma=10, b=B)
    assert [v.word for v in found.verdict] == [
        "stable" if v < 10 * (10 + B + 3) / (10 - B - 1) else "unstable" for v in r
    ]


@pytest.mark.parametrize("count", [12, pytest.param(60, marks=pytest.mark.long)])
def test_one_question_after_another_gives_the_same_members_as_one_call(
    plus: Any, count: int
) -> None:
    r = np.random.default_rng(3).uniform(1.001, 1e3, count)
    one = [plus.member([v], [10.0, B])[0] for v in r]
    assert np.allclose(one, np.sqrt(B * (r - 1)), rtol=1e-13)
    assert np.allclose(plus.member(r[:, None], [10.0, B])[:, 0], one, rtol=1e-13)


def test_many_members_over_all_parameters_are_those_of_the_closed_form(plus: Any) -> None:
    rng = np.random.default_rng(4)
    r, sigma, b = (rng.uniform(*ends, 3000) for ends in ((0.1, 200), (0.5, 30), (0.1, 9)))
    found = plus.search(r[:, None], np.column_stack([sigma, b]))
    assert (found.good == (r > 1)).all()
    exact = np.sqrt(b[r > 1] * (r[r > 1] - 1))
    assert np.allclose(found.u[r > 1, 0], exact, rtol=1e-12)


@pytest.mark.few(2)
@pytest.mark.parametrize("r", [1.0, 0.999, 0.5, -3.0])
def test_no_other_fixed_point_stands_in_where_this_one_ends(plus: Any, r: float) -> None:
    """Below r = 1 the origin is left, and Newton's method would go there."""
    with pytest.raises(st.StabilityError, match="stopped at a pitchfork at r = 1,"):
        plus.member([r], [10.0, B])
    with pytest.raises(st.StabilityError, match=r"no member at r = "):
        st.spectrum(plus, at=[2.0, r], sigma=10, b=B)


@pytest.mark.parametrize("count", [5, pytest.param(60, marks=pytest.mark.long)])
def test_a_branch_point_is_named_wherever_the_question_lies(plus: Any, count: int) -> None:
    for r in np.random.default_rng(6).uniform(-500, 1, count):
        said = plus.search([[r]], [[10.0, B]]).why(0)
        assert "stopped at a pitchfork at r = 1, where another branch crosses; " in said
        assert said.endswith("its switch follows the other branch.")
    run = st.branch(plus, 28, -3, [10, B], points=11)
    [point] = run.branch_points
    assert (point.kind, point.value) == ("pitchfork", pytest.approx(1.0, abs=1e-12))
    assert np.abs(point.switch(-3.0).state).max() < 1e-12  # the remedy: the origin goes on


def test_a_branch_of_a_bare_system_is_refused_with_the_way_to_a_family(lorenz: Any) -> None:
    with pytest.raises(
        st.StabilityError,
        match=r"family is a System; give a stability.Family: "
        r"system\.steady\(at, guess=\{…\}\), disk_family\(…\), body\.family\(…\)\.",
    ):
        st.branch(lorenz, 2, 28, [10, B])


def test_a_member_beyond_a_fold_is_refused_though_another_sheet_has_one() -> None:
    """P = x³ - 3x: the lower sheet ends at x = -1, p = 2; at p = 4 the upper one has x = 2.1958."""
    system, _ = scalar(lambda x, p: p[0] - x**3 + 3 * x, "p")
    lower = system.steady("p", guess={"x": -2.0, "p": -2.0})
    exact = min(np.roots([1, 0, -3, -1.999]).real)
    assert lower.member([1.999], [])[0] == pytest.approx(exact, rel=1e-9)
    for p in (2.001, 4.0):
        with pytest.raises(st.StabilityError, match="stopped at a fold at p = 2"):
            lower.member([p], [])


def test_the_bead_on_a_hoop_does_not_fall_onto_the_lowest_point() -> None:
    """θ = arccos(g/(w² R)) ends in a pitchfork at w² = g/R; a tilt removes it."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], ca.sin(x[0]) * (p[0] ** 2 * ca.cos(x[0]) - 1) + p[1] - 0.3 * x[1])
    hoop = st.System("hoop", x, p, rates, states=("theta", "v"), parameters=("w", "tilt"))
    bead = hoop.steady("w", guess={"theta": 1.0, "w": 2.0, "tilt": 0.0})
    assert bead.member([1.01], [0.0])[0] == pytest.approx(math.acos(1.01**-2), rel=1e-12)
    for w in (0.2, 0.9, 0.999):
        with pytest.raises(st.StabilityError, match="stopped at a pitchfork at w = 1"):
            bead.member([w], [0.0])
        tilted = bead.member([w], [0.01])[0]  # the imperfect pitchfork joins both
        assert math.sin(tilted) * (w * w * math.cos(tilted) - 1) == pytest.approx(-0.01, rel=1e-9)
        assert tilted > 0


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-9])
def test_a_small_gap_is_not_jumped(gap: float) -> None:
    """x² = p² + gap²: the upper hyperbola stays positive, and its asymptotes cross at p = 0.

    A gap that is too narrow to be followed is a refusal.
    """
    system, _ = scalar(lambda x, p: p[0] ** 2 + gap**2 - x**2, "p")
    upper = system.steady("p", guess={"x": 1.0, "p": 1.0})
    p = np.array([-0.3, -1.0, -7.0])
    found = upper.search(p[:, None], np.zeros((3, 0)))
    assert np.allclose(found.u[found.good, 0], np.hypot(p, gap)[found.good], rtol=1e-12)
    if gap > 1e-5:
        assert found.good.all()


def test_a_member_goes_straight_through_a_crossing_branch() -> None:
    system, _ = scalar(lambda x, p: (x - ca.sin(p[0])) * (p[0] + x), "p")
    family = system.steady("p", guess={"x": 0.8, "p": 1.0})
    p = np.linspace(-2, 2, 7)[[0, 1, 2, 4, 5, 6]]
    assert np.allclose(family.member(p[:, None], [])[:, 0], np.sin(p), rtol=1e-10)


def test_the_governor_is_found_with_its_unknowns_and_equations() -> None:
    """X = arccos b, z = 1/√b (Sotomayor, Mello, Braga 2006); it ends at b = 1."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    rates = ca.vertcat(
        x[1],
        x[2] ** 2 * ca.sin(x[0]) * ca.cos(x[0]) - ca.sin(x[0]) - p[0] * x[1],
        p[1] * (ca.cos(x[0]) - p[2]),
    )
    watt = st.System("governor", x, p, rates, states=("x", "y", "z"), parameters=("e", "a", "b"))
    family = watt.steady(
        "b", guess={"x": 1.0, "z": 1.4, "e": 1.0, "a": 0.5, "b": 0.5}, positive=("x", "z")
    )
    b = np.linspace(0.1, 0.99, 12)
    found = family.member(b[:, None], [1.0, 0.5])
    assert np.allclose(found, np.column_stack([np.arccos(b), 0 * b, b**-0.5]), atol=1e-12)
    with pytest.raises(st.StabilityError, match="stopped at a branch point at b = 1"):
        family.member([1.2], [1.0, 0.5])
    # flutter at e = 2 a b^(3/2)
    at = 2 * 0.5 * 0.5**1.5
    words = [st.spectrum(family, at=0.5, e=e, a=0.5).verdict.word for e in (at + 1e-6, at - 1e-6)]
    assert words == ["stable", "unstable"]


def test_a_state_on_which_nothing_depends_is_left_out() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    system = st.System(
        "s",
        x,
        p,
        ca.vertcat(p - x[0] ** 2, p - x[0] ** 2),
        states=("x", "place"),
        parameters=("p",),
    )
    family = system.steady("p", guess={"x": 1.0, "p": 1.0})
    assert family.left_out == ("place",)
    assert family.equations == ("x",)
    assert np.allclose(family.member([4.0], []), [2.0, 0.0])


def test_the_sign_of_a_guess_is_kept_where_its_members_exist_on_one_side_only() -> None:
    """Bogdanov and Takens: x² + b x + a = 0 on x = (-b - sqrt(b² - 4 a))/2; trace -x."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], p[0] + p[1] * x[0] + x[0] ** 2 - x[0] * x[1])
    system = st.System("fold", x, p, rates, states=("x", "y"), parameters=("a", "b"))
    left = system.steady("a", guess={"x": -1.0, "a": -2.0, "b": -1.0})
    assert left.member([-2.0], [-1.0]) == pytest.approx([-1.0, 0.0])
    words = [st.spectrum(left, at=a, b=-1.0, certify=True).verdict.word for a in (-1e-12, 1e-12)]
    assert words == ["unstable", "stable"]
    (edge,) = st.boundaries(left, axis=("a", -1, 0.2, 4), b=-1.0)
    assert (edge.value, edge.crossing.word) == (0.0, "flutter")


def test_a_family_that_travels_to_another_process_stays_itself(plus: Any) -> None:
    back = pickle.loads(pickle.dumps(plus.anchor))
    assert back == plus.anchor
    assert back.unknown == pytest.approx([math.sqrt(72), math.sqrt(72), 27.0], rel=1e-14)


def test_what_does_not_fit_is_refused_in_one_sentence(lorenz: Any) -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"guess": {"x": 1.0}}, "guess needs a value of r, sigma and b"),
        ({"guess": {"w": 1.0}}, "guess names 'w'; known are x, y, z, sigma, r, b"),
        ({"guess": {"r": 2.0}, "r": 3.0}, "'r' is given in guess and by name"),
        ({"guess": {"x": math.nan}}, "guess x"),
        ({"held": {"w": 1.0}}, "state is 'w'"),
        ({"guess": {"r": 2.0, "sigma": 1, "b": 1}, "equations": ("x",)}, "3 unknowns and 1 eq"),
    ]
    for given, said in cases:
        with pytest.raises(st.StabilityError, match=said) as caught:
            lorenz.steady("r", **given)
        assert "\n" not in str(caught.value)
    nothing, _ = scalar(lambda x, p: p[0] + x**2, "p")
    with pytest.raises(st.StabilityError, match="no member that damped Newton steps reach"):
        nothing.steady("p", guess={"x": 1.0, "p": 1.0})
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    free = st.System(
        "f", x, p, ca.vertcat(x[0] * x[1] - p, 0), states=("x", "y"), parameters=("p",)
    )
    with pytest.raises(st.StabilityError, match="leave 1 of the unknowns x and y op"):
        free.steady("p", guess={"x": 1.0, "y": 1.0, "p": 1.0})


@pytest.mark.parametrize("guess", [(0.49, 0.87), (0.3, 0.3), (0.6, 0.4), (0.1, 1.5), (0.5, 0.5)])
def test_the_triangular_point_above_is_found_where_only_that_one_is_admissible(
    guess: tuple[float, float],
) -> None:
    """At x = 1/2 - m, y = √3/2; below lies its mirror image, and between are three with y = 0."""
    x, y, u, v, m = (ca.SX.sym(n) for n in ("x", "y", "u", "v", "m"))
    far = ca.sqrt((x + m) ** 2 + y**2), ca.sqrt((x + m - 1) ** 2 + y**2)
    potential = (x**2 + y**2) / 2 + (1 - m) / far[0] + m / far[1]
    pull = ca.gradient(potential, ca.vertcat(x, y)) + 2 * ca.vertcat(v, -u)
    bodies = system_of("three bodies", [x, y, u, v], [m], [u, v, pull])
    family = st.Family(
        bodies,
        "L4",
        at=("m",),
        held={"u": 0, "v": 0},
        equations=("u", "v"),
        positive=("y",),
        unknown={"x": guess[0], "y": guess[1]},
        typical={"m": 0.02},
    )
    share = np.linspace(0.005, 0.495, 50)[:, None]
    found = family.search(share, np.zeros((50, 0)))
    above = np.hypot(found.u[:, 0] - 0.5 + share[:, 0], found.u[:, 1] - 0.75**0.5) < 1e-12
    assert (above == found.good).all() and found.good.sum() >= 49


def test_members_next_to_a_pitchfork_are_not_refused_by_luck() -> None:
    """X = y exists for all p > 0: q x² + (1 + p) x = 1.  Lines cross a pitchfork near p = 1."""
    x, y, p, q = (ca.SX.sym(n) for n in "xypq")
    rates = ca.vertcat(x * (1 - x - p * y - q * x**2), y * (1 - y - p * x - q * y**2))
    system = system_of("rivals", [x, y], [p, q], rates)
    even = system.steady("p", guess={"x": 0.6, "y": 0.6, "p": 0.5}, q=0.1)
    grid = np.meshgrid(np.linspace(0.1, 3, 40), np.linspace(0.01, 0.5, 30))
    at, other = grid[0].ravel(), grid[1].ravel()
    found = even.search(at[:, None], other[:, None])
    assert found.good.all()
    exact = (np.sqrt((1 + at) ** 2 + 4 * other) - 1 - at) / (2 * other)
    assert np.allclose(found.u, exact[:, None], rtol=1e-10)


def test_a_side_branch_does_not_go_on_as_the_middle_one() -> None:
    """X = c ± √(1/3 - p) ends at a pitchfork, beyond which x = c has a slope of the same sign."""
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    for c in (0.0, 2.0, 1000.0):
        rate = -((x - c) ** 3) - (p - 1 / 3) * (x - c)
        system = st.System("s", x, p, rate, states=("x",), parameters=("p",))
        side = system.steady("p", guess={"x": c + 1, "p": -2 / 3})
        stops = np.array([[0.34], [0.5], [1.0], [7.0]])
        assert not side.search(stops, np.zeros((4, 0))).good.any()
        assert side.search(np.array([[0.33]]), np.zeros((1, 0))).good.all()


def test_a_member_that_runs_to_infinity_is_refused_in_a_sentence() -> None:
    """A stirred tank reactor: towards D = 0 the equations overflow, and again where D < 0."""
    x, y, b, c, d = (ca.SX.sym(n) for n in ("x", "y", "B", "c", "D"))
    rate = d * (1 - x) * ca.exp(y)
    tank = system_of("tank", [x, y], [b, c, d], [-x + rate, -y + b * rate - c * y])
    hot = tank.steady("D", guess={"x": 0.7, "y": 3.0, "D": 0.15}, B=7.06, c=0.74)
    given = np.array([0.15, 7.06, 0.74]) + [-0.155, 204.74, -0.925]
    found = hot.search(given[None, :1], given[None, 1:])
    assert not found.good[0]
    assert "it stopped at D = " in found.why(0)


def test_a_place_may_move() -> None:
    """A car at v = F/b; one that rests, or drives by v (1 - v); a cart that turns in circles."""
    x, v, f, b = (ca.SX.sym(n) for n in ("x", "v", "F", "b"))

    def car(rate: ca.SX) -> st.System:
        return st.System(
            "car",
            ca.vertcat(x, v),
            ca.vertcat(f, b),
            ca.vertcat(v, rate),
            states=("x", "v"),
            parameters=("F", "b"),
        )

    for guess in ({"v": 1.0}, {"x": 3.0, "v": 1.0}, {}):
        cruise = car(f - b * v).steady("F", guess={**guess, "F": 1.0}, b=1.0)
        assert cruise.member([3.0], [0.5])[1] == pytest.approx(6.0)
        assert st.spectrum(cruise, at=3.0, b=0.5).eigenvalues == pytest.approx(-0.5)
    own = car(v * (f - b * v))
    assert own.steady("F", guess={"v": 0.9, "F": 1.0}, b=1.0).member([2.0], [1.0])[1] == 2.0
    assert car(f * x - f * x - 0 * v).steady("F", guess={"F": 1.0}, b=1.0).held == {"x": 0.0}
    free = car(ca.SX(0)).steady("F", held={"v": 1.0}, guess={"F": 1.0, "b": 1.0})
    assert free.left_out == ("x",)

    y, heading, turn, m = (ca.SX.sym(n) for n in ("y", "heading", "turn", "M"))
    cart = system_of(
        "cart",
        [x, y, heading, v, turn],
        [f, m],
        [v * ca.cos(heading), v * ca.sin(heading), turn, f - v, m - 2 * turn],
    )
    circle = cart.steady("F", guess={"v": 1.0, "turn": 1.0, "F": 1.0}, M=1.0)
    assert circle.member([2.0], [3.0])[3:] == pytest.approx([2.0, 1.5])


@pytest.mark.parametrize("guess", [(-math.pi / 3, math.pi / 3, math.pi / 3), (-1.2, 1.1, 0.9)])
def test_three_hinged_bars_hang_at_the_pose_of_their_guess(guess: tuple[float, ...]) -> None:
    """Bars of length 1 between hinges 2 apart hang as half a hexagon.

    There the outer bars turn at ω and the middle one at -ω, so T = 3/4 ω² and V'' = 5 g/√3.
    """
    q, u, g, c = ca.SX.sym("q", 3), ca.SX.sym("u", 3), ca.SX.sym("g"), ca.SX.sym("c")
    angle, turn = ca.cumsum(q), ca.cumsum(u)
    x = y = vx = vy = kinetic = potential = ca.SX(0)
    for i in range(3):
        sine, cosine = ca.sin(angle[i]), ca.cos(angle[i])
        kinetic += ((vx - sine * turn[i] / 2) ** 2 + (vy + cosine * turn[i] / 2) ** 2) / 2
        kinetic += turn[i] ** 2 / 24
        potential += g * (y + sine / 2)
        x, y, vx, vy = x + cosine, y + sine, vx - sine * turn[i], vy + cosine * turn[i]
    bars = st.mechanics(
        q,
        u,
        ca.vertcat(g, c),
        kinetic=kinetic,
        potential=potential,
        forces=ca.vertcat(-c * u[0], 0, 0),
        holonomic={"X": x - 2, "Y": y},
        independent=("u_0",),
    )
    pose = dict(zip(("q_0", "q_1", "q_2"), guess, strict=True))
    hang = bars.steady("g", guess={**pose, "g": 9.81}, c=0.1)
    found = st.spectrum(hang, at=9.81, c=0.1)
    assert found.verdict.word == "stable"
    assert found.eigenvalues == pytest.approx(np.sort(np.roots([1.5, 0.1, 5 * 9.81 / 3**0.5])))


def test_the_member_of_a_system_without_parameters_needs_no_name() -> None:
    """Two wells with damping 0.2: λ² + λ/5 + 2 at each bottom; as with the damping as parameter."""
    x, v, c = ca.SX.sym("x"), ca.SX.sym("v"), ca.SX.sym("c")

    def wells(p: ca.SX, damping: Any, names: tuple[str, ...]) -> st.System:
        rates = ca.vertcat(v, x - x**3 - damping * v)
        return st.System("wells", ca.vertcat(x, v), p, rates, states=("x", "v"), parameters=names)

    plain, other = wells(ca.SX(0, 1), 0.2, ()), wells(c, c, ("c",))
    right = st.Family(plain, "right", at=(), held={"x": 1, "v": 0})
    found = st.spectrum(right)
    assert found.verdict.word == "stable"
    assert found.eigenvalues == pytest.approx(np.sort(np.roots([1, 0.2, 2])))
    assert repr(found).startswith("<Spectrum of right: stable; 2 eigenvalues: ")
    assert st.spectrum(plain.steady((), guess={"x": 0.8})).eigenvalues == pytest.approx(
        found.eigenvalues
    )
    named = st.Family(other, "right", at=("c",), held={"x": 1, "v": 0})
    grid: dict[str, Any] = {"x": ("x", -2, 2, 4), "y": ("v", -1, 1, 3), "horizon": 100}
    alone = st.basins(plain, families=right, **grid).outcome
    assert (alone == st.basins(other, families=named, c=0.2, **grid).outcome).all()
    assert 0.3 < float((alone == 1).mean()) < 0.7
    end = st.simulate(plain, start={"x": 1.2, "v": 0.1}, times=200.0, families=right)
    assert "settled" in str(end.outcome.attrs) and end.outcome == 1
    for call in (
        lambda: st.boundaries(right, axis=("x", 0, 1, 5)),
        lambda: st.branch(right, 0, 1),
        lambda: st.spectrum(right, at=1.0),
    ):
        with pytest.raises(st.StabilityError, match="right has one member alone"):
            call()
    with pytest.raises(st.StabilityError, match="at is empty"):
        st.Family(other, "right", at=(), held={"x": 1, "v": 0})
    by_state = st.Family(plain, "right", at=("x",), held={"v": 0})
    with pytest.raises(st.StabilityError, match="not steady where x changes a little"):
        st.basins(plain, families=by_state, **grid)


def test_a_guess_at_which_the_slope_vanishes_finds_a_member() -> None:
    """Roots p and -q: between them, at p = q + 2, lies the guess 1, where the slope is 0."""
    x, p, q = (ca.SX.sym(n) for n in "xpq")
    system = st.System(
        "c", x, ca.vertcat(p, q), -(x - p) * (x + q), states=("x",), parameters=("p", "q")
    )
    family = st.Family(system, "m", at=("p",), unknown={"x": 1.0}, equations=("x",))
    assert float(st.spectrum(family, at=3.0, q=1.0).states[0]) in (3.0, -1.0)
    assert 4 not in st.stability_map(family, x=("p", 2, 4, 5), y=("q", 0.5, 1.5, 3)).verdict
