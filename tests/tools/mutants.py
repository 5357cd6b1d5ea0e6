"""Break the package in seeded places, one at a time, and see which tests notice.

`draw`: two places in each folder, into tests/data/mutants.json.
`reach`: which tests execute each place, and how long each test takes, from one run of all.
`run`: each place broken in a copy of a commit, and the tests that execute it run there, quick ones
first, up to the first failure.  Nothing is changed in the tree itself.

`reach` hands further words to pytest (`-m long tests/maps`).  Both keep what they find in `--out`.
The file of the places holds for each which test found it before the tests were sorted into tiers,
which test of `make test` finds it after, and of those that none finds why they make no difference.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PLACES = ROOT / "tests/data/mutants.json"
KINDS = ("comparison", "sign", "constant", "term", "exception", "range")
TURNED = {
    ast.Lt: ">",
    ast.LtE: ">",
    ast.Gt: "<",
    ast.GtE: "<",
    ast.Eq: "!=",
    ast.NotEq: "==",
}
PROBE = '''"""Notes which test executes a place, and how long each test takes."""
import os
FILE, SEEN = {file!r}, set()
def pytest_runtest_logreport(report):
    with open(FILE + ".times", "a") as out:
        out.write(f"{{report.duration:.4f}}\\t{{report.outcome}}\\t{{report.nodeid}}\\n")
def hit(number):
    test = os.environ.get("PYTEST_CURRENT_TEST", "").rsplit(" ", 1)[0]
    if test and (number, test) not in SEEN:
        SEEN.add((number, test))
        with open(FILE, "a") as out:
            out.write(f"{{number}}\\t{{test}}\\n")
    return True
'''


@dataclass(frozen=True)
class Place:
    """One expression or statement on one line, and what it becomes."""

    file: str
    function: str
    kind: str
    line: int
    start: int
    end: int
    broken: str


def _broken(node: ast.AST, source: str) -> Iterator[tuple[str, str]]:
    """What a node may become: kind and text."""

    def text(part: ast.AST) -> str:
        return ast.get_source_segment(source, part) or ""

    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in TURNED:
            yield "comparison", f"{text(left)} {TURNED[type(op)]} {text(right)}"
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield "sign", text(operand)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            if not isinstance(left, ast.Constant | ast.JoinedStr | ast.Tuple | ast.List):
                yield "sign", f"{text(left)} - {text(right)}"
                yield "term", text(left)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            yield "sign", f"{text(left)} + {text(right)}"
            yield "term", text(left)
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            if not isinstance(left, ast.Constant | ast.JoinedStr | ast.Tuple | ast.List):
                yield "term", text(left)
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            yield "constant", repr(value + 1 if isinstance(value, int) else 2 * value + 1e-300)
        case ast.Raise(exc=ast.AST()):
            yield "exception", "pass"
        case ast.Call(func=ast.Name("range"), args=[*_, stop]):
            start = text(node)
            yield "range", f"{start[: -len(text(stop)) - 1]}{text(stop)} - 1)"


def places(file: Path) -> Iterator[Place]:
    """Everything in the functions of a file that can be broken on one line."""
    source = file.read_text(encoding="utf-8")
    lines = source.splitlines()

    def visit(node: ast.AST, inside: str) -> Iterator[Place]:
        named = isinstance(node, ast.FunctionDef | ast.ClassDef | ast.AsyncFunctionDef)
        name = f"{inside}.{node.name}".lstrip(".") if named else inside
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "type_params"):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from visit(child, name)
        if isinstance(node, ast.JoinedStr | ast.FormattedValue):
            return
        if name and isinstance(node, ast.expr | ast.stmt) and node.lineno == node.end_lineno:
            row = lines[node.lineno - 1]
            if not row.isascii():
                return
            for kind, broken in _broken(node, source):
                yield Place(
                    file.relative_to(ROOT).as_posix(),
                    name,
                    kind,
                    node.lineno,
                    node.col_offset,
                    node.end_col_offset,
                    broken,
                )

    tree = ast.parse(source)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield from visit(node, "")


def draw(seed: int) -> None:
    """Choose two places in each folder, of kinds in turn, and keep them."""
    choice = random.Random(seed)
    kinds, chosen = list(KINDS), []
    for folder in sorted(p for p in (ROOT / "stability").iterdir() if (p / "__init__.py").exists()):
        found = [place for file in sorted(folder.rglob("*.py")) for place in places(file)]
        for _ in range(2):
            for kind in kinds:
                if several := [place for place in found if place.kind == kind]:
                    chosen.append(choice.choice(several))
                    kinds.remove(kind)
                    kinds.append(kind)
                    break
    records = []
    for number, place in enumerate(chosen, 1):
        row = (ROOT / place.file).read_text(encoding="utf-8").splitlines()[place.line - 1]
        records.append(
            {
                "number": number,
                "file": place.file,
                "function": place.function,
                "kind": place.kind,
                "line": row,
                "start": place.start,
                "end": place.end,
                "broken": row[: place.start] + place.broken + row[place.end :],
            }
        )
    PLACES.write_text(json.dumps(records, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"{len(records)} places in {PLACES.relative_to(ROOT)}")


def _copy(into: Path, commit: str) -> Path:
    """A commit in a folder of its own."""
    tree = into / "tree"
    tree.mkdir()
    archive = subprocess.run(["git", "archive", commit], cwd=ROOT, capture_output=True, check=True)
    subprocess.run(["tar", "-x", "-C", str(tree)], input=archive.stdout, check=True)
    subprocess.run(["git", "init", "-q"], cwd=tree, check=True)
    return tree


def _line(tree: Path, record: dict[str, Any], row: str) -> str:
    """Write another line at a place; returns the file as it was."""
    path = tree / record["file"]
    before = path.read_text(encoding="utf-8")
    lines = before.split("\n")
    inside = _lines_of(before, record["function"])
    there = [i for i in inside if lines[i] == record["line"]]
    if len(there) != 1:
        raise SystemExit(f"place {record['number']} stands {len(there)} times in {record['file']}")
    lines[there[0]] = row
    path.write_text("\n".join(lines), encoding="utf-8")
    return before


def _lines_of(source: str, function: str) -> range:
    node: Any = ast.parse(source)
    for name in function.split("."):
        named = (n for n in ast.walk(node) if getattr(n, "name", None) == name)
        node = next(n for n in named if hasattr(n, "lineno"))
    return range(node.lineno - 1, node.end_lineno)


def _pytest(tree: Path, *words: str, **kwargs: Any) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(tree)}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", *words],
        cwd=tree,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
        **kwargs,
    )


def reach(out: Path, commit: str, words: list[str]) -> None:
    """Run the tests once with a probe at each place; keep which test comes by, and for how long."""
    records = json.loads(PLACES.read_text(encoding="utf-8"))
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as into:
        tree = _copy(Path(into), commit)
        hits = out / "hits.txt"
        for file in (hits, Path(f"{hits}.times")):
            file.write_text("")
        (tree / "stability/_probe.py").write_text(PROBE.format(file=str(hits)))
        for r in records:
            call = f"__import__('stability._probe').{'_probe'}.hit({r['number']})"
            text = r["line"][r["start"] : r["end"]]
            probed = f"{call}; {text}" if r["kind"] == "exception" else f"({call} and ({text}))"
            _line(tree, r, r["line"][: r["start"]] + probed + r["line"][r["end"] :])
        result = _pytest(
            tree,
            "-n",
            "2",
            "-p",
            "stability._probe",
            *words,
        )
        (out / "reach.log").write_text(result.stdout)
    print(result.stdout.splitlines()[-1])


FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
FIRST = 40
"""So many tests run first, before the rest is even imported."""


def reached(out: Path) -> tuple[dict[int, set[str]], dict[str, float]]:
    """The tests that passed and execute each place, and the seconds of each test."""
    tests: dict[int, set[str]] = {}
    for line in (out / "hits.txt").read_text(encoding="utf-8").splitlines():
        number, test = line.split("\t")
        tests.setdefault(int(number), set()).add(test)
    seconds: dict[str, float] = {}
    failed = set()
    for line in (out / "hits.txt.times").read_text(encoding="utf-8").splitlines():
        took, outcome, test = line.split("\t")
        seconds[test] = seconds.get(test, 0.0) + float(took)
        if outcome == "failed":
            failed.add(test)
    return {number: found - failed for number, found in tests.items()}, seconds


def tried(tree: Path, record: dict[str, Any], tests: list[str], limit: float) -> dict[str, Any]:
    """Break one place, run its tests, mend it; which test failed first."""
    before = _line(tree, record, record["broken"])
    start, found = time.monotonic(), None
    names = tree / "tests-to-run.txt"
    try:
        for part in (tests[:FIRST], tests[FIRST:]):
            if not part or found:
                continue
            names.write_text("\n".join(part), encoding="utf-8")
            left = limit - (time.monotonic() - start)
            try:
                said = _pytest(tree, "-x", "-m", "", f"@{names}", timeout=max(left, 1.0)).stdout
            except subprocess.TimeoutExpired:
                found = "no answer in time"
            else:
                match = FAILED.search(said)
                found = match.group(1) if match else None
                if not match and " passed" not in said:
                    found = said[-300:]
    finally:
        (tree / record["file"]).write_text(before, encoding="utf-8")
    seconds = round(time.monotonic() - start, 1)
    return {"found by": found, "tests": len(tests), "seconds": seconds}


def run(out: Path, commit: str, numbers: list[int], jobs: int, limit: float) -> None:
    """Try every place, and print which test finds it."""
    records = [
        r
        for r in json.loads(PLACES.read_text(encoding="utf-8"))
        if not numbers or r["number"] in numbers
    ]
    tests, seconds = reached(out)
    results_file = out / "results.json"
    results: dict[str, Any] = json.loads(results_file.read_text()) if results_file.exists() else {}
    with tempfile.TemporaryDirectory() as into, ThreadPoolExecutor(jobs) as pool:
        trees: SimpleQueue[Path] = SimpleQueue()
        for number in range(jobs):
            (Path(into) / str(number)).mkdir()
            trees.put(_copy(Path(into) / str(number), commit))

        def one(record: dict[str, Any]) -> None:
            folder = record["file"].split("/")[1]
            chosen = sorted(
                tests.get(record["number"]) or {f"tests/{folder}"},
                key=lambda t: (not t.startswith(f"tests/{folder}/"), seconds.get(t, 0.0)),
            )
            tree = trees.get()
            try:
                result = tried(tree, record, chosen, limit)
            finally:
                trees.put(tree)
            results[str(record["number"])] = result
            results_file.write_text(json.dumps(results, indent=1) + "\n")
            print(record["number"], record["file"], result, flush=True)

        list(pool.map(one, records))
    lost = sorted(int(n) for n, r in results.items() if r["found by"] is None)
    print(f"{len(results) - len(lost)} of {len(results)} found; not found: {lost}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", choices=("draw", "reach", "run"))
    parser.add_argument("--seed", type=int, default=37)
    parser.add_argument("--out", type=Path, default=ROOT / "build/mutants")
    parser.add_argument("--commit", default="HEAD")
    parser.add_argument("--only", type=int, nargs="*", default=[], help="numbers of places to run")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--limit", type=float, default=900.0, help="seconds for one place")
    given, rest = parser.parse_known_args()
    if given.task == "draw":
        draw(given.seed)
    elif given.task == "reach":
        reach(given.out.resolve(), given.commit, rest)
    else:
        run(given.out.resolve(), given.commit, given.only, given.jobs, given.limit)
