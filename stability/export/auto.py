"""Input of AUTO-07p: an equations file in C, and the constants of a first run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca

from ..base.errors import ParameterError
from ..systems.family import Family
from .c_code import c_name, generated
from .folder import write_folder
from .steady_problem import SteadyProblem, steady_problem

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
    overwrite: bool = False,
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
        Whether files of an earlier call are replaced.
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
    ...     found = st.auto_input(st.disk_family("spinning", "viscous"), folder + "/disk",
    ...                           free="phi_dot", start=5.0, stop=1.8, k=0.25, mu=0.8)
    ...     print(*sorted(path.name for path in found.iterdir()))
    c.spinning spinning.c
    """
    problem = steady_problem(family, free, start, stop, parameters)
    if len(problem.parameters) > MOST_PARAMETERS:
        raise ParameterError(
            f"{family.name} has {len(problem.parameters)} parameters; AUTO has room for "
            f"{MOST_PARAMETERS}."
        )
    own = c_name(name or family.name)
    title = f"{family.name} of {family.system.name}".replace("*/", "")
    files = {
        f"{own}.c": _equations(problem, own, title),
        f"c.{own}": _constants(problem, own, title),
    }
    return write_folder(out, files, overwrite=overwrite)


def places(count: int) -> list[int]:
    """Place of each parameter in PAR, counted from 1, without those that AUTO uses itself.

    Parameters
    ----------
    count
        Number of parameters.

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
