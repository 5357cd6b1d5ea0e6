"""A body in every question that takes a family: its quantities, its families as objects."""

from typing import Any

import numpy as np
import pytest

import stability as st
from stability.base.quantities import Kind, read, written
from stability.bodies.contact_laws import LAWS
from stability.bodies.quantities import disk_quantities
from stability.bodies.subject import subject_of

BODIES = (
    st.Torus(0.2),
    st.Torus(0.2, solid=False),
    st.Spheroid(0.5),
    st.EccentricSphere(0.3),
    st.ThickDisk(0.3),
)
SI = st.Spheroid(0.5, mass=0.5, gravity=9.81, length=0.3)
OWN = st.Body(lambda _, tube: tube, axial=0.4, transverse=0.4, shape={"tube": 1.0}, name="ball")


# --- families as objects ---


@pytest.mark.few(3)
@pytest.mark.parametrize("law", LAWS)
def test_a_family_of_a_body_is_that_of_the_calls_by_name(law: str) -> None:
    body = st.Torus(0.2)
    mu = dict.fromkeys(LAWS[law].symbols(), 0.3)
    if "creep" in law:
        with pytest.raises(st.StabilityError, match="made for the disk"):
            body.family("tumbling", law)
        return
    family = body.family("tumbling", LAWS[law](**mu))
    named = subject_of("tumbling", body=body, contact=law, parameters=mu)
    assert family == named.family
    one = st.spectrum(family, at=1.0, **named.numbers)
    other = st.spectrum("tumbling", at=1.0, body=body, contact=law, **mu)
    assert (one.eigenvalues == other.eigenvalues).all()
    assert body.family("tumbling", law).at == ("theta",)


def test_conditions_of_a_body_are_its_thresholds() -> None:
    """Upright on a rough plane a spheroid is held by φ̇² (1 + a²)/5 > … as its boundary says."""
    family = st.Spheroid(1.0).family("spinning", "rough")
    found = st.conditions(family, positive=["aspect"])
    [b] = st.boundaries("spinning", axis=("at", 0.1, 9, 9), body=st.Spheroid(0.5), contact="rough")
    for at, verdict in ((b.value - 1e-9, "unstable"), (b.value + 1e-9, "neutral")):
        assert found.decide({"phi_dot": at, "aspect": 0.5}).word == verdict
    text = st.table("conditions", family).to_text()
    assert "spheroid, rough, spinning: exact conditions of stability" in text


def test_hopf_of_a_body_by_name_is_that_of_its_family() -> None:
    body, axis = st.Torus(0.2), ("theta", 0.9, 1.2, 9)
    [named] = st.hopf("tumbling", body=body, contact=st.Viscous(0.9), axis=axis)
    [same] = st.hopf(body.family("tumbling", "viscous"), axis=axis, tube=0.2, mu=0.9)
    assert named == same
    [b] = st.boundaries("tumbling", axis=axis, body=body, contact=st.Viscous(0.9))
    assert named.at == pytest.approx(b.value, rel=1e-12)
    with pytest.raises(st.StabilityError, match="axis is missing"):
        st.hopf("tumbling", body=body, contact=st.Viscous(0.9))


def test_a_branch_of_a_body_is_followed() -> None:
    family = st.Torus(0.2).family("tumbling", "viscous")
    run = st.branch(family, 1.4, 0.6, tube=0.2, mu=0.3, points=5)
    assert run.complete
    found = st.spectrum("tumbling", at=run.at, body=st.Torus(0.2), contact=st.Viscous(0.3))
    assert found.states == pytest.approx(run.state, abs=1e-12)


def test_a_name_where_a_family_is_needed_is_led_to_the_bodys() -> None:
    for call in (
        lambda: st.branch("rolling", 1, 2),  # type: ignore[arg-type]
        lambda: st.table("conditions", "rolling"),
    ):
        with pytest.raises(st.StabilityError, match=r"body\.family\("):
            call()
    torus = st.Torus(0.2)
    with pytest.raises(st.StabilityError, match="contact is missing; give Smooth"):
        st.conditions("rolling", body=torus)
    by_name = st.conditions("rolling", body=torus, contact="viscous")
    assert str(by_name) == str(st.conditions(torus.family("rolling", st.Viscous(0.3))))


# --- quantities ---


