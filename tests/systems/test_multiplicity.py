"""What is left out of a spectrum is zero at the member asked for, by proof; else it stays in."""

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability import Verdict
from stability.algebra.exact.function_field import FunctionField
from stability.algebra.exact.number_fields import NotExact, characteristic, vanishes
from stability.algebra.exact.roots import clustered
from stability.base.errors import DomainError, ParameterError
from stability.polynomials.identities import certain, identity


def _system(name: str, states: str, rhs, parameters: str = "p") -> st.System:
    x, p = ca.SX.sym("x", len(states)), ca.SX.sym("p", len(parameters))
    return st.System(
        name, x, p, ca.vertcat(*rhs(x, p)), states=tuple(states), parameters=tuple(parameters)
    )


def _hop() -> st.Family:
    """Branches y = 1, with a zero for every p, and y = 1 + p, with eigenvalues -p, p/10, -1."""
    system = _system(
        "hop", "yzw", lambda x, p: ((x[0] - 1) * (p - (x[0] - 1)), 0.1 * (x[0] - 1) * x[1], -x[2])
    )
    return st.Family(
        system,
        "steady",
        at=("p",),
        held={"z": 0.0, "w": 0.0},
        unknown={"y": 1.3},
        equations=("y",),
    )


WAYS = [{}, {"certify": True}, {"escalate": False}, {"certify": True, "escalate": False}]


@pytest.mark.parametrize("way", WAYS)
def test_a_member_on_another_branch_keeps_its_eigenvalues(way: dict[str, bool]) -> None:
    found = st.spectrum(_hop(), at=0.31, **way)
    assert found.states[0] == pytest.approx(1.31)
    assert found.verdict is Verdict.UNSTABLE
    assert found.structural_zeros == 0
    assert found.eigenvalues.real == pytest.approx([-1, -0.31, 0.031], rel=1e-14)
    assert "none is so here by structure" in found.reason


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("size", [ca.fabs, lambda v: ca.sqrt(v * v)])
def test_an_absolute_value_has_another_structure_on_its_other_side(size, way) -> None:
    """The eigenvalue (|p| - p)/10 is zero for p > 0 and p/5 below."""
    system = _system("kink", "yz", lambda x, p: ((size(p) - p) * 0.1 * x[0], -x[1]))
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    found = st.spectrum(rest, at=-1.0, **way)
    assert found.verdict is Verdict.UNSTABLE
    assert found.abscissa == pytest.approx(0.2)
    above = st.spectrum(rest, at=1.0, **way)
    assert above.verdict is Verdict.STABLE
    assert above.structural_zeros == 1
    # at the kink the zero is there on one side only: it counts
    assert st.spectrum(rest, at=0.0, certify=True).verdict is Verdict.NEUTRAL
    # below every rounding of the other eigenvalue, and decided where that is allowed
    tiny = st.spectrum(rest, at=-1e-20, **way)
    assert tiny.verdict is not Verdict.STABLE or way == {"escalate": False}
    if way != {"escalate": False}:
        assert tiny.verdict is Verdict.UNSTABLE


def test_points_of_one_request_leave_out_the_same_number() -> None:
    system = _system("kink", "yz", lambda x, p: ((ca.fabs(p) - p) * 0.1 * x[0], -x[1]))
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    found = st.spectrum(rest, at=[-1.0, 1.0])
    assert found.structural_zeros == 0
    assert found.eigenvalues.real == pytest.approx(np.array([[-1, 0.2], [-1, 0.0]]))
    assert [v.word for v in found.verdict] == ["unstable", "stable"]  # as each alone, and as a map
    assert [v.word for v in st.spectrum(rest, at=[2.0, 1.0]).verdict] == ["stable", "stable"]


