"""The thin disk in MuJoCo and in this package, side by side: threshold, a slow roll, times.

MuJoCo is a simulator of many bodies with soft contacts; here it gets the inertia of a uniform thin
disk on a flat ellipsoid, which touches the plane in one point, and friction too high to slide.
Two questions: from which omega3^2 on does upright rolling stop falling over, fitted to the lean of
simulated runs; and where does a slow, leaning roll go.  Units m = R = g = 1; times are wall times.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

import stability as st

try:
    import mujoco
except ImportError:
    mujoco = None

# Mass and inertia are given outright: the geometry only says where the body touches.  Friction
# slides (condim 3), with neither rolling nor drilling torque, which the model of the disk lacks.
XML = """<mujoco>
<option timestep="{dt}" integrator="{integrator}" cone="{cone}" impratio="{impratio}"
  noslip_iterations="{noslip}" gravity="0 0 -1" tolerance="1e-14" noslip_tolerance="1e-14"/>
<default><geom condim="3" friction="{friction} 0 0" solref="{soft} 1"/></default>
<worldbody><geom type="plane" size="0 0 1"/>
  <body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.25 0.25 0.5"/>
    <geom type="{shape}" size="{size}"/></body></worldbody></mujoco>"""
EVERY = 0.04  # time between samples: a multiple of every time step
TILT = 1e-5  # lean of the upright launches, quadratic terms of which the fit should not see
SPEEDS = (0.10, 0.25, 0.30, 0.36, 0.50)  # omega3^2 of the upright launches
LAUNCHES = [(math.pi / 2 - TILT, 0.0, 0.0, math.sqrt(w)) for w in SPEEDS]
UPRIGHT, SLOW = 8.0, 5.0  # lengths of the runs
START = (math.radians(80), 0.0, 0.0, 0.4)  # theta, theta_dot, phi_dot, omega3 of the slow roll
TURNS = 5  # repeats of what is timed
STATES = ("theta", "phi_dot", "omega3")
COLUMNS = {  # head, width and format of each column behind the first
    "MuJoCo": (10, ".6f"),
    "stability": (10, ".6f"),
    "difference": (11, ".1e"),
    "MuJoCo ms": (10, ".1f"),
    "stab. ms": (9, ".2f"),
    "ratio": (8, ".1f"),
}


@dataclass(frozen=True)
class Setting:
    """What MuJoCo is told."""

    integrator: str = "implicitfast"
    dt: float = 1e-3
    half: float = 1e-3  # half the thickness
    shape: str = "ellipsoid"
    cone: str = "elliptic"
    impratio: float = 100.0
    noslip: int = 0
    friction: float = 10.0
    soft: float | None = None  # time constant of contact; else two steps, MuJoCo's stiffest

    def model(self) -> Any:
        size = f"1 {self.half}" if self.shape == "cylinder" else f"1 1 {self.half}"
        values = asdict(self) | {"size": size, "soft": self.soft or 2 * self.dt}
        return mujoco.MjModel.from_xml_string(XML.format(**values))


class FailedRun(Exception):
    """A run of MuJoCo that gives no number, and why."""


@dataclass
class Row:
    """One line of the table; what is not asked or has failed is None."""

    quantity: str
    mujoco: float | None = None
    package: float | None = None
    difference: float | None = None
    mujoco_ms: float | None = None
    package_ms: float | None = None
    ratio: float | None = None
    failed: str = ""


def frame(theta: Any, phi: Any) -> tuple[Any, Any, Any]:
    """1 towards the contact point, 2 along the rim and level, 3 the symmetry axis."""
    out = np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=-1)
    along = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=-1)
    cosine, sine, up = np.cos(theta)[..., None], np.sin(theta)[..., None], np.array([0.0, 0, 1])
    return cosine * out - sine * up, along, sine * out + cosine * up


def arm(theta: Any, phi: Any, half: float) -> Any:
    """From the centre to the lowest point of the ellipsoid; its third semi-axis may be 0."""
    towards, _, axis = frame(theta, phi)
    sine, cosine = np.sin(theta)[..., None], np.cos(theta)[..., None]
    return (sine * towards - half**2 * cosine * axis) / np.hypot(sine, half * cosine)


def to_mujoco(state: Any, half: float, phi: float = 0.0, psi: float = 0.0) -> tuple[Any, Any]:
    """The qpos and qvel of a disk that does not slip: velocity of the world, spin of the body."""
    theta, theta_dot, phi_dot, omega3 = (np.float64(x) for x in state)
    one, two, three = frame(theta, np.float64(phi))
    omega = -phi_dot * np.sin(theta) * one + theta_dot * two + omega3 * three
    x = np.cos(psi) * one + np.sin(psi) * two
    turn = np.stack([x, np.cross(three, x), three], axis=1)
    touch = arm(theta, np.float64(phi), half)
    quaternion = np.roll(Rotation.from_matrix(turn).as_quat(), 1)  # MuJoCo puts the scalar first
    qpos = np.concatenate([[0, 0, -touch[2]], quaternion])
    return qpos, np.concatenate([-np.cross(omega, touch), turn.T @ omega])


def from_mujoco(qpos: Any, qvel: Any, half: float) -> dict[str, Any]:
    """State, pose, contact point and slip from rows of qpos and qvel."""
    turn = Rotation.from_quat(np.roll(qpos[:, 3:], -1, axis=1)).as_matrix()
    axis, mark = turn[:, :, 2], turn[:, :, 0]
    flat = np.hypot(axis[:, 0], axis[:, 1])
    theta, phi = np.arctan2(flat, axis[:, 2]), np.arctan2(axis[:, 1], axis[:, 0])
    one, two, three = frame(theta, phi)
    omega, touch = np.einsum("nij,nj->ni", turn, qvel[:, 3:]), arm(theta, phi, half)
    along = {n: (omega * v).sum(1) for n, v in (("one", one), ("two", two), ("three", three))}
    return {
        "theta": theta,
        "lean": np.arctan2(axis[:, 2], flat),
        "phi": phi,
        "psi": np.arctan2((mark * two).sum(1), (mark * one).sum(1)),
        "theta_dot": along["two"],
        "phi_dot": -along["one"] / np.sin(theta),
        "omega3": along["three"],
        "contact": (qpos[:, :3] + touch)[:, :2],
        "slip": np.linalg.norm(qvel[:, :2] + np.cross(omega, touch)[:, :2], axis=1),
    }


def check_conversions() -> tuple[float, float]:
    """Largest errors there and back, and of the rates against MuJoCo's own step of a pose."""
    rng, model, h = np.random.default_rng(1), Setting().model(), 1e-5
    names, back, rates = ("theta", "theta_dot", "phi_dot", "omega3", "phi", "psi"), 0.0, 0.0
    for _ in range(200):
        state = rng.uniform([0.2, -2, -2, -2], [2.9, 2, 2, 2])
        phi, psi = rng.uniform(-3, 3, 2)
        qpos, qvel = to_mujoco(state, 1e-3, phi, psi)
        seen = from_mujoco(qpos[None], qvel[None], 1e-3)
        off = np.array([seen[n][0] for n in names]) - [*state, phi, psi]
        back = max(back, np.abs(off).max(), seen["slip"][0])
        moved = np.stack([qpos, qpos])
        mujoco.mj_integratePos(model, moved[0], qvel, h)
        mujoco.mj_integratePos(model, moved[1], qvel, -h)
        pose = from_mujoco(moved, np.stack([qvel, qvel]), 1e-3)
        turned = np.array([pose[n][0] - pose[n][1] for n in ("theta", "phi", "psi")])
        turned = (turned + np.pi) % (2 * np.pi) - np.pi  # angles wrap
        exact = [state[1], state[2], state[3] - state[2] * np.cos(state[0])]
        rates = max(rates, np.abs(turned / (2 * h) - exact).max())
    if back > 1e-12 or rates > 1e-6:
        raise SystemExit(f"conversions are wrong: {back:.1e} there and back, {rates:.1e} in rates")
    return back, rates


