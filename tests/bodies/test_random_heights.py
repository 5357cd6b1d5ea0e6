"""Random heights against Newton's and Euler's laws in inertial axes: verdicts, changes, motions.

The oracle knows the surface alone (`random_heights`), finds members by Newton's method, and reads a
verdict from eigenvalues to 15 digits and more.  What the package leaves undecided is counted.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import convex_body as oracle
import mpmath as mp
import numpy as np
import pytest
from body_motion import move
from jets import Array, plain, precise
from random_heights import HEIGHTS, HeightBody, random_height

import stability as st
from stability.base.errors import NoMemberError
from stability.bodies.contact_laws import LAWS

DIGITS = 30
CLEAR = 1e-9
"""Real part, over the largest eigenvalue, beyond which the oracle has a verdict."""
FAST = 0.01
"""Rate of decay from which a launch is followed until it settles."""
NAMED = {"rolling": [3], "spinning": [2], "tumbling": [0], "circling": [0, 2], "precession": [0, 2]}
UNKNOWN = {"rolling": [0], "spinning": [], "tumbling": [2, 3], "circling": [3], "precession": [3]}
"""Places, in the oracle's state, of what names a member, and of what is solved for."""
DISK_STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
RATES = ("rolling", "spinning", "vertical")
"""Families along a rate, which have a member at every one."""
SERIES = {"sqrt": ca.sqrt, "exp": ca.exp}
CASADI = lambda kind, t, **n: HEIGHTS[kind](ca.cos(t), ca.sin(t), SERIES, **n)  # noqa: E731


