"""Kernels compiled by Numba, their machine code kept on disk; plain Python without Numba.

A kernel is a module of plain functions and constants.  `compiled` joins the code of one or more
such modules to one text, compiles every function in it at its first call, and hands the functions
back.  Functions that the text names in `INLINE` are written into their callers, so that a loop that
calls them becomes vector instructions.  Numba is optional (extra `kernels`) and is imported by the
first call of `compiled` alone.  Without it the same functions run as Python, on NumPy arrays in
place of numbers.

Machine code is kept in a folder that is named by a digest of the text, so that no edit and no new
version meets old code: comments and docstrings do not count.  Numba itself recompiles for another
processor or another version of Numba.  The folder is `STABILITY_CACHE_DIR`, or the user's cache
folder (`XDG_CACHE_HOME`, otherwise ~/.cache; ~/Library/Caches; LOCALAPPDATA), never the installed
package, which may be read-only.  Where that folder cannot be written either, each process compiles
again in memory, and nothing fails.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import sys
import tempfile
import threading
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

_PARSING = threading.Lock()
"""CPython 3.11 counts the depth of a tree for all threads together, and raises a SystemError."""
STAMP = 1_000_000_000
"""Time stamp of every written text; some versions of Numba take another stamp for an edit."""


def numba_found() -> bool:
    """Whether Numba is installed; it is not imported for this."""
    return find_spec("numba") is not None


def folder() -> Path:
    """The folder for machine code of this user.

    Returns
    -------
    Path
        It need not exist, and may not be writable.

    Examples
    --------
    >>> folder().name
    'kernels'
    """
    cache = os.environ.get("STABILITY_CACHE_DIR")
    if cache:
        return Path(cache) / "kernels"
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return base / "stability" / "kernels"


def code(*modules: ModuleType) -> str:
    """The functions and constants of modules as one text.

    Parameters
    ----------
    modules
        Modules of plain functions, each before those that use it.

    Returns
    -------
    str
        Without comments, docstrings, annotations and relative imports.
    """
    body: list[ast.stmt] = []
    for module in modules:
        with _PARSING:
            tree = ast.parse(inspect.getsource(module))
        for node in tree.body:
            local = isinstance(node, ast.ImportFrom) and (node.level or node.module == "__future__")
            text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
            if not (local or text):
                body.append(_bare(node))
    return ast.unparse(ast.fix_missing_locations(ast.Module(body, []))) + "\n"


def _bare(node: ast.stmt) -> ast.stmt:
    """A statement without docstring and annotations."""
    if isinstance(node, ast.FunctionDef):
        if ast.get_docstring(node) is not None:
            node.body = node.body[1:] or [ast.Pass()]
        node.returns = None
        for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
            argument.annotation = None
        node.body = [_bare(inner) for inner in node.body]
    if isinstance(node, ast.AnnAssign) and node.value is not None:
        return ast.Assign([node.target], node.value)
    return node


@cache
def compiled(*modules: ModuleType, plain: bool = False) -> SimpleNamespace:
    """The functions of modules, compiled by Numba where it is installed.

    Parameters
    ----------
    modules
        Modules of plain functions, each before those that use it.  Functions call each other by
        their bare names.
    plain
        Whether the functions stay Python although Numba is installed.

    Returns
    -------
    SimpleNamespace
        All names of the text.  Compiled functions release the lock of the interpreter, divide by
        zero to inf or nan, and keep the order of every sum (no `fastmath`).

    Examples
    --------
    >>> import colorsys  # any module of plain functions
    >>> compiled(colorsys, plain=True).rgb_to_hsv(1.0, 1.0, 1.0)
    (0.0, 0.0, 1.0)
    """
    return from_text(code(*modules), modules[-1].__name__.rpartition(".")[2], plain=plain)


def from_text(text: str, name: str, *, plain: bool = False) -> SimpleNamespace:
    r"""The functions of a text, compiled by Numba where it is installed.

    Parameters
    ----------
    text
        Python source of plain functions and constants.
    name
        Name of the kernel, a word.
    plain
        Whether the functions stay Python although Numba is installed.

    Returns
    -------
    SimpleNamespace
        As for `compiled`.

    Examples
    --------
    >>> from_text("def twice(x):\n    return 2 * x\n", "doc", plain=True).twice(4)
    8
    """
    jit = not plain and numba_found()
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    path = _written(text, folder() / digest / f"{name}.py") if jit else None
    module = ModuleType(f"stability_kernel_{name}_{digest}")
    space = module.__dict__
    exec(compile(text, str(path or f"<kernel {name}>"), "exec"), space)
    if jit:
        sys.modules[module.__name__] = module  # kept machine code looks its module up by name
        for key, value in list(space.items()):
            if inspect.isfunction(value) and value.__globals__ is space:
                space[key] = _jitted(value, path is not None, key in space.get("INLINE", ()))
    return SimpleNamespace(**{k: v for k, v in space.items() if not k.startswith("__")})


def _jitted(function: Any, keep: bool, inline: bool = False) -> Any:
    """A function that Numba compiles at its first call."""
    import numba

    settings: dict[str, Any] = {"nogil": True, "error_model": "numpy", "forceinline": inline}
    if keep:
        with suppress(RuntimeError):  # no folder for machine code can be written
            return numba.njit(cache=True, **settings)(function)
    return numba.njit(**settings)(function)


def _written(text: str, path: Path) -> Path | None:
    """A file with the text, next to which Numba keeps its machine code; None where none can be."""
    with suppress(OSError):
        if path.is_file() and path.read_text() == text:
            return path
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False) as file:
            file.write(text)
        os.utime(file.name, (STAMP, STAMP))
        os.replace(file.name, path)
        return path
    return None