@pytest.mark.long
def test_a_map_keeps_them_too() -> None:
    system = _system("kink", "yz", lambda x, p: ((ca.fabs(p[0]) - p[0]) * x[0], -p[1] * x[1]), "pq")
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    drawn = st.stability_map(rest, x=("p", -1.0, 1.0, 4), y=("q", 0.5, 1.5, 2))
    assert (drawn.verdict.values[:, :2] == Verdict.UNSTABLE.code).all()
    assert (drawn.verdict.values[:, 2:] == Verdict.STABLE.code).all()
    assert drawn.abscissa.values[0] == pytest.approx([2.0, 2 / 3, -0.5, -0.5])
    with pytest.raises(DomainError, match="leave out modes"):
        st.stability_map(rest, x=("p", -1.0, 1.0, 4), y=("q", 0.5, 1.5, 2), modes=True)


def test_a_zero_that_an_algebraic_root_makes_is_proved() -> None:
    """On y = √p the second eigenvalue y² - p vanishes on the branch only."""
    system = _system("root", "yz", lambda x, p: (p - x[0] ** 2, (x[0] ** 2 - p) * x[1]))
    branch = st.Family(
        system, "root", at=("p",), held={"z": 0.0}, unknown={"y": 1.0}, equations=("y",)
    )
    assert identity(branch).zeros == 1  # the entry is a multiple of the equation
    for at in (2.0, 4.0, 0.3):
        found = st.spectrum(branch, at=at, certify=True)
        assert (found.structural_zeros, found.verdict) == (1, Verdict.STABLE)
        assert found.eigenvalues[0].real == pytest.approx(-2 * at**0.5, rel=1e-14)


def test_a_zero_that_one_of_two_algebraic_branches_makes_is_proved_there() -> None:
    """On y² = p the second eigenvalue vanishes; on y = 3 it does not."""
    system = _system(
        "two", "yz", lambda x, p: ((p - x[0] ** 2) * (3 - x[0]), (x[0] ** 2 - p) * x[1])
    )
    for guess, at, zeros, wanted in ((1.4, 2.0, 1, "stable"), (3.1, 2.0, 0, "unstable")):
        branch = st.Family(
            system,
            "two",
            at=("p",),
            held={"z": 0.0},
            unknown={"y": guess},
            equations=("y",),
            typical={"p": 2.0},
        )
        found = st.spectrum(branch, at=at, certify=True)
        assert found.structural_zeros == zeros
        assert found.verdict.word == wanted
    start = st.Family(
        system, "two", at=("p",), held={"z": 0.0}, unknown={"y": 1.4}, equations=("y",)
    )
    assert not certain(start)  # neither branch speaks for the other


def test_a_zero_that_a_transcendental_equation_makes_is_proved() -> None:
    """The second eigenvalue is a multiple of the equation for any root."""
    system = _system("log", "yz", lambda x, p: (p - ca.exp(x[0]), (ca.exp(x[0]) - p) * x[1]))
    branch = st.Family(
        system, "log", at=("p",), held={"z": 0.0}, unknown={"y": 0.5}, equations=("y",)
    )
    found = st.spectrum(branch, at=2.0, certify=True)
    assert (found.structural_zeros, found.verdict) == (1, Verdict.STABLE)
    assert found.eigenvalues[0].real == pytest.approx(-2.0, rel=1e-14)


def test_a_zero_that_nothing_proves_stays_in_and_leaves_the_verdict_open() -> None:
    """exp(y) = p makes exp(2y) - p² vanish; that exp(2y) = exp(y)² is not known."""
    system = _system(
        "log", "yz", lambda x, p: (p - ca.exp(x[0]), (ca.exp(2 * x[0]) - p * p) * x[1])
    )
    branch = st.Family(
        system, "log", at=("p",), held={"z": 0.0}, unknown={"y": 0.5}, equations=("y",)
    )
    for way in ({}, {"certify": True}):
        found = st.spectrum(branch, at=2.0, **way)
        assert found.verdict is Verdict.UNDECIDED
        assert found.structural_zeros == 0
        assert "none is so here by structure" in found.reason
        assert (np.abs(found.eigenvalues - [-2.0, 0.0]) <= found.radius + 1e-15).all()


