"""Creep, the slow manifold of viscous contact: its error falls as mu to the power -(order + 1).

The truth is the viscous disk with six states, which other tests hold against independent
derivations; here it is asked at friction so large that the order of an error can be read.
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest

import stability as st
from stability.algebra.number_types import Algebra
from stability.algebra.program import Program
from stability.algebra.upright import UPRIGHT
from stability.bodies.contact_laws import CREEP, Viscous
from stability.bodies.families import FAMILIES
from stability.bodies.newton_euler import STATES
from stability.bodies.thin_disk import disk_system

START = (1.2, 0.1, 0.6, 1.6)
MPMATH = Algebra(
    "mpmath",
    lambda v: mpmath.mpf(v),
    {
        "sin": mpmath.sin,
        "cos": mpmath.cos,
        "sqrt": mpmath.sqrt,
        "pow": mpmath.power,
    },
)


def run(law: Any, last: float, start: Any = START, **options: Any) -> Any:
    return st.simulate(st.Disk(k=0.25), law, list(start), [0.0, last], **options)


def law_of(order: int, mu: float) -> Any:
    return st.Rough() if order == 0 else st.Creep(mu, order=order)


def four(motion: Any) -> Any:
    return np.array([float(motion[n][-1]) for n in STATES[:4]])


@lru_cache
def truth(mu: float) -> Any:
    """The viscous disk from the manifold, whose slip is known to O(mu⁻⁴), at time 3."""
    at_once = run(st.Creep(mu, order=3), 0.1)
    slip = [float(at_once[n][0]) for n in ("slip_x", "slip_y")]
    assert np.hypot(*slip) > 0.01 / mu
    return four(run(Viscous(mu), 3.0, (*START, *slip), method="dop853", tolerance=1e-14))


@pytest.mark.long
@pytest.mark.parametrize("order", range(4))
def test_the_error_of_a_motion_falls_as_the_order_says(order: int) -> None:
    frictions = (25.0, 50.0, 100.0, 200.0)
    errors = []
    for mu in frictions:
        motion = run(law_of(order, mu), 3.0, method="dop853", tolerance=1e-13)
        errors.append(np.abs(four(motion) - truth(mu)).max())
    slopes = -np.diff(np.log2(errors))
    assert slopes[-1] == pytest.approx(order + 1, abs=0.12), errors
    assert errors[-1] < 2.0 * (2.5 / frictions[-1]) ** (order + 1) * 0.2


@pytest.mark.few(1)
@pytest.mark.parametrize("order", range(4))
def test_the_orders_hold_for_a_torus(order: int) -> None:
    """Against the viscous torus from the manifold, as for the disk."""
    torus, errors = st.Torus(0.2), []
    options: dict[str, Any] = {"method": "dop853", "tolerance": 1e-13, "check": False}
    for mu in (60.0, 120.0):
        at_once = st.simulate(torus, st.Creep(mu, order=3), list(START), [0.0, 0.1], **options)
        slip = [float(at_once[n][0]) for n in ("slip_x", "slip_y")]
        true = st.simulate(torus, Viscous(mu), [*START, *slip], [0.0, 1.0], **options)
        mine = st.simulate(torus, law_of(order, mu), list(START), [0.0, 1.0], **options)
        errors.append(np.abs(four(mine) - four(true)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order + 1, abs=0.3), errors


def test_a_disk_with_a_resistance_of_zero_creeps_as_the_disk() -> None:
    law = st.Creep(200.0, order=2)
    plain, body = (run(law, 5.0, resistance=r) for r in (None, st.AirTorque(0.0)))
    for name in (*STATES, "force_x", "power"):
        assert np.abs(body[name].values - plain[name].values).max() < 1e-9, name
    with pytest.raises(st.StabilityError, match="creep needs slip that decays faster"):
        run(st.Creep(0.1, order=2), 1.0, resistance=st.RollingResistance(0.01))


@pytest.mark.parametrize(("family", "at"), [("rolling", 1.3), ("spinning", 2.2)])
def test_verdicts_are_those_of_the_viscous_torus(family: str, at: float) -> None:
    body = st.Torus(0.2, mass=0.3, gravity=9.81, length=0.1)
    mine = st.spectrum(family, at=10 * at, body=body, contact=st.Creep(300.0, order=2))
    full = st.spectrum(family, at=10 * at, body=body, contact=Viscous(300.0))
    assert mine.verdict is full.verdict and mine.verdict.word in ("stable", "unstable")
    assert float(mine.abscissa) == pytest.approx(float(full.abscissa), rel=0.05)


@lru_cache
def jacobian_program(law: Any) -> Program:
    system = disk_system(law)
    return Program(ca.Function("jacobian", [system.x, system.p], [system.jacobian]))


def eigenvalues(law: Any, family: str, at: float, mu: Any) -> list[Any]:
    """Of the Jacobian in many digits, those of zero and of fast decay left out, by size."""
    k = mpmath.mpf("0.3")
    member = FAMILIES[family].member(mpmath, mpmath.mpf(at), k)
    x = [
        mpmath.pi / 2 if member[n] is UPRIGHT else mpmath.mpf(member[n])
        for n in disk_system(law).states
    ]
    p = [k, mu][: disk_system(law).p.numel()]
    matrix = mpmath.matrix(jacobian_program(law).dense(MPMATH, [x, p]))
    found = mpmath.eig(matrix, left=False, right=False)
    return sorted((v for v in found if 1e-20 < abs(v) < mu / 100), key=lambda v: (v.imag, v.real))


@pytest.mark.few(3)
@pytest.mark.parametrize(("family", "at"), [("rolling", 1.3), ("spinning", 2.2), ("tumbling", 0.8)])
@pytest.mark.parametrize("order", range(3))
def test_eigenvalues_are_the_slow_ones_to_the_order(order: int, family: str, at: float) -> None:
    with mpmath.workdps(60):
        errors = []
        for mu in (mpmath.mpf(10) ** 5, mpmath.mpf(10) ** 6):
            mine = eigenvalues(CREEP[order], family, at, mu)
            slow = eigenvalues(Viscous, family, at, mu)
            if order == 0:  # the rough disk has a zero for each slow decay
                slow = [v for v in slow if abs(v) > 100 / mu]
            assert len(mine) == len(slow) >= 2
            errors.append(max(abs(a - b) for a, b in zip(mine, slow, strict=True)))
        slope = float(mpmath.log10(errors[0] / errors[1]))
    assert slope == pytest.approx(order + 1, abs=1e-3), [mpmath.nstr(e, 5) for e in errors]


@pytest.mark.parametrize(
    ("order", "family", "at"),
    [(1, "rolling", 1.3), (1, "tumbling", 0.8)]
    + [
        pytest.param(*case, marks=pytest.mark.long)
        for case in ((1, "rolling", 1.5), (2, "spinning", 2.2), (2, "tumbling", 0.8))
    ],
)
def test_verdicts_are_those_of_the_viscous_disk(order: int, family: str, at: float) -> None:
    disk = st.Disk(k=0.3)
    mine = st.spectrum(family, at=at, disk=disk, contact=law_of(order, 300.0))
    full = st.spectrum(family, at=at, disk=disk, contact=Viscous(300.0))
    assert mine.verdict is full.verdict
    assert mine.verdict.word in ("stable", "unstable")
    assert float(mine.abscissa) == pytest.approx(float(full.abscissa), rel=0.05)


@pytest.mark.parametrize("order", [1, 2, pytest.param(3, marks=pytest.mark.long)])
def test_a_motion_keeps_its_account_and_reports_its_slip(order: int) -> None:
    law = st.Creep(30.0, order=order)
    motion = run(law, 5.0)
    assert float(motion.energy_error) < 1e-9
    assert float(motion.dissipated[-1]) > 1e-3
    assert motion.attrs["method"] != "heyoka"
    system = disk_system(law)
    seen = system.observe([float(motion[n][-1]) for n in STATES[:4]], [0.25, 30.0])
    slip = [float(motion[n][-1]) for n in ("slip_x", "slip_y")]
    assert slip == pytest.approx(np.ravel(seen["slip"]).tolist(), rel=1e-12)
    # the force is the viscous law's for that slip, to the order
    force = -30.0 * float(np.ravel(seen["normal_force"])[0]) * np.array(slip)
    off = np.abs(np.ravel(seen["contact_force"]) - force).max() / np.abs(force).max()
    assert off < 3.0 * (3.0 / 30.0) ** order


def test_units_do_not_matter() -> None:
    disk = st.Disk(k=0.25, mass=2.0, radius=0.3, gravity=9.81)
    rate, speed = float(disk.rate), float(disk.speed)
    start = [START[0], *(v * rate for v in START[1:])]
    si = st.simulate(disk, st.Creep(100.0 / speed, order=2), start, [0.0, 3.0 / rate])
    plain = run(st.Creep(100.0, order=2), 3.0)
    assert float(si.theta[-1]) == pytest.approx(float(plain.theta[-1]), abs=1e-8)
    assert float(si.slip_x[-1]) == pytest.approx(speed * float(plain.slip_x[-1]), rel=1e-6)


@pytest.mark.few(1)
@pytest.mark.parametrize("law", CREEP[1:])
@pytest.mark.parametrize("mu", [3e2, 3e4, 3e6])
def test_creep_ends_before_the_normal_force_does_and_claims_no_lift_off(
    law: Any, mu: float
) -> None:
    """There the slip grows, and the viscous disk slides on after the rough one has lifted off."""
    start = [1.0, 0.0, 5.0, -5.0, 0.0, 0.0]
    rough = st.simulate(st.Disk(), st.Rough(), start, 3.0, check=False)
    viscous = st.simulate(st.Disk(), Viscous(mu), start, 3.0, check=False)
    assert float(viscous.end_time) > 1.1 * float(rough.end_time)
    motion = st.simulate(st.Disk(), law(mu), start, 3.0, check=False)
    assert motion.attrs["outcome"] == "domain-end"
    assert "take Viscous(mu) there" in str(motion.evidence.values)
    assert 0.8 * float(rough.end_time) < float(motion.end_time) < float(rough.end_time)
    # the orders still make a small correction there, for every mu
    held = disk_system("rough").observe(four(motion), [0.25])["normal_force"]
    assert float(motion.normal_force[-1]) == pytest.approx(float(held), rel=0.06)


@pytest.mark.parametrize("law", CREEP[1:])
def test_where_slip_decays_too_slowly_creep_is_refused(law: Any) -> None:
    with pytest.raises(
        st.StabilityError, match=r"less 5, must be positive and is -4\.[0-9]*; take Viscous"
    ):
        run(law(1.0), 1.0, (1.0, 0.0, 1.0, 1.0))


def test_a_spectrum_is_refused_there_too() -> None:
    with pytest.raises(st.StabilityError, match="take Viscous"):
        st.spectrum("rolling", at=3.0, contact=st.Creep(3.0, order=1))


def test_a_slip_at_the_start_is_refused_and_none_is_needed() -> None:
    law = st.Creep(30.0, order=2)
    with pytest.raises(st.StabilityError, match=r"creep-2 contact follows from the other states"):
        run(law, 1.0, (*START, 0.1, 0.0))
    with pytest.raises(st.StabilityError, match=r"rough contact is 0"):
        run(st.Rough(), 1.0, (*START, 0.1, 0.0))
    with_zeros, without = (run(law, 1.0, (*START, *more)) for more in ((0.0, 0.0), ()))
    assert four(with_zeros).tolist() == four(without).tolist()


def test_orders_are_in_their_order() -> None:
    assert [law.name for law in CREEP] == ["rough", "creep-1", "creep-2", "creep-3"]
    for lower, upper in itertools.pairwise(CREEP[1:]):
        assert upper.order == lower.order + 1


def test_a_flat_disk_is_refused_as_flat_and_with_a_number() -> None:
    with pytest.raises(st.StabilityError, match="strictly between 0 and π") as told:
        st.simulate(st.Disk(), st.Creep(300.0, order=1), {"theta": 0.0, "omega3": 1.0}, 1.0)
    assert "nan" not in str(told.value)
