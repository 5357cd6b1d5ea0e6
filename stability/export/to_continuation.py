"""Input of programs that continue isolated equilibria: AUTO-07p and BifurcationKit.jl.

Along a family that is named by a state, the Jacobian A has a zero with the family's tangent t.  A
program that continues isolated equilibria wants none.  With c the value that names the member and a
the state, f(x) - t (a - c) has the same equilibrium, and there the Jacobian A - t e_a^T, whose
eigenvalues are those of A but for one: the zero of the tangent is -1 (Brauer 1952).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.straight_lines import Language, Line, Record
from ..base.checks import instance
from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.types import Floats, Overwrite
from ..systems.family import A_FAMILY, Family, refuse_system
from ..systems.structure.structural_zeros import structure
from .to_c import c_name, generated, write_folder

STEPS = 50
"""Steps of the first run, about."""


@dataclass(frozen=True, eq=False)
class SteadyProblem:
    """Rates whose equilibria are the steady motions, one for each value of the parameters."""

    states: tuple[str, ...]
    """Names of the states."""
    parameters: tuple[str, ...]
    """Names of the parameters: what names a member, then the system's own."""
    function: ca.Function
    """(u, par) to the rates, their Jacobian by u, and by par, all dense."""
    start: Floats
    """State at the start."""
    values: Floats
    """Parameters at the start."""
    free: str
    """Parameter that is continued."""
    stop: float
    """Its last value."""

    @property
    def first(self) -> float:
        """The first value of the parameter that is continued."""
        return float(self.values[self.parameters.index(self.free)])

    @property
    def low(self) -> float:
        """Smaller end."""
        return min(self.first, self.stop)

    @property
    def high(self) -> float:
        """Larger end."""
        return max(self.first, self.stop)

    @property
    def steps(self) -> dict[str, float]:
        """First, shortest and longest step of the continuation; the first has its direction."""
        length = self.high - self.low
        first = math.copysign(length / (10 * STEPS), self.stop - self.first)
        return {"ds": first, "dsmin": length * 1e-9, "dsmax": length / STEPS}


def _steady_problem(
    family: Family, free: str, start: float, stop: float, parameters: Mapping[str, Any]
) -> SteadyProblem:
    """The problem of a family, with its start.

    Parameters
    ----------
    family
        The family.
    free
        Name of the parameter that is continued.
    start, stop
        Its first and last value.
    parameters
        Values of all others by name.

    Returns
    -------
    SteadyProblem

    Raises
    ------
    ParameterError, NameUnknownError
        If names or numbers do not fit, or the equilibria are not isolated.

    Source: A. Brauer, Duke Math. J. 19 (1952) 75-91; tests/export/test_continuation.py.
    """
    refuse_system(family)
    instance("family", family, Family, A_FAMILY)
    names = (*family.at, *family.parameters)
    if free not in names:
        raise NameUnknownError(f"free is {shown(free)}; known are {', '.join(names)}.")
    if float(start) == float(stop) or not np.isfinite([start, stop]).all():
        raise ParameterError(f"start is {start:g} and stop is {stop:g}; give two finite numbers.")
    _check(names, free, parameters)
    family.system.refuse_algebraic("a continuation program")
    _isolated(family)
    numbers = {n: float(parameters[n]) for n in names if n != free} | {free: float(start)}
    values = np.array([numbers[n] for n in names])
    whole = family.member(values[: len(family.at)], values[len(family.at) :])
    keep = [i for i, n in enumerate(family.system.states) if n not in family.left_out]
    return SteadyProblem(
        tuple(family.system.states[i] for i in keep),
        names,
        _function(family, keep),
        whole[keep],
        values,
        free,
        float(stop),
    )


def _check(names: tuple[str, ...], free: str, parameters: Mapping[str, Any]) -> None:
    for name in parameters:
        if name not in names or name == free:
            left = ", ".join(n for n in names if n != free)
            raise NameUnknownError(f"{name} is no parameter to give; these are {left}.")
    missing = [n for n in names if n != free and n not in parameters]
    if missing:
        raise ParameterError(f"{missing[0]} has no value; give {', '.join(missing)}.")
    for name, value in parameters.items():
        if not isinstance(value, (int, float, np.number)) or not np.isfinite(value):
            raise ParameterError(f"{name} is {shown(value)}; give one finite number.")


def _isolated(family: Family) -> None:
    """Refuse zeros of the Jacobian that are no tangents of the family."""
    if family.trimmed:
        raise ParameterError(
            f"{family.name} is solved for {', '.join(family.trimmed)}; continuation codes solve "
            "for states alone. Name the family by it, and solve for the states."
        )
    zeros = structure(family).zeros - len(family.left_out) - family.tangents
    if zeros > 0:
        raise ParameterError(
            f"{family.name} has {zeros} more eigenvalue{'s' * (zeros > 1)} 0 by structure than "
            "its own tangents; continuation needs isolated steady motions. Take "
            "st.boundaries, which leaves these zeros out."
        )


