"""SymPy's KanesMethod and PyDy on the same disk, against this package: values and times.

1. The disk that rolls without slip by KanesMethod with velocity constraints, linearised about
   upright rolling: zeros, eigenvalues, threshold, and verdicts near it.  The peer's verdict is what
   people do: the sign of the largest real part that LAPACK returns.
2. The disk with viscous friction, whose normal force enters the force: tumbling.
3. PyDy's System on the equations of (1): a gentle launch to T = 20.

First calls count the imports: SymPy's and PyDy's in this process, the package's in a fresh one.
Repeats are medians, the two in turns.  Ratios are the peer's time over the package's: above 1 the
package is faster.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from tables import COLD, Seconds, first_call, medians, report, table, timed, times

import stability as st

K, OMEGAS, SPINS = 0.25, (0.3, 0.5, 0.7, 1.2, 1.8), 1000
THETAS, MUS = (0.3, 0.8, 1.2), (0.05, 0.3, 3.0)
START, LAST = (1.45, 0.05, 0.1, 1.3), 20.0
GRID = np.linspace(0.0, LAST, 201)


class Body:
    """Frames, points and speeds that both contact laws share.

    phi, theta, psi are yaw, tilt of the axis from the vertical, and spin; the contact radius is the
    first axis of the leaning frame.  u1, u2, u3 are components of the angular velocity there.
    """

    def __init__(self, me: Any, names: str) -> None:
        import sympy as sp

        self.k, self.mu = sp.symbols("k mu", positive=True)
        self.q, self.u = me.dynamicsymbols(names), me.dynamicsymbols(f"u1:{len(names.split()) + 1}")
        phi, theta, psi = self.q[:3]
        self.fixed = me.ReferenceFrame("N")
        self.yaw = self.fixed.orientnew("Y", "Axis", [phi, self.fixed.z])
        self.lean = self.yaw.orientnew("L", "Axis", [theta, self.yaw.y])
        self.disk = self.lean.orientnew("D", "Axis", [psi, self.lean.z])
        self.spin = sum((u * e for u, e in zip(self.u, self.lean, strict=False)), me.Vector(0))
        true = self.disk.ang_vel_in(self.fixed)
        self.kinematic = [(true - self.spin).dot(e) for e in self.lean]
        self.disk.set_ang_vel(self.fixed, self.spin)
        self.centre = me.Point("C")

    def contact(self, velocity: Any) -> Any:
        """The disk's material point that touches, once the centre's velocity is known."""
        self.centre.set_vel(self.fixed, velocity)
        point = self.centre.locatenew("P", self.lean.x)
        point.v2pt_theory(self.centre, self.fixed, self.disk)
        return point

    def rigid(self, me: Any) -> Any:
        inertia = me.inertia(self.lean, self.k, self.k, 2 * self.k)
        return me.RigidBody("B", self.centre, self.disk, 1, (inertia, self.centre))


def steady(method: Any, me: Any, values: dict[Any, Any], rates: dict[Any, Any]) -> dict[Any, Any]:
    """An operating point: named values and rates, every other one zero."""
    t = me.dynamicsymbols._t
    point = dict.fromkeys([*method.q, *method.u], 0) | values
    return point | {s.diff(t): rates.get(s, 0) for s in [*method.q, *method.u]}


def rolling_disk(me: Any) -> tuple[Any, Body]:
    """No slip: three velocity constraints, one configuration constraint for the height."""
    import sympy as sp

    body = Body(me, "phi theta psi X Y Z")
    t = me.dynamicsymbols._t
    x, y, z = body.u[3:]
    contact = body.contact(x * body.fixed.x + y * body.fixed.y + z * body.fixed.z)
    shifts = [q.diff(t) - u for q, u in zip(body.q[3:], body.u[3:], strict=True)]
    method = me.KanesMethod(
        body.fixed,
        body.q[:5],
        body.u[:3],
        kd_eqs=body.kinematic + shifts,
        q_dependent=body.q[5:],
        configuration_constraints=[body.q[5] - sp.sin(body.q[1])],
        u_dependent=body.u[3:],
        velocity_constraints=[contact.vel(body.fixed).dot(e) for e in body.fixed],
    )
    method.kanes_equations([body.rigid(me)], [(body.centre, -body.fixed.z)])
    return method, body


def viscous_disk(me: Any, *, auxiliary: bool) -> tuple[Any, Body, Any]:
    """F = gn (z^ - mu vA).  An auxiliary speed along z^ brings in the equation for gn."""
    import sympy as sp

    body = Body(me, "phi theta psi X Y")
    lift, gn = me.dynamicsymbols("lift gn")
    t = me.dynamicsymbols._t
    _, theta, _, x, y = body.q
    up, yaw = body.fixed.z, body.yaw
    # in the yawing frame, where tumbling stands still
    level = body.u[3] * yaw.x + body.u[4] * yaw.y
    velocity = level + sp.cos(theta) * body.u[1] * up
    contact = body.contact(velocity + lift * up if auxiliary else velocity)
    true = x.diff(t) * body.fixed.x + y.diff(t) * body.fixed.y
    kinematic = body.kinematic + [(true - level).dot(e) for e in (yaw.x, yaw.y)]
    slip = velocity + body.spin.cross(body.lean.x)
    drag = sum((slip.dot(e) * e for e in (yaw.x, yaw.y)), me.Vector(0))
    extra = [lift] if auxiliary else None
    method = me.KanesMethod(body.fixed, body.q, body.u, kd_eqs=kinematic, u_auxiliary=extra)
    loads = [(body.centre, -up), (contact, gn * up - body.mu * gn * drag)]
    method.kanes_equations([body.rigid(me)], loads)
    return method, body, gn


def zeros(matrix: Any) -> int:
    """Multiplicity of the eigenvalue zero, from the exact characteristic polynomial."""
    import sympy as sp

    coefficients = matrix.charpoly(sp.Symbol("lam")).all_coeffs()
    found = 0
    while sp.simplify(coefficients[-1 - found]) == 0:
        found += 1
    return found


def farthest(values: Any, wanted: Any) -> float:
    """Largest distance of the wanted eigenvalues to the largest ones of `values`, paired."""
    from scipy.optimize import linear_sum_assignment

    kept = values[np.argsort(-np.abs(values))][: len(wanted)]
    cost = np.abs(kept[:, None] - np.asarray(wanted)[None, :])
    return float(cost[linear_sum_assignment(cost)].max())


def rolling(me: Any, imported: Seconds) -> tuple[list[Any], Any]:
    import sympy as sp

    (method, body), derived = timed(lambda: rolling_disk(me))
    omega3 = sp.Symbol("omega3", real=True)
    phi, theta, psi, _, y, z = method.q
    at = {theta: sp.pi / 2, z: 1, method.u[2]: omega3, method.u[4]: -omega3}
    point = steady(method, me, at, {psi: omega3, y: -omega3})
    (matrix, *_), linear = timed(lambda: method.linearize(A_and_B=True, op_point=point))
    entries, compiled = timed(lambda: sp.lambdify((omega3, body.k), matrix))

    def eigenvalues(value: float, rows: Any = slice(None)) -> Any:
        return np.linalg.eigvals(np.array(entries(value, K), dtype=float)[rows][:, rows])

    build = [
        ("import sympy.physics.mechanics", imported),
        ("derive (KanesMethod)", derived),
        ("linearize about rolling", linear),
        ("lambdify", compiled),
    ]
    values = rolling_values(matrix, body, omega3, eigenvalues)
    rest = rolling_verdicts(eigenvalues), rolling_times(build, eigenvalues)
    return [values, *rest], (method, body, imported + derived)


def rolling_values(matrix: Any, body: Body, omega3: Any, eigenvalues: Any) -> Any:
    import sympy as sp

    rows: list[list[Any]] = []
    exact = zeros(matrix)
    for value in OMEGAS:
        ours = st.spectrum("rolling", at=value, contact=st.Rough())
        theirs = eigenvalues(value)
        largest = theirs[np.argmax(np.abs(theirs))]
        same = ours.eigenvalues[np.argmin(np.abs(ours.eigenvalues - largest))]
        rows.append(
            [
                f"eigenvalue at omega3 = {value}",
                f"{complex(largest):.8f}",
                f"{complex(same):.8f}",
                farthest(theirs, ours.eigenvalues),
            ]
        )
    last = matrix.charpoly(sp.Symbol("lam")).all_coeffs()[-1 - exact]
    roots = sp.roots(sp.numer(sp.together(last.subs(body.k, sp.Rational(1, 4)))), omega3)
    (square,) = (root**2 for root in roots if root > 0)
    edge = st.boundaries("rolling", axis=("at", 0.1, 2.0, 50), contact=st.Rough())[0]
    theirs, ours = float(square), edge.value**2
    rows.append(["threshold omega3^2", f"{theirs:.14f}", f"{ours:.14f}", abs(theirs - ours)])
    exactly = [int((eigenvalues(v) == 0).sum()) for v in OMEGAS]
    seen = st.spectrum("rolling", at=OMEGAS[0], contact=st.Rough()).structural_zeros
    rows.append(["states", matrix.rows, len(st.disk_system("rough").states), None])
    rows.append(["zeros by structure", exact, seen, exact - seen])
    rows.append(["zeros that LAPACK returns as 0", f"{min(exactly)} to {max(exactly)}", None, None])
    return table(
        "1. rolling without slip, k = 1/4",
        ("quantity", "SymPy", "package", "difference"),
        rows,
        "The difference of an eigenvalue is the largest over all that are not zero by structure.",
        "SymPy keeps phi, psi, X, Y, which add zeros; its threshold is solved from the polynomial.",
    )


def rolling_verdicts(eigenvalues: Any) -> Any:
    """SymPy's with all states, and with the four the package keeps: theta, u1, u2, u3."""
    kinds: tuple[Any, ...] = slice(None), [1, 5, 6, 7]
    rows: list[list[Any]] = []
    for distance in (-1e-2, -1e-6, -1e-10, 1e-10, 1e-6, 1e-2):
        at = float(np.sqrt((1 + distance) / 3))
        found = [f"omega3^2 = (1 {'-' if distance < 0 else '+'} {abs(distance):.0e})/3"]
        for rows_kept in kinds:
            largest = float(eigenvalues(at, rows_kept).real.max())
            found.append(f"{'unstable' if largest > 0 else 'neutral'} ({largest:.0e})")
        plain = st.spectrum("rolling", at=at, contact=st.Rough())
        proved = st.spectrum("rolling", at=at, contact=st.Rough(), certify=True)
        rows.append([*found, plain.verdict.word, proved.verdict.word])
    above = np.sqrt(np.linspace(1 / 3, 4, 202)[1:-1])
    counts = [int(sum(eigenvalues(v, r).real.max() > 0 for v in above)) for r in kinds]
    for certify in (False, True):
        codes = st.spectrum("rolling", at=above, contact=st.Rough(), certify=certify).codes
        counts.append(int((codes != st.Verdict.NEUTRAL.code).sum()))
    rows.append(["not 'neutral', of 200 above", *counts])
    return table(
        "verdicts near the threshold (largest real part)",
        ("omega3", "SymPy, 8 states", "SymPy, 4 states", "package", "certified"),
        rows,
    )


