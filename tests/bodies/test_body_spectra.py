"""Spectra at random members of every family, against the oracle that knows the surface alone.

Which families a body has is read from its surface too: where its lowest point lies below the centre
of mass, and how the centre moves.  The oracle's members are steady to 25 digits.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import body_profiles
import casadi as ca
import convex_body as oracle
import mpmath as mp
import numpy as np
import pytest
import random_bodies
from body_heights import HEIGHTS, by_height, superellipse
from jets import Array, plain, precise
from scipy.optimize import linear_sum_assignment

import stability as st
from stability.base.errors import NoMemberError
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.families import round_family

BOTH = ("vertical 0", "vertical pi")
FAMILIES = {
    "torus": ("rolling", "spinning", "tumbling"),
    "eccentric sphere": ("tumbling", *BOTH),
    "spheroid": ("rolling", "spinning", "tumbling", *BOTH),
    "thick disk": ("rolling", "tumbling"),
    "egg": ("rolling", "tumbling", *BOTH),
    "lens": ("rolling", "spinning", "tumbling", *BOTH),
    "cap": ("rolling", "tumbling", "vertical 0"),
    "superellipsoid": ("rolling", "tumbling"),
}
"""Families of each body under every law; the surface is made of parts, which have some of them."""
OWN = {"rough": ("circling",), "smooth": ("precession",)}
EVERY = ("rolling", "spinning", "tumbling", "vertical 0", "vertical pi", "circling", "precession")
MEMBERS = 2
"""Members of each family that are compared."""
DIGITS = 40
APART = 1e-4
"""Least distance of two eigenvalues over the largest: closer ones lose digits to rounding."""
NEAR = 0.25
"""Least sine of an inclination: angles lose digits next to a pole."""


@dataclass(frozen=True)
class Place:
    """A body in the oracle's terms and the package's, with one of its inclinations."""

    body: oracle.ConvexBody
    own: st.Body
    theta: float
    law: oracle.Law
    rng: np.random.Generator

    def lever(self, theta: float) -> float:
        """How far the lowest point lies from the foot of the centre of mass."""
        return float(oracle.pose_at(self.body, np.array([theta, 0, 0, 0, 0, 0.0])).arm[0])

    def has(self, family: str) -> bool:
        """Whether the part of the surface around the inclination has the family."""
        low, high = self.own.between
        if family == "rolling":  # the lever changes its sign, or vanishes upright
            inside = np.linspace(low, high, 42)[1:-1]
            signs = np.sign([self.lever(float(t)) for t in inside])
            return bool((signs[:-1] * signs[1:] < 0).any()) or self.has("spinning")
        if family == "spinning":
            return low < math.pi / 2 < high and abs(self.lever(math.pi / 2)) < 1e-12
        if family == "tumbling":
            return self.square() > 0
        if family.startswith("vertical"):
            names, end = {
                "vertical 0": (("lens", "cap"), low == 0.0),
                "vertical pi": (("lens",), high == math.pi),
            }[family]
            round_ones = ("eccentric sphere", "spheroid", "egg")
            return self.body.name in round_ones or self.body.name in names and end
        # of a height that holds on no side of 1 rad these two are refused: the test at the end
        return family in OWN.get(self.law.name, ()) and low < 1.0 < high

    def square(self) -> float:
        """phi_dot² of a motion with the centre at rest, from the moments about the centre.

        With the centre at rest the spin is along the line from the centre to the contact point,
        turned about the vertical; the angular momentum turns with it, and weight at the lever
        moves it: phi_dot² K = m g lever, K from a spin of phi_dot = 1.
        """
        unit = np.array([self.theta, 0, 1.0, 0, 0, 0])
        still = oracle.pose_at(self.body, unit)
        s, c = math.sin(self.theta), math.cos(self.theta)
        away = still.arm @ np.array([c, 0, -s])  # from the axis, and along it
        along = still.arm @ np.array([s, 0, c])
        unit[3] = -s * along / away
        pose = oracle.pose_at(self.body, unit)
        assert abs(pose.velocity).max() < 1e-12
        moved = np.cross([0, 0, 1.0], pose.momentum)[1]
        return float(-self.body.mass * self.body.gravity * pose.arm[0] / moved)


def _surface(place: Place, side: int) -> oracle.ConvexBody:
    """The body with a surface that is regular at a pole: a dome's sphere goes on."""
    body, given = place.body, place.body.parameters
    if body.name not in ("lens", "cap"):
        return body
    middle = (
        -given["centre"]
        if body.name == "cap"
        else side * given["radius"] * math.cos(given["angle"])
    )
    dome = body_profiles.eccentric_sphere(middle, body.axial, body.transverse, given["radius"])
    return replace(dome, mass=body.mass, gravity=body.gravity)


