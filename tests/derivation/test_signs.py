"""Proofs of signs: never wrong at random points, edges included; conditions of random families."""

import random
from fractions import Fraction
from typing import Any

import casadi as ca
import pytest
import sympy
from flint import Ordering, fmpq, fmpq_mpoly_ctx

import stability as st
from stability.algebra.exact.function_field import evaluate
from stability.algebra.exact.hurwitz_forms import Budget, hurwitz_determinants, subdiscriminants
from stability.derivation.signs import Bounds, Domain

F = Fraction
RING = fmpq_mpoly_ctx.get(("x", "y", "z"), Ordering.degrevlex)
X, Y, Z = RING.gens()


def random_poly(chance: random.Random) -> Any:
    """A sparse polynomial, mostly with positive coefficients."""
    total = RING.constant(0)
    for _ in range(chance.randrange(1, 5)):
        powers = X ** chance.randrange(3) * Y ** chance.randrange(3) * Z ** chance.randrange(3)
        total = total + powers * fmpq(chance.randrange(-2, 7), chance.randrange(1, 4))
    return total


def inside(limits: Bounds, chance: random.Random) -> fmpq:
    """A point of an interval, often on or next to a bound."""
    tiny = fmpq(1, 10 ** chance.randrange(1, 9))
    if limits.free:
        return fmpq(chance.randrange(-30, 31), 10)
    if limits.high is None:
        on = limits.at_low and chance.random() < 0.4
        step = chance.choice((tiny, fmpq(chance.randrange(1, 90), 10), 1 / tiny))
        return limits.low + (0 if on else step)
    if limits.low is None:
        return limits.high - chance.choice((tiny, fmpq(chance.randrange(1, 90), 10)))
    if limits.at_low and chance.random() < 0.3:
        return limits.low
    if limits.at_high and chance.random() < 0.3:
        return limits.high
    width = limits.high - limits.low
    return limits.low + width * chance.choice((tiny, 1 - tiny, fmpq(chance.randrange(1, 9), 10)))


CHOICES = (
    (None, None, False),
    (fmpq(0), None, False),
    (fmpq(0), None, True),
    (None, fmpq(1), False),
    (fmpq(-1), fmpq(1), True),
    (fmpq(0), fmpq(1, 2), False),
    (fmpq(1), None, True),
)


def random_domain(chance: random.Random) -> Domain:
    domain = Domain(RING, "xyz")
    for index in range(3):
        low, high, closed = chance.choice(CHOICES)
        if (low, high) != (None, None):
            domain.bound(index, low, high, closed=closed)
    return domain


@pytest.mark.parametrize("count", [400, pytest.param(1500, marks=pytest.mark.long)])
def test_what_is_proved_positive_is_positive_everywhere_in_its_domain(count: int) -> None:
    chance = random.Random(7)
    proved = 0
    for _ in range(count):
        domain = random_domain(chance)
        poly = random_poly(chance)
        if poly == 0 or not domain.positive(poly):
            continue
        proved += 1
        for _ in range(40):
            point = {i: inside(domain.bounds.get(i, Bounds()), chance) for i in range(3)}
            assert evaluate(poly, point) > 0, (poly, domain.bounds, point)
    assert 15 * proved > 2 * count


@pytest.mark.parametrize(
    ("poly", "low", "high", "closed", "holds"),
    [
        (1 - X, fmpq(-1), fmpq(1), True, False),  # 0 on the bound
        (1 - X, fmpq(-1), fmpq(1), False, True),
        (2 - X, fmpq(-1), fmpq(1), True, True),
        (1 - X**2, fmpq(-1), fmpq(1), False, True),
        (X, fmpq(0), None, True, False),
        (X, fmpq(0), None, False, True),
        (X**2, None, None, False, False),  # 0 at 0
        (X**2 + X + 1, None, None, False, True),  # no real root
        (X**2 - 2, fmpq(3, 2), None, False, True),
        (X**2 - 2, fmpq(7, 5), None, False, False),
        (X**3 - 3 * X + 3, fmpq(0), fmpq(2), True, True),
    ],
)
def test_bounds_that_are_allowed_count(
    poly: Any, low: Any, high: Any, closed: bool, holds: bool
) -> None:
    domain = Domain(RING, "xyz")
    if (low, high) != (None, None):
        domain.bound(0, low, high, closed=closed)
    assert bool(domain.positive(poly)) is holds