def roll(model: Any, setting: Setting, state: Any, last: float) -> dict[str, Any]:
    """A run of MuJoCo, sampled; FailedRun where it is not one of a disk that rolls."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = to_mujoco(state, setting.half)
    count, steps = round(last / EVERY), round(EVERY / setting.dt)
    qpos, qvel = np.empty((count + 1, 7)), np.empty((count + 1, 6))
    gaps = np.zeros(count + 1)
    qpos[0], qvel[0] = data.qpos, data.qvel
    for i in range(1, count + 1):
        mujoco.mj_step(model, data, steps)
        qpos[i], qvel[i] = data.qpos, data.qvel
        gaps[i] = data.contact.dist.min() if data.ncon else np.inf
    # MuJoCo resets a state that diverged and goes on: its clock and its warnings tell
    diverged = any(data.warning[i].number for i in range(len(data.warning)))
    diverged |= abs(data.time - last) > 1e-6 or not np.isfinite([qpos.sum(), qvel.sum()]).all()
    if diverged or not np.isfinite(gaps).all():
        raise FailedRun("diverged" if diverged else "the disk left the plane")
    return from_mujoco(qpos, qvel, setting.half) | {"depth": float(-gaps.min())}


def squared_rate(times: Any, lean: Any) -> float:
    """Fit of lean'' = s lean + c, where s is rate^2, or -frequency^2, and c a constant of launch.

    For each s the rest is linear, and all is smooth through s = 0.
    """

    def misfit(s: float) -> float:
        turn = 1j * np.sqrt(complex(s)) * times / np.pi  # sinc of it is sinh(x) / x
        odd, even = times * np.sinc(turn).real, times**2 * np.sinc(turn / 2).real ** 2
        basis = np.stack([np.ones_like(times), odd, even], axis=1)
        basis /= np.linalg.norm(basis, axis=0)
        found = np.linalg.lstsq(basis, lean, rcond=None)[0]
        return math.log(float(((basis @ found - lean) ** 2).sum()) + 1e-300)

    trial = np.linspace(-1.5, 1.5, 121)
    around = trial[int(np.argmin([misfit(s) for s in trial]))] + np.array([-0.025, 0.025])
    best = minimize_scalar(misfit, bounds=around, method="bounded", options={"xatol": 1e-9})
    off = math.sqrt(math.exp(best.fun) / len(lean)) / np.ptp(lean)
    if off > 0.01:
        raise FailedRun(f"the fit leaves {100 * off:.1f} % of the lean, more than 1 %")
    return float(best.x)


def crossing(found: list[float]) -> float:
    """omega3^2 at which rate^2 passes through zero, by a line between its neighbours."""
    if not (found[0] > 0 > found[-1] and (np.diff(found) < 0).all()):
        raise FailedRun("rate^2 does not fall through zero")
    return float(np.interp(0.0, -np.array(found), SPEEDS))


def grid(last: float) -> Any:
    return np.linspace(0, last, round(last / EVERY) + 1)


def package_rates() -> tuple[list[float], list[float]]:
    """Eigenvalues squared, and the fit to this package's own motions, which tests the fit."""
    rough, times = st.Rough(), grid(UPRIGHT)
    found = st.spectrum("rolling", at=np.sqrt(SPEEDS), contact=rough).eigenvalues
    runs = [st.simulate(st.Disk(), rough, s, times, tolerance=1e-16) for s in LAUNCHES]
    fitted = [squared_rate(times, math.pi / 2 - run["theta"].values) for run in runs]
    return [float(x) for x in (found[:, 0] ** 2).real], fitted


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """What a call returns, and how long it takes [ms]."""
    begin = time.perf_counter()
    value = call()
    return value, 1e3 * (time.perf_counter() - begin)


