"""Systems from CasADi functions, live or from a file: (x) or (x, p) → rates, observables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import casadi as ca

from ...algebra.program import operations
from ...algebra.switches import no_folding
from ...base.errors import FileError, ParameterError, shown
from .exact_terms import Probes, Term, graph, solve


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
        name, x, p, rhs, states, parameters, observables, approximation.

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
        rounded: list[str] = []
        try:
            expressions = _scalar(function, [x, p][:inputs], Probes(x, p), rounded)
        except ParameterError:
            raise
        except Exception:  # CasADi raises several exception classes
            raise ParameterError(
                f"the function {function.name()} is no graph of smooth elementary functions: it "
                "holds an operation that CasADi does not write out, such as bspline or low (but an "
                "interpolant is read); build that part with SX, or give a Python function, of "
                "which nothing can be proved."
            ) from None
    return {
        "name": function.name(),
        "x": x,
        "p": p,
        "rhs": ca.densify(expressions[0]),
        "states": names[0] if states is None else states,
        "parameters": names[1] if parameters is None else parameters,
        "observables": dict(zip(function.name_out()[1:], expressions[1:], strict=True)),
        "approximation": "".join(rounded),
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
        loaded = ca.Function.load(str(place))
    except Exception:  # CasADi raises several exception classes
        raise refusal from None
    if not isinstance(loaded, ca.Function) or loaded.is_null():
        raise refusal
    return loaded


def _scalar(
    function: ca.Function, inputs: list[ca.SX], probes: Probes, rounded: list[str]
) -> list[ca.SX]:
    """The outputs of a function as scalar operations, one instruction after another.

    CasADi's own `expand` has no linear solver, and a determinant by it branches on its pivots.
    `rounded` takes what a proof speaks of where numbers are rounded.
    """
    if function.class_name() != "MXFunction":
        return list(function.call(inputs))  # what cannot be written out stays as a call
    free = [ca.MX.sym("x", function.sparsity_in(i)) for i in range(function.n_in())]
    function = ca.Function("inlined", free, function.call(free, True, False))
    if {ca.OP_SOLVE, ca.OP_DETERMINANT, ca.OP_LOGSUMEXP}.isdisjoint(operations(function)):
        return list(function.call(inputs))
    entries: list[list[Any]] = [[ca.SX(0)] * function.nnz_out(i) for i in range(function.n_out())]
    work: dict[int, ca.SX] = {}
    for i in range(function.n_instructions()):
        code, node = function.instruction_id(i), function.instruction_MX(i)
        to, read = function.instruction_output(i), function.instruction_input(i)
        if code == ca.OP_INPUT:
            work[to[0]] = inputs[read[0]]
            continue
        parts = [work[r] for r in read]
        if code == ca.OP_OUTPUT:
            start = node.info()["offset"]
            entries[to[0]][start : start + parts[0].nnz()] = parts[0].nonzeros()
            continue
        if code == ca.OP_CONST:
            values = [ca.SX(node.to_DM())]
        elif code == ca.OP_CALL:
            values = _scalar(node.which_function(), parts, probes, rounded)
        elif code == ca.OP_SOLVE:
            matrix = parts[1].T if node.info()["tr"] else parts[1]
            try:
                values = [_solution(matrix, parts[0], probes)]
            except ParameterError:  # a fraction of two numbers, neither of which is a double
                values = [ca.solve(matrix, parts[0])]
                rounded[:] = [ROUNDED]
        elif code == ca.OP_RESHAPE:
            values = [ca.reshape(parts[0], *node.shape)]
        elif code in WRITTEN:
            values = [WRITTEN[code](*parts)]
        else:
            values = _operation(node, parts)
        work |= dict(zip(to, values, strict=True))
    return [
        ca.SX(function.sparsity_out(i), ca.vertcat(*nonzeros))
        if nonzeros
        else ca.SX(*function.size_out(i))
        for i, nonzeros in enumerate(entries)
    ]


def _log_of_sum(x: ca.SX) -> ca.SX:
    total: ca.SX = ca.log(ca.sum1(ca.exp(x)))
    return total


ROUNDED = "for the equations with the numbers of a solved linear system rounded to doubles"
"""What a proof speaks of where the solution of a linear system has no exact graph."""
WRITTEN: dict[int, Callable[..., ca.SX]] = {
    ca.OP_DETERMINANT: ca.det,
    ca.OP_LOGSUMEXP: _log_of_sum,
    ca.OP_HORZCAT: ca.horzcat,
    ca.OP_VERTCAT: ca.vertcat,
    ca.OP_DIAGCAT: ca.diagcat,
}
"""Operations on matrices that CasADi does not write out, or not without branches or by one node."""


def _operation(node: ca.MX, parts: list[ca.SX]) -> list[ca.SX]:
    """The outputs of one operation on matrices."""
    inner = [node.dep(k) for k in range(node.n_dep())]
    free = [ca.MX.sym("x", part.sparsity()) for part in inner]
    outer = [node] if node.n_out() == 1 else [node.get_output(k) for k in range(node.n_out())]
    alone = ca.Function("operation", free, ca.graph_substitute(outer, inner, free))
    return list(alone.expand().call(parts))


def _solution(matrix: ca.SX, right: ca.SX, probes: Probes) -> ca.SX:
    """The solution of matrix · X = right by elimination, each number exact."""

    def term(entry: ca.SX) -> Term:
        return Fraction(float(entry)) if entry.is_constant() else entry

    size = range(matrix.size1())
    rows = [[term(matrix[i, j]) for j in size] for i in size]
    columns = [[term(right[i, k]) for i in size] for k in range(right.size2())]
    solved = (solve(rows, column, [(size, size)], probes)[0] for column in columns)
    return ca.horzcat(*(ca.vertcat(*map(graph, column)) for column in solved))
