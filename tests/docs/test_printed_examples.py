"""Examples of the reference run as they are printed: no name but `st` is taken for granted."""

import ast
import builtins
import doctest
import inspect
from collections.abc import Iterator
from typing import Any

import stability as st
from stability.base.lazy import HOMES


def described() -> Iterator[tuple[str, Any]]:
    """Every public name, and each public method and property of a class, with its docstring."""
    for name in HOMES:
        one = getattr(st, name)
        yield name, inspect.getdoc(one)
        for own in dir(one) if inspect.isclass(one) else ():
            part = inspect.getattr_static(one, own)
            part = getattr(part, "fget", None) or getattr(part, "__func__", part)
            if not own.startswith("_") and inspect.isfunction(part):
                yield f"{name}.{own}", inspect.getdoc(part)


def missing(code: str) -> set[str]:
    """Names that a piece of code reads and nothing in it binds."""
    bound, read = {"st"}, set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            bound |= {(a.asname or a.name).split(".")[0] for a in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            bound.add(node.name)
        elif isinstance(node, ast.arg):
            bound.add(node.arg)
        elif isinstance(node, ast.ExceptHandler) and node.name:
            bound.add(node.name)
        elif isinstance(node, ast.Name):
            (read if isinstance(node.ctx, ast.Load) else bound).add(node.id)
    return {n for n in read - bound if not hasattr(builtins, n)}


def test_a_name_that_is_not_imported_is_found() -> None:
    assert missing("Disk().k\nx = np.pi") == {"Disk", "np"}
    assert not missing("import numpy as np\nst.Disk(k=np.pi / 10)")


def test_every_example_names_what_it_imports() -> None:
    found = {}
    for name, text in described():
        code = "".join(e.source for e in doctest.DocTestParser().get_examples(text or ""))
        if names := missing(code):
            found[name] = names
    assert not found