def medians(*calls: Callable[[], Any]) -> list[float]:
    """Median times, the calls taking turns so that a busy machine hits all alike [ms]."""
    turns = [[timed(call)[1] for call in calls] for _ in range(TURNS)]
    return [statistics.median(column) for column in zip(*turns, strict=True)]


def fitted_rates(setting: Setting) -> tuple[list[float], float]:
    """The rates squared, and the time of the runs without their fits [ms]."""
    model = setting.model()
    runs = [timed(lambda s=s: roll(model, setting, s, UPRIGHT)) for s in LAUNCHES]
    return [squared_rate(grid(UPRIGHT), run["lean"]) for run, _ in runs], sum(ms for _, ms in runs)


def steps(*sizes: float) -> dict[str, Setting]:
    kinds = ("implicitfast", "RK4")
    return {f"{kind}, dt={dt:g}": Setting(kind, dt) for kind in kinds for dt in sizes}


DEFAULTS = Setting("Euler", 2e-3, cone="pyramidal", impratio=1, friction=1, soft=0.02)
THRESHOLDS = {
    **steps(4e-3, 2e-3, 1e-3),
    **{f"RK4, dt=0.002, half={h:g}": Setting("RK4", 2e-3, h) for h in (0.1, 0.03, 0.01)},
    "implicitfast, dt=0.001, no-slip": Setting(noslip=10),
    "defaults": DEFAULTS,
    "defaults, friction 10": replace(DEFAULTS, friction=10.0),
}


