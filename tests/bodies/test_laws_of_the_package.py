"""A law in the package's list: its polynomials are looked up, its units and numbers are checked."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from own_law import Cubic, Weakening
from proofs import stored as kept
from proofs.disk_polynomials import derive

import stability as st
from stability.bodies import contact_laws
from stability.bodies.contact_laws import LAWS, MOTION_LAWS
from stability.bodies.disk_polynomials import stored, stored_laws
from stability.tables.conditions import _contacts


@pytest.fixture(params=[Weakening, Cubic])
def law(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> type[st.Contact]:
    """A law that stands in the list and has no stored polynomials."""
    kind: type[st.Contact] = request.param
    monkeypatch.setitem(MOTION_LAWS, kind.name, kind)
    monkeypatch.setitem(LAWS, kind.name, kind)
    return kind


def test_the_laws_with_polynomials_are_those_of_the_data() -> None:
    assert stored_laws() == ["smooth", "viscous", "linear-viscous", "rough"]
    assert [name for name, law in MOTION_LAWS.items() if stored(law)] == stored_laws()
    assert set(stored_laws()) <= set(LAWS)
    assert not any(stored(law) for law in (st.Creep, st.Coulomb, Weakening))


def test_a_law_in_the_list_needs_no_polynomials(law: type[st.Contact], tmp_path: Path) -> None:
    """Before, `explore` and `make derive` took every law of the list to have them."""
    assert not stored(law)
    numbers = {p.name: 0.3 for p in law.parameters}
    named = st.spectrum("rolling", at=2.0, contact=law.name, **numbers)  # type: ignore[arg-type]
    same = st.spectrum("rolling", at=2.0, contact=st.Viscous(0.3))
    assert np.allclose(named.eigenvalues, same.eigenvalues, rtol=0, atol=1e-12)
    page = st.explore("rolling", mu=0.3, out=tmp_path / "page.html", certify=False)
    assert f'"{law.name}"' not in page.read_text(encoding="utf-8")
    with pytest.raises(st.StabilityError, match="the page draws smooth, viscous"):
        st.explore("rolling", contact=law(**numbers), out=tmp_path / "own.html", certify=False)
    with pytest.raises(st.StabilityError, match="there is one for rolling under smooth"):
        st.exact_polynomial("rolling", law.name)


def test_deriving_leaves_out_a_law_whose_numbers_are_others(
    law: type[st.Contact], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stored polynomial reads mu and c alone: with nu it would have been that of mu = 1."""
    monkeypatch.setattr(kept, "LAWS", {law.name: law})
    assert kept.of_disk()["cases"] == {}
    with pytest.raises(st.StabilityError, match=r"derived for laws of mu \[s/m\] or c \[kg/s\]"):
        derive("rolling", law.name)


def test_a_unit_of_no_kind_is_refused() -> None:
    @dataclass(frozen=True, eq=False)
    class Odd(st.Contact):
        nu: float
        name: ClassVar[str] = "odd"
        parameters: ClassVar[tuple[st.Parameter, ...]] = (st.Parameter("nu", "furlong"),)
        force = Weakening.force

    for ask in (
        lambda: st.spectrum("rolling", at=2.0, contact=Odd(0.3)),
        lambda: st.simulate(st.Disk(), Odd(0.3), {"theta": 1.2}, 1.0),
        lambda: st.spectrum("rolling", at=2.0, body=st.Torus(0.2), contact=Odd(0.3)),
    ):
        with pytest.raises(st.StabilityError, match="'furlong'; known are 1, rad, .*, s2/m2, kg/s"):
            ask()


def test_the_refusal_of_a_missing_number_shows_a_call_that_works(law: type[st.Contact]) -> None:
    """It was `RegularisedCoulomb(epsilon)`, which lacks mu."""
    for kind, missing in ((law, law.parameters[-1].name), (st.RegularisedCoulomb, "epsilon")):
        given = {p.name: 0.3 for p in kind.parameters if p.name != missing}
        with pytest.raises(st.StabilityError) as refusal:
            st.simulate(st.Disk(), kind.name, {"theta": 1.2}, 1.0, **given)
        call, words = str(refusal.value).split("; give ")[1].split(", or ")
        names = {p.name: 0.3 for p in kind.parameters}
        scope = {kind.__name__: kind, **names}
        assert eval(call, scope).given == names
        shown = (
            words.rstrip(".")
            .replace(" with ", ", ")
            .replace(" and ", ", ")
            .replace("NUMBER", "0.3")
        )
        arguments = eval(f"dict({shown})")
        assert arguments == {"contact": kind.name, **names}
        st.simulate(st.Disk(), start={"theta": 1.2}, times=0.01, **arguments)


def test_a_table_takes_a_law_whose_coefficient_has_another_name(
    law: type[st.Contact],
) -> None:
    if len(law.parameters) > 1:
        with pytest.raises(st.StabilityError, match="of laws of one coefficient"):
            _contacts(law.name, [0.3])
        return
    assert [contact.given for contact in _contacts(law.name, [0.3, 1.0])] == [
        {"nu": 0.3},
        {"nu": 1.0},
    ]
    with pytest.raises(st.StabilityError, match="mu is given but the weakening law takes nu"):
        st.table("conditions", contact=law.name, k=0.25, mu=0.3)


def test_a_number_of_another_law_names_its_owners() -> None:
    with pytest.raises(st.StabilityError, match="none; it belongs to coulomb-regularised"):
        contact_laws.law_named("viscous", 0.3, others={"epsilon": 1.0})
    with pytest.raises(st.StabilityError, match="none; it belongs to linear-viscous"):
        contact_laws.law_named("viscous", 0.3, others={"c": 1.0})