@pytest.mark.parametrize("count", [250, pytest.param(700, marks=pytest.mark.long)])
def test_what_follows_from_a_condition_is_positive_where_it_is(count: int) -> None:
    chance = random.Random(9)
    found = 0
    for _ in range(count):
        domain, poly = random_domain(chance), random_poly(chance)
        given = Z * (random_poly(chance) * 0 + X**2 + 1) - random_poly(chance)
        if poly.is_constant() or not (proof := domain.implied(poly, given, "given")):
            continue
        found += 1
        assert "follows from given" in proof
        for _ in range(60):
            point = {i: inside(domain.bounds.get(i, Bounds()), chance) for i in range(3)}
            if evaluate(given, point) > 0:
                assert evaluate(poly, point) > 0
    assert 50 * found > count


def test_a_square_and_a_product_tell_the_sign_of_what_is_left() -> None:
    domain = Domain(RING, "xyz")
    domain.bound(0, fmpq(0))
    domain.learn(X * (Y - 1), "z**2, where z is not zero")
    assert domain.positive(Y) is not None
    assert domain.interval(1) == "y > 1"
    assert domain.sign((Y - 2) * X).open != ()


# --- forms against SymPy ---


def test_determinants_and_subdiscriminants_are_those_of_sympy() -> None:
    ring = fmpq_mpoly_ctx.get(tuple("abcde"), Ordering.degrevlex)
    names = sympy.symbols("a b c d e")
    low = list(ring.gens())[::-1]  # e + d λ + … + a λ⁴
    a, b, c, d, e = names
    rows = sympy.Matrix([[b, d, 0, 0], [a, c, e, 0], [0, b, d, 0], [0, a, c, e]])
    for n, value in enumerate(hurwitz_determinants(low, Budget(1000, 60)), start=1):
        assert sympy.expand(sympy.sympify(str(value).replace("^", "**")) - rows[:n, :n].det()) == 0
    y = sympy.Symbol("y")
    disc = sympy.discriminant(sympy.Poly(a * y**4 + b * y**3 + c * y**2 + d * y + e, y), y)
    last = sympy.sympify(str(subdiscriminants(low, Budget(1000, 60))[-1]).replace("^", "**"))
    assert sympy.expand(last - a**6 * disc) == 0


@pytest.mark.parametrize("count", [40, pytest.param(80, marks=pytest.mark.long)])
@pytest.mark.parametrize("order", [2, 3, 4])
def test_even_polynomials_are_neutral_where_every_square_is_real_and_negative(
    order: int, count: int
) -> None:
    """z⁽²ᵐ⁾ + a z⁽²ᵐ⁻²⁾ + …: Sturm's count of SymPy for the roots λ²."""
    x, p = ca.SX.sym("x", 2 * order), ca.SX.sym("p", order)
    chain = [*ca.vertsplit(x)[1:], -sum((p[i] * x[2 * i] for i in range(order)), ca.SX(0))]
    states = tuple(f"s{i}" for i in range(2 * order))
    names = tuple(f"a{i}" for i in range(order))
    system = st.System("even", x, p, ca.vertcat(*chain), states=states, parameters=names)
    found = st.conditions(st.Family(system, "rest", at=("a0",), held=dict.fromkeys(states, 0.0)))
    y = sympy.Symbol("y")
    chance = random.Random(order)
    words = []
    for _ in range(count):
        roots = [-F(chance.randrange(1, 30), 7) for _ in range(order)]
        exact = sympy.Poly(
            sympy.prod([y - sympy.Rational(r.numerator, r.denominator) for r in roots]), y
        )
        change = sympy.Rational(chance.randrange(-20, 21), 20) * chance.choice((0, 1, 3))
        exact = exact + sympy.Poly(change * y ** chance.randrange(order), y)
        values = [F(int(c.p), int(c.q)) for c in exact.all_coeffs()[::-1][:order]]
        distinct = exact.sqf_part()
        negative = distinct.count_roots(-sympy.oo, 0) - (distinct.eval(0) == 0)
        zero = distinct.degree() - negative == 1 and distinct.eval(0) == 0
        expected = "neutral" if negative == distinct.degree() or zero else "unstable"
        words.append(found.decide(dict(zip(names, values, strict=True))).word)
        assert words[-1] == expected, exact
    assert 6 * min(words.count("neutral"), words.count("unstable")) > count


