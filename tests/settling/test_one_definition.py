"""A disk, a body and a system settle by one definition, and one launch as many do."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.settling import settling as definition
from stability.settling.body_lines import body_settling, disk_settling
from stability.settling.settling import Settling
from stability.settling.system_lines import system_settling

K, MU = 0.25, 0.3
WITHIN = 0.02
DISK = np.array([K, MU])


def states(count: int) -> Any:
    """States of a disk near spinning and tumbling."""
    rng = np.random.default_rng(4)
    six, turned = np.zeros((count, 6)), rng.random(count) < 0.5
    six[:, 0] = np.where(turned, math.pi / 2, rng.uniform(0.3, 1.4, count))
    sign = rng.choice([-1.0, 1.0], count)
    tumbling = sign / np.sqrt(K * np.sin(six[:, 0]))
    six[:, 2] = np.where(turned, sign * rng.uniform(1.5, 5, count), tumbling)
    off = rng.normal(size=six.shape)
    size = 10 ** rng.uniform(-6, -1.5, count)
    return six + off * (size / np.linalg.norm(off, axis=1))[:, None]


def same(one: Settling, p: Any, other: Settling, q: Any, six: Any) -> Any:
    """Which states each proves to settle, on the same member."""
    first, second = one.many(six, p, WITHIN), other.many(six, q, WITHIN)
    assert [one.names[i] for i in first.family] == [other.names[i] for i in second.family]
    assert first.distance == pytest.approx(second.distance, rel=1e-9, abs=1e-14)
    both = first.settled.proved & second.settled.proved
    apart = np.abs(first.settled.limit - second.settled.limit)[both, 0]
    assert (apart <= (first.settled.error + second.settled.error)[both]).all()
    return first.settled.proved, second.settled.proved


def only(settling: Settling, *names: str) -> Settling:
    return Settling(tuple(line for line in settling.lines if line.name in names))


def test_a_disk_and_the_body_of_its_height_settle_alike() -> None:
    disk = only(disk_settling(st.Viscous), "spinning", "tumbling")
    body = st.Body(ca.sin, axial=2 * K, transverse=K)
    mine = only(body_settling(body, st.Viscous, ("mu",)), "spinning", "tumbling")
    numbers = {"axial": 2 * K, "transverse": K, "mu": MU}
    p = np.array([numbers[n] for n in mine.lines[0].system.parameters])
    first, second = same(disk, DISK, mine, p, states(100))
    assert 50 < second.sum() <= first.sum() < 90
    assert not (second & ~first).any()  # the body's graph has wider balls near upright


def test_a_disk_and_its_equations_as_a_system_settle_alike() -> None:
    disk = only(disk_settling(st.Viscous), "spinning")
    own = st.disk_system("viscous")
    guards = own.observables["normal_force"], own.observables["determinant"], ca.sin(own.x[0])
    conditions = [st.Condition(v, "a guard is {value}") for v in guards]
    mine = st.System(
        "mine",
        own.x,
        own.p,
        own.rhs,
        states=own.states,
        parameters=own.parameters,
        conditions=conditions,
    )
    held = {"theta": st.UPRIGHT} | dict.fromkeys(("theta_dot", "omega3", "slip_x", "slip_y"), 0.0)
    system = system_settling((st.Family(mine, "spinning", at=("phi_dot",), held=held),))
    first, second = same(disk, DISK, system, DISK, states(100))
    assert 20 < first.sum() < 60
    assert first.tolist() == second.tolist()


def bare(rhs: Any, *names: str, parameters: tuple[str, ...] = ()) -> st.System:
    x, p = ca.SX.sym("x", len(names)), ca.SX.sym("p", len(parameters))
    return st.System(
        "bare", x, p, ca.SX(ca.vertcat(*rhs(x, p))), states=names, parameters=parameters
    )


def alike(settling: Settling, x: Any, p: Any) -> Any:
    """What many states together are told, which each alone must be told too."""
    found = settling.many(x, p, WITHIN)
    for i, (state, own) in enumerate(zip(x, p, strict=True)):
        near = settling.nearest(state, own, WITHIN)
        assert near.family == (settling.names[found.family[i]] if found.family[i] >= 0 else "")
        assert near.distance == pytest.approx(found.distance[i], rel=1e-12)
        assert near.settled == found.settled.proved[i]
    return found


def test_a_state_that_is_left_out_adds_nothing_to_a_distance() -> None:
    system = bare(lambda x, p: (x[1], -p[0] * x[1]), "place", "v", parameters=("c",))
    rest = st.Family(system, "rest", at=("c",), held={"v": 0.0})
    x = np.array([[7.0, 1e-3], [-40.0, 0.5], [0.0, 0.0]])
    found = alike(system_settling((rest,)), x, np.full((3, 1), 0.5))
    assert found.distance == pytest.approx([1e-3, 0.5, 0.0])
    assert not found.settled.proved.any()


def test_what_is_not_steady_is_no_member() -> None:
    # the rates vanish at x = 1 for a = 1 alone, and a root exists for a > 0 alone
    system = bare(lambda x, p: (p[0] - x[0] ** 2,), "x", parameters=("a",))
    held = st.Family(system, "held", at=("a",), held={"x": 1.0})
    root = st.Family(
        system, "root", at=("a",), unknown={"x": 1.0}, equations=("x",), positive=("x",)
    )
    p = np.array([[1.0], [4.0], [-1.0]])
    x = np.array([[1.001], [1.001], [1.001]])
    found = alike(system_settling((held, root)), x, p)
    assert [found.names[i] if i >= 0 else "" for i in found.family] == ["held", "root", ""]
    assert found.distance[:2] == pytest.approx([1e-3, 0.999])
    assert found.settled.proved.tolist() == [True, False, False]


def test_a_family_without_a_number_of_its_own_has_no_member_where_it_is_not_steady() -> None:
    system = bare(lambda x, _: (-x[0], x[0] ** 2 + 1 - x[1]), "x", "y")
    true = st.Family(system, "true", at=(), held={"x": 0.0, "y": 1.0})
    wrong = st.Family(system, "wrong", at=(), held={"x": 0.0, "y": 1.001})
    x = np.array([[0.0, 1.0011], [1e-3, 1.0]])
    found = alike(system_settling((wrong, true)), x, np.zeros((2, 0)))
    assert (found.family == 1).all()
    assert found.settled.proved.all()


@pytest.mark.parametrize("share", [1.0, 0.0])
def test_launches_basins_and_scenes_ask_one_definition(
    share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where no distance counts as close, none of them settles."""
    word = "settled" if share else "moving"
    close = definition.is_close
    monkeypatch.setattr(definition, "is_close", lambda far, within: close(far, share * within))
    start, law, last = {"theta": 1.52, "phi_dot": 2.5}, st.Viscous(MU), 200.0
    run = st.simulate(st.Disk(), law, start, last)
    axes: Any = {"x": ("phi_dot", 2.5, 2.6, 2), "y": ("theta", 1.5, 1.52, 2)}
    found = st.basins(st.Disk(), law, **axes, horizon=last)
    scene = st.Scene(st.Disk(), law, start, last, quantities=("outcome",))
    assert run.attrs["outcome"] == scene.answer().value == word
    assert (found.outcome == st.Outcome[word.upper()].code).all()
