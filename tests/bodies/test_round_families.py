"""Families of a body of revolution: closed forms, steadiness, and a search for others."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import least_squares

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system
from stability.bodies.round_body.families import round_family
from stability.bodies.round_body.inclinations import level, tumbling_ranges
from stability.bodies.round_body.pole_equations import pole_system

EGG = st.Body(
    lambda theta, a, b: 1 + a * ca.cos(theta) + b * ca.cos(2 * theta) + 0.01 * ca.cos(3 * theta),
    axial=0.3,
    transverse=0.4,
    shape={"a": 0.1, "b": 0.08},
    name="egg",
)
BODIES = (
    st.Torus(0.2),
    st.Spheroid(0.4),
    st.Spheroid(1.7),
    st.EccentricSphere(0.2),
    EGG,
    st.ThickDisk(0.3),
)


def _numbers(body: st.Body, mu: float) -> dict[str, float]:
    axial, transverse = body.moments()
    return {"axial": axial, "transverse": transverse, "mu": mu} | dict(body.shape)


def _tumbles(body: st.Body, theta: float) -> tuple[float, float] | None:
    """phi_dot and omega3 of tumbling by the closed form, from h and h' as numbers."""
    h, slope = body.height_at(theta), body.height_at(theta, 1)
    axial, transverse = body.moments()
    s, c = math.sin(theta), math.cos(theta)
    r, z = h * s + slope * c, h * c - slope * s
    square = slope * r / (s * (transverse * r * c - axial * z * s))
    return (math.sqrt(square), math.sqrt(square) * s * z / r) if square > 0 else None


@pytest.mark.few(6)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("body", BODIES, ids=lambda b: b.name)
def test_tumbling_has_the_closed_form_and_is_steady(body: st.Body, law: str) -> None:
    given = ("mu",) if LAWS[law].parameters else ()
    family = round_family(body, "tumbling", LAWS[law], given, physical=False)
    p = [_numbers(body, 0.4)[n] for n in family.parameters]
    low, high = body.between
    met = 0
    for theta in np.linspace(low, high, 14)[1:-1]:  # never upright
        known = _tumbles(body, float(theta))
        if known is None:
            with pytest.raises(st.StabilityError):
                family.member([theta], p)
            continue
        state = family.member([theta], p)
        assert state[2:4] == pytest.approx(known, rel=1e-9)
        assert np.abs(family.system.rates(state, p)).max() < 1e-9
        met += 1
    assert met or body.name == "eccentric sphere"


@pytest.mark.parametrize(("thickness", "theta"), [(0.2, 1.0), (0.2, 0.3), (0.8, 0.5), (0.8, 1.3)])
def test_a_thick_disk_tumbles_whatever_its_thickness(thickness: float, theta: float) -> None:
    """Sizes at which structure is sampled are those of the body: at thickness 1 there is none."""
    body = st.ThickDisk(thickness)
    assert _tumbles(body, theta) is not None
    found = st.spectrum("tumbling", at=theta, body=body, contact=st.Viscous(0.3))
    assert found.structural_zeros == 1
    assert found.states[2:4] == pytest.approx(_tumbles(body, theta), rel=1e-9)


def test_a_body_tumbles_in_the_ranges_of_the_closed_form() -> None:
    for body in (st.Torus(0.3), st.Spheroid(1.7), st.EccentricSphere(0.2), st.ThickDisk(0.8)):
        ranges = tumbling_ranges(body)
        assert ranges
        low, high = body.between
        for theta in np.linspace(low, high, 40)[1:-1]:
            if min(abs(theta - end) for pair in ranges for end in pair) < 0.01:
                continue
            inside = any(a < theta < b for a, b in ranges)
            assert inside == (_tumbles(body, float(theta)) is not None), (body.name, theta)
    ball = st.Body(lambda _: 1.0, axial=0.4, transverse=0.4, name="ball")
    assert tumbling_ranges(ball) == []


def test_rolling_leans_where_the_height_has_its_flat_points() -> None:
    assert level(st.Torus(0.2)) is None
    thick = st.ThickDisk(0.3)
    assert level(thick) == pytest.approx(math.atan(2 / 0.3), rel=1e-14)
    family = round_family(thick, "rolling", LAWS["viscous"], ("mu",), physical=False)
    state = family.member([1.3], [0.3, 0.5])
    assert state[0] == pytest.approx(math.atan(2 / 0.3), rel=1e-14)
    assert np.abs(family.system.rates(state, [0.3, 0.5])).max() < 1e-14
    lean = st.Body(lambda t: 1 + 0.08 * ca.cos(4 * t) / 2, axial=0.3, transverse=0.3, name="knob")
    with pytest.raises(st.StabilityError, match="give theta="):
        level(st.Body(lambda t: 1 + 0.02 * ca.cos(3 * t), axial=0.3, transverse=0.3))
    assert level(lean) is None
    assert level(lean, 0.8) == pytest.approx(math.pi / 4)


