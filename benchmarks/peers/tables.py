"""What the comparisons with peers share: timing, tables, and a run whose parts may fail."""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

PROPER = {"sympy": "SymPy", "pydy": "PyDy"}
COLD = """
try:
    import heyoka
    heyoka.llvm_state.set_diskcache_enabled(False)
except ImportError:
    pass
"""
"""heyoka keeps compiled code on disk: a second process would find it there."""


class Seconds(float):
    """A time, printed in the unit that suits it."""

    def __str__(self) -> str:
        scale, unit = (1, "s") if self >= 1 else (1e3, "ms") if self >= 1e-3 else (1e6, "us")
        return f"{self * scale:.3g} {unit}"


def cell(value: Any) -> str:
    if isinstance(value, float) and not isinstance(value, Seconds):
        return f"{value:.3g}"
    return "-" if value is None else str(value)


def table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]], *notes: str) -> Any:
    return {"title": title, "columns": list(columns), "rows": list(rows), "notes": list(notes)}


def show(found: dict[str, Any]) -> None:
    print(f"\n{found['title']}")
    texts = [found["columns"], *([cell(v) for v in row] for row in found["rows"])]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    for first, *rest in texts if widths else ():
        right = [t.rjust(w) for t, w in zip(rest, widths[1:], strict=True)]
        print("  " + "  ".join([first.ljust(widths[0]), *right]))
    for note in found["notes"]:
        print(f"  {note}")


def timed(run: Callable[[], Any]) -> tuple[Any, Seconds]:
    begin = time.perf_counter()
    value = run()
    return value, Seconds(time.perf_counter() - begin)


def medians(a: Callable[[], Any], b: Callable[[], Any], repeats: int = 9) -> list[Seconds]:
    """Of two routes that take turns, so that a busy machine hits both alike."""
    spent = [[timed(run)[1] for run in (a, b)] for _ in range(repeats)]
    return [Seconds(statistics.median(each)) for each in zip(*spent, strict=True)]


def first_call(ask: str, before: str = "", cold: str = "") -> Seconds:
    """What the package needs for its first answer in a process that has NumPy and `before`."""
    lines = ["import time, numpy as np", before, "begin = time.perf_counter()"]
    lines += ["import stability as st", cold, ask, "print(time.perf_counter() - begin)"]
    command = [sys.executable, "-c", "\n".join(lines)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"the package's first call: {(done.stderr.splitlines() or ['?'])[-1]}")
    return Seconds(done.stdout.split()[-1])


def times(build: Sequence[tuple[str, float]], first: float, rest: Sequence[Any], peer: str) -> Any:
    """Rows of what is built once, their sum against the package's first call, and repeats."""
    total = Seconds(sum(t for _, t in build))
    rows: list[list[Any]] = [[name, t, None, None] for name, t in build]
    rows.append(["first call, all of the above", total, first, total / first])
    rows += [[name, theirs, ours, theirs / ours] for name, theirs, ours in rest]
    return table("times", ("quantity", peer, "package", "ratio"), rows)


def report(versions: Sequence[str], parts: Sequence[tuple[str, Callable[[], Any]]]) -> int:
    """Runs the parts, each of which may fail by itself, and prints what they found."""
    parser = argparse.ArgumentParser(
        description=sys.modules["__main__"].__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--json", action="store_true", help="the same as one JSON object")
    as_json = parser.parse_args().json
    if importlib.util.find_spec(versions[0]) is None:
        line = f"{PROPER.get(versions[0], versions[0])}: missing (pip install {versions[0]})"
        print(json.dumps({"missing": [line]}) if as_json else line)
        return 0
    found: dict[str, Any] = {"versions": {}, "tables": [], "failed": []}
    for name in versions:
        if importlib.util.find_spec(name):
            found["versions"][name] = importlib.metadata.version(name)
    for name, part in parts:
        try:
            found["tables"] += part()
        except Exception as error:  # the other parts still run; a failure has no number
            line = (str(error).splitlines() or ["no message"])[0]
            found["failed"].append(f"{name}: failed: {type(error).__name__}: {line}")
    if as_json:
        print(json.dumps(found, indent=1))
    else:
        print("versions: " + ", ".join(f"{n} {v}" for n, v in found["versions"].items()))
        for each in found["tables"]:
            show(each)
        print("".join(f"\n{line}" for line in found["failed"]), end="\n" * bool(found["failed"]))
    return 1 if found["failed"] else 0
