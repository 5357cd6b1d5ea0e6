"""A script without a guard is refused before any process starts."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

import stability as st
from stability.base.main_module import guarded_line

SCRIPT = """
import stability as st

AXES = {"x": ("at", 0.5, 4, 8), "y": ("mu", 0.1, 2, 6)}
LAUNCHES = {"contact": "viscous", "mu": 0.3, "horizon": 1.0,
            "x": ("theta", 1.2, 1.5, 2), "y": ("omega3", 1, 2, 2)}


def asked(executor):
    for call in (
        lambda: st.stability_map("rolling", **AXES, executor=executor),
        lambda: st.basins(**LAUNCHES, executor=executor),
    ):
        try:
            call()
        except st.StabilityError as error:
            print(error)


asked("processes")
asked("dask")
try:
    st.report("report", ["spectrum"])
except st.StabilityError as error:
    print(error)
print("at once")
if __name__ == "__main__":
    print(st.stability_map("rolling", **AXES, executor="processes", workers=1).verdict.size)
"""


def test_a_script_without_a_guard_gets_one_sentence_at_once(tmp_path: Path) -> None:
    """Seconds: two processes import the script and its libraries, one after the other."""
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    root = str(Path(st.__file__).parents[1])
    environment = os.environ | {"PYTHONPATH": root}
    begin = time.monotonic()
    done = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=100,
        check=True,
    )
    assert time.monotonic() - begin < 50  # far below the time in which workers must start
    assert done.stderr == ""
    said = done.stdout.splitlines()[:7]  # then those of the worker of the last call
    lines = [SCRIPT.splitlines().index(f'asked("{n}")') + 1 for n in ("processes", "dask")]
    asked = [("processes", lines[0])] * 2 + [("dask", lines[1])] * 2
    for text, (word, line) in zip(said[:4], asked, strict=True):
        assert text == (
            f'executor="{word}" starts processes, which import script.py and would come to line '
            f"{line} again; put that line under `if __name__ == '__main__':`."
        )
    assert said[4].startswith("the comparison starts processes, which import script.py")
    assert said[5] == "at once"
    assert "is itself one that has not started yet" in said[6]
    assert done.stdout.splitlines()[-1] == "48"


@pytest.mark.parametrize(
    ("source", "guarded"),
    [
        ("work()", False),
        ("if __name__ == '__main__':\n    work()  # here", True),
        ("if '__main__' == __name__ and fast:\n    for i in (1, 2):\n        work()  # here", True),
        ("if __name__ == '__main__':\n    pass\nwork()  # here", False),
        ("if __name__ != '__main__':\n    raise SystemExit\nwork()  # here", True),
        ("import sys\nif __name__ != '__main__':\n    sys.exit()\nwork()  # here", True),
        ("if parent_process() is None:\n    work()  # here", True),
        ("import multiprocessing as m\nif m.parent_process() is None:\n    work()  # here", True),
        ("match __name__:\n    case '__main__':\n        work()  # here", True),
        ("if fast:\n    work()  # here", False),
        ("name = __name__\nwork()  # here", False),
        ("def main():\n    if __name__ == '__main__':\n        pass\nmain()  # here", False),
    ],
)
def test_a_line_is_guarded_by_a_condition_on_who_runs_it(source: str, guarded: bool) -> None:
    lines = source.splitlines()
    line = next((i for i, text in enumerate(lines, 1) if "# here" in text), 1)
    assert guarded_line(ast.parse(source), line) == guarded