def thresholds() -> tuple[list[Row], list[str]]:
    def boundary() -> float:
        found = st.boundaries("rolling", axis=("at", 0.3, 0.8, 6), contact=st.Rough())
        return float(found[0].value) ** 2

    value, first = timed(boundary)
    exact, fitted = package_rates()
    rows, rates, fine = [], {}, "RK4, dt=0.002"
    for name, setting in THRESHOLDS.items():
        row = Row(f"threshold: {name}", None, value, None, None, *medians(boundary))
        try:
            rates[name], row.mujoco_ms = fitted_rates(setting)
            row.mujoco, row.ratio = crossing(rates[name]), row.mujoco_ms / row.package_ms
            row.difference = row.mujoco - value
        except FailedRun as reason:
            row.failed = str(reason)
        rows.append(row)
    some = zip(SPEEDS, rates.get(fine, ()), exact, strict=False)
    rows += [Row(f"rate^2 at omega3^2={w:.2f}: {fine}", a, b, a - b) for w, a, b in some]
    off = max(abs(a - b) for a, b in zip(exact, fitted, strict=True))
    notes = [
        f"st.boundaries is {abs(value - 1 / 3):.0e} off 1/3; its first call takes {first:.0f} ms.",
        f"The same fit to st.simulate: rate^2 off by {off:.1e} at most, threshold by "
        f"{abs(crossing(fitted) - value):.1e}.",
        "half: half the thickness, else 0.001.  MuJoCo's time: five runs to T = 8, without fits.",
    ]
    return rows + controls(), notes


CONTROLS = {f"cylinder, half={h:g}": Setting(shape="cylinder", half=h) for h in (0.1, 0.001)}
CONTROLS |= {n: s for n, s in THRESHOLDS.items() if n.startswith("defaults")}


def controls() -> list[Row]:
    """A cylinder stands on its flat rim, where a disk would fall: how far each leans by T = 8."""
    start, rows = LAUNCHES[0], []
    run = st.simulate(st.Disk(), st.Rough(), start, [UPRIGHT])
    fall = math.pi / 2 - float(run["theta"][-1])
    for name, setting in CONTROLS.items():
        row = Row(f"lean at T=8: {name}", package=fall)
        try:
            row.mujoco = float(roll(setting.model(), setting, start, UPRIGHT)["lean"][-1])
            row.difference = row.mujoco - fall
        except FailedRun as reason:
            row.failed = str(reason)
        rows.append(row)
    return rows


