"""C code of a graph, by CasADi's generator, with an example that checks itself."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from ..base.errors import DomainError, FileError, ParameterError, shown
from ..base.types import Floats, Overwrite, Record
from ..storage.files import together, write_file
from ..storage.targets import path_text, place, refusing
from ..systems.equations import Equations
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem

SEED = 20160201
"""Seed of the points in the example."""
TRIES = 200
"""Random points that are tried for each one that is kept."""
AGREES = 1e-12
"""Difference that the example accepts, relative to the largest entry of each output."""
EXAMPLE = """\
/* Compile: cc -O2 example.c {name}.c -lm -o example && ./example
   It compares {name} at {points} random points with the values of the graph, and ends with 1 if
   they differ by more than {agrees:g} of the largest entry. */
#include <math.h>
#include <stdio.h>
#include "{name}.h"

#define POINTS {points}
static const double given[POINTS][{wide}] = {{{given}}};
static const double wanted[POINTS][{tall}] = {{{wanted}}};

int main(void) {{
  static const int inputs[] = {{{inputs}}}, outputs[] = {{{outputs}}};
  double worst = 0;
  for (int point = 0; point < POINTS; point++) {{
    static double found[{tall}], w[{work} + 1];
    static casadi_int iw[{iwork} + 1];
    const double *arg[{args} + 1] = {{0}};
    double *res[{results} + 1] = {{0}};
    for (int i = 0, at = 0; i < {n_in}; at += inputs[i++]) arg[i] = given[point] + at;
    for (int i = 0, at = 0; i < {n_out}; at += outputs[i++]) res[i] = found + at;
    if ({name}(arg, res, iw, w, 0)) return 2;
    for (int i = 0, at = 0; i < {n_out}; at += outputs[i++]) {{
      double large = 0, off = 0;
      for (int j = at; j < at + outputs[i]; j++) {{
        large = fmax(large, fabs(wanted[point][j]));
        off = fmax(off, fabs(found[j] - wanted[point][j]));
        if (found[j] != found[j]) return 2;
      }}
      if (large > 0) worst = fmax(worst, off / large);
      else worst = fmax(worst, off);
    }}
  }}
  printf("{name}: largest relative difference at %d points %.1e\\n", POINTS, worst);
  return worst > {agrees:g};
}}
"""


@dataclass(frozen=True, eq=False)
class CCode(Record):
    """C code that was written."""

    folder: Path
    """Where it is."""
    name: str
    """Name of the function."""
    inputs: tuple[str, ...]
    """Inputs of the function, each a column, in order."""
    outputs: tuple[str, ...]
    """Outputs, each dense, matrices by columns."""
    command: str
    """How to compile and run the example, in the folder."""


def c_code(
    subject: Equations | Family | ca.Function,
    out: str | Path,
    *,
    name: str | None = None,
    points: int = 5,
    overwrite: Overwrite = False,
) -> CCode:
    """C code of a system's rates and Jacobian, or of any CasADi function, with an example.

    The folder gets NAME.c and NAME.h by CasADi's generator, and example.c, which calls the function
    at random points and compares it with values of the graph.

    Parameters
    ----------
    subject
        A `System` or the system of a `Family`: inputs x and p, outputs the rates f and the Jacobian
        of f by x, by columns; or a `casadi.Function`, whose outputs become dense.
    out
        Folder to write.
    name
        Name of the C function; that of the subject when left out.
    points
        Points of the example.
    overwrite
        Whether files of an earlier call are replaced; "same": if the same call wrote them all.

    Returns
    -------
    CCode
        The folder, the function's name, inputs and outputs, and the command that runs the example.

    Raises
    ------
    ParameterError
        If the subject is something else.
    DomainError
        If random points near 1 give no finite values.
    FileError
        If the folder has such files, or cannot be written.

    Source: CasADi's code generator; tests/export/test_c_code.py compiles it.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     code = st.export.c_code(st.disk_system("viscous"), folder + "/disk", name="disk")
    ...     sorted(path.name for path in code.folder.iterdir())
    ['disk.c', 'disk.h', 'example.c']
    """
    if isinstance(points, bool) or not isinstance(points, int) or not 1 <= points <= 1000:
        raise ParameterError(f"points is {shown(points)}; give a whole number from 1 to 1000.")
    function = dense(subject, name)
    source, header = generated(function)
    example = _example(function, points)
    files = {f"{function.name()}.c": source, f"{function.name()}.h": header, "example.c": example}
    folder = write_folder(out, files, overwrite=overwrite)
    command = f"cc -O2 example.c {function.name()}.c -lm -o example && ./example"
    return CCode(
        folder, function.name(), tuple(function.name_in()), tuple(function.name_out()), command
    )


def dense(subject: Any, name: str | None = None) -> ca.Function:
    """A function with dense inputs and outputs of a subject."""
    if isinstance(subject, Family):
        subject = subject.system
    if isinstance(subject, NumericSystem):
        raise ParameterError(f"{subject.name} is a Python function; give a System with a graph.")
    if isinstance(subject, Equations):
        subject.refuse_algebraic("C code")
        rates = ca.densify(subject.rhs)
        both = ca.cse([rates, ca.densify(ca.jacobian(subject.rhs, subject.x))])
        return ca.Function(
            c_name(name or subject.name), [subject.x, subject.p], both, ["x", "p"], ["f", "J"]
        )
    if isinstance(subject, ca.Function):
        inputs = [ca.SX.sym(n, *subject.size_in(i)) for i, n in enumerate(subject.name_in())]
        outputs = [ca.densify(v) for v in subject.call(inputs)]
        return ca.Function(
            c_name(name or subject.name()), inputs, outputs, subject.name_in(), subject.name_out()
        )
    raise ParameterError(
        f"subject is {shown(subject)}; give a System, a Family, or a casadi.Function."
    )


def c_name(text: str) -> str:
    """A name as one of C.

    Examples
    --------
    >>> c_name("disk, viscous")
    'disk_viscous'
    """
    word = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    return word if word[:1].isalpha() else f"f_{word}"


def generated(function: ca.Function) -> tuple[str, str]:
    """C source and header of a function."""
    generator = ca.CodeGenerator(f"{function.name()}.c", {"with_header": True})
    generator.add(function)
    name = function.name()
    header = f"""\