def rolling_times(build: Any, eigenvalues: Any) -> Any:
    many, rough = np.linspace(0.6, 2.0, SPINS), st.Rough()
    one = medians(
        lambda: eigenvalues(1.2), lambda: st.spectrum("rolling", at=1.2, contact=rough), 25
    )
    every = medians(
        lambda: [eigenvalues(v) for v in many],
        lambda: st.spectrum("rolling", at=many, contact=rough),
    )
    first = first_call('st.spectrum("rolling", at=1.2, contact=st.Rough())')
    rest = [("one point", *one), (f"{SPINS} points", *every)]
    found = times(build, first, rest, "SymPy")
    found["notes"].append("SymPy's: lambdify and eigvals; the package's have bounds and verdicts.")
    return found


def tumbling(me: Any) -> list[Any]:
    import sympy as sp

    direct = "works"
    (full, body, gn), derived = timed(lambda: viscous_disk(me, auxiliary=True))
    tilt, rate = sp.symbols("tilt rate", positive=True)

    def at(method: Any) -> dict[Any, Any]:
        phi, theta, psi = method.q[:3]
        values = {theta: tilt, method.u[0]: -rate * sp.sin(tilt)}
        return steady(method, me, values, {phi: rate, psi: -rate * sp.cos(tilt)})

    normal = sp.solve(me.msubs(full.auxiliary_eqs[0], at(full)), gn)[0]
    try:
        full.linearize(A_and_B=True, op_point=at(full) | {gn: normal})
    except Exception as error:  # any error is the finding
        direct = said(error)
    (method, body, gn), again = timed(lambda: viscous_disk(me, auxiliary=False))
    (matrix, inputs, extra), linear = timed(
        lambda: method.linearize(A_and_B=True, op_point=at(method) | {gn: normal})
    )
    if list(extra) != [gn] or any(sp.simplify(e) != 0 for e in inputs):
        raise RuntimeError("gn enters the linearisation: it must be eliminated first")
    entries, compiled = timed(lambda: sp.lambdify((tilt, rate, body.k, body.mu), matrix))

    def eigenvalues(theta: float, mu: float) -> Any:
        spin = 1 / np.sqrt(K * np.sin(theta))
        return np.linalg.eigvals(np.array(entries(theta, spin, K, mu), dtype=float))

    exact = zeros(matrix.subs(rate, 1 / sp.sqrt(body.k * sp.sin(tilt))))
    build = [
        ("derive, with and without the auxiliary speed", Seconds(derived + again)),
        ("linearize about tumbling", linear),
        ("lambdify", compiled),
    ]
    notes = (
        f"KanesMethod.linearize with u_auxiliary: {direct}",
        "So a second KanesMethod without it has gn as an input; the auxiliary equation gives",
        f"gn = {normal} at tumbling, where the input's column is zero, since the slip vanishes.",
    )
    return [tumbling_values(eigenvalues, exact, notes), tumbling_times(build, eigenvalues)]