def compare(name: str, found: dict[str, Any], run: Any) -> list[Row]:
    """Values at the end, and largest differences over the run."""
    rows = []
    for c in STATES:
        a, b = found[c], run[c].values
        rows.append(Row(f"{name}: {c}", float(a[-1]), float(b[-1]), float(np.abs(a - b).max())))
    mine = np.stack([run["contact_x"].values, run["contact_y"].values], axis=1)
    mine, theirs = mine - mine[0], found["contact"] - found["contact"][0]
    far = [np.linalg.norm(p, axis=1) for p in (theirs, mine, theirs - mine)]
    slip = float(found["slip"].max())
    rows.append(Row(f"{name}: contact", float(far[0][-1]), float(far[1][-1]), float(far[2].max())))
    return [*rows, Row(f"{name}: slip", slip, 0.0, slip)]


ROLLS = steps(4e-3, 1e-3, 2.5e-4)
# a fine step with the contact of the coarse one tells what of the difference is the contact
ROLLS["RK4, dt=0.00025, soft=0.008"] = Setting("RK4", 2.5e-4, soft=8e-3)


def slow_roll() -> tuple[list[Row], list[str]]:
    def ours(tolerance: float = 1e-9) -> Any:
        disk, contact = st.Disk(), st.Rough()
        return st.simulate(disk, contact, START, times, pose=True, tolerance=tolerance)

    times = grid(SLOW)
    run, first = timed(ours)
    finer = ours(1e-16)
    own = max(float(np.abs(run[c] - finer[c]).max()) for c in (*STATES, "contact_x", "contact_y"))
    rows, compiled, depth = [], [], 0.0
    for name, setting in ROLLS.items():
        model, ms = timed(setting.model)
        compiled.append(ms)
        try:
            found = roll(model, setting, START, SLOW)
        except FailedRun as reason:
            rows.append(Row(name, failed=str(reason)))
            continue
        both = medians(lambda m=model, s=setting: roll(m, s, START, SLOW), ours)
        block = compare(name, found, run)
        depth = max(depth, found["depth"])
        block[0].mujoco_ms, block[0].package_ms, block[0].ratio = *both, both[0] / both[1]
        rows += block
    low = math.degrees(float(run["theta"].min()))
    notes = [
        f"Values at T = {SLOW:g} (contact: way), largest differences; medians of {TURNS}.",
        f"soft: time constant of contact, else 2 dt.  Lowest at {low:.0f} degrees.  Sinks in "
        f"{depth:.0e}.",
        f"st.simulate at 1e-9 is {own:.1e} off its run at 1e-16; first call {first:.0f} ms; "
        f"MuJoCo's compile {statistics.median(compiled):.1f} ms.",
    ]
    return rows, notes


def show(title: str, rows: list[Row], notes: list[str]) -> None:
    print(f"\n{title}\n{'':42}" + "".join(f"{h:>{w}}" for h, (w, _) in COLUMNS.items()))
    for row in rows:
        cells = zip(list(asdict(row).values())[1:-1], COLUMNS.values(), strict=True)
        text = "".join(("-" if v is None else f"{v:{f}}").rjust(w) for v, (w, f) in cells)
        print(f"{row.quantity:<42}" + (f"  failed: {row.failed}" if row.failed else text))
    print("".join(f"  {note}\n" for note in notes), end="")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object in place of a table")
    options = parser.parse_args()
    if mujoco is None:
        print("MuJoCo: missing (pip install mujoco)")
        return
    mujoco.set_mju_user_warning(lambda _: None)  # else it writes a log file; the data tell as well
    back, rates = check_conversions()
    slow = slow_roll()  # first, so that its first call is the first of the process
    head = (
        f"MuJoCo {mujoco.__version__}, stability {st.__version__}; k = 1/4, no slip.  Conversions: "
        f"{back:.0e} there and back,\n{rates:.0e} in rates against MuJoCo's own step of a pose."
    )
    parts = {
        "Upright rolling: unstable below omega3^2 = 1/3": thresholds(),
        "Slow roll from theta = 80 degrees, omega3 = 0.4": slow,
    }
    if options.json:
        tables = {t: {"rows": [asdict(r) for r in p[0]], "notes": p[1]} for t, p in parts.items()}
        print(json.dumps({"head": head, **tables}, indent=1))
        return
    print(head)
    for title, (rows, notes) in parts.items():
        show(title, rows, notes)


if __name__ == "__main__":
    main()