def _places(name: str, law: str, rng: np.random.Generator) -> Iterator[Place]:
    """Random bodies of a kind, at random inclinations."""
    for _ in range(300):
        body = random_bodies.random_body(rng, name)
        theta = float(rng.uniform(0.25, math.pi - 0.25))
        if name == "egg" and body.parameters["long"] > 0.1:
            continue  # flat sides: a series of many terms, whose curvature has rounding of n²
        if random_bodies.allowed(body, theta):
            mu = 0.0 if law in ("smooth", "rough") else float(rng.uniform(0.05, 1.0))
            yield Place(body, by_height(body, theta), theta, oracle.Law(law, mu), rng)


def _number(place: Place, family: str) -> list[float]:
    """A random number that names a member."""
    rate = float(place.rng.uniform(0.5, 4.0) * place.rng.choice([-1.0, 1.0]))
    if family == "tumbling":
        return [place.theta]
    return [place.theta, rate] if family in ("circling", "precession") else [rate]


def _true(place: Place, family: str, at: list[float], near: Array) -> tuple[Array, Array]:
    """The oracle's member near a state, and its spectrum.

    The state stands in angles, or for a vertical axis in fixed axes.
    """
    body, law = place.body, place.law
    with mp.workdps(DIGITS):
        if family.startswith("vertical"):
            side = 1 if family.endswith("0") else -1
            body = _surface(place, side)

            def rates(values: Array) -> Array:
                return oracle.axis_rates(body, law, values, side)

            state = precise([0, 0, 0, 0, at[0], 0, 0])
        else:

            def rates(values: Array) -> Array:
                return oracle.rates(body, law, values)

            state = _steady(body, law, family, at, near)
        worst = np.abs(plain(rates(state))[: len(near)]).max()
        assert worst < 1e-25 * (1 + np.abs(plain(state)).max() ** 2), (family, worst)
        matrix = oracle.jacobian(rates, state, DIGITS)[: len(near), : len(near)]
    return plain(state), oracle.spectrum(matrix, DIGITS)


def _steady(
    body: oracle.ConvexBody, law: oracle.Law, family: str, at: list[float], near: Array
) -> Array:
    """The steady motion near a state, its unknowns by Newton's method on the oracle's rates."""
    unknown = {
        "rolling": [0],
        "spinning": [],
        "tumbling": [2, 3],
        "circling": [3],
        "precession": [3],
    }[family]
    state = precise([*near[:4], 0, 0])
    named = {
        "rolling": [3],
        "spinning": [2],
        "tumbling": [0],
        "circling": [0, 2],
        "precession": [0, 2],
    }[family]
    state[named] = precise(at)
    if family == "spinning":
        state[0], state[3] = mp.pi / 2, mp.mpf(0)

    def left(values: Array) -> Array:
        moved = state.copy()
        moved[unknown] = values
        pose = oracle.pose_at(body, moved)
        rate = oracle.rates_of(pose, oracle.respond(pose, law))[1]
        return np.array([rate, pose.velocity[1]][: len(unknown)])

    for _ in range(3 if unknown else 0):
        values = state[unknown]
        slope = oracle.jacobian(left, values, DIGITS)
        state[unknown] = values - oracle.solve(slope, left(values))
    return state


def _family(place: Place, family: str) -> st.Family:
    kind = LAWS[place.law.name]
    given = tuple(p.name for p in kind.parameters[:1])
    pole = {"vertical 0": 0, "vertical pi": "pi"}.get(family)
    return round_family(place.own, family.split()[0], kind, given, physical=True, pole=pole)


def _numbers(place: Place, record: st.Family) -> dict[str, float]:
    coefficient = {n: place.law.coefficient for n in ("mu", "c")}
    table = dict(place.own.given) | coefficient
    return {n: table[n] for n in record.parameters}


