"""Kernels compile once for all processes, run without Numba, and need no folder."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stability.algebra.kernels import compiled as module
from stability.algebra.kernels.compiled import code, folder, from_text

TEXT = """
import numpy as np
HALF = 0.5
def half(x):
    return HALF * x
def root(x):
    return np.sqrt(half(x))
"""
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")


def in_another_process(body: str, cache: Path, **more: str) -> str:
    head = f"from stability.algebra.kernels.compiled import from_text\nTEXT = {TEXT!r}\n"
    where = os.environ | {"STABILITY_CACHE_DIR": str(cache)} | more
    done = subprocess.run(
        [sys.executable, "-c", head + body], env=where, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


ROOT = "k = from_text(TEXT, 'doubled'); k.root(8.0)\n"
HITS = ROOT + "s = k.root.stats; print(len(s.cache_hits), len(s.cache_misses))"


@pytest.mark.long
@needs_numba
def test_a_second_process_compiles_nothing(tmp_path: Path) -> None:
    assert in_another_process(HITS, tmp_path) == "0 1"
    assert in_another_process(HITS, tmp_path) == "1 0"
    edited = "TEXT = TEXT.replace('0.5', '0.25')\n" + HITS
    assert in_another_process(edited, tmp_path) == "0 1"


@pytest.mark.long
@needs_numba
def test_where_no_folder_can_be_written_each_process_compiles_in_memory(tmp_path: Path) -> None:
    blocked = tmp_path / "a_file"
    blocked.write_text("")  # a folder cannot be made below a file, whoever runs this
    more = {name: str(blocked) for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR")}
    assert in_another_process(ROOT + "print(k.root(8.0))", blocked, **more) == "2.0"
    assert in_another_process(HITS, blocked, **more) == "0 1"
    assert in_another_process(HITS, blocked, **more) == "0 1"


def test_without_numba_the_same_text_runs_on_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "numba_found", lambda: False)
    found = from_text(TEXT, "doubled")
    assert found.root(np.array([8.0, 32.0])).tolist() == [2.0, 4.0]
    assert not hasattr(found.root, "py_func")


def test_importing_the_package_does_not_import_numba() -> None:
    said = "import sys, stability.algebra.kernels.compiled; print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_comments_and_docstrings_do_not_change_the_text(monkeypatch: pytest.MonkeyPatch) -> None:
    def text(source: str) -> str:
        monkeypatch.setattr(module.inspect, "getsource", lambda _: source)
        return code(SimpleNamespace())  # type: ignore[arg-type]

    plain = text("from .a import b\n\nA = 2\n\ndef f(x):\n    return x + A\n")
    told = '"""D."""\nA = 2\ndef f(x: int) -> int:\n    """D."""\n    return x + A  # why\n'
    assert text(told) == plain
    assert text("A = 2\ndef f(x):\n    return x - A\n") != plain
    assert "import" not in plain


@pytest.mark.parametrize("names", [("STABILITY_CACHE_DIR",), ("XDG_CACHE_HOME",)])
def test_the_folder_follows_the_environment(
    names: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("STABILITY_CACHE_DIR", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv(names[0], str(tmp_path))
    assert folder().is_relative_to(tmp_path)