@pytest.mark.parametrize(
    ("rates", "zeros", "even"),
    [
        (lambda x, p: (0 * p, p[0] * x[2], -ca.sin(x[1])), 1, True),  # an ignorable coordinate
        (lambda x, _: (x[1] + x[2], -x[1] - x[2], x[0]), 1, False),  # y + z is conserved
        (lambda x, p: ((ca.sin(p[0]) ** 2 + ca.cos(p[0]) ** 2 - 1) * x[0], x[2], -x[1]), 1, True),
        (lambda x, p: (x[1], 0 * p, -x[2]), 2, False),  # a Jordan block
        (lambda x, p: (x[1], -p[0] * x[0], -x[2]), 0, False),
    ],
)
def test_identities_are_found_in_the_expressions(rates, zeros: int, even: bool) -> None:
    system = _system("identity", "yzw", rates)
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys("yzw", 0.0))
    found = identity(rest)
    assert found.zeros == zeros
    assert found.even == even
    assert certain(rest)


def test_expressions_know_the_relations_of_their_functions() -> None:
    field = FunctionField(["a", "b"])
    a, b = field.symbols
    sine, cosine = a.function("sin"), a.function("cos")
    assert vanishes(sine * sine + cosine * cosine - 1)
    assert vanishes((-a).function("sin") + sine)
    assert vanishes(a.function("tan") * cosine - sine)
    assert vanishes((a * a + 2 * a * b + b * b).sqrt() ** 2 - (a + b) ** 2)
    assert not vanishes((a * a).sqrt() - a)  # |a|
    assert not vanishes((a * a).fabs() - a * a)  # the sign of a² is not known to it
    # √(ab) is not b √(a/b) where both are negative
    assert not vanishes((a * b).sqrt() - b * (a / b).sqrt())
    assert vanishes((a / b).sqrt() ** 2 - a / b)
    assert vanishes(a / b * b - a)
    with pytest.raises(NotExact):
        1 / (sine**2 + cosine**2 - 1)


def test_the_characteristic_polynomial_needs_no_division() -> None:
    rng = np.random.default_rng(5)
    for size in range(1, 6):
        matrix = rng.integers(-4, 5, (size, size))
        assert characteristic(matrix.tolist()) == pytest.approx(np.poly(matrix)[::-1])


