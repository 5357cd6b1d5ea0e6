"""Python functions from a straight list of instructions: no loop, no look-up.

What reads nothing but constants, and inputs that do not vary, is computed by a function of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..number_types import BY_OTHERS, UNARY, function_of

Step = tuple[int | None, str | float | tuple[int, int], tuple[int, ...]]
"""(register, what is written there, registers that it reads).  No register: a line of the outputs.
Words are Python source, a float is a constant, a pair an entry of an input."""
Varying = frozenset[tuple[int, int]] | None
"""(input, entry) of what varies; None for every entry."""
Parts = tuple[Callable[..., list[Any]], Callable[..., list[list[Any]]]]
"""What is fixed, of (functions, constants, inputs); the outputs, of (functions, fixed, inputs)."""


def split(name: str, steps: Sequence[Step], sizes: Sequence[int], varying: Varying) -> Parts:
    """Two functions: what is fixed, and the outputs by it.

    Parameters
    ----------
    name
        Name of the list in tracebacks.
    steps
        The instructions.
    sizes
        Number of entries of each output.
    varying
        What varies from call to call.

    Examples
    --------
    >>> steps = [(0, (0, 0), ()), (1, 2.0, ()), (1, "{0} + {0}", (1,)), (0, "{0} * {1}", (0, 1)),
    ...     (None, "o0[0] = {}", (0,))]
    >>> fixed, run = split("f", steps, [1], None)
    >>> kept = fixed({}, [2.0], ())
    >>> kept, run({}, kept, [[3.0]])
    ([2.0, 4.0], [[12.0]])
    """
    still: list[str] = []
    moving = [f"    o{i} = [0] * {size}" for i, size in enumerate(sizes)]
    places: dict[int, int | None] = {}  # among what is fixed, of registers that hold it
    constants = 0
    for register, words, source in steps:
        fixed = all(places[r] is not None for r in source)
        if isinstance(words, float):
            line, constants = f"c[{constants}]", constants + 1
        elif isinstance(words, tuple):
            line = "a[{}][{}]".format(*words)
            fixed = varying is not None and words not in varying
        else:
            line = words.format(*(_read(r, places) for r in source))
        if register is None:
            moving.append(f"    {line}")
        elif fixed:
            still.append(f"    put({line})")
            places[register] = len(still) - 1
        else:
            moving.append(f"    w{register} = {line}")
            places[register] = None
    outputs = ", ".join(f"o{i}" for i in range(len(sizes)))
    text = _function("fixed(f, c, a)", ["    k = []", "    put = k.append", *still], "k")
    text += _function("run(f, k, a)", moving, f"[{outputs}]")
    space: dict[str, Any] = {"function_of": function_of}
    exec(compile(text, f"<graph {name}>", "exec"), space)
    return space["fixed"], space["run"]


def _read(register: int, places: dict[int, int | None]) -> str:
    place = places[register]
    return f"w{register}" if place is None else f"k[{place}]"


def _function(head: str, lines: Sequence[str], result: str) -> str:
    """A function that knows the functions of the number type that it uses."""
    body = "\n".join(lines)
    names = [f"    f_{n} = f[{n!r}]" for n in (*UNARY, "pow", "fabs") if f"f_{n}(" in body]
    names += [f"    f_{n} = function_of(f, {n!r})" for n in BY_OTHERS if f"f_{n}(" in body]
    if "f_sign(" in body:  # the slope of |x|: no value at 0, unless the number type has one
        names.append("    f_sign = f.get('sign') or (lambda x: x / f['fabs'](x))")
    start = "\n".join([f"def {head}:", *names])
    return f"{start}\n{body}\n    return {result}\n"
