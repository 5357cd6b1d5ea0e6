"""Systems from CasADi functions, live or from a file: (x) or (x, p) → rates, observables."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import casadi as ca

from ...algebra.program import Program
from ...algebra.switches import no_folding
from ...base.errors import FileError, ParameterError, shown


def is_python(function: Any) -> bool:
    """Whether a function is plain Python; what is no function at all is refused."""
    if isinstance(function, (ca.Function, str, PathLike)):
        return False
    if not callable(function):
        raise ParameterError(
            f"function is {shown(function)}; give a CasADi Function, the path of its file, or a "
            "Python function f(x, p)."
        )
    return True


def casadi_function(
    function: Any, *, states: Sequence[str] | None = None, parameters: Sequence[str] | None = None
) -> dict[str, Any]:
    """The arguments of a `System` from a CasADi function.

    Returns
    -------
    dict
        name, x, p, rhs, states, parameters, observables.

    Raises
    ------
    ParameterError, FileError
        If inputs and outputs do not fit, or the function has no scalar graph.

    Examples
    --------
    >>> x = ca.MX.sym("x", 2)
    >>> found = casadi_function(ca.Function("f", [x], [ca.vertcat(x[1], -x[0])]))
    >>> found["rhs"], found["states"]
    (SX([i0_1, (-i0_0)]), ('i0_0', 'i0_1'))
    """
    if isinstance(function, (str, PathLike)):
        function = _loaded(function)
    inputs, outputs = function.n_in(), function.n_out()
    if inputs not in (1, 2) or not outputs:
        raise ParameterError(
            f"the function has {inputs} inputs ({', '.join(function.name_in())}) and {outputs} "
            "outputs; give one of (x) or (x, p) that returns the rates first."
        )
    sizes = [function.size_in(i) for i in range(inputs)]
    for (rows, columns), name in zip(sizes, function.name_in(), strict=True):
        if columns != 1 and rows:
            raise ParameterError(
                f"input {name} of the function is {rows} x {columns}; give a column."
            )
    if function.size_out(0) != (sizes[0][0], 1):
        rows, columns = function.size_out(0)
        raise ParameterError(
            f"the function returns rates of {rows} x {columns} for {sizes[0][0]} states; give a "
            "column with one rate for each."
        )
    names = [_names(function.name_in(i), sizes[i][0]) for i in range(inputs)]
    names += [()] * (2 - inputs)
    x, p = (ca.vertcat(*map(ca.SX.sym, some)) if some else ca.SX(0, 1) for some in names)
    with no_folding():  # the graph as it is: CasADi joins constants in doubles
        scalar = _expanded(function)
        found = scalar.call([x, p][:inputs])
    return {
        "name": function.name(),
        "x": x,
        "p": p,
        "rhs": ca.densify(found[0]),
        "states": names[0] if states is None else states,
        "parameters": names[1] if parameters is None else parameters,
        "observables": dict(zip(function.name_out()[1:], found[1:], strict=True)),
    }


def _names(name: str, count: int) -> tuple[str, ...]:
    return (name,) if count == 1 else tuple(f"{name}_{i}" for i in range(count))


def _loaded(path: Any) -> ca.Function:
    place = Path(fspath(path))
    try:
        text = place.read_bytes()
    except OSError as error:
        raise FileError(
            f"{shown(str(place))} cannot be read ({error.strerror}); give a file that "
            "Function.save wrote."
        ) from None
    refusal = FileError(
        f"{shown(str(place))} is no file of a CasADi function; give one that Function.save wrote."
    )
    if not text:
        raise refusal
    try:
        found = ca.Function.load(str(place))
    except Exception:  # CasADi raises several exception classes
        raise refusal from None
    if not isinstance(found, ca.Function) or found.is_null():
        raise refusal
    return found


def _expanded(function: ca.Function) -> ca.Function:
    """The function as scalar operations that every number type has, or a refusal."""
    try:
        scalar = function if function.is_a("SXFunction") else function.expand()
        Program(scalar)
    except Exception:  # CasADi raises several exception classes
        raise ParameterError(
            f"the function {function.name()} is no graph of smooth elementary functions: it "
            "branches, or calls an integrator, a root-finder or outside code; rewrite that part, "
            "or give a Python function, of which nothing can be proved."
        ) from None
    return scalar
