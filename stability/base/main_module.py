"""Whether a script may start processes: each of them imports the script, up to its guard."""

from __future__ import annotations

import ast
import multiprocessing
import sys
from pathlib import Path
from types import FrameType
from typing import Any

from .errors import ParameterError, one_line

GUARDS = ("__name__", "parent_process", "current_process")
"""Names by which the condition of a guard tells the script from its workers."""
LEAVES = ("exit", "_exit", "quit")
"""Functions that end a process."""


def check_main(what: str) -> None:
    """Refuse to start processes from the top of a script without a guard.

    Each process would import the script, come to the same call, and fail there; the parent would
    wait for it.  What is typed, or runs in a notebook, is imported by no process.

    Parameters
    ----------
    what
        What is asked for, such as `executor="dask"`.

    Raises
    ------
    ParameterError
        If the line of the script that runs now is under no `if __name__ == "__main__":`.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise ParameterError(
            f"{what} starts processes, and this process is itself one that has not started yet; in "
            "the script that it imports, put the call under `if __name__ == '__main__':`."
        )
    main = sys.modules.get("__main__")
    file, spec = getattr(main, "__file__", None), getattr(main, "__spec__", None)
    if file is None or str(getattr(spec, "name", "")).endswith("__main__"):
        return
    if not Path(file).is_file():  # as <stdin>
        raise ParameterError(
            f"{what} starts processes, which cannot import {one_line(str(file), 60)}; put the "
            "script in a file, or use executor='threads'."
        )
    line = _running(sys._getframe(1), vars(main))
    try:
        tree = ast.parse(Path(file).read_bytes()) if line else None
    except (OSError, ValueError, SyntaxError):  # no script that a process could import
        return
    if tree is not None and not guarded_line(tree, line):
        raise ParameterError(
            f"{what} starts processes, which import {one_line(Path(file).name, 60)} and would come "
            f"to line {line} again; put that line under `if __name__ == '__main__':`."
        )


def _running(frame: FrameType | None, space: dict[str, Any]) -> int:
    """The line at the top of the main module that runs; 0 where none does."""
    while frame is not None:
        if frame.f_code.co_name == "<module>" and frame.f_globals is space:
            return frame.f_lineno
        frame = frame.f_back
    return 0


def guarded_line(tree: ast.Module, line: int) -> bool:
    r"""Whether only the script itself, and no process that imports it, comes to a line.

    Examples
    --------
    >>> tree = ast.parse("if __name__ == '__main__':\n    work()\nwork()")
    >>> guarded_line(tree, 2), guarded_line(tree, 3)
    (True, False)
    """
    for node in ast.walk(tree):
        if isinstance(node, (ast.If, ast.Match)) and _tells(node):
            inside = node.lineno <= line <= (node.end_lineno or node.lineno)
            if inside or (node.lineno < line and any(map(_leaves, ast.walk(node)))):
                return True
    return False


def _tells(node: ast.If | ast.Match) -> bool:
    """Whether a condition asks who runs the script."""
    asked = node.test if isinstance(node, ast.If) else node.subject
    named = {getattr(n, "id", getattr(n, "attr", "")) for n in ast.walk(asked)}
    return not named.isdisjoint(GUARDS)


def _leaves(node: ast.AST) -> bool:
    """Whether a statement ends the process or the import."""
    if isinstance(node, ast.Call):
        return getattr(node.func, "id", getattr(node.func, "attr", "")) in LEAVES
    return isinstance(node, ast.Raise)
