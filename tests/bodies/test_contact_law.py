"""A law of a user's, from its class alone: spectra, boundaries, maps, motions, the command line.

`own_law.py` holds a law of twenty lines.  At rest its force has the slope of viscous friction, so
that every linear answer is that of `Viscous`, which goes by the stored polynomials; a second law
repeats the viscous force, so that every motion is that of `Viscous` too.
"""

from __future__ import annotations

import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import own_law
import pytest
from own_law import Cubic, Weakening, by_speed

import stability as st
from stability.cli import main

FAMILIES = [("rolling", 0.9), ("rolling", 2.0), ("spinning", 2.03), ("tumbling", 1.0)]
DISKS = {"dimensionless": st.Disk(k=0.3), "SI": st.Disk(k=0.3, mass=2.0, radius=0.3, gravity=9.81)}


@dataclass(frozen=True, eq=False)
class Same(st.Contact):
    """Viscous friction once more, which the package does not know for what it is."""

    nu: Any
    name: ClassVar[str] = "same"
    parameters: ClassVar[tuple[st.Parameter, ...]] = (st.Parameter("nu", "s/m", by_speed),)

    def force(self, slip: Any, normal: Any, nu: Any) -> Any:
        return [-nu * normal * slip[0], -nu * normal * slip[1]]


class Half(st.Viscous):
    """Half the force under the name of the stored law."""

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        return [-mu * normal * slip[0] / 2, -mu * normal * slip[1] / 2]


@dataclass(frozen=True, eq=False)
class Suction(st.Contact):
    """A force that is not linear in the normal force."""

    nu: Any
    name: ClassVar[str] = "suction"
    parameters: ClassVar[tuple[st.Parameter, ...]] = (st.Parameter("nu", "s/m", by_speed),)

    def force(self, slip: Any, normal: Any, nu: Any) -> Any:
        return [-nu * normal**2 * slip[0], -nu * normal**2 * slip[1]]


@dataclass(frozen=True, eq=False)
class Boastful(Same):
    """Says that it keeps energy, and does not."""

    name: ClassVar[str] = "boastful"
    conservative: ClassVar[bool] = True


@pytest.mark.few(8)
@pytest.mark.parametrize("disk", DISKS.values(), ids=DISKS)
@pytest.mark.parametrize(("family", "at"), FAMILIES)
@pytest.mark.parametrize("certify", [False, True])
def test_spectra_are_those_of_the_same_slope(
    family: str, at: float, disk: st.Disk, certify: bool
) -> None:
    at = at if family == "tumbling" else at * float(np.asarray(disk.rate))
    mine = st.spectrum(family, disk=disk, contact=Weakening(0.97), at=at, certify=certify)
    known = st.spectrum(family, disk=disk, contact=st.Viscous(0.97), at=at, certify=certify)
    assert mine.verdict is known.verdict
    assert np.abs(mine.eigenvalues - known.eigenvalues).max() <= mine.radius.max() * (1 + 1e-9)
    assert mine.structural_zeros == known.structural_zeros


def test_a_batch_over_the_laws_parameter_has_its_unit() -> None:
    nu = np.array([0.2, 0.7, 3.0])
    mine = st.spectrum("rolling", contact=Weakening(nu), at=2.0)
    known = st.spectrum("rolling", contact=st.Viscous(nu), at=2.0)
    assert np.abs(mine.eigenvalues - known.eigenvalues).max() < 1e-12
    found = st.stability_map(
        "rolling",
        x=("at", 3.0, 9.0, 3),
        y=("nu", 0.1, 0.5, 3),
        contact=Weakening,
        disk=DISKS["SI"],
    )
    assert found.nu.attrs["units"] == "s/m"
    assert found.attrs["contact"] == "weakening"


class Alone(st.Contact):
    """A force that is one number."""

    name: ClassVar[str] = "alone"

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        return 3


class Sticky(st.Coulomb):
    """Another force, whose sticking would be that of Coulomb."""

    name: ClassVar[str] = "sticky"

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        return [-mu * normal * slip[0], -mu * normal * slip[1]]


class Slipless(Same):
    """A force, and no slip for it to act on."""

    name: ClassVar[str] = "slipless"
    slips: ClassVar[bool] = False


class Homeless(st.Contact):
    """A parameter without a field."""

    name: ClassVar[str] = "homeless"
    parameters: ClassVar[tuple[st.Parameter, ...]] = (st.Parameter("nu", "s/m"),)


