"""Modules that the documents of version 0.4 name: each still imports, and its names warn."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

MOVED = {
    "stability.contact": (
        "bodies.contact_laws",
        "bodies.dry_friction",
        "bodies.contact",
        "bodies.law_names",
    ),
    "stability.equations": ("bodies.thin_disk.disk_equations",),
    "stability.slowflow": ("derivation.centre_manifold",),
    "stability.formulas": ("derivation.formulas",),
    "stability.completeness": ("derivation.completeness",),
    "stability.outcome": ("motion.result",),
    "stability.plots": ("figures.diagram", "figures.canvas"),
    "stability.pictures": ("figures.launch.motion", "figures.launch.caption"),
    "stability.verdict": ("base.verdict",),
    "stability.compare.cases": ("compare.spectrum.cases",),
    "stability.compare.catalogue": ("compare.failures",),
    "stability.compare.routes": (
        "compare.spectrum.routes.jacobians",
        "compare.spectrum.routes.route",
    ),
    "stability.compare.drivers": ("compare.motion.drivers",),
}
"""New modules with the names of each old module."""


def found(name: str, old: str, places: Sequence[str]) -> Any:
    """A name of an old module, from the first new one that has it.

    Parameters
    ----------
    name
        Name to find.
    old
        Name of the old module.
    places
        Names of the new modules, within the package.
    """
    if name.startswith("__"):  # Python and its tools ask every module for these
        raise AttributeError(name)
    for place in places:
        value = getattr(import_module(f"stability.{place}"), name, None)
        if value is not None:
            warnings.warn(
                f"{old} has moved and goes in version 0.6; import {name} from stability.{place}.",
                DeprecationWarning,
                stacklevel=3,
            )
            return value
    raise AttributeError(f"module {old!r} has no attribute {name!r}")


class _Loader:
    # no base class: importlib.abc would triple the time that importing the package takes
    def create_module(self, spec: ModuleSpec) -> ModuleType | None:  # noqa: ARG002
        return None  # Python then makes an empty module

    def exec_module(self, module: ModuleType) -> None:
        old = module.__name__

        def hand_on(name: str) -> Any:
            return found(name, old, MOVED[old])

        module.__getattr__ = hand_on  # type: ignore[method-assign]


_LOADER: Any = _Loader()


class Finder:
    """Finder of the old modules, which have no files."""

    def find_spec(self, fullname: str, *_: Any) -> ModuleSpec | None:
        """An empty module for an old path; None for every other."""
        return ModuleSpec(fullname, _LOADER) if fullname in MOVED else None


def install() -> None:
    """Add the finder as the last that Python asks."""
    if not any(isinstance(finder, Finder) for finder in sys.meta_path):
        sys.meta_path.append(Finder())