#ifndef {name.upper()}_H
#define {name.upper()}_H
#ifndef casadi_real
#define casadi_real double
#endif
#ifndef casadi_int
#define casadi_int long long int
#endif
#ifdef __cplusplus
extern "C" {{
#endif
/* inputs {", ".join(function.name_in())}; outputs {", ".join(function.name_out())}, by columns;
   work space: arg {function.sz_arg()}, res {function.sz_res()}, iw {function.sz_iw()},
   w {function.sz_w()} */
int {name}(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem);
#ifdef __cplusplus
}}
#endif
#endif
"""
    return str(generator.dump()), header


def _example(function: ca.Function, points: int) -> str:
    arguments, wanted = _points(function, points)
    n_in, n_out = function.n_in(), function.n_out()
    return EXAMPLE.format(
        name=function.name(),
        points=points,
        agrees=AGREES,
        wide=max(1, arguments.shape[1]),
        tall=wanted.shape[1],
        given=_rows(arguments),
        wanted=_rows(wanted),
        inputs=", ".join(str(function.numel_in(i)) for i in range(n_in)),
        outputs=", ".join(str(function.numel_out(i)) for i in range(n_out)),
        args=function.sz_arg(),
        results=function.sz_res(),
        iwork=function.sz_iw(),
        work=function.sz_w(),
        n_in=n_in,
        n_out=n_out,
    )


def _rows(table: Floats) -> str:
    return ",\n  ".join("{" + ", ".join(float(v).hex() for v in row) + "}" for row in table)


def _points(function: ca.Function, points: int) -> tuple[Floats, Floats]:
    """Random inputs near 1 with finite outputs, and the outputs."""
    rng = np.random.default_rng(SEED)
    drawn: list[Floats] = []
    wanted: list[Floats] = []
    for _ in range(TRIES * points):
        inputs = [rng.uniform(0.5, 1.5, function.size_in(i)) for i in range(function.n_in())]
        outputs: Sequence[Any] = function.call([ca.DM(v) for v in inputs])
        values = np.concatenate([np.asarray(v).ravel(order="F") for v in outputs])
        if np.isfinite(values).all():
            drawn.append(np.concatenate([v.ravel(order="F") for v in inputs]))
            wanted.append(values)
        if len(drawn) == points:
            return np.array(drawn), np.array(wanted)
    raise DomainError(
        f"{function.name()} has finite values at {len(drawn)} of {TRIES * points} random points "
        "from 0.5 to 1.5; no example can be made."
    )


def write_folder(out: str | Path, files: Mapping[str, str], *, overwrite: Overwrite) -> Path:
    """Write texts into a folder, which is made if needed; all of them or none."""
    folder = place(out)
    if folder.exists() and not folder.is_dir():
        raise FileError(f"{path_text(folder)} is a file; give a folder.")
    with refusing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with together():
        for name, text in files.items():
            write_file(folder / name, text, overwrite=overwrite)
    return folder