@dataclass(frozen=True)
class Case:
    """A body under a law, and its twin in the package."""

    shape: HeightBody
    own: st.Body
    law: oracle.Law
    contact: st.Contact
    rng: np.random.Generator

    def __repr__(self) -> str:
        body = self.shape.body
        return (
            f"{self.shape.kind} {dict(self.shape.numbers)}, axial {body.axial}, transverse "
            f"{body.transverse}, {self.contact}"
        )

    def families(self) -> Iterator[tuple[str, Any]]:
        """Families that the surface has under the law, and a random number for each."""
        rate = lambda: float(self.rng.uniform(0.2, 4.0) * self.rng.choice([-1, 1]))  # noqa: E731
        theta = float(self.rng.uniform(0.3, math.pi - 0.3))
        grid = np.linspace(0.01, math.pi - 0.01, 301)
        levers = [self.shape.at(t)[1] for t in grid]
        places = [t for t, f, g in zip(grid, levers, levers[1:], strict=False) if f * g < 0]
        if self.shape.even or len(places) < 2:
            yield "rolling", rate()
        else:
            yield from ((f"rolling {t + 0.005}", rate()) for t in places)
        yield "tumbling", theta
        if self.shape.even:
            yield "spinning", rate()
        if not self.shape.numbers["edge"]:
            yield from (("vertical 0", rate()), ("vertical pi", rate()))
        pair = {"rough": "circling", "smooth": "precession"}.get(self.law.name)
        if pair:
            yield pair, (theta, rate())

    def has(self, family: str, at: Any) -> bool:
        """Whether the surface has a member that the package refuses."""
        if (
            family == "tumbling"
        ):  # the moment of the weight turns the angular momentum the right way
            s, c, (h, lever, _) = math.sin(at), math.cos(at), self.shape.at(at)
            pose = oracle.pose_at(self.shape.body, np.array([at, 0, 1.0, 0, 0, 0]))
            along, away = pose.arm @ pose.axis, h * s + lever * c
            spin = np.array([at, 0, 1.0, -s * along / away, 0, 0])
            pose = oracle.pose_at(self.shape.body, spin)
            return bool(pose.arm[0] * np.cross([0, 0, 1.0], pose.momentum)[1] < 0)
        return family != "rolling" or any(
            self.shape.at(t)[1] * self.shape.at(3.1)[1] < 0 for t in np.linspace(0.02, 3.0, 99)
        )

    def family(self, name: str) -> st.Family:
        """The family of the package."""
        pole = {"vertical 0": 0, "vertical pi": "pi"}.get(name)
        word, *near = name.split()
        theta = float(near[0]) if word == "rolling" and near else None
        return self.own.family(word, self.contact, pole=pole, theta=theta)

    def numbers(self, record: st.Family) -> dict[str, float]:
        """Values of its parameters."""
        table = dict(self.own.given) | {n: self.law.coefficient for n in ("mu", "c")}
        return {n: table[n] for n in record.parameters}

    def truth(self, family: str, at: Any, near: Array, zeros: int = 7) -> str | None:
        """The verdict at the oracle's member near a state; None next to the imaginary axis.

        Where more than so many eigenvalues vanish, as of a ball on its pole, it is None too.
        """
        body, law = self.shape.body, self.law
        with mp.workdps(DIGITS):
            if family.startswith("vertical"):
                side = 1 if family.endswith("0") else -1
                rates = lambda x: oracle.axis_rates(body, law, x, side)  # noqa: E731
                state = precise([0, 0, 0, 0, at, 0, 0])
            else:
                rates = lambda x: oracle.rates(body, law, x)  # noqa: E731
                state = self._member(family, at, near)
            size = len(state) - 2 * (law.name in ("rough", "smooth"))
            worst = np.abs(plain(rates(state))[:size]).max()
            assert worst < 1e-18, (self, family, at, worst)
            matrix = oracle.jacobian(rates, state, DIGITS)[:size, :size]
            values = oracle.spectrum(matrix, DIGITS)
        values = values / max(1.0, np.abs(values).max())
        if (np.abs(values) <= CLEAR).sum() > zeros:
            return None
        values = values[np.abs(values) > CLEAR]
        growth = values.real.max(initial=-1.0 if law.name not in ("rough", "smooth") else 0.0)
        if growth > CLEAR:
            return "unstable"
        if law.name in ("rough", "smooth"):
            return "neutral" if growth < CLEAR**1.5 else None
        return "stable" if growth < -CLEAR else None

    def _member(self, family: str, at: Any, near: Array) -> Array:
        family = family.split()[0]
        unknown, state = UNKNOWN[family], precise([*near[:4], 0, 0])
        state[NAMED[family]] = precise(np.atleast_1d(at))
        if family == "spinning":
            state[0], state[3] = mp.pi / 2, mp.mpf(0)

        def left(values: Array) -> Array:
            moved = state.copy()
            moved[unknown] = values
            pose = oracle.pose_at(self.shape.body, moved)
            rate = oracle.rates_of(pose, oracle.respond(pose, self.law))[1]
            return np.array([rate, pose.velocity[1]][: len(unknown)])

        for _ in range(3 if unknown else 0):
            slope = oracle.jacobian(left, state[unknown], DIGITS)
            state[unknown] = state[unknown] - oracle.solve(slope, left(state[unknown]))
        return state


def cases(seed: int, count: int, kinds: Sequence[str]) -> Iterator[Case]:
    """Random bodies, each under a random law; half have the numbers of the height as parameters."""
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        shape = random_height(rng, kinds)
        name = str(rng.choice(list(LAWS)))
        mu = 0.0 if name in ("smooth", "rough") else round(float(rng.uniform(0.05, 1.0)), 2)
        contact: Any = {
            "smooth": st.Smooth,
            "rough": st.Rough,
            "viscous": st.Viscous,
            "linear-viscous": st.LinearViscous,
        }[name]
        contact = contact(mu) if mu else contact()
        kind, numbers, given = shape.kind, dict(shape.numbers), {}
        if rng.random() < 0.5:
            given = {n: numbers.pop(n) for n in ("b", "d")}
        own = st.Body(
            lambda t, _n=numbers, _k=kind, **free: CASADI(_k, t, **_n, **free),
            axial=shape.body.axial,
            transverse=shape.body.transverse,
            shape=given,
            name=kind,
        )
        yield Case(shape, own, oracle.Law(name, mu), contact, rng)