def _function(family: Family, keep: list[int]) -> ca.Function:
    system = family.system
    names = (*family.at, *family.parameters)
    u, par = ca.SX.sym("u", len(keep)), ca.SX.sym("par", len(names))
    table: dict[str, Any] = dict(zip(names, ca.vertsplit(par), strict=True))
    state: Any = ca.SX.zeros(len(system.states))  # ignorable states act on nothing
    state[keep] = u
    parameters = ca.vertcat(*[table.get(n, 0) for n in system.parameters])
    rates, seen = ca.substitute(
        [system.rhs, ca.vertcat(*[system.observables[n] for n in _seen(family)])],
        [system.x, system.p],
        [state, parameters],
    )
    rows = [
        *(rates[system.states.index(n)] for n in family.equations if n in system.states),
        *ca.vertsplit(seen),
    ]
    f = rates[keep]
    position = {system.states[i]: row for row, i in enumerate(keep)}
    for name in (n for n in family.at if n in system.states):
        tangent = _tangent(family, ca.vertcat(*rows), u, position, name)
        f = f - tangent * (u[position[name]] - table[name])
    parts = [ca.densify(e) for e in (f, ca.jacobian(f, u), ca.jacobian(f, par))]
    return ca.Function("steady", [u, par], ca.cse(parts), ["u", "par"], ["f", "dfdu", "dfdp"])


def _seen(family: Family) -> list[str]:
    return [n for n in family.equations if n not in family.system.states]


def _tangent(
    family: Family, rows: ca.SX, u: ca.SX, position: Mapping[str, int], name: str
) -> ca.SX:
    """Direction of the family in the state, with 1 for the state that names the member."""
    tangent = ca.SX.zeros(u.numel())
    tangent[position[name]] = 1
    unknown = [position[n] for n in family.unknown]
    if unknown:
        slopes = ca.jacobian(rows, u)
        solved = ca.solve(slopes[:, unknown], -slopes[:, position[name]])
        for row, value in zip(unknown, ca.vertsplit(solved), strict=True):
            tangent[row] = value
    return tangent


# --- AUTO-07p ---


RESERVED = range(10, 15)
"""Places in PAR that AUTO uses itself."""
MOST_PARAMETERS = 31
"""Places in PAR up to 36 that are left."""
EQUATIONS = """\
/* {title}
   Run:  auto-07p, then  run('{name}');  or  @r {name}
   States: {states}
   Parameters: {parameters} */
#include "auto_f2c.h"
{code}
int func(integer ndim, const doublereal *u, const integer *icp, const doublereal *par,
         integer ijac, doublereal *f, doublereal *dfdu, doublereal *dfdp) {{
  static const int place[{count}] = {{{places}}};
  double own[{count}], slopes[{entries}], w[{work} + 1];
  casadi_int iw[{iwork} + 1];
  const double *arg[{args} + 1] = {{u, own}};
  double *res[{results} + 1] = {{f, ijac > 0 ? dfdu : 0, ijac > 1 ? slopes : 0}};
  int i, j, failed;
  for (j = 0; j < {count}; j++) own[j] = par[place[j]];
  failed = {function}(arg, res, iw, w, 0);
  if (ijac > 1)
    for (j = 0; j < {count}; j++)
      for (i = 0; i < {ndim}; i++) dfdp[{ndim} * place[j] + i] = slopes[{ndim} * j + i];
  return failed;
}}
int stpnt(integer ndim, doublereal t, doublereal *u, doublereal *par) {{
{start}
  return 0;
}}
int pvls(integer ndim, const doublereal *u, doublereal *par) {{ return 0; }}
int bcnd(integer ndim, const doublereal *par, const integer *icp, integer nbc,
         const doublereal *u0, const doublereal *u1, integer ijac, doublereal *fb,
         doublereal *dbc) {{ return 0; }}
int icnd(integer ndim, const doublereal *par, const integer *icp, integer nint,
         const doublereal *u, const doublereal *uold, const doublereal *udot,
         const doublereal *upold, integer ijac, doublereal *fi, doublereal *dint) {{ return 0; }}
int fopt(integer ndim, const doublereal *u, const integer *icp, const doublereal *par,
         integer ijac, doublereal *fs, doublereal *dfdu, doublereal *dfdp) {{ return 0; }}
"""
CONSTANTS = """\
# {title}
e = '{name}'
unames = {{{unames}}}
parnames = {{{parnames}}}
NDIM = {ndim}, IPS = 1, IRS = 0, ILP = 1
ICP = ['{free}']
NTST = 1, NCOL = 4, IAD = 3, ISP = 2, ISW = 1, IPLT = 0, NBC = 0, NINT = 0
NMX = 2000, NPR = 100, MXBF = 0, IID = 2, ITMX = 20, ITNW = 7, NWTN = 3, JAC = 1
EPSL = 1e-09, EPSU = 1e-09, EPSS = 1e-07
DS = {ds!r}, DSMIN = {dsmin!r}, DSMAX = {dsmax!r}, IADS = 1
NPAR = 36, THL = {{}}, THU = {{}}
UZSTOP = {{'{free}': {stop!r}}}
"""