@pytest.mark.parametrize("force", [0.3, 2.2, 2.6, 4.5])
def test_certified_is_not_weaker_than_plain(force: float) -> None:
    """Ziegler's column without damping: Routh's array has a row of zeros at every force."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    stiff = ca.DM([[2.0, -1.0], [-1.0, 1.0]]) - ca.SX(ca.DM([[1.0, -1.0], [0.0, 0.0]])) * p[0]
    acceleration = ca.solve(ca.SX(ca.DM([[3.0, 1.0], [1.0, 1.0]])), -(stiff @ x[:2])) - p[1] * x[2:]
    column = st.System(
        "column",
        x,
        p,
        ca.vertcat(x[2:], acceleration),
        states=tuple("abcd"),
        parameters=("F", "damping"),
    )
    rest = st.Family(column, "straight", at=("F",), held=dict.fromkeys("abcd", 0.0))
    square = np.linalg.eigvals(np.linalg.solve([[3, 1], [1, 1]], [[2 - force, force - 1], [-1, 1]]))
    wanted = (
        Verdict.NEUTRAL
        if (square.imag == 0).all() and (square.real > 0).all()
        else (Verdict.UNSTABLE)
    )
    for way in ({}, {"certify": True}):
        assert st.spectrum(rest, at=force, damping=0.0, **way).verdict is wanted


def test_eigenvalues_that_coincide_are_given_with_their_verdict() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    pendulum = st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("g", "damping"),
    )
    hanging = st.Family(pendulum, "hanging", at=("g",), held={"angle": 0, "rate": 0})
    found = st.spectrum(hanging, at=[1.0, 2.0], damping=2.0, certify=True)
    assert [v.word for v in found.verdict] == ["stable", "stable"]
    assert (found.eigenvalues[0] == -1).all()
    assert (found.radius[0] == 0).all()
    # a member that is not rational: cos of a lean of one radian, balls and a cluster
    x = ca.SX.sym("x", 2)
    leaning = st.System(
        "leaning",
        x,
        p,
        ca.vertcat(
            x[1] - p[0] * 0, -(ca.cos(p[0]) ** 2) * x[0] - 2 * ca.cos(p[0]) * x[1] - p[1] * x[0]
        ),
        states=("angle", "rate"),
        parameters=("lean", "push"),
    )
    rest = st.Family(leaning, "rest", at=("lean",), held={"angle": 0, "rate": 0})
    twice = st.spectrum(rest, at=1.0, push=0.0, certify=True)
    assert twice.verdict is Verdict.STABLE
    assert (np.abs(twice.eigenvalues + np.cos(1.0)) <= twice.radius + 1e-16).all()
    assert (twice.radius < 1e-15).all()


def test_a_cluster_holds_as_many_roots_as_it_says() -> None:
    from flint import arb

    # (x - 1)³ (x + 2), each coefficient known to 1e-30
    exact = [-2, 5, -3, -1, 1]
    coefficients = [arb(c) + arb(0, 1e-30) for c in exact[:-1]] + [arb(1)]
    roots = clustered(coefficients)
    held = [sum(r.real.contains(v) and r.imag.contains(0) for r in roots) for v in (1, -2)]
    assert held == [3, 1]
    assert all(float(r.real.rad()) < 1e-5 for r in roots)


def test_a_point_left_open_is_certified_by_itself_and_says_so() -> None:
    at = np.array([1.8, 2**0.5])  # rolling, k = 1/4: the boundary is at √2
    plain = st.spectrum("rolling", at=at, contact=st.Viscous(0.3), escalate=False)
    assert [v.word for v in plain.verdict] == ["stable", "undecided"]
    found = st.spectrum("rolling", at=at, contact=st.Viscous(0.3))
    assert found.verdict[1] is not Verdict.UNDECIDED
    assert found.certified.tolist() == [False, True]
    assert (found.eigenvalues[0] == plain.eigenvalues[0]).all()
    one = st.spectrum("rolling", at=float(at[1]), contact=st.Viscous(0.3))
    assert one.reason.startswith("double precision left it open; proved in rational arithmetic")
    with pytest.raises(ParameterError, match="escalate is 1"):
        st.spectrum("rolling", at=1.0, contact=st.Viscous(0.3), escalate=1)


@pytest.mark.parametrize(
    ("terms", "truth"),
    [
        ([1.0, 1e-30, -1.0], "1/1000000000000000000000000000000"),
        ([1e16, 1.0, -1e16], "1"),
        ([0.1, 0.2, -0.3], None),
        ([-0.3, -0.1], None),
    ],
)
def test_numbers_of_the_graph_are_taken_as_exact(terms: list[float], truth: str | None) -> None:
    """CasADi adds the coefficients of Σ c x in doubles when it differentiates; the sum is exact."""
    from fractions import Fraction

    exact = sum(map(Fraction, terms), Fraction(0))
    assert truth is None or abs(exact - Fraction(truth)) < Fraction(1, 10**46)

    def rates(x, p):
        total = 0
        for c in terms:
            total = total + c * x[0]
        return total, -p * x[1]

    rest = st.Family(_system("sum", "yz", rates), "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    wanted = Verdict.UNSTABLE if exact > 0 else Verdict.STABLE
    for way in WAYS:
        found = st.spectrum(rest, at=1.0, **way)
        open_ = (Verdict.UNDECIDED,) if way == {"escalate": False} else ()
        assert found.verdict in (wanted, *open_)
        gaps = [abs(Fraction(v.real) - exact) for v in found.eigenvalues]
        best = int(np.argmin([float(g) for g in gaps]))
        assert gaps[best] <= Fraction(float(found.radius[best]))


def test_a_held_value_is_not_rounded_into_the_graph() -> None:
    """sin(1)² + cos(1)² - 1 is zero; in doubles, folded, it need not be."""

    def rates(x, p):
        return 0 * p, (ca.sin(x[0]) ** 2 + ca.cos(x[0]) ** 2 - 1 - p) * x[1]

    system = _system("held", "yz", rates)
    rest = st.Family(system, "rest", at=("p",), held={"y": 1.1, "z": 0.0})
    found = st.spectrum(rest, at=1e-40, certify=True)
    assert found.verdict is Verdict.STABLE
    assert found.eigenvalues[-1].real == pytest.approx(-1e-40, rel=1e-12)


def test_the_error_of_a_root_reaches_the_discs_next_to_a_double_root() -> None:
    system = _system("fold", "yz", lambda x, p: (-(x[0] - 1) * (x[0] - 1 - p), (x[0] - 1) * x[1]))
    branch = st.Family(
        system, "fold", at=("p",), held={"z": 0.0}, unknown={"y": 1.3}, equations=("y",)
    )
    for way in ({}, {"escalate": False}):
        found = st.spectrum(branch, at=0.0, **way)  # truth: both eigenvalues are zero
        assert found.verdict is Verdict.UNDECIDED
        assert (np.abs(found.eigenvalues) <= found.radius).all()


def test_a_spectrum_without_eigenvalues_is_refused() -> None:
    system = _system(
        "empty",
        "yz",
        lambda x, p: (
            ((p + 0.5) * (p + 0.5) - p * p - p - 0.25) * x[0],
            ((p - 1) * (p + 1) - (p * p - 1)) * x[1],
        ),
    )
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    for way in WAYS:
        with pytest.raises(DomainError, match="every eigenvalue is zero by structure"):
            st.spectrum(rest, at=1.0, **way)


@pytest.mark.parametrize("way", WAYS)
def test_an_even_polynomial_that_is_not_even_elsewhere_is_not_taken_as_even(way) -> None:
    system = _system("half", "yvz", lambda x, p: (x[1], -x[0], (ca.fabs(p) - p) * x[2]))
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys("yvz", 0.0), conservative=True)
    assert not certain(rest)
    found = st.spectrum(rest, at=-1.0, **way)
    assert found.verdict is Verdict.UNSTABLE
    assert found.abscissa == pytest.approx(2.0)
    if way != {"escalate": False}:
        assert st.spectrum(rest, at=1.0, **way).verdict is Verdict.NEUTRAL


@pytest.mark.few(7)
@pytest.mark.parametrize(
    "name",
    [
        "sin",
        "cos",
        "tan",
        "exp",
        "log",
        "sqrt",
        "asin",
        "acos",
        "atan",
        "sinh",
        "cosh",
        "tanh",
        "fabs",
    ],
)
def test_errors_hold_to_every_order(name: str) -> None:
    """The value at any point within the error is within the stated error of the value."""
    import mpmath

    from stability.algebra.running_error import TRACKED, RunningError

    rng = np.random.default_rng(11)
    x = rng.uniform(0.05, 0.9, 200)
    e = x * 10.0 ** rng.uniform(-17, 0.05, 200)
    with np.errstate(all="ignore"):
        found = TRACKED.functions[name](RunningError(x, e))
    function = getattr(mpmath, {"log": "ln"}.get(name, name))
    for i in range(200):
        for share in (-1.0, -0.5, 1.0):
            exact = function(mpmath.mpf(x[i]) + share * mpmath.mpf(e[i]))
            if isinstance(exact, mpmath.mpc) or not mpmath.isfinite(exact):
                assert not found.error[i] < 1e300
                continue
            assert not abs(exact - mpmath.mpf(float(found.value[i]))) > found.error[i] * 1.01


def test_the_command_line_can_forbid_it(capsys: pytest.CaptureFixture[str]) -> None:
    import json

    from stability.cli import main

    words = []
    for flags in ([], ["--no-escalate"], ["--certify"]):
        main(["spectrum", "rolling", "--at", repr(2**0.5), "--mu", "0.3", "--json", *flags])
        record = json.loads(capsys.readouterr().out)
        words.append((record["verdict"], record["certified"]))
    assert words == [("stable", True), ("undecided", False), ("stable", True)]


@pytest.mark.long
def test_boundaries_keep_to_the_zeros_of_each_member() -> None:
    """|p| - p - 1/2 changes its sign at p = -1/4; for p > 0 it is constant."""
    system = _system("kink", "yz", lambda x, p: ((ca.fabs(p[0]) - p[0] - p[1]) * x[0], -x[1]), "pq")
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    every = st.boundaries(rest, axis=("p", -1, 1, 21), q=0.5)
    (found,) = every
    assert every.complete  # a kink of a coefficient is no crossing
    assert abs(found.value + 0.25) <= found.error
    system = _system("half", "yz", lambda x, p: ((ca.fabs(p) - p) * x[0], -x[1]))
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "z": 0.0})
    with pytest.warns(st.StabilityWarning):  # zero all along for p > 0, growing below
        (found,) = st.boundaries(rest, axis=("p", -1, 1, 20))
    assert abs(found.value) <= found.error
    assert not found.stable_below
    assert found.frequency == 0.0


def test_large_entries_at_typical_members_hide_no_zero() -> None:
    """A line of steady motions; next to it an entry of 1e40 where the zeros are counted."""
    system = _system(
        "large",
        "yzvw",
        lambda x, p: (
            x[2] - x[0] ** 2,
            -0.4375 * x[1],
            x[1] - 0.1 * (x[2] - x[0] ** 2),
            -(2.0**20) * p**9 * x[3],
        ),
    )
    line = st.Family(
        system,
        "line",
        at=("y",),
        held={"z": 0.0, "w": 0.0},
        unknown={"v": 0.1},
        equations=("y",),
        typical={"p": 1e15},
    )
    found = st.spectrum(line, at=0.3, p=1.0, certify=True)
    assert found.structural_zeros == 1
    assert found.verdict is Verdict.STABLE


def test_a_null_vector_that_rounding_leaves_open_bounds_nothing() -> None:
    """In doubles the last entry, which is 1, is 0 ± 2; the zero is that of the third."""
    system = _system(
        "open",
        "abcd",
        lambda x, p: (-1e-30 * x[0], 1e-30 * x[1], 0 * p, 1e16 * x[3] + x[3] + (-1e16) * x[3]),
    )
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys("abcd", 0.0))
    plain = st.spectrum(rest, at=1.0, escalate=False)
    assert (np.abs(plain.eigenvalues - 1.0) <= plain.radius).any()
    found = st.spectrum(rest, at=1.0)
    assert found.eigenvalues.real == pytest.approx([-1e-30, 1e-30, 1.0])
    assert found.structural_zeros == 1


@pytest.mark.few(3)
@pytest.mark.parametrize("p", [0.1, 0.10000000000000002, 0.3])
@pytest.mark.parametrize("rate", [1.0, 131072.0])
def test_a_root_at_zero_is_enclosed(p: float, rate: float) -> None:
    """Newton's method tends to the root 0 without end; the ball must still hold it."""
    from flint import arb

    from stability.algebra.number_types import precision
    from stability.systems.structure.enclosure import ball_unknowns

    system = _system("zero", "yz", lambda x, q: (-(x[0] + q) * x[0], rate * q * x[0] * x[1]))
    branch = st.Family(
        system, "zero", at=("p",), held={"z": 0.0}, unknown={"y": 2.0}, equations=("y",)
    )
    for bits in (64, 128, 512):
        with precision(bits):
            [ball] = ball_unknowns(branch, [arb(p)], [])
        assert ball.contains(0)
    for way in ({}, {"certify": True}):  # eigenvalues -p and 0, for every p on this branch
        found = st.spectrum(branch, at=p, **way)
        assert (found.verdict, found.structural_zeros) in (
            (Verdict.STABLE, 1),
            (Verdict.NEUTRAL, 0),
        )


def test_a_zero_that_is_flat_is_not_structural() -> None:
    """The power p**40 vanishes at p = 0 alone, however small it is next to the other entries."""
    system = _system(
        "flat",
        "yzw",
        lambda x, p: (p**40 * x[0] + x[1], -x[1] + 0.3 * x[2], -2 * x[2] + 0.1 * x[1]),
    )
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys("yzw", 0.0), typical={"p": 1e-9})
    for way in ({}, {"certify": True}):
        found = st.spectrum(rest, at=0.0, **way)
        assert (found.structural_zeros, found.verdict) == (0, Verdict.NEUTRAL)
        assert st.spectrum(rest, at=0.5, **way).verdict is Verdict.UNSTABLE