def _verdicts(case: Case, count: Counter[str]) -> None:
    for family, at in case.families():
        try:
            record = case.family(family)
            numbers = case.numbers(record)
            near = record.member(np.atleast_1d(at), list(numbers.values()))
        except NoMemberError:
            count["no member"] += 1
            assert not case.has(family, at), (case, family, at)
            continue
        found = st.spectrum(record, at=at, certify=bool(case.rng.random() < 0.3), **numbers)
        true = case.truth(family, at, near, found.structural_zeros)
        count["undecided" if found.verdict.word == "undecided" else "verdicts"] += 1
        if true is None:
            count["next to the axis"] += 1
        elif found.verdict.word != "undecided":
            assert found.verdict.word == true, (case, family, at, true)


def _changes(case: Case, count: Counter[str]) -> None:
    """Verdicts between the changes along the number of a family, which are all there are."""
    family = str(case.rng.choice(sorted({f for f, _ in case.families() if f.split()[0] in RATES})))
    try:
        record = case.family(family)
    except NoMemberError:
        count["no member"] += 1
        return
    numbers = case.numbers(record)
    changes = st.boundaries(record, axis=(record.at[0], 0.05, 12.0, 15), **numbers)
    if not changes.complete:
        count["incomplete"] += 1
        return
    ends = [0.05, *(p.value for p in changes), 12.0]
    for i, (low, high) in enumerate(zip(ends[:-1], ends[1:], strict=True)):
        for share in (0.01, 0.5, 0.99):
            at = low + share * (high - low)
            if any(abs(at - v) < 1e-3 for v in (*changes.touching, *ends[1:-1])):
                continue
            near = record.member([at], list(numbers.values()))
            true = case.truth(family, at, near)
            if true is None or not len(changes):
                continue
            good = changes[i].stable_below if i < len(changes) else not changes[i - 1].stable_below
            assert (true != "unstable") == good, (case, family, at, true, changes)
            count["sides"] += 1
    count["axes"] += 1


class Regularised(oracle.Law):
    """Dry friction of a slip that is smoothed over a speed."""

    def drag(self, slip: Array) -> tuple[Array, Array]:
        """Force against the slip, without and per normal force."""
        mu, speed = self.coefficient
        return 0 * slip, slip * (mu / math.sqrt(slip @ slip + speed**2))


def _motion(case: Case, count: Counter[str]) -> None:
    """States up to the end, and whether the plane holds the body until then and no longer."""
    law, contact, rng = case.law, case.contact, case.rng
    if rng.random() < 0.3:
        law, contact = Regularised("regularised", (0.3, 0.05)), st.RegularisedCoulomb(0.3, 0.05)
    six = rng.normal(size=6) * [0, 0.8, 0.8, 1.5, 0.3, 0.3]
    six[0] = rng.uniform(0.6, math.pi - 0.6)
    if law.name == "rough":
        six[4:] = 0
    if oracle.response_at(case.shape.body, law, six).force[2] < 0.05:
        count["starts in the air"] += 1
        return
    run = st.simulate(case.own, contact, six, np.linspace(0.0, 2.0, 5), tolerance=1e-11)
    word = run.attrs["outcome"]
    count[word] += 1
    times = run.time.values
    if word != "moving":
        times = np.append(times[times < run.end_time.item() - 1e-9], run.end_time.item())
    true = move(case.shape.body, law, oracle.pose_at(case.shape.body, six), times, 1e-11)
    kept = min(len(times), len(run.time))
    for name, values in (("axis", np.cos(run.theta)), ("spin", run.omega3)):
        known = true.axis[:, 2] if name == "axis" else (true.spin * true.axis).sum(axis=1)
        gap = np.abs(values.values[: kept - 1] - known[: kept - 1]).max(initial=0.0)
        assert gap < 1e-8, (case, law, six.tolist(), name, gap)
    assert (true.normal_force[:-1] > 0).all(), (case, law, six.tolist(), word)
    if word == "lift-off":
        assert abs(true.normal_force[-1]) < 1e-6, (case, law, six.tolist(), true.normal_force)


