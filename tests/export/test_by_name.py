"""A family by its name: the same answer, default and refusal by every call that takes a family."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import stability as st

MISSING = "contact is missing; give Smooth(), Viscous(mu), LinearViscous(c) or Rough()."
WITHOUT: dict[str, Callable[[], Any]] = {
    "spectrum": lambda: st.spectrum("rolling", at=1.8),
    "spectrum of a body": lambda: st.spectrum("rolling", at=1.8, body=st.Torus(0.2)),
    "conditions": lambda: st.conditions("rolling"),
    "conditions of a body": lambda: st.conditions("rolling", body=st.Torus(0.2)),
    "latex": lambda: st.latex("rolling"),
    "exact_polynomial": lambda: st.exact_polynomial("rolling"),
    "disk_family": lambda: st.disk_family("rolling"),
    "Body.family": lambda: st.Torus(0.2).family("rolling"),
}


@pytest.mark.parametrize("name", WITHOUT)
def test_a_missing_law_is_the_same_sentence(name: str) -> None:
    with pytest.raises(st.StabilityError) as refused:
        WITHOUT[name]()
    assert str(refused.value) == MISSING


def test_a_missing_law_of_a_motion_or_of_friction_names_the_laws_that_it_takes() -> None:
    calls: dict[str, Callable[[], Any]] = {
        "Viscous(mu) or LinearViscous(c).": lambda: st.drift(at=1.8, tilt=0.01),
        "Viscous(mu) or LinearViscous(c). ": lambda: st.hopf("spinning"),
        "Creep(mu, order=3).": lambda: st.simulate(
            st.Disk(), None, {"theta": 1.3, "omega3": 2.0}, 1.0
        ),
        "Creep(mu, order=3).   ": lambda: st.simulate(
            st.Torus(0.2), None, {"theta": 1.3, "omega3": 2.0}, 1.0
        ),
        "Creep(mu, order=3). ": lambda: st.basins(
            family="rolling", x=("at", 1, 2, 2), y=("tilt", 0.01, 0.1, 2), horizon=0.1
        ),
        "Creep(mu, order=3).  ": lambda: st.disk_system(),
    }
    for end, call in calls.items():
        with pytest.raises(st.StabilityError) as refused:
            call()
        said = str(refused.value)
        assert said.startswith("contact is missing; give ") and said.endswith(end.strip())


def test_a_name_is_answered_as_its_family_is() -> None:
    by_name = st.conditions("rolling", contact="viscous", positive=["k"])
    family = st.disk_family("rolling", "viscous")
    assert by_name.rule == st.conditions(family, positive=["k"]).rule
    assert st.conditions("rolling", mu=1).rule == st.conditions(family, mu=1).rule  # as spectrum
    torus = st.conditions("spinning", contact=st.Rough, body=st.Torus(0.2), positive=["tube"])
    assert "tube" in [v.name for v in torus.variables]
    assert (
        torus.rule
        == st.conditions(st.Torus(0.2).family("spinning", "rough"), positive=["tube"]).rule
    )
    text = st.latex("spinning", contact=st.Rough(), positive=["k"])
    assert text == st.latex(st.disk_family("spinning", "rough"), positive=["k"])


@pytest.mark.parametrize("law", ["viscous", st.Viscous, st.Viscous(0.3)])
def test_a_law_is_given_by_name_class_or_instance_everywhere(law: Any) -> None:
    assert st.disk_family("rolling", law) == st.disk_family("rolling", "viscous")
    assert st.disk_system(law).name == "disk, viscous"
    assert st.exact_polynomial("rolling", law) == st.exact_polynomial("rolling", "viscous")
    assert st.Torus(0.2).family("rolling", law).system.name == "torus, viscous"


def test_a_family_of_ones_own_takes_no_law_and_no_body() -> None:
    family = st.disk_family("rolling", "viscous")
    for given in ({"contact": "rough"}, {"body": st.Torus(0.2)}):
        word = next(iter(given))
        with pytest.raises(st.StabilityError, match=f"{word} belongs to a family by its name"):
            st.conditions(family, **given)
        with pytest.raises(st.StabilityError, match=f"{word} belongs to a family by its name"):
            st.latex(family, **given)
    with pytest.raises(st.StabilityError, match="body is 3; give a stability.Body"):
        st.conditions("rolling", contact="rough", body=3)  # type: ignore[arg-type]


def test_a_call_that_needs_a_family_says_where_to_get_one(tmp_path: Path) -> None:
    accepted = r"give a stability.Family: system.steady\(at, guess={…}\), disk_family\(…\), body"
    ends: dict[str, Any] = {"free": "k", "start": 0.2, "stop": 0.3}
    for call in (
        lambda: st.conditions(3),  # type: ignore[arg-type]
        lambda: st.branch("rolling", 1, 2),  # type: ignore[arg-type]
        lambda: st.auto_input("rolling", tmp_path / "a", **ends),  # type: ignore[arg-type]
        lambda: st.bifurcationkit_input("rolling", tmp_path / "b", **ends),  # type: ignore[arg-type]
    ):
        with pytest.raises(st.StabilityError, match=accepted):
            call()
