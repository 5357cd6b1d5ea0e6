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

from numpydoc.docscrape import FunctionDoc
from numpydoc.validate import validate

import stability as st
from stability.base.lazy import HOMES

ROOT = Path(__file__).resolve().parents[2]
NOT_ASKED = {
    "PR01": "the fields of a record have texts of their own, below",
    "PR04": "types are annotations, which mypy checks",
    "SS05": "summaries are noun phrases, and some of these are plural",
    "SA01": "pages of the reference show together what belongs together",
    "ES01": "one sentence is enough where it says all",
}
"""Checks of numpydoc that are not asked, with the reason."""
NO_FIELDS = {"Disk": "its constructor takes any arguments, so that it can warn of a lone number"}
"""Classes whose parameters numpydoc cannot see (PR02)."""
SOURCE = re.compile(r"^Source: (.*?)(?=\n\s*\n|\Z)", re.DOTALL | re.MULTILINE)


def text_of(name: str) -> str:
    """The docstring of a public name; of a constant, the text below it in its module."""
    value = getattr(st, name)
    if isinstance(value, type) or callable(value):
        return inspect.getdoc(value) or ""
    home = import_module(HOMES[name])
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
        f.name
        for f in fields(value)
        if not f.name.startswith("_")
        and f.name not in known
        and not re.search(rf"^\s*[\w, ]*\b{f.name}\b[\w, ]*$", text, re.MULTILINE)
    ]


def complaints(name: str) -> list[tuple[str, str]]:
    """What numpydoc says of the docstring of a public name."""
    value = getattr(st, name)
    if isinstance(value, type):
        if issubclass(value, Enum):
            return []  # its call has the parameters of the class Enum
    elif not inspect.isfunction(value):
        return []  # a constant has no docstring of its own
    return [(code, said) for code, said in validate(f"{value.__module__}.{name}")["errors"]]


def test_every_docstring_has_all_its_parts_in_the_form_of_numpydoc() -> None:
    lacks = {name: missing(getattr(st, name), text_of(name)) for name in HOMES}
    assert {name: said for name, said in lacks.items() if said} == {}
    every = {name: complaints(name) for name in HOMES}
    asked = {
        name: [
            one
            for one in said
            if one[0] not in NOT_ASKED and not (one[0] == "PR02" and name in NO_FIELDS)
        ]
        for name, said in every.items()
    }
    assert {name: said for name, said in asked.items() if said} == {}
    # so that no check stays off without need
    assert set(NOT_ASKED) <= {code for said in every.values() for code, _ in said}


def test_every_source_names_what_exists_and_treats_the_name() -> None:
    for name in HOMES:
        source_names_what_exists(name)


def source_names_what_exists(name: str) -> None:
    """Each path, function of a test and module is there; a test names the module's own names."""
    [source] = SOURCE.findall(text_of(name))
    source = " ".join(source.split())
    named = re.findall(r"(?:tests|benchmarks|docs|notebooks|stability)/[\w/-]+(?:\.\w+)?", source)
    for path in named:
        assert (ROOT / path).exists(), (name, path)
    for module in re.findall(r"`(stability(?:\.\w+)+)`", source):
        import_module(module)
    tests = [ROOT / path for path in named if path.startswith("tests")]
    files = [f for t in tests for f in (sorted(t.rglob("*.py")) if t.is_dir() else [t])]
    text = "\n".join(f.read_text(encoding="utf-8") for f in files)
    for function in re.findall(r"\btest_\w+\b(?!\.py)", source):
        assert f"def {function}(" in text, function
    for file in re.findall(r"(?<![/\w])test_\w+\.py", source):
        assert any(f.with_name(file).is_file() for f in files), file
    near = [n for n in HOMES if HOMES[n] == HOMES[name]]
    treated = name in TREATED or any(re.search(rf"\b{n}\b", text) for n in near)
    assert treated or not tests, near


TREATED = {
    "Rung": "the rungs of answers are compared with the full model",
    "System": "random systems come from tests/oracles/random_systems.py",
    "report": "its cells are what the tests judge",
    "LinearViscous": "the law is there by its name",
}
"""Names whose tests reach them by another name."""


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
        "a summary that is a sentence",
        "a source",
        "an example",
        "parameter b",
        "what it returns",
        "what it raises",
    ]


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
    assert sorted(names) == sorted(HOMES)


def test_groups_come_in_the_order_of_a_reader() -> None:
    order = [group.name for group in part("reference").GROUPS]
    assert order[:11] == [
        "bodies",
        "systems",
        "families",
        "spectra",
        "boundaries",
        "maps",
        "motion",
        "scene",
        "basins",
        "figures",
        "tables",
    ]


def test_every_command_and_option_is_in_the_reference() -> None:
    module = part("command_line")
    found = module.commands()
    assert {"spectrum", "map", "boundaries", "atlas", "simulate", "basins", "scene"} <= set(found)
    # bodies have options that only a command line with --body or --help has
    assert "--body NAME" in module.section("spectrum", found["spectrum"])
    assert "--tube" in module.section("basins", found["basins"])
    for name, parser in found.items():
        text = module.section(name, parser)
        for action in parser._actions:
            assert all(
                option in text
                for option in action.option_strings
                if option[1:2] != "h" and option != "--help"
            )
