"""heyoka is imported without SymPy, and its exchange with SymPy still works."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("heyoka")

AFTER = """
import sys
import stability as st
run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.8}, 5.0, method="heyoka")
assert run.attrs["outcome"] == "moving"
print("sympy" in sys.modules)
"""
EXCHANGE = """
import heyoka as hy
import sympy
x, y = hy.make_vars("x", "y")
for made in (hy.sin(x) * y + hy.par[0] / 3.0, hy.kepE(x, y) + hy.erf(x) - hy.atan2(y, x) ** 2):
    there = hy.to_sympy(made)
    assert isinstance(there, sympy.Expr)
    print(there)
print(hy.from_sympy(sympy.cos(sympy.Symbol("x")) + 1))
print(type(sympy.Symbol).__module__, sympy.factor(sympy.Symbol("x") ** 2 - 1))
"""


def _printed(code: str, **names: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | names,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.long
def test_a_motion_does_not_import_sympy() -> None:
    assert _printed(AFTER) == "False\n"


def test_the_clock_of_a_progress_bar_keeps_the_import_without_sympy() -> None:
    code = """
import io, sys
from stability.algebra.number_types import heyoka
from stability.cli.terminal import waiting
class Terminal(io.StringIO):
    def isatty(self): return True
sys.stderr = Terminal()
with waiting():
    heyoka()
print("sympy" in sys.modules)
"""
    assert _printed(code) == "False\n"


@pytest.mark.long
def test_heyoka_and_sympy_exchange_expressions_as_after_a_plain_import() -> None:
    lazily = "from stability.algebra.number_types import heyoka\nheyoka()\n" + EXCHANGE
    assert _printed(lazily) == _printed(EXCHANGE)


@pytest.mark.long
def test_a_thread_of_the_caller_keeps_the_plain_import() -> None:
    code = """
import sys, threading
from stability.algebra.number_types import heyoka
stop = threading.Event()
thread = threading.Thread(target=stop.wait)
thread.start()
heyoka()
stop.set()
print("sympy" in sys.modules)
"""
    assert _printed(code) == "True\n"


def test_machine_code_is_kept_in_a_small_file_of_the_package(tmp_path: Path) -> None:
    read = "state = heyoka().llvm_state\nprint(state.get_diskcache_path())\n"
    ours = "from stability.algebra.number_types import heyoka\n" + read
    size = "print(state.get_diskcache_limit() == 2**26)"
    assert _printed(ours + size, HEYOKA_CACHE_DIR=str(tmp_path)) == f"{tmp_path}/stability\nTrue\n"
    users = _printed("import heyoka as _\n" + ours, HEYOKA_CACHE_DIR=str(tmp_path))
    assert users == f"{tmp_path}\n"


@pytest.mark.parametrize("home", ["", "/dev/null"])
def test_a_motion_needs_no_folder_for_machine_code(home: str) -> None:
    names = {"HOME": home, "HEYOKA_CACHE_DIR": home, "XDG_CACHE_HOME": ""}
    assert _printed(AFTER, **names) == "False\n"