def tumbling_values(eigenvalues: Any, exact: int, notes: Sequence[str]) -> Any:
    rows: list[list[Any]] = []
    for theta in THETAS:
        for mu in MUS:
            ours = st.spectrum("tumbling", at=theta, contact=st.Viscous(mu))
            theirs = eigenvalues(theta, mu)
            name = f"largest real part, theta = {theta}, mu = {mu}"
            kept = theirs[np.argsort(-np.abs(theirs))][: len(ours.eigenvalues)]
            rows.append(
                [
                    name,
                    f"{kept.real.max():.10f}",
                    f"{ours.abscissa:.10f}",
                    farthest(theirs, ours.eigenvalues),
                ]
            )
    rows.append(["zeros by structure", exact, ours.structural_zeros, exact - ours.structural_zeros])
    return table(
        "2. tumbling, viscous friction, k = 1/4",
        ("quantity", "SymPy", "package", "difference"),
        rows,
        "The difference is the largest over all eigenvalues not zero by structure.",
        *notes,
    )


def tumbling_times(build: Any, eigenvalues: Any) -> Any:
    ask = 'st.spectrum("tumbling", at=0.8, contact=st.Viscous(0.3))'
    before = 'import stability as st\nst.spectrum("rolling", at=1.2, contact=st.Rough())'
    one = medians(
        lambda: eigenvalues(0.8, 0.3),
        lambda: st.spectrum("tumbling", at=0.8, contact=st.Viscous(0.3)),
        25,
    )
    found = times(build, first_call(ask, before), [("one point", *one)], "SymPy")
    found["notes"].append("Imports are not counted again, on either side.")
    return found