@pytest.mark.few(1)
@pytest.mark.parametrize("certify", [False, True])
def test_a_lean_names_a_member(certify: bool) -> None:
    mine = st.spectrum("tumbling", contact=Weakening(0.97), lean=0.3, certify=certify)
    known = st.spectrum("tumbling", contact=st.Viscous(0.97), lean=0.3, certify=certify)
    assert mine.verdict is known.verdict
    assert np.abs(mine.eigenvalues - known.eigenvalues).max() < 1e-11
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("warnings.warn", lambda *_, **__: None)
        found = st.boundaries("tumbling", axis=("lean", 0.1, 1.4, 9), contact=Weakening(0.97))
    stored = st.boundaries("tumbling", axis=("lean", 0.1, 1.4, 9), contact=st.Viscous(0.97))
    assert [b.crossing for b in found] == [b.crossing for b in stored]


@pytest.mark.few(2)
@pytest.mark.parametrize("disk", DISKS.values(), ids=DISKS)
@pytest.mark.parametrize(
    ("family", "axis", "at"),
    [
        ("rolling", ("at", 0.5, 3.0, 30), None),
        ("spinning", ("at", 0.5, 3.0, 30), None),
        ("tumbling", ("at", 0.2, 1.5, 30), None),
        ("spinning", ("k", 0.1, 0.5, 30), 2.0),
        ("spinning", ("nu", 0.5, 2.0, 30), 2.0),
    ],
)
def test_boundaries_are_those_of_the_same_slope(
    family: str, axis: tuple[Any, ...], at: float | None, disk: st.Disk
) -> None:
    rate = 1.0 if family == "tumbling" else float(np.asarray(disk.rate))
    if axis[0] == "at":
        axis = ("at", axis[1] * rate, axis[2] * rate, axis[3])
    mu = 0.97 / float(np.asarray(disk.speed))
    where = {} if at is None else {"at": at * rate}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("warnings.warn", lambda *_, **__: None)
        mine = st.boundaries(family, axis=axis, disk=disk, contact=Weakening(mu), **where)
    name = "mu" if axis[0] == "nu" else axis[0]
    known = st.boundaries(
        family, axis=(name, *axis[1:]), disk=disk, contact=st.Viscous(mu), **where
    )
    assert len(known) >= (axis[0] == "at" and family != "tumbling")
    assert [b.crossing for b in mine] == [b.crossing for b in known]
    for a, b in zip(mine, known, strict=True):
        assert abs(a.value - b.value) <= a.error + b.error


def test_maps_are_those_of_the_same_slope() -> None:
    axes = {"x": ("at", 0.5, 3.0, 31), "disk": st.Disk(k=0.3)}
    mine = st.stability_map("spinning", y=("nu", 0.1, 3.0, 21), contact=Weakening, **axes)
    known = st.stability_map("spinning", y=("mu", 0.1, 3.0, 21), contact=st.Viscous, **axes)
    assert set(np.unique(known.verdict)) == {0, 2} or len(np.unique(known.verdict)) > 1
    differ = mine.verdict.values != known.verdict.values
    undecided = ~np.isin(mine.verdict.values, np.unique(known.verdict.values))
    assert not (differ & ~undecided).any()
    assert "AD Jacobian" in mine.attrs["method"]
    assert "exact polynomials" in known.attrs["method"]


@pytest.mark.long
@pytest.mark.parametrize("family", ["spinning", "tumbling"])
def test_hopf_points_are_those_of_the_same_slope(family: str) -> None:
    disk, mu = st.Disk(k=0.375), 0.9
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("warnings.warn", lambda *_, **__: None)
        mine = st.hopf(family, contact=Same(mu), disk=disk)
    known = st.hopf(family, contact=st.Viscous(mu), disk=disk)
    assert [(p.kind, p.stable_below) for p in mine] == [(p.kind, p.stable_below) for p in known]
    for a, b in zip(mine, known, strict=True):
        assert (a.at, a.crossing, a.push) == pytest.approx((b.at, b.crossing, b.push))


