"""A quantity that is an axis and is given as a number too is refused with both values."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import pytest

import stability as st


def rest() -> st.Family:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], -p[1] * x[0] + p[0] * x[1] - x[0] ** 3)
    system = st.System("oscillator", x, p, rates, states=("q", "v"), parameters=("c", "k"))
    return st.Family(system, "rest", at=("c",), held={"q": 0, "v": 0})


MAP: dict[str, Any] = {"x": ("c", -1, 1, 5), "y": ("k", 2, 3, 5)}
CALLS: list[tuple[str, Callable[..., Any], dict[str, Any]]] = [
    ("map, keyword", st.stability_map, MAP | {"k": 0.3}),
    ("map, mapping", st.stability_map, MAP | {"parameters": {"k": 0.3}}),
    ("plane", st.codimension_two, MAP | {"k": 0.3}),
    ("boundaries", st.boundaries, {"axis": ("k", 2, 3, 5), "c": 1.0, "k": 0.3}),
    ("hopf", st.hopf, {"axis": ("k", 2, 3, 5), "c": 1.0, "k": 0.3}),
]


@pytest.mark.parametrize(("call", "given"), [c[1:] for c in CALLS], ids=[c[0] for c in CALLS])
def test_a_parameter_is_no_axis_and_number_at_once(
    call: Callable[..., Any], given: dict[str, Any]
) -> None:
    with pytest.raises(st.StabilityError) as caught:
        call(rest(), **given)
    assert str(caught.value) == "k is given as 0.3, and as an axis from 2 to 3; give it once."


@pytest.mark.parametrize("given", [{"at": 0.25}, {"c": 0.25}])
def test_the_members_own_quantity_is_no_axis_and_number_at_once(given: dict[str, float]) -> None:
    with pytest.raises(st.StabilityError, match=r"c is given as 0.25, and as an axis from -1 to 1"):
        st.boundaries(rest(), axis=("c", -1, 1, 5), k=1.0, **given)


def test_a_streamed_map_refuses_it_too_and_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(st.StabilityError, match=r"k is given as 0.3, and as an axis from 2 to 3"):
        st.stream_map(rest(), **MAP, k=0.3, out=tmp_path / "map.nc")
    assert not list(tmp_path.iterdir())


def test_a_disks_at_is_refused_with_both_values() -> None:
    with pytest.raises(
        st.StabilityError, match=r"at .phi_dot. is given as 2.0, and as an axis from 1 to 4"
    ):
        st.stability_map("spinning", x=("at", 1, 4, 5), y=("mu", 0.1, 2, 5), at=2.0)
