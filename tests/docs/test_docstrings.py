"""Every public name says what it is, takes, gives and raises, its source, and has an example."""

from __future__ import annotations

import ast
import inspect
import re
import sys
import textwrap
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from numpydoc.docscrape import FunctionDoc
from numpydoc.validate import validate

import stability as st

ROOT = Path(__file__).resolve().parents[2]
NOT_ASKED = {
    "PR01", "PR02", "PR04",  # types are annotations; parameters are compared below
    "PR08", "PR09", "RT04", "RT05",  # names in lower case may begin a sentence here
    "SA01", "ES01", "EX01",  # no *See Also*; examples are compared below
    "SS05", "SS06", "RT02", "RT03", "GL01", "GL02", "GL03", "GL07", "PR03",
}  # fmt: skip
"""Checks of numpydoc that are a question of style, or that a test below makes more strictly."""


def text_of(name: str) -> str:
    """The docstring of a public name; of a constant, the text below it in its module."""
    value = getattr(st, name)
    if isinstance(value, type) or callable(value):
        return inspect.getdoc(value) or ""
    home = import_module(f"stability.{st._WHERE[name]}")
    body = ast.parse(Path(str(home.__file__)).read_text(encoding="utf-8")).body
    for line, below in zip(body, body[1:], strict=False):
        targets = line.targets if isinstance(line, ast.Assign) else [getattr(line, "target", None)]
        named = any(isinstance(t, ast.Name) and t.id == name for t in targets)
        if named and isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant):
            return inspect.cleandoc(str(below.value.value))
    return ""


def tree_of(value: Any) -> ast.AST:
    return ast.parse(textwrap.dedent(inspect.getsource(value))).body[0]


def missing(value: Any, text: str) -> list[str]:
    """What the docstring of a name leaves out."""
    lacks = []
    summary = text.split("\n\n")[0]
    if not summary or not re.search(r"[.!?]$", summary.rstrip()):
        lacks.append("a summary that is a sentence")
    if not re.search(r"^Source: \S", text, re.MULTILINE):
        lacks.append("a source")
    if ">>> " not in text:
        lacks.append("an example")
    if inspect.isfunction(value):
        doc = FunctionDoc(value)
        said = {n.strip(" *") for p in doc["Parameters"] for n in p.name.split(",")}
        lacks += [f"parameter {n}" for n in inspect.signature(value).parameters if n not in said]
        if not doc["Returns"]:
            lacks.append("what it returns")
        if any(isinstance(n, ast.Raise) for n in ast.walk(tree_of(value))) and not doc["Raises"]:
            lacks.append("what it raises")
    if is_dataclass(value) and isinstance(value, type):
        lacks += [f"field {n}" for n in undocumented(value, text)]
    return lacks


def undocumented(value: type, text: str) -> list[str]:
    """Fields of a record without a text below them, and without a word in the class's docstring."""
    known: set[str] = set()
    for base in value.__mro__:
        if base.__module__.startswith("stability"):
            body = getattr(tree_of(base), "body", [])
            for line, below in zip(body, body[1:], strict=False):
                if isinstance(line, ast.AnnAssign) and isinstance(below, ast.Expr):
                    known.add(ast.unparse(line.target))
    return [
        f.name for f in fields(value)
        if not f.name.startswith("_") and f.name not in known and not re.search(
            rf"^\s*[\w, ]*\b{f.name}\b[\w, ]*$", text, re.MULTILINE)
    ]  # fmt: skip


@pytest.mark.parametrize("name", st.__all__)
def test_a_public_name_has_every_part_of_its_docstring(name: str) -> None:
    value, text = getattr(st, name), text_of(name)
    assert missing(value, text) == []


@pytest.mark.parametrize("name", st.__all__)
def test_a_docstring_has_the_form_of_numpydoc(name: str) -> None:
    value = getattr(st, name)
    if isinstance(value, type):
        if issubclass(value, Enum):
            return  # its call has the parameters of the class Enum
    elif not inspect.isfunction(value):
        return  # a constant has no docstring of its own
    found = validate(f"{value.__module__}.{name}")
    errors = [(code, said) for code, said in found["errors"] if code not in NOT_ASKED]
    assert errors == []


def test_a_docstring_that_leaves_something_out_is_found() -> None:
    def bare(a: float, b: float) -> float:
        """Sum

        Parameters
        ----------
        a
            First.
        """
        if a < 0:
            raise ValueError
        return a + b

    found = missing(bare, inspect.getdoc(bare) or "")
    assert found == [
        "a summary that is a sentence", "a source", "an example", "parameter b", "what it returns",
        "what it raises",
    ]  # fmt: skip


# --- the pages of the reference ---


def part(name: str) -> ModuleType:
    """A module of the site's own parts that needs no Sphinx."""
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        return import_module(f"sphinx_parts.{name}")
    finally:
        sys.path.pop(0)


def test_every_public_name_has_one_place_in_the_reference() -> None:
    names = [name for group in part("reference").grouped().values() for name in group]
    assert sorted(names) == st.__all__


def test_groups_come_in_the_order_of_a_reader() -> None:
    order = [group.name for group in part("reference").GROUPS]
    assert order[:11] == ["bodies", "systems", "families", "spectra", "boundaries", "maps",
                          "motion", "scene", "basins", "figures", "tables"]  # fmt: skip


def test_every_command_and_option_is_in_the_reference() -> None:
    module = part("command_line")
    found = module.commands()
    assert {"spectrum", "map", "boundaries", "atlas", "simulate", "basins", "scene"} <= set(found)
    for name, parser in found.items():
        text = module.section(name, parser)
        for action in parser._actions:
            assert all(option in text for option in action.option_strings if option[1:2] != "h"
                       and option != "--help")  # fmt: skip