@pytest.mark.long
def test_hopf_says_what_it_scanned() -> None:
    with pytest.warns(st.StabilityWarning, match="scanned from 0.001 to 1.5707 at 50 points"):
        st.hopf("tumbling", contact=Same(0.9), disk=st.Disk(k=0.375), points=50)


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["auto", "dop853", "cvodes", "idas"])
@pytest.mark.parametrize("disk", DISKS.values(), ids=DISKS)
def test_motions_are_those_of_the_same_force(method: str, disk: st.Disk) -> None:
    start = {"theta": 1.3, "omega3": 1.1, "phi_dot": 0.2, "slip_x": 0.3, "slip_y": -0.1}
    mine = st.simulate(disk, Same(0.7), start, 2.0, method=method)
    known = st.simulate(disk, st.Viscous(0.7), start, 2.0, method=method)
    assert mine.attrs["outcome"] == known.attrs["outcome"]
    bound = float(mine.final_error + known.final_error)
    for name in ("theta", "omega3", "slip_x", "energy", "normal_force"):
        assert abs(float(mine[name][-1] - known[name][-1])) <= 10 * bound


def test_energy_is_kept_in_account_under_a_law_of_its_own() -> None:
    start = {"theta": 1.3, "omega3": 1.1, "slip_x": 0.9}
    mine = st.simulate(st.Disk(), Weakening(0.7), start, 3.0, tolerance=1e-12)
    viscous = st.simulate(st.Disk(), st.Viscous(0.7), start, 3.0, tolerance=1e-12)
    assert float(mine.energy_error) < 1e-9
    assert float(mine.dissipated[-1]) > 0.1
    assert abs(float(mine.theta[-1] - viscous.theta[-1])) > 1e-3  # another law, another motion


def test_a_subclass_of_a_stored_law_does_not_get_its_polynomials() -> None:
    half = st.spectrum("rolling", contact=Half(0.6), at=2.0, certify=True)
    known = st.spectrum("rolling", contact=st.Viscous(0.3), at=2.0, certify=True)
    assert np.abs(half.eigenvalues - known.eigenvalues).max() < 1e-12


@pytest.mark.parametrize(
    ("call", "why"),
    [
        (lambda: st.spectrum("rolling", contact=Suction(0.3), at=2.0), "not linear in the normal"),
        (lambda: st.simulate(st.Disk(), Suction(0.3), {"theta": 1.3}, 1.0), "not linear"),
        (lambda: st.spectrum("rolling", contact=Boastful(0.3), at=2.0), "conservative"),
        (lambda: st.spectrum("rolling", contact=Alone(), at=2.0), "force of the alone law is 3"),
        (
            lambda: st.stream_map(
                "rolling",
                x=("at", 1, 2, 9),
                y=("k", 0.1, 0.5, 9),
                out="m.nc",
                contact=Weakening(0.3),
            ),
            "the weakening law has no exact polynomials",
        ),
        (lambda: st.simulate(st.Disk(), Sticky(0.3), {"theta": 1.3}, 1.0), "sticky law sticks"),
        (lambda: st.simulate(st.Disk(), Slipless(0.3), {"theta": 1.3}, 1.0), "leaves out the slip"),
        (lambda: st.spectrum("rolling", contact=Slipless(0.3), at=2.0), "leaves out the slip"),
        (lambda: Homeless(), "parameter nu and no such field"),
        (lambda: Weakening(-1.0), "nu is -1"),
        (lambda: Weakening(None), "nu is None"),
        (lambda: st.spectrum("rolling", contact=Weakening, at=2.0), "give Weakening"),
        (lambda: st.spectrum("circling", contact=Weakening(0.3), at=[1.0, 1.0]), "rough disk"),
        (lambda: st.drift(at=2.0, tilt=0.1, contact=Weakening(0.3)), "drift needs a law"),
        (
            lambda: st.stability_map(
                "rolling", x=("at", 1, 2, 3), y=("k", 0.1, 0.5, 3), contact=Weakening
            ),
            "nu is missing; give Weakening",
        ),
    ],
)
def test_what_a_law_cannot_do_is_refused_in_a_sentence(call: Any, why: str) -> None:
    with pytest.raises(st.StabilityError, match=why):
        call()


@pytest.fixture
def near(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(own_law.__file__).parent)