# --- random families against certified spectra ---


def random_family(chance: random.Random) -> st.Family:
    """Three or four states; rates with products of parameters, sines, cosines and roots."""
    size = chance.choice((3, 4))
    x, p = ca.SX.sym("x", size), ca.SX.sym("p", 4)
    a, b, angle, u = ca.vertsplit(p)
    atoms = [a, b, ca.sin(angle), ca.cos(angle), ca.sqrt(u), a * b, a / (1 + b**2), ca.SX(1)]

    def entry() -> Any:
        if chance.random() < 0.35:
            return ca.SX(0)
        return chance.randrange(-2, 3) * chance.choice(atoms) + 0.5 * chance.choice(atoms)

    rates = []
    for i in range(size):
        line = sum((entry() * x[j] for j in range(size)), ca.SX(0))
        rates.append(line - 1.5 * x[i] + x[i] ** 2)
    states = tuple(f"s{i}" for i in range(size))
    system = st.System(
        "random", x, p, ca.vertcat(*rates), states=states, parameters=("a", "b", "angle", "u")
    )
    return st.Family(system, "rest", at=("a",), held=dict.fromkeys(states, 0.0))


def compare(seeds: range) -> set[str]:
    """Verdicts of conditions and of certified spectra at random members of random families."""
    words = set()
    for seed in seeds:
        chance = random.Random(seed)
        family = random_family(chance)
        found = st.conditions(family)
        for _ in range(4):
            at, b, angle = (chance.uniform(-2, 2) for _ in range(3))
            others = {"b": b, "angle": angle, "u": chance.uniform(0.1, 3)}
            spectrum = st.spectrum(family, at=at, certify=True, **others)
            assert found.verdict(at, **others) is spectrum.verdict, (seed, at, others)
            words.add(spectrum.verdict.word)
    return words  # the family of seed 5 is too large for its determinants: Routh's array decides


@pytest.mark.parametrize("seeds", [range(3, 4), pytest.param(range(3, 7), marks=pytest.mark.long)])
def test_random_families_have_the_verdicts_of_certified_spectra(seeds: range) -> None:
    assert compare(seeds) >= {"stable", "unstable"}


@pytest.mark.long
def test_many_random_families_have_the_verdicts_of_certified_spectra() -> None:
    assert compare(range(100, 200)) >= {"stable", "unstable"}


def free_domain() -> Domain:
    return Domain(RING, ["x", "y", "z"])


def test_squares_outweigh_negative_terms_exactly_up_to_their_product() -> None:
    """The polynomial a x⁴ - b x² y + c y² + 1 is positive where b² ≤ 4 a c, else -∞ somewhere."""
    one = RING.constant(1)
    for a, b, c in ((1, 2, 1), (3, 5, 4), (1, 2, 2), (2, -3, 5)):
        poly = a * X**4 - b * X**2 * Y + c * Y**2 + one
        why = free_domain().positive(poly)
        assert why is not None
        assert "2*a*b <= a**2 + b**2" in why
    assert free_domain().positive(X**4 - 3 * X**2 * Y + 2 * Y**2 + one) is None
    assert free_domain().positive((X**2 - Y) ** 2) is None  # vanishes where y = x²
    assert free_domain().positive((X - Y) ** 2 + (Y - Z) ** 2 + one) is None  # needs shares of y²


@pytest.mark.parametrize("count", [400, pytest.param(4000, marks=pytest.mark.long)])
def test_a_proof_by_squares_is_never_wrong_at_random_points(count: int) -> None:
    chance, proved = random.Random(5), 0
    for _ in range(count):
        a, b = (X ** chance.randrange(3) * Y ** chance.randrange(3) for _ in "ab")
        p, q, c = (fmpq(chance.randrange(1, 9)) for _ in range(3))
        poly = p * a**2 - c * a * b + q * b**2 + random_poly(chance) ** 2
        why = free_domain().positive(poly)
        if why is None or "2*a*b" not in why:
            continue
        proved += 1
        for _ in range(20):
            point = [fmpq(chance.randrange(-20, 21), chance.randrange(1, 9)) for _ in range(3)]
            assert evaluate(poly, point) > 0, (poly, point)
    assert proved > count // 40