def _settled(case: Case, count: Counter[str]) -> None:
    """Next to a member, what a motion settles on is stable; the end is that of the oracle."""
    if case.law.name in ("smooth", "rough"):
        return
    fastest = None
    for family, at in case.families():
        try:
            record = case.family(family)
        except NoMemberError:
            continue
        numbers = case.numbers(record)
        try:
            growth = float(st.spectrum(record, at=at, **numbers).abscissa)
        except NoMemberError:
            continue
        if fastest is None or abs(growth) > abs(fastest[0]) or growth < -FAST:
            fastest = growth, family, at, record, numbers
        if growth < -FAST:
            break
    if fastest is None:
        return
    growth, family, at, record, numbers = fastest
    near = record.member(np.atleast_1d(at), list(numbers.values()))
    member = dict(zip(record.system.states, near.tolist(), strict=True))
    pole = 0.0 if family.endswith("0") else math.pi
    if family.startswith("vertical"):
        start = {"theta": abs(pole - 1e-3), "phi_dot": 0.0, "omega3": at * math.cos(pole)}
    else:
        start = {n: member.get(n, 0.0) + 1e-3 * case.rng.uniform(-1, 1) for n in DISK_STATES}
    last = float(np.clip(12 / abs(growth) if growth else 100.0, 5.0, 1500.0))
    run = st.simulate(case.own, case.contact, start, last, tolerance=1e-9)
    word = run.attrs["outcome"]
    count[word] += 1
    stable = case.truth(family, at, near) == "stable"
    if word != "settled":
        count["stable, not settled"] += stable
        return
    name, place = str(run.nearest_family.item()), float(run.nearest_at)
    if name.startswith("vertical"):
        name = "vertical 0" if name.endswith("= 0") else "vertical pi"
    name = family if name == family.split()[0] else name.replace("near theta = ", "")
    count[name.split()[0]] += 1
    record = case.family(name)
    limit = record.member([place], list(case.numbers(record).values()))
    assert case.truth(name, place, limit) == "stable", (case, start, name, place)
    if last > 60:
        return
    six = np.array([start.get(n, 0.0) for n in DISK_STATES])
    times = np.array([0.0, last])
    true = move(case.shape.body, case.law, oracle.pose_at(case.shape.body, six), times, 1e-10)
    gap = abs(math.cos(float(run.theta[-1])) - true.axis[-1, 2])
    assert gap < float(run.final_error) + 1e-7, (case, start, gap)
    count["moved"] += 1


@pytest.mark.parametrize(
    ("check", "seed", "count"),
    [(_verdicts, 21, 2), (_changes, 22, 3), (_motion, 23, 2), (_settled, 29, 4)]
    + [
        pytest.param(*given, marks=pytest.mark.long)
        for given in (
            (_verdicts, 61, 300),
            (_changes, 32, 60),
            (_motion, 33, 60),
            (_settled, 41, 300),
        )
    ],
)
def test_random_heights(check: Callable[..., None], seed: int, count: int) -> None:
    """Nothing is wrong, and next to nothing undecided or left out."""
    seen: Counter[str] = Counter()
    for case in cases(seed, count, tuple(HEIGHTS)):
        check(case, seen)
    assert seen["undecided"] <= seen["next to the axis"] + count // 100, seen
    assert seen["incomplete"] <= count // 20, seen
    least = {_verdicts: ("verdicts", 2), _changes: ("sides", 1), _motion: ("moving", 0.5)}
    what, share = least.get(check, ("settled", 0.02))
    assert seen[what] >= share * count, seen