@pytest.mark.few(7)
@pytest.mark.parametrize("body", BODIES, ids=lambda b: b.name)
@pytest.mark.parametrize("law", ["smooth", "viscous", "rough"])
def test_every_number_of_a_body_has_a_quantity_and_its_unit(body: st.Body, law: str) -> None:
    from dataclasses import replace

    system = replace(body, mass=1.0, gravity=1.0, length=2.0).family("tumbling", law).system
    known = system.quantities
    assert set(known) == {*system.states, *system.parameters, *system.observables}
    assert all(q.long_name and q.name == n for n, q in known.items())
    assert all(system.units[n] == q.kind.si for n, q in known.items())
    for name, quantity in disk_quantities(LAWS[law]).items():
        if name in known and not name.startswith("slip_"):
            assert known[name] == quantity
    assert all(known[n].symbol for n in (*body.shape, "length", "mass", "gravity"))
    assert len({known[n].symbol for n in system.parameters}) == len(system.parameters)


def test_a_users_number_is_no_quantity_of_a_named_body() -> None:
    known = OWN.family("tumbling", "rough").system.quantities
    assert (known["tube"].symbol, known["tube"].long_name) == ("", "tube")
    assert read(written(known)) == known
    assert OWN.family("tumbling", "rough") != st.Torus(0.2).family("tumbling", "rough")


def test_the_words_of_a_unit_are_those_of_the_disk_or_si() -> None:
    plain = st.spectrum("rolling", at=[1.0, 2.0], body=st.Spheroid(0.5), contact=st.Viscous(0.3))
    assert plain.rate_unit == "√(g/R)"
    assert plain.to_xarray().omega3.attrs["unit_in_words"] == "√(g/R)"
    assert plain.to_xarray().abscissa.attrs["units"] == "1"
    si = st.spectrum("rolling", at=5.0, body=SI, contact=st.Viscous(0.3))
    assert si.rate_unit == "1/s"
    head = si._repr_html_().split("</div>")[0]
    assert head.startswith(
        "<div><b>rolling</b> of spheroid, viscous contact (F = -μ N v), ω₃ = 5 rad/s, a = 0.5"
    )
    assert "g = 9.81 m/s², R = 0.3 m, μ = 0.3 s/m" in head
    assert "<th>ω₃</th>" in plain._repr_html_()
    assert "a = 0.5, μ = 0.3/√(gR)" in plain._repr_html_()


def test_units_scale_as_the_kinds_say() -> None:
    """A dimensionless number times its unit in words is the SI number, for rates and for mu."""
    rate, speed = np.sqrt(9.81 / 0.3), np.sqrt(9.81 * 0.3)
    si = st.spectrum("rolling", at=2.0 * rate, body=SI, contact=st.Viscous(0.3 / speed))
    plain = st.spectrum("rolling", at=2.0, body=st.Spheroid(0.5), contact=st.Viscous(0.3))
    assert si.eigenvalues == pytest.approx(plain.eigenvalues * rate, rel=1e-11)
    assert Kind.ANGULAR_VELOCITY.words == "√(g/R)"
    assert si.family.system.quantities["mu"].kind is Kind.INVERSE_VELOCITY


@pytest.mark.parametrize(
    ("axis", "why"), [(("k", 0.1, 0.9, 9), r"\(0, 1/2\]"), (("mass", -1, 0.9, 9), "mass is -1")]
)
def test_an_axis_of_a_disk_with_a_resistance_has_the_disks_limits(axis: Any, why: str) -> None:
    against = {"resistance": st.RollingResistance(0.01), "contact": st.Viscous(0.3)}
    with pytest.raises(st.StabilityError, match=why):
        st.boundaries("spinning", at=2.5, disk=st.Disk(), axis=axis, **against)


def test_boundaries_of_a_body_that_are_proved_say_of_what() -> None:
    found = st.boundaries(
        "tumbling", axis=("at", 0.05, 1.5, 9), contact=st.Smooth(), body=st.Torus(0.2)
    )
    assert found.complete
    assert found.how.endswith("or a single crossing, on one branch of steady motions")


def test_the_same_disk_or_body_with_other_numbers() -> None:
    quarter = st.Disk.named("quarter")
    assert quarter.having({"k": 0.3}).given == quarter.given | {"k": 0.3}
    torus = st.Torus(0.3).having({"tube": 0.2, "mass": 2.0, "gravity": 1, "length": 1})
    assert torus == st.Torus(0.2, mass=2.0, gravity=1.0, length=1.0)
    for body, name in ((quarter, "tube"), (torus, "k")):
        with pytest.raises(st.StabilityError, match=f"'{name}'; known are mass, "):
            body.having({name: 0.2})
