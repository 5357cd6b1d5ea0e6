"""Deep paths that the documents of version 0.4 showed: each still imports, and says where to."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

from stability.old_paths import MOVED

SHOWN = [
    ("stability.contact", "Viscous"), ("stability.equations", "disk_system"),
    ("stability.formulas", "formulas"), ("stability.completeness", "prove"),
    ("stability.outcome", "BY_CODE"), ("stability.plots", "diagram"), ("stability.plots", "save"),
    ("stability.pictures", "caption"), ("stability.pictures", "motion_figure"),
    ("stability.verdict", "Verdict"), ("stability.algebra", "numpy_algebra"),
    ("stability.slowflow", "derive_slow_flow"), ("stability.compare.cases", "CASES"),
    ("stability.compare.catalogue", "attempt"), ("stability.compare.routes", "AutomaticJacobian"),
    ("stability.compare.drivers", "Driver"),
]  # fmt: skip


@pytest.mark.parametrize(("module", "name"), SHOWN)
def test_an_old_path_hands_on_and_warns(module: str, name: str) -> None:
    old = importlib.import_module(module)
    with pytest.warns(DeprecationWarning, match=f"import {name} from stability"):
        value = getattr(old, name)
    assert getattr(value, "__name__", name) in (name, value.__name__ if callable(value) else name)


def test_every_old_path_is_shown_and_nothing_else_is_found() -> None:
    assert set(MOVED) <= {module for module, _ in SHOWN}
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("stability.nowhere")
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        importlib.import_module("stability.plots").nothing  # noqa: B018


def test_an_old_path_works_in_a_process_of_its_own() -> None:
    code = "from stability.plots import diagram; print(diagram.__module__)"
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True
    )
    assert done.stdout.strip() == "stability.figures.diagram", done.stderr