def ours_to_the_end(tolerance: float) -> Any:
    run = st.simulate(st.Disk(), st.Rough(), [*START, 0, 0], GRID, tolerance=tolerance)
    if run.attrs["outcome"] not in ("moving", "settled"):
        raise RuntimeError(f"the package's run ended early: {run.attrs['outcome_sentence']}")
    return np.array([float(run[n][-1]) for n in ("theta", "theta_dot", "phi_dot", "omega3")])


def system(method: Any, body: Body) -> Any:
    """PyDy's System at the start; the centre's velocity follows from no slip."""
    from pydy.system import System

    tilt, tilt_rate, yaw_rate, spin = START
    _, theta, _, _, _, height = method.q
    u1, u2, u3, u4, u5, u6 = method.u
    start = {
        theta: tilt,
        height: np.sin(tilt),
        u1: -yaw_rate * np.sin(tilt),
        u2: tilt_rate,
        u3: spin,
        u4: tilt_rate * np.sin(tilt),
        u5: -spin,
        u6: tilt_rate * np.cos(tilt),
    }
    return System(method, constants={body.k: K}, initial_conditions=start, times=GRID)


def pydy(shared: tuple[Any, Body, float]) -> list[Any]:
    if importlib.util.find_spec("pydy") is None:
        return [table("PyDy: missing (pip install pydy)", (), ())]
    try:
        _, imported = timed(lambda: importlib.import_module("pydy.system"))
    except Exception as error:  # it does not know this SymPy or Python
        return [table(f"PyDy: missing: {said(error)}", (), ())]
    method, body, before = shared
    tolerances = (1e-9, 1e-12)
    exact, *here = (ours_to_the_end(t) for t in (1e-15, *tolerances))
    ask = f"st.simulate(st.Disk(), st.Rough(), {[*START, 0, 0]}, np.linspace(0, {LAST}, 201))"
    first = first_call(ask, cold=COLD)
    errors: list[list[Any]] = []
    found = []
    for generator in ("lambdify", "cython"):
        try:
            coded, begun, runs = pydy_runs(generator, method, body, tolerances)
        except Exception as error:  # a generator that does not work here has no number
            errors.append([generator, f"missing: {said(error)[:60]}", None, None])
            continue
        rest = []
        for run, tolerance, mine in zip(runs, tolerances, here, strict=True):
            there = run()
            gaps = [
                float(np.abs(a - b).max())
                for a, b in ((there, exact), (mine, exact), (there, mine))
            ]
            errors.append([f"{generator}, tolerance {tolerance:.0e}", *gaps])
            spent = medians(run, lambda tolerance=tolerance: ours_to_the_end(tolerance))
            rest.append((f"repeated run, tolerance {tolerance:.0e}", *spent))
        build = [
            ("import SymPy, derive (as in 1)", Seconds(before)),
            ("import PyDy", imported),
            (f"System and {generator} code", coded),
            ("first run", begun),
        ]
        found.append(times(build, first, rest, f"PyDy {generator}"))
    columns = ("error of the final state", "PyDy", "package", "difference")
    title = f"3. rough disk to T = {LAST:g} from theta, rates, omega3 = {START}"
    return [table(title, columns, errors, "Errors are against the package at 1e-15."), *found]


