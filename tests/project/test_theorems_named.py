"""The tests that try to refute a theorem, as `stability table theorems` lists them, exist."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "stability" / "derivation" / "theorems"


def _tests(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_every_test_that_tries_to_refute_a_theorem_exists() -> None:
    [(place, file)] = [
        (path, found[1])
        for path in FOLDER.glob("*.py")
        if (found := re.search(r'^FILE = "(\S+)"$', path.read_text(encoding="utf-8"), re.M))
    ]
    there = _tests(ROOT / file)
    named: dict[str, int] = {}
    for path in sorted(FOLDER.glob("*.py")):
        source = path.read_text(encoding="utf-8")
        names = re.findall(r"\{FILE\}::(\w+)", source)
        assert set(names) <= there, path
        named[path.name] = len(names)
        assert bool(names) or "return Theorem(" not in source, path
    assert place.name in named
    assert sum(named.values()) >= 8
