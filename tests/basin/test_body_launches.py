"""Launches near the steady motions of bodies: their starts, their ends, and the linear verdict."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest
import xarray

import stability as st
from stability.base.errors import NameUnknownError, ParameterError

LAW: dict[str, Any] = {"contact": "viscous", "mu": 0.3}
FEW: dict[str, Any] = {"y": ("tilt", 0.1, 0.2, 2), "horizon": 1.0} | LAW
OFFSET = 0.3


@pytest.fixture(scope="module")
def top() -> xarray.Dataset:
    """A tippe top, set down with its centre of mass high up."""
    return st.basins(
        st.EccentricSphere(OFFSET),
        family="vertical",
        pole="pi",
        horizon=300.0,
        x=("at", 0.2, 2.2, 9),
        y=("tilt", 0.02, 1.4, 6),
        **LAW,
    )


def jellett(moments: tuple[float, float], theta: Any, phi_dot: Any, omega3: Any) -> Any:
    """Jellett's integral of a ball with its centre of mass off centre, for every friction.

    The angular momentum along the line from the centre of mass to the contact point: that line is
    ẑ - e n with n the axis, and L·ẑ = I1 φ̇ sin²θ + I3 ω₃ cosθ, L·n = I3 ω₃.
    """
    axial, transverse = moments
    return transverse * phi_dot * np.sin(theta) ** 2 + axial * omega3 * (np.cos(theta) - OFFSET)


@pytest.mark.long
def test_ends_keep_jellett_s_integral(top: xarray.Dataset) -> None:
    """No force at the contact changes it: the start alone says which member is reached."""
    moments = tuple(map(float, st.EccentricSphere(OFFSET).moments()))
    axial, transverse = moments
    start = np.moveaxis(top.start_state.values, -1, 0)
    first = jellett((axial, transverse), start[0], start[2], start[3])
    names = str(top.family.attrs["flag_meanings"]).split()
    settled, member = top.outcome.values == 1, top.member.values
    c, s = np.cos(member), np.sin(member)
    spin = np.sqrt(OFFSET / (transverse * c - axial * (c - OFFSET)))  # of tumbling at rest
    last = {
        "vertical_at_theta_=_0": axial * member * (1 - OFFSET),
        "tumbling": spin * (transverse * s**2 + axial * (c - OFFSET) ** 2),
    }
    slopes = {"vertical_at_theta_=_0": axial * (1 - OFFSET)}
    step = 1e-6
    for name, value in last.items():
        mine = settled & (top.family.values == names.index(name))
        assert mine.sum() >= 5, name
        if name == "tumbling":
            more = member + step
            c2, s2 = np.cos(more), np.sin(more)
            spin2 = np.sqrt(OFFSET / (transverse * c2 - axial * (c2 - OFFSET)))
            slope = (spin2 * (transverse * s2**2 + axial * (c2 - OFFSET) ** 2) - value) / step
        else:
            slope = np.full_like(value, slopes[name])
        # the reflected motion has the integral with the other sign, and the same member
        off = np.minimum(abs(value - first), abs(value + first)) / abs(slope)
        assert (off[mine] <= 1.5 * top.member_error.values[mine] + 1e-6).all()
        assert (top.member_error.values[mine] < 0.1).all()


@pytest.mark.long
def test_starts_lean_from_the_member(top: xarray.Dataset) -> None:
    start = top.start_state
    tilt, rate = np.meshgrid(top.tilt.values, top.omega_Z.values, indexing="ij")
    assert np.array_equal(start.values[..., 0], math.pi - tilt)
    assert np.array_equal(start.values[..., 3], -rate)  # the axis points down
    assert not start.values[..., [1, 2, 4, 5]].any()
    assert top.omega_Z.attrs["long_name"] == "angular velocity along Z"
    assert top.omega_Z.attrs["unit_in_words"] == "√(g/R)"
    assert top.attrs["launched_near"] == "vertical at theta = pi"


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("body", "near"),
    [
        (st.EccentricSphere(OFFSET), {"family": "vertical", "pole": "pi", "at": 1.1}),
        (st.Torus(0.3), {"family": "spinning", "at": 2.5}),
        (st.Spheroid(0.7, mass=0.2, gravity=9.8, length=0.04), {"family": "tumbling", "at": 0.9}),
        (st.ThickDisk(0.3), {"family": "rolling", "at": 2.0}),
    ],
    ids=["top", "torus", "spheroid in SI", "thick disk"],
)
def test_each_ends_as_its_single_launch(body: Any, near: dict[str, Any]) -> None:
    own, at = dict(near), near["at"]
    del own["at"]
    scale = 1.0 if body.dimensionless else math.sqrt(body.length / body.gravity)
    found = st.basins(
        body=body,
        horizon=60.0 * scale,
        x=("at", 0.9 * at, at, 2),
        y=("tilt", 0.02, 0.3, 2),
        **own,
        **LAW,
    )
    [name] = [str(n) for n in found.outcome.dims if n != "tilt"]
    for at_one in found[name].values:
        for tilt in found.tilt.values:
            one = found.sel({name: at_one, "tilt": tilt})
            six = st.launch(near["family"], at=at_one, tilt=tilt, body=body, pole=near.get("pole"))
            assert np.allclose(one.start_state, six, rtol=1e-14, atol=0)
            alone = st.simulate(body, st.Viscous(0.3), six, [0.0, 60.0 * scale])
            assert int(one.outcome) == st.Outcome(alone.attrs["outcome"]).code


@pytest.mark.long
def test_the_linear_verdict_changes_at_the_published_rate() -> None:
    """Spin of a tippe top about its high centre of mass, from the expansion at the pole.

    With ρ = 1 the radius, h = 1 + e and h'' = -e at θ = π, it is stable where
    n² (I3 h - I1) > e h²: Jellett's top, I3 h > I1.
    """
    body = st.Body(lambda theta: 1 - 0.1 * ca.cos(theta), axial=0.42, transverse=0.4, name="top")
    h = 1.1
    rate = math.sqrt(0.1 * h**2 / (0.42 * h - 0.4))
    found = st.basins(body, family="vertical", pole="pi", x=("at", 0.5, 2 * rate, 9), **FEW)
    told = found.linear_verdict
    assert found.linear_verdict.dims == ("omega_Z",)
    assert told.attrs["changes"] == pytest.approx([rate], rel=1e-10)
    assert told.attrs["zones"] == [2, 1]
    assert told.values.tolist() == [2 if v < rate else 1 for v in found.omega_Z.values]
    assert "of vertical at theta = pi under viscous contact" in told.attrs["long_name"]


@pytest.mark.long
def test_other_states_may_differ_from_those_of_the_member() -> None:
    found = st.basins(
        st.Torus(0.3), family="rolling", x=("at", 1.0, 1.2, 2), held={"theta_dot": 0.05}, **FEW
    )
    assert (found.start_state.values[..., 1] == 0.05).all()
    assert "linear_verdict" in found.coords


def test_labels_take_a_family_of_a_body() -> None:
    ends = st.launch_labels(
        body=st.EccentricSphere(OFFSET),
        family="vertical",
        pole="pi",
        varied=("omega_Z", "tilt"),
        horizon=300.0,
        **LAW,
    )
    [first, last] = ends(np.array([[0.7, 0.2], [6.0, 1.0]]))
    assert ends.words(first) == "settled on tumbling" and ends.words(last) == "lift-off"


@pytest.mark.parametrize(
    ("asked", "error", "words"),
    [
        (
            dict(
                body=st.ThickDisk(0.3),
                family="rolling",
                x=("thickness", 0.1, 0.3, 3),
                held={"at": 1.0},
            ),
            ParameterError,
            "rolling has another inclination at each",
        ),
        (
            dict(body=st.Torus(0.2), family="vertical", x=("at", 1, 2, 3)),
            st.StabilityError,
            "not smooth at theta = 0",
        ),
        (
            dict(body=st.Torus(0.2), family="circling", x=("at", 1, 2, 3)),
            NameUnknownError,
            "give one of rolling, spinning, tumbling, vertical",
        ),
        (
            dict(body=st.Torus(0.2), family="tumbling", x=("at", 0.5, 1.9, 3)),
            ParameterError,
            "the tilt takes theta|no such motion",
        ),
        (dict(family="vertical", x=("at", 1, 2, 3)), NameUnknownError, "'vertical'"),
        (dict(family="rolling", pole=0, x=("at", 1, 2, 3)), ParameterError, "pole belongs"),
        (
            dict(body=st.Torus(0.2), theta=1.0, x=("omega3", 1, 2, 3)),
            ParameterError,
            "theta chooses where a family rolls",
        ),
        (
            dict(body=st.Torus(0.2), pole=0, x=("omega3", 1, 2, 3)),
            ParameterError,
            "pole belongs to the family vertical",
        ),
        (
            dict(body=st.EccentricSphere(0.3), family="vertical", pole=3, x=("at", 1, 2, 3)),
            ParameterError,
            "give 0 or 'pi'",
        ),
        (
            dict(body=st.Torus(0.2), family="rolling", x=("omega_Z", 1, 2, 3)),
            NameUnknownError,
            "'omega_Z' varies nothing here",
        ),
    ],
)
def test_what_does_not_fit_is_refused_before_a_launch_runs(
    asked: dict[str, Any], error: type[Exception], words: str
) -> None:
    seen: list[tuple[int, int]] = []
    with pytest.raises(error, match=words):
        st.basins(
            **(FEW | {"y": ("tilt", 0.1, 0.6, 3)} | asked), progress=lambda *told: seen.append(told)
        )
    assert not seen


def test_a_member_missing_in_the_middle_of_an_axis_is_refused_first() -> None:
    """The first and the last launch of the map exist."""
    seen: list[tuple[int, int]] = []
    with pytest.raises(ParameterError, match="no such motion|overflows|tilt takes"):
        st.basins(
            body=st.EccentricSphere(OFFSET),
            family="tumbling",
            x=("at", 0.3, 3.0, 7),
            y=("tilt", 0.01, 0.1, 2),
            horizon=500.0,
            **LAW,
            progress=lambda *told: seen.append(told),
        )
    assert not seen


def test_one_launch_refuses_shapes_that_lean_differently() -> None:
    with pytest.raises(ParameterError, match="another inclination at each"):
        st.launch("rolling", at=1.0, body=st.ThickDisk(np.array([0.1, 0.3])))
    equal = st.launch("rolling", at=1.0, body=st.Torus(np.array([0.1, 0.3])))
    assert (equal[:, 0] == math.pi / 2 - 0.1).all()
