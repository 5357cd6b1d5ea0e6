"""An axis that is one of two names of a member: `at` is then the other name's value."""

from typing import Any

import casadi as ca
import pytest
from own_systems import system_of

import stability as st


def spinner() -> st.Family:
    """d²θ/dt² = (w² - v) θ - w dθ/dt: unstable where w² > v."""
    theta, rate, v, w = (ca.SX.sym(n) for n in ("theta", "rate", "v", "w"))
    system = system_of("spinner", [theta, rate], [v, w], [rate, (w**2 - v) * theta - w * rate])
    return st.Family(system, "rest", ("v", "w"), held={"theta": 0.0, "rate": 0.0})


@pytest.mark.parametrize("given", [{"at": 4.0}, {"at": [4.0]}, {"v": 4.0}])
def test_at_is_the_name_that_the_axis_leaves(given: dict[str, Any]) -> None:
    (edge,) = st.boundaries(spinner(), axis=("w", 0.5, 9, 9), **given)
    assert edge.value == 2.0
    (one,) = st.hopf(spinner(), axis=("w", -1, 0.5, 9), **given)
    assert one.at == 0.0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"at": [1.0, 2.0, 3.0]}, r"at holds 3 numbers.*beyond the axis at holds 1 \(v\)"),
        ({"at": 4.0, "v": 4.0}, "v is given as at and by name; give it once"),
        ({"at": [4.0, 1.0]}, "w is given as 1.0, and as an axis"),
    ],
)
def test_other_numbers_are_refused_in_words(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        st.boundaries(spinner(), axis=("w", 0.5, 9, 9), **given)


def test_a_map_over_both_names_leaves_nothing_for_at() -> None:
    with pytest.raises(ValueError, match="beyond the axis at holds none, so leave it out"):
        st.stability_map(spinner(), x=("v", 1, 9, 5), y=("w", 1, 9, 5), at=[1.0])