def auto_input(
    family: Family,
    out: str | Path,
    *,
    free: str,
    start: float,
    stop: float,
    name: str | None = None,
    overwrite: Overwrite = False,
    **parameters: Any,
) -> Path:
    """AUTO-07p's input for a family of steady motions: NAME.c and c.NAME.

    The equations are those of the graph with exact derivatives.  A family that is named by a state
    becomes a branch of isolated equilibria: the zero of its tangent moves to -1, and all other
    eigenvalues stay, so that AUTO's Hopf and branch points are those of the family.

    Parameters
    ----------
    family
        A family whose zeros by structure are its own tangents and those of ignorable states.
    out
        Folder to write.
    free
        What AUTO continues: what names a member, or a parameter.
    start, stop
        First and last value of it, in the family's units.
    name
        Name of the problem; that of the family when left out.
    overwrite
        Whether files of an earlier call are replaced; "same": if the same call wrote them all.
    **parameters
        Values of everything else that names a member, and of the other parameters.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    ParameterError, NameUnknownError
        If names or numbers do not fit, or the family's equilibria are not isolated.
    NoMemberError
        If there is no steady motion at the start.
    FileError
        If the folder has such files, or cannot be written.

    Source: E. Doedel et al., AUTO-07p, manual, ch. 3 and 10; tests/export/test_continuation.py.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = st.export.auto_input(st.disk_family("spinning", "viscous"), folder + "/disk",
    ...                           free="phi_dot", start=5.0, stop=1.8, k=0.25, mu=0.8)
    ...     print(*sorted(path.name for path in found.iterdir()))
    c.spinning spinning.c
    """
    problem = _steady_problem(family, free, start, stop, parameters)
    if len(problem.parameters) > MOST_PARAMETERS:
        raise ParameterError(
            f"{family.name} has {len(problem.parameters)} parameters; AUTO has room for "
            f"{MOST_PARAMETERS}."
        )
    stem = c_name(name or family.name)
    title = f"{family.name} of {family.system.name}".replace("*/", "")
    files = {
        f"{stem}.c": _equations(problem, stem, title),
        f"c.{stem}": _constants(problem, stem, title),
    }
    return write_folder(out, files, overwrite=overwrite)


def places(count: int) -> list[int]:
    """Place of each parameter in PAR, counted from 1, without those that AUTO uses itself.

    Examples
    --------
    >>> places(11)
    [1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 16]
    """
    free = [i for i in range(1, 37) if i not in RESERVED]
    return free[:count]


def _equations(problem: SteadyProblem, name: str, title: str) -> str:
    function = ca.Function(
        f"{name}_rates", problem.function.sx_in(), problem.function.call(problem.function.sx_in())
    )
    count, ndim = len(problem.parameters), len(problem.states)
    at = places(count)
    state = zip(range(ndim), problem.start, problem.states, strict=True)
    values = [(f"u[{i}]", v, n) for i, v, n in state]
    named = zip(at, problem.values, problem.parameters, strict=True)
    values += [(f"par[{i - 1}]", v, n) for i, v, n in named]
    start = [f"  {entry} = {float(v)!r}; /* {n} */" for entry, v, n in values]
    return EQUATIONS.format(
        title=title,
        name=name,
        code=generated(function)[0],
        function=function.name(),
        states=", ".join(problem.states),
        parameters=", ".join(problem.parameters),
        count=count,
        ndim=ndim,
        entries=count * ndim,
        places=", ".join(str(i - 1) for i in at),
        work=function.sz_w(),
        iwork=function.sz_iw(),
        args=function.sz_arg(),
        results=function.sz_res(),
        start="\n".join(start),
    )


def _constants(problem: SteadyProblem, name: str, title: str) -> str:
    at = places(len(problem.parameters))
    # a name is that of a state or of a parameter; a state that names the member is both
    labels = {n: f"{n}_at" if n in problem.states else n for n in problem.parameters}
    return CONSTANTS.format(
        title=title,
        name=name,
        ndim=len(problem.states),
        free=labels[problem.free],
        stop=problem.stop,
        **problem.steps,
        unames=", ".join(f"{i}: '{n}'" for i, n in enumerate(problem.states, start=1)),
        parnames=", ".join(f"{i}: '{n}'" for i, n in zip(at, labels.values(), strict=True)),
    )