def said(error: Exception) -> str:
    return f"{type(error).__name__}: {(str(error).splitlines() or ['no message'])[0]}"


def pydy_runs(generator: str, method: Any, body: Body, tolerances: Any) -> Any:
    """The time of code generation and of a first run, and the runs, all of which went through."""
    from scipy.integrate import ODEintWarning

    begin = system(method, body)
    _, coded = timed(lambda: begin.generate_ode_function(generator=generator))

    def run(tolerance: float) -> Any:
        with warnings.catch_warnings():  # odeint only warns when it gives up
            warnings.simplefilter("error", ODEintWarning)
            last = begin.integrate(rtol=tolerance, atol=tolerance)[-1]
        end = dict(zip(begin.states, last, strict=True))
        tilt, u = end[begin.coordinates[1]], [end[s] for s in begin.speeds[:3]]
        return np.array([tilt, u[1], -u[0] / np.sin(tilt), u[2]])

    times_ = [timed(lambda t=t: run(t))[1] for t in tolerances]
    return coded, times_[0], [lambda t=t: run(t) for t in tolerances]


def parts() -> list[tuple[str, Callable[[], Any]]]:
    if importlib.util.find_spec("sympy") is None:
        return []
    me, imported = timed(lambda: importlib.import_module("sympy.physics.mechanics"))
    shared: list[Any] = []

    def first() -> list[Any]:
        found, kept = rolling(me, imported)
        shared.append(kept)
        return found

    def last() -> list[Any]:
        if not shared:
            raise RuntimeError("there are no equations, since part 1 failed")
        return pydy(*shared)

    return [("rolling", first), ("tumbling", lambda: tumbling(me)), ("PyDy", last)]


if __name__ == "__main__":
    sys.exit(report(("sympy", "pydy", "scipy", "numpy"), parts()))