@pytest.mark.usefixtures("near")
def test_the_command_line_takes_a_law_from_a_module(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    law = ["--contact", "own_law:Weakening"]
    given = [*law, "--set", "nu=0.3"]
    assert main(["spectrum", "rolling", *given, "--at", "2", "--json"]) == 0
    mine = json.loads(capsys.readouterr().out)
    assert main(["spectrum", "rolling", "--mu", "0.3", "--at", "2", "--json"]) == 0
    known = json.loads(capsys.readouterr().out)
    assert mine["eigenvalues"] == known["eigenvalues"]
    assert mine["parameters"]["nu"] == 0.3
    out = str(tmp_path / "m.nc")
    axes = ["--x", "at:0.5:2:5", "--y", "nu:0.1:0.5:4"]
    assert main(["map", "rolling", *axes, *law, "--out", out]) == 0
    assert st.read_map(out).sizes["nu"] == 4
    motion = ["simulate", "--theta", "1.4", "--omega3", "1", "--time", "1", *given]
    assert main(motion) == 0
    assert "moving" in capsys.readouterr().out


@pytest.mark.usefixtures("near")
@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["own_law:Weakening"], "nu is missing; the weakening law needs"),
        (["own_law:Weaken", "--set", "nu=1"], "cannot be imported"),
        (["no_such_module:Law"], "cannot be imported"),
        (["os:path"], "not a subclass of Contact"),
        (["own law:x y"], "give `module:Class`"),
        (["own_law:Weakening", "--set", "nu"], "give NAME=NUMBER"),
        (["own_law:Weakening", "--set", "nu=a"], "a number is needed"),
        (["own_law:Weakening", "--set", "nu=1", "--set", "nu=2"], "given twice"),
        (["own_law:Weakening", "--set", "nu=1", "--mu", "2"], "the weakening law takes nu"),
        (["viscous", "--mu", "2", "--set", "nu=1"], "the viscous law has none"),
    ],
)
def test_a_wrong_law_on_the_command_line_is_one_sentence(
    words: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["spectrum", "rolling", "--at", "2", "--contact", *words]) == 2
    said = capsys.readouterr()
    assert why in said.err
    assert said.err.count("\n") == 1
    assert not said.out


# --- a law of two numbers, one of which may be zero ---


def test_a_number_that_may_be_zero_is_accepted_at_zero_and_not_below() -> None:
    start = [1.2, 0.1, 0.4, 1.6, 0.3, -0.2]
    plain = st.simulate(st.Disk(), st.Viscous(0.3), start, [1.0, 3.0])
    zero = st.simulate(st.Disk(), Cubic(0.3, 0.0), start, [1.0, 3.0])
    more = st.simulate(st.Disk(), Cubic(0.3, 5.0), start, [1.0, 3.0])
    assert np.allclose(zero.theta, plain.theta, rtol=0, atol=float(plain.final_error) + 1e-12)
    assert abs(more.theta - plain.theta).max() > 1e-3
    found = st.stability_map(
        "rolling", x=("at", 0.5, 2, 4), y=("beta", 0, 1, 3), contact=Cubic(0.3, 1.0)
    )
    known = st.stability_map("rolling", x=("at", 0.5, 2, 4), y=("mu", 0.3, 1, 3))
    assert (found.verdict.values == known.verdict.values[0]).all()  # linear: beta is not in it
    with pytest.raises(st.StabilityError, match="beta is -1; it must not be negative"):
        Cubic(0.3, -1.0)
    with pytest.raises(st.StabilityError, match="mu is 0; friction must be positive"):
        Cubic(0.0, 1.0)
    with pytest.raises(st.StabilityError, match="beta is -1; it must not be negative"):
        st.stability_map(
            "rolling", x=("at", 1, 2, 3), y=("beta", -1, 1, 3), contact=Cubic(0.3, 1.0)
        )


def test_one_number_is_given_and_the_other_swept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "two_numbers", SimpleNamespace(Law=Cubic))
    words = [
        "map",
        "rolling",
        "--x",
        "at:.5:2:5",
        "--y",
        "beta:0:1:4",
        "--contact",
        "two_numbers:Law",
        "--mu",
        "0.3",
        "--out",
        str(tmp_path / "m.nc"),
    ]
    assert main(words) == 0
    capsys.readouterr()
    assert json.loads(st.read_map(tmp_path / "m.nc").attrs["parameters"])["mu"] == 0.3
    assert (
        main(
            [
                "spectrum",
                "rolling",
                "--at",
                "2",
                "--contact",
                "two_numbers:Law",
                "--mu",
                "0.3",
                "--set",
                "beta=0.5",
            ]
        )
        == 0
    )
    line = capsys.readouterr().out.splitlines()[0]
    assert re.search("mu = 0.3[^,]*, beta = 0.5", line), line


def test_slow_drift_is_told_of_the_laws_it_was_derived_for_alone() -> None:
    with pytest.raises(st.StabilityError, match="drift needs a law with friction: Viscous"):
        st.drift(at=1.3, contact=Half(0.3), tilt=0.01)
