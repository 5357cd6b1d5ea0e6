"""Members whose unknowns lie in a number field although their equations hold roots."""

import casadi as ca
import mpmath as mp
import pytest
from flint import arb, fmpq
from own_systems import system_of

import stability as st
from stability.algebra.exact.number_fields import Algebraic, NotExact
from stability.algebra.number_types import precision
from stability.base.verdict import Verdict
from stability.polynomials.member import exact_unknowns


def triangle() -> st.Family:
    """Three bodies of total mass 1 in the rotating frame, positions relative to the first."""
    z = [ca.SX.sym(n) for n in ("x2", "y2", "x3", "y3", "u2", "v2", "u3", "v3")]
    x2, y2, x3, y3, u2, v2, u3, v3 = z
    m2, m3 = ca.SX.sym("m2"), ca.SX.sym("m3")

    def pull(own: list[ca.SX], mass: ca.SX, other: list[ca.SX], weight: ca.SX) -> list[ca.SX]:
        near, far = (ca.sqrt(p[0] ** 2 + p[1] ** 2) for p in (own, other))
        between = ca.sqrt((other[0] - own[0]) ** 2 + (other[1] - own[1]) ** 2)
        return [
            -mass * s / near**3 + weight * ((o - s) / between**3 - o / far**3)
            for s, o in zip(own, other, strict=True)
        ]

    first, second = pull([x2, y2], 1 - m3, [x3, y3], m3), pull([x3, y3], 1 - m2, [x2, y2], m2)
    system = st.System(
        "three bodies",
        ca.vertcat(*z),
        ca.vertcat(m2, m3),
        ca.vertcat(
            u2,
            v2,
            u3,
            v3,
            first[0] + 2 * v2 + x2,
            first[1] - 2 * u2 + y2,
            second[0] + 2 * v3 + x3,
            second[1] - 2 * u3 + y3,
        ),
        states=tuple(s.name() for s in z),
        parameters=("m2", "m3"),
    )
    held = dict.fromkeys(("y2", "u2", "v2", "u3", "v3"), 0.0) | {"x2": 1.0, "x3": 0.5}
    return st.Family(
        system,
        "triangle",
        ("m2",),
        held=held,
        unknown={"y3": 0.87},
        equations=("v3",),
        typical={"m2": 0.02, "m3": 0.01},
    )


def test_the_triangle_of_three_bodies_is_neutral_up_to_rouths_mass_ratio() -> None:
    """Routh (1875): (λ² + 1) and λ⁴ + λ² + 27/4 (m₁m₂ + m₂m₃ + m₃m₁), and two more zeros."""
    m3 = mp.mpf(0.01)
    edge = float(mp.findroot(lambda m: (1 - m - m3) * (m + m3) + m * m3 - mp.mpf(1) / 27, 0.03))
    family = triangle()
    for m2, word in (
        (0.01, "neutral"),
        (edge * (1 - 1e-12), "neutral"),
        (edge * (1 + 1e-12), "unstable"),
        (0.06, "unstable"),
    ):
        found = st.spectrum(family, at=m2, m3=0.01, certify=True)
        assert (found.verdict.word, found.structural_zeros, found.certified) == (word, 2, True)
    m2 = 0.01
    quarter = mp.mpf(27) / 4 * ((1 - m2 - m3) * (m2 + m3) + m2 * m3)
    squares = [-1, *mp.polyroots([1, 1, quarter])]
    wanted = sorted(s * float(mp.sqrt(-x)) for x in squares for s in (-1, 1))
    found = st.spectrum(family, at=m2, m3=0.01, certify=True)
    assert sorted(found.eigenvalues.imag) == pytest.approx(wanted, rel=1e-13)


def two_roots(second: int) -> st.Family:
    """Members u = √p and w = 1 + √s; the eigenvalue of z is w - u - 1."""
    u, w, z, p, s = (ca.SX.sym(n) for n in "uwzps")
    system = system_of(
        "roots", [u, w, z], [p, s], [p - ca.sqrt(u**4), s - ca.sqrt((w - 1) ** 4), (w - u - 1) * z]
    )
    start = second**0.5
    return st.Family(
        system,
        "roots",
        ("p",),
        held={"z": 0.0},
        unknown={"u": 1.4, "w": 1.1 + start},
        equations=("u", "w"),
    )


def test_two_unknowns_of_one_field_show_a_zero_between_them() -> None:
    found = st.spectrum(two_roots(2), at=2.0, s=2.0, certify=True)
    assert found.verdict is Verdict.NEUTRAL
    assert sorted(found.eigenvalues.real) == pytest.approx([-(8**0.5), -(8**0.5), 0.0])


def balls(bits: int, *digits: mp.mpf) -> list[arb]:
    with mp.workdps(300), precision(600):
        return [arb(mp.nstr(v, 250), arb(2) ** -bits) for v in digits]


def test_the_numbers_of_a_member_are_recognised_and_proved() -> None:
    with mp.workdps(300):
        root = mp.sqrt(2)
        close, wide = balls(500, root, 1 + root), balls(250, root, 1 + root)
        other = balls(500, root, 1 + root + mp.mpf(10) ** -60), wide
    given = [fmpq(2)], [fmpq(2)]
    with precision(512):
        u, w = exact_unknowns(two_roots(2), given, close, wide)
        assert isinstance(u, Algebraic) and u * u == 2 and w - u == 1
        with pytest.raises(NotExact):  # digits of a number that is not 1 + √2
            exact_unknowns(two_roots(2), given, *other)
        with pytest.raises(NotExact):  # the digits are right, and the equations others
            exact_unknowns(two_roots(2), ([fmpq(2)], [fmpq(3)]), close, wide)