# --- a search to refute completeness ---
#
# A motion is steady if the body, seen from axes that turn about the vertical at a constant rate,
# does not change.  Angles say so by rates that vanish; fixed axes, which hold at the poles too,
# have that rate as an unknown of the search.  Each root must be a member by closed forms.

LENS = st.Body(
    lambda t, a: ca.sqrt(0.2 + ca.sin(t) ** 2) * (1 + a * ca.sin(t) ** 2),
    axial=0.35,
    transverse=0.2,
    shape={"a": 0.03},
    name="lens",
)
ROUND = (st.Spheroid(0.4), st.Spheroid(1.7), st.EccentricSphere(0.2), EGG, LENS)
EVERY = (*ROUND, st.Torus(0.2), st.Torus(0.6, solid=False), st.ThickDisk(0.3), st.ThickDisk(1.5))
SEARCHES = [15, pytest.param(60, marks=pytest.mark.long)]
MOST = 0.5
"""Least share of the searches that end at a steady motion."""
NEAR = 1e-4
"""How far a root may lie from a member: equations are flat where families meet, and at rest."""

Residual = Callable[[np.ndarray], np.ndarray]


def _values(body: st.Body, names: tuple[str, ...]) -> list[float]:
    axial, transverse = body.moments()
    table = {"axial": axial, "transverse": transverse, "mu": 0.4, "c": 0.4} | dict(body.shape)
    return [float(table[n]) for n in names]


def _given(law: str) -> tuple[str, ...]:
    return tuple(p.name for p in LAWS[law].parameters[:1])


def _root(left: ca.SX, unknowns: ca.SX, p: ca.SX, numbers: list[float]) -> tuple[Residual, ...]:
    """The equations and their slopes as functions of the unknowns."""
    made = ca.Function("search", [unknowns, p], [left, ca.jacobian(left, unknowns)])

    def value(y: np.ndarray) -> np.ndarray:
        found = np.asarray(made(y, numbers)[0]).ravel()
        return np.where(np.isfinite(found), found, 1e6)

    return value, lambda y: np.nan_to_num(np.asarray(made(y, numbers)[1]))


def _kind(body: st.Body, law: str, motion: tuple[float, float, float], slip: float) -> str | None:
    """The family of (theta, phi_dot, omega3) with a slip; None for a motion that has no name."""
    theta, phi_dot, omega3 = motion
    h, slope, _ = body.heights(theta)
    axial, transverse = body.moments()
    s, c = math.sin(theta), math.cos(theta)
    r, z = h * s + slope * c, h * c - slope * s
    size = 1 + phi_dot**2 + omega3**2
    if slip > NEAR * size:
        return None
    if abs(phi_dot) < NEAR * size and abs(slope) < NEAR * size:
        return "rolling"
    if law in ("rough", "smooth"):
        left = {
            "rough": phi_dot
            * (omega3 * (r * h + axial * s) - phi_dot * s * (z * h + transverse * c)),
            "smooth": phi_dot * s * (axial * omega3 - transverse * phi_dot * c),
        }[law]
        name = {"rough": "circling", "smooth": "precession"}[law]
        return name if abs(slope + left) < NEAR * size else None
    if max(abs(c), abs(slope), abs(omega3)) < NEAR * size:
        return "spinning"
    rests = abs(omega3 * r - phi_dot * s * z) < NEAR * size
    turns = abs(phi_dot**2 * s * (transverse * r * c - axial * z * s) - slope * r) < NEAR * size
    return "tumbling" if rests and turns else None


def _search(value: Residual, slope: Residual, starts: list[np.ndarray]) -> list[np.ndarray]:
    """Roots that the searches end at."""
    found = []
    with np.errstate(all="ignore"):
        for start in starts:
            end = least_squares(
                value, start, slope, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=1500
            )
            if np.abs(end.fun).max() < 1e-13 * (1 + np.abs(end.x).max() ** 2):
                found.append(end.x)
    return found


@pytest.mark.few(4)
@pytest.mark.parametrize("searches", SEARCHES)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("body", EVERY, ids=lambda b: f"{b.name} {list(b.shape.values())[0]}")
def test_no_other_steady_motion_is_found(body: st.Body, law: str, searches: int) -> None:
    system = round_system(body, LAWS[law], _given(law), physical=False)
    kept = [i for i, n in enumerate(system.states) if n != "theta_dot"]
    unknowns = ca.SX.sym("y", len(kept))
    state = ca.vertcat(unknowns[0], 0, unknowns[1:])
    rhs = ca.substitute(system.rhs, system.x, state)
    value, slope = _root(rhs[1:], unknowns, system.p, _values(body, system.parameters))
    rng = np.random.default_rng(5)
    low, high = body.between
    starts = [
        np.array(
            [
                rng.uniform(low + 0.1, high - 0.1),
                *rng.normal(0, 1.5, 2),
                *rng.normal(0, 0.3, len(kept) - 3),
            ]
        )
        for _ in range(searches)
    ]
    kinds: Counter[str | None] = Counter()
    for theta, phi_dot, omega3, *slip in _search(value, slope, starts):
        if body in ROUND:  # through a pole to the other side, where the height is the same
            theta = abs(math.remainder(theta, 2 * math.pi))
        motion, sliding = (float(theta), float(phi_dot), float(omega3)), math.hypot(*slip)
        if low + 1e-3 < theta < high - 1e-3:
            kinds[_kind(body, law, motion, sliding)] += 1
        elif body in ROUND:  # the axis is vertical, and so is all of its spin
            kinds["vertical" if sliding < NEAR * (1 + phi_dot**2 + omega3**2) else None] += 1
    assert None not in kinds, kinds
    assert sum(kinds.values()) > MOST * searches, kinds