# --- BifurcationKit.jl ---


JULIA = """\
# {title}
# Run: julia {name}.jl, with BifurcationKit installed.
# States: {states}
using BifurcationKit

function rates(u, p)
    par = ({unpacked},)
{rates}
    return [{outputs}]
end

function jacobian(u, p)
    par = ({unpacked},)
{slopes}
    return reshape([{entries}], {ndim}, {ndim})
end

u0 = [{start}]
par = ({values},)
problem = BifurcationProblem(rates, u0, par, (@optic _.{free}); J = jacobian,
    record_from_solution = (u, p; k...) -> ({recorded},))
options = ContinuationPar(p_min = {low!r}, p_max = {high!r}, ds = {ds!r}, dsmin = {dsmin!r},
    dsmax = {dsmax!r}, max_steps = 2000, nev = {ndim}, detect_bifurcation = 3, n_inversion = 8)
branch = continuation(problem, PALC(), options)
println(branch)
"""


def bifurcationkit_input(
    family: Family,
    out: str | Path,
    *,
    free: str,
    start: float,
    stop: float,
    name: str | None = None,
    overwrite: Overwrite = False,
    **parameters: Any,
) -> Path:
    """BifurcationKit.jl's input for a family of steady motions: NAME.jl.

    Equations and their Jacobian are straight lines of the graph's own operations.

    Parameters
    ----------
    family, out, free, start, stop, name, overwrite, **parameters
        As for `stability.auto_input`.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    ParameterError, NameUnknownError, NoMemberError, FileError
        As for `stability.auto_input`.

    Source: R. Veltz, BifurcationKit.jl; tests/export/test_continuation.py.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = st.export.bifurcationkit_input(
    ...         st.disk_family("spinning", "viscous"), folder + "/disk",
    ...         free="mu", start=0.2, stop=1.5, phi_dot=2.6, k=0.25)
    ...     [path.name for path in found.iterdir()]
    ['spinning.jl']
    """
    problem = _steady_problem(family, free, start, stop, parameters)
    stem = c_name(name or family.name)
    title = f"{family.name} of {family.system.name}".replace("\n", " ")
    return write_folder(out, {f"{stem}.jl": _file(problem, stem, title)}, overwrite=overwrite)


def _file(problem: SteadyProblem, name: str, title: str) -> str:
    f = problem.function
    inputs = f.sx_in()
    outputs = f.call(inputs)
    rates, results = _straight(ca.Function("rates", inputs, [outputs[0]]))
    slopes, entries = _straight(ca.Function("slopes", inputs, [outputs[1]]))
    named = zip(problem.parameters, problem.values, strict=True)
    words = [c_name(n) for n in problem.parameters]
    return JULIA.format(
        title=title,
        name=name,
        states=", ".join(problem.states),
        rates=rates,
        slopes=slopes,
        outputs=", ".join(results),
        entries=", ".join(entries),
        ndim=len(problem.states),
        unpacked=", ".join(f"p.{w}" for w in words),
        free=c_name(problem.free),
        start=", ".join(repr(float(v)) for v in problem.start),
        values=", ".join(f"{c_name(n)} = {float(v)!r}" for n, v in named),
        recorded=", ".join(f"{c_name(n)} = u[{i}]" for i, n in enumerate(problem.states, start=1)),
        low=problem.low,
        high=problem.high,
        **problem.steps,
    )


TWO = (("atan2", "atan"), ("hypot", "hypot"))
"""Functions of two numbers, with their names in Julia."""
LANGUAGE = Language(
    "Julia", "    {name} = {text}", repr, "{name}({value})", "{a} ^ {b}", renamed=(("fabs", "abs"),)
)
"""How Julia writes numbers, lines and functions."""


def _straight(function: ca.Function) -> tuple[str, list[str]]:
    """Lines of Julia for a function of (u, par), and the entries of its output."""
    record = Record(LANGUAGE)

    def two(name: str) -> Any:
        return lambda y, x: record.line(f"{name}({record.text(y)}, {record.text(x)})")

    plain = record.algebra()
    table = {n: two(name) for n, name in TWO}
    table["sign"] = lambda x: record.line(f"sign({record.text(x)})")
    number = Algebra(plain.name, plain.constant, plain.functions | table, lasting=False)
    inputs = [
        [Line(record, f"{word}[{i + 1}]") for i in range(function.numel_in(j))]
        for j, word in enumerate(("u", "par"))
    ]
    values = Program(function).run(number, inputs)[0]
    return "\n".join(record.lines), [record.text(v) for v in values]
