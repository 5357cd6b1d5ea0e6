"""Input of BifurcationKit.jl: one Julia file with equations, Jacobian and a first continuation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca

from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.straight_lines import Language, Line, Record
from ..systems.family import Family
from .c_code import c_name
from .folder import write_folder
from .steady_problem import SteadyProblem, steady_problem

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
    overwrite: bool = False,
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
    ...     found = st.bifurcationkit_input(st.disk_family("spinning", "viscous"), folder + "/disk",
    ...                                     free="mu", start=0.2, stop=1.5, phi_dot=2.6, k=0.25)
    ...     [path.name for path in found.iterdir()]
    ['spinning.jl']
    """
    problem = steady_problem(family, free, start, stop, parameters)
    own = c_name(name or family.name)
    title = f"{family.name} of {family.system.name}".replace("\n", " ")
    return write_folder(out, {f"{own}.jl": _file(problem, own, title)}, overwrite=overwrite)


def _file(problem: SteadyProblem, name: str, title: str) -> str:
    f = problem.function
    inputs = f.sx_in()
    outputs = f.call(inputs)
    rates, found = _straight(ca.Function("rates", inputs, [outputs[0]]))
    slopes, entries = _straight(ca.Function("slopes", inputs, [outputs[1]]))
    named = zip(problem.parameters, problem.values, strict=True)
    words = [c_name(n) for n in problem.parameters]
    return JULIA.format(
        title=title,
        name=name,
        states=", ".join(problem.states),
        rates=rates,
        slopes=slopes,
        outputs=", ".join(found),
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

    own = record.algebra()
    table = {n: two(name) for n, name in TWO}
    table["sign"] = lambda x: record.line(f"sign({record.text(x)})")
    number = Algebra(own.name, own.constant, own.functions | table, lasting=False)
    inputs = [
        [Line(record, f"{word}[{i + 1}]") for i in range(function.numel_in(j))]
        for j, word in enumerate(("u", "par"))
    ]
    values = Program(function).run(number, inputs)[0]
    return "\n".join(record.lines), [record.text(v) for v in values]