@pytest.mark.parametrize(
    ("body", "law", "searches"),
    [(ROUND[0], "rough", 20), (ROUND[2], "smooth", 20)]
    + [pytest.param(body, law, 60, marks=pytest.mark.long) for body in ROUND for law in LAWS],
    ids=lambda v: f"{v.name} {list(v.shape.values())[0]}" if isinstance(v, st.Body) else str(v),
)
def test_no_other_steady_motion_is_found_at_or_near_a_pole(
    body: st.Body, law: str, searches: int
) -> None:
    system = pole_system(body, LAWS[law], _given(law), physical=False)
    x, turn = system.x, ca.SX.sym("turn")
    up = ca.SX([0, 0, 1])
    axis, omega, slip = x[:3], x[3:6], x[6:]
    seen = [
        system.rhs[:3] - turn * ca.cross(up, axis),
        system.rhs[3:6] - turn * ca.cross(up, omega),
    ]
    if slip.numel():
        seen.append(system.rhs[6:] - turn * ca.vertcat(-slip[1], slip[0]))
    left = ca.vertcat(*seen, ca.sumsqr(axis) - 1)
    value, slope = _root(left, ca.vertcat(x, turn), system.p, _values(body, system.parameters))
    rng = np.random.default_rng(6)
    starts = []
    for i in range(searches):
        wide = 1.0 if i % 2 else 0.1  # half of them next to a pole
        axis_ = np.array([*rng.normal(0, wide, 2), rng.choice([-1.0, 1.0])])
        starts.append(
            np.concatenate(
                [
                    axis_ / np.linalg.norm(axis_),
                    rng.normal(0, 1.5, 3),
                    rng.normal(0, 0.3, slip.numel()),
                    rng.normal(0, 1.5, 1),
                ]
            )
        )
    kinds = Counter(_at_pole(body, law, y, slip.numel()) for y in _search(value, slope, starts))
    assert None not in kinds, kinds
    assert sum(kinds.values()) > MOST * searches, kinds
    if law in ("viscous", "linear-viscous"):  # vertical spin is the edge of families of pairs
        assert {"vertical 0", "vertical pi"} <= kinds.keys()


def _at_pole(body: st.Body, law: str, y: np.ndarray, slips: int) -> str | None:
    axis, omega, slip = y[:3], y[3:6], float(np.hypot(*y[6:8])) if slips else 0.0
    size = 1 + float(omega @ omega)
    if np.hypot(*axis[:2]) < NEAR:
        still = max(float(np.hypot(*omega[:2])), slip) < NEAR * size
        return ("vertical 0" if axis[2] > 0 else "vertical pi") if still else None
    return _kind(body, law, (math.acos(axis[2]), float(y[-1]), float(omega @ axis)), slip)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("body", "theta"),
    [
        # random members next to this one rest at no such inclination
        (replace(st.Egg(0.2), axial=0.2), 1.6),
        # at the middle of its numbers the contact point is below the centre, at every rate of turn
        (replace(st.ThickDisk(1.88), axial=0.1638, transverse=0.1644), 1.154),
    ],
)
@pytest.mark.parametrize("law", ["rough", "smooth", "viscous"])
def test_a_member_is_not_refused_for_others_that_do_not_exist(
    body: st.Body, theta: float, law: str
) -> None:
    """What is established at random members is established where there are some."""
    mu = {"mu": 0.3} if law == "viscous" else {}
    found = st.spectrum("tumbling", at=theta, contact=law, body=body, certify=True, **mu)
    system = found.family.system
    jacobian = ca.Function("J", [system.x, system.p], [ca.densify(system.jacobian)])
    known = body.given | mu
    true = np.linalg.eigvals(
        np.asarray(jacobian(found.states, [known[n] for n in system.parameters]))
    )
    left = true[np.argsort(np.abs(true))][found.structural_zeros :]
    assert abs(left.real.max() - found.abscissa) < 1e-6 * np.abs(true).max()
    assert (found.verdict is st.Verdict.UNSTABLE) == (found.abscissa > 1e-6)
