"""What names a member may be given by its own name in place of `at`, everywhere alike."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import system_of

import stability as st
from stability.base.errors import ParameterError

LAW: dict[str, Any] = {"contact": "viscous", "mu": 0.3}


@pytest.fixture(scope="module")
def bent() -> st.Family:
    """A pendulum with a moment p at its hinge, at rest at the angle x."""
    x, v, p, m = (ca.SX.sym(n) for n in "xvpm")
    system = system_of("pendulum", [x, v], [p, m], [v, -m * v - ca.sin(x) + p])
    return st.Family(system, "bent", ("p",), held={"v": 0.0}, unknown={"x": 0.1}, equations=("v",))


@pytest.mark.parametrize(
    ("family", "names", "others"),
    [
        ("rolling", {"omega3": [1.2, 1.9]}, LAW),
        ("spinning", {"phi_dot": 2.5}, LAW),
        ("tumbling", {"theta": 1.1}, LAW),
        ("circling", {"theta": 0.7, "phi_dot": [2.0, 2.2]}, {"contact": "rough"}),
        ("rolling", {"omega3": 1.2}, LAW | {"body": st.Torus(0.3)}),
        ("vertical", {"omega_Z": 2.0}, LAW | {"body": st.EccentricSphere(0.3), "pole": "pi"}),
    ],
)
def test_a_spectrum_is_the_same_by_at_and_by_name(
    family: str, names: dict[str, Any], others: dict[str, Any]
) -> None:
    values = [np.asarray(v, dtype=float) for v in names.values()]
    at = values[0] if len(values) == 1 else np.stack(np.broadcast_arrays(*values), axis=-1)
    one, other = st.spectrum(family, at=at, **others), st.spectrum(family, **names, **others)
    assert np.array_equal(one.eigenvalues, other.eigenvalues)
    assert np.array_equal(one.at, other.at) and np.array_equal(one.codes, other.codes)


def test_a_user_s_family_takes_its_own_name(bent: st.Family) -> None:
    one, other = st.spectrum(bent, at=0.3, m=0.1), st.spectrum(bent, p=0.3, m=0.1)
    assert np.array_equal(one.eigenvalues, other.eigenvalues)
    # λ² + m λ + cos x = 0 with sin x = p
    c = np.sqrt(1 - 0.3**2)
    assert other.eigenvalues[1] == pytest.approx(-0.05 + 1j * np.sqrt(c - 0.0025), rel=1e-12)
    found = [st.boundaries(bent, axis=("m", -1.0, 1.0, 9), **n) for n in ({"p": 0.3}, {"at": 0.3})]
    assert [b.value for b in found[0]] == [b.value for b in found[1]] == pytest.approx([0.0])


@pytest.mark.parametrize(
    ("family", "at", "names", "axes"),
    [
        ("rolling", 1.2, {"omega3": 1.2}, {"x": ("k", 0.1, 0.5, 5), "y": ("mu", 0.1, 1, 3)}),
        (
            "circling",
            1.2,
            {"phi_dot": 1.2},
            {"x": ("theta", 0.1, 0.5, 5), "y": ("k", 0.1, 0.5, 3), "contact": "rough"},
        ),
        (
            "circling",
            0.4,
            {"theta": 0.4},
            {"x": ("phi_dot", 1.0, 3.0, 5), "y": ("k", 0.1, 0.5, 3), "contact": "rough"},
        ),
    ],
)
def test_a_map_is_the_same_by_at_and_by_name(
    family: str, at: float, names: dict[str, float], axes: dict[str, Any]
) -> None:
    one, other = st.stability_map(family, at=at, **axes), st.stability_map(family, **names, **axes)
    assert np.array_equal(one.verdict, other.verdict) and one.verdict.values.any()
    assert np.array_equal(one.abscissa, other.abscissa)


def test_along_an_axis_too() -> None:
    one = st.boundaries("rolling", axis=("k", 0.1, 0.5, 9), mu=0.3, at=1.4)
    other = st.boundaries("rolling", axis=("k", 0.1, 0.5, 9), mu=0.3, omega3=1.4)
    assert [b.value for b in one] == [b.value for b in other] and len(one)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (lambda: st.spectrum("rolling", at=1.2, omega3=1.2, **LAW), "omega3 is given as at and by"),
        (
            lambda: st.spectrum("tumbling", theta=1.2, lean=0.1, **LAW),
            "theta and lean are both given",
        ),
        (lambda: st.spectrum("rolling", phi_dot=1.2, **LAW), "at is missing; .* here omega3"),
        (lambda: st.spectrum("rolling", body=st.Torus(0.3), **LAW), "at is missing; .* omega3"),
        (lambda: st.spectrum("circling", theta=0.7, contact="rough"), "here theta and phi_dot"),
        (
            lambda: st.spectrum("circling", theta=[0.7, 0.8], phi_dot=[1.0, 2, 3], contact="rough"),
            "shapes are theta .2,., phi_dot .3,.; make them fit",
        ),
        (lambda: st.spectrum("rolling", omega3="fast", **LAW), "omega3 is 'fast'"),
        (
            lambda: st.stability_map(
                "rolling", x=("at", 0.1, 2, 5), y=("mu", 0.1, 1, 3), omega3=1.2
            ),
            "at .omega3. is given as 1.2, and as an axis from 0.1 to 2",
        ),
        (
            lambda: st.stability_map(
                "circling",
                x=("theta", 0.1, 0.5, 5),
                y=("k", 0.1, 0.5, 3),
                contact="rough",
                theta=0.2,
                phi_dot=1.0,
            ),
            "theta is given as 0.2, and as an axis from 0.1 to 0.5",
        ),
    ],
)
def test_what_is_given_twice_or_not_at_all_is_refused(asked: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        asked()