def _compare(place: Place, family: str) -> bool:
    """Compare one member; False where two eigenvalues are nearly equal, or next to a pole."""
    record, at = _family(place, family), _number(place, family)
    numbers = _numbers(place, record)
    state = record.member(at, list(numbers.values()))
    found = st.spectrum(record, at=at if len(at) > 1 else at[0], **numbers)
    if family == "rolling" and math.sin(state[0]) < NEAR:
        return False
    known, true = _true(place, family, at, state)
    assert np.abs(state - known[: len(state)]).max() < 1e-12 * (1 + np.abs(known).max()), family
    size, zeros = np.abs(true).max(), found.structural_zeros
    true = true[np.argsort(np.abs(true))]
    assert np.abs(true[:zeros]).max() < 1e-9 * size, family
    true = true[zeros:]
    assert found.eigenvalues.shape == true.shape
    gaps = np.abs(np.subtract.outer(true, true)) + np.diag(np.full(len(true), np.inf))
    if gaps.min() < APART * size:
        return False
    far = np.abs(np.subtract.outer(found.eigenvalues, true))
    assert far[linear_sum_assignment(far)].max() < 1e-11 * size, (family, at)
    return True


@pytest.mark.parametrize(
    ("name", "law", "members"),
    [("torus", "rough", 1), ("thick disk", "viscous", 1)]
    + [
        pytest.param(name, law, MEMBERS, marks=pytest.mark.long) for name in HEIGHTS for law in LAWS
    ],
)
def test_spectra_at_random_members_of_every_family(name: str, law: str, members: int) -> None:
    """A family that the surface does not have is refused; the first two cases have every one."""
    rng = np.random.default_rng(14)
    met = dict.fromkeys((*FAMILIES[name], *OWN.get(law, ())), 0)
    refused: set[str] = set()
    for place in _places(name, law, rng):
        for family in EVERY:
            if met.get(family) == members:
                continue
            if place.has(family):
                assert family in met
                met[family] += _compare(place, family)
            elif family not in (refused | set(OWN.get(law, ()))):
                with pytest.raises(NoMemberError):
                    record = _family(place, family)
                    record.member(_number(place, family), [*_numbers(place, record).values()])
                refused.add(family)
        if all(count == members for count in met.values()):
            break
    assert set(met.values()) == {members}, met
    assert set(EVERY) == refused | set(met)


@pytest.mark.parametrize(("family", "law"), [("circling", "rough"), ("precession", "smooth")])
def test_a_height_that_holds_above_upright_has_the_two_families_of_pairs(
    family: str, law: str
) -> None:
    """A thick disk on its other rim: the mirror image of the one at π - theta."""
    disk = st.ThickDisk(0.3)
    other = st.Body(
        lambda t, thickness: ca.sin(t) - thickness * ca.cos(t) / 2,
        axial=disk.axial,
        transverse=disk.transverse,
        shape=disk.shape,
        between=(math.pi / 2, math.pi),
        name="other",
    )
    known = st.spectrum(family, at=(1.2, 0.9), body=disk, contact=law)
    found = st.spectrum(family, at=(math.pi - 1.2, 0.9), body=other, contact=law)
    assert found.eigenvalues == pytest.approx(known.eigenvalues, abs=1e-12)


def _shapes(numbers: dict[str, float]) -> tuple[st.Body, st.Body]:
    """A part of a superellipsoid with free numbers, and with the same as constants."""
    free = st.Body(
        lambda t, across, along, power: superellipse(across, along, power, t, 1.0),
        axial=0.4,
        transverse=0.4,
        shape=numbers,
        between=(0.4, 1.2),
        name="free",
    )
    fixed = st.Body(
        lambda t: superellipse(**numbers, theta=t, side=1.0),
        axial=0.4,
        transverse=0.4,
        between=(0.4, 1.2),
        name="fixed",
    )
    return free, fixed


@pytest.mark.few(1)
@pytest.mark.parametrize("law", ["viscous", "rough"])
def test_an_exponent_may_be_a_number_of_the_shape(law: str) -> None:
    free, fixed = _shapes({"across": 1.0, "along": 0.9, "power": 3.0})
    mu = {"mu": 0.3} if law == "viscous" else {}
    found = st.spectrum("tumbling", at=0.7, body=free, contact=law, **mu)
    known = st.spectrum("tumbling", at=0.7, body=fixed, contact=law, **mu)
    assert found.eigenvalues == pytest.approx(known.eigenvalues, abs=1e-12)


@pytest.mark.long
def test_a_shape_rolls_whose_neighbours_do_not() -> None:
    """Of shapes with numbers near these, some roll outside the range of the height."""
    free, fixed = _shapes({"across": 0.93, "along": 1.0, "power": 2.3})
    for law in ("smooth", "rough"):
        known = st.spectrum("rolling", at=1.3, body=fixed, contact=law)
        found = st.spectrum("rolling", at=1.3, body=free, contact=law)
        assert found.eigenvalues == pytest.approx(known.eigenvalues, abs=1e-12)
