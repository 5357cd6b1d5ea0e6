"""Every theorem is shown by a notebook, and the tests that try to refute it exist."""

import ast
import re
from importlib import import_module
from pathlib import Path
from typing import Any

from proofs.catalogue import BODIES, DISK

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = ROOT / "notebooks"


def _tests(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def _texts(tree: ast.Module, module: Any) -> list[str]:
    """Texts of a module, those with constants of it filled in."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.append(node.value)
        elif isinstance(node, ast.JoinedStr):
            parts = []
            for value in node.values:
                if isinstance(value, ast.Constant):
                    parts.append(str(value.value))
                elif isinstance(value, ast.FormattedValue) and isinstance(value.value, ast.Name):
                    parts.append(str(getattr(module, value.value.id, "")))
            found.append("".join(parts))
    return found


def test_every_test_that_tries_to_refute_a_theorem_exists() -> None:
    named: set[tuple[str, str]] = set()
    for path in sorted((NOTEBOOKS / "proofs").rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        module = import_module(".".join(path.relative_to(NOTEBOOKS).with_suffix("").parts))
        texts = "\n".join(_texts(ast.parse(source), module))
        here = set(re.findall(r"(tests/[\w/]+\.py)::(\w+)", texts))
        assert here or "return Theorem(" not in source, path
        named |= here
    for file, test in named:
        assert test in _tests(ROOT / file), test
    assert len(named) >= 30


def test_every_theorem_is_shown_by_a_notebook() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in NOTEBOOKS.glob("theorems_*.py"))
    for prove in (*BODIES.values(), *DISK.values()):
        assert re.search(rf"^shown\((\w+\.)?{prove.__name__}\(\)\)$", text, re.MULTILINE), prove
