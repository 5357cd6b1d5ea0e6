"""Cost against error; hard cases.

Compares routes to one answer on this machine, and shows where methods fail.
May import `figures`, `tables`, `export` and the floors below.
To add a route, a driver or a hard case: a class or a record, as `docs/explanation/compare.md` says.
The names for it are listed here.  Each name loads its module at first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOME = {
    "spectrum.routes": ("AutomaticJacobian", "Route"),
    "spectrum.cases": ("CASES", "Case"),
    "motion.drivers": ("Driver",),
    "failures": ("attempt",),
}
_WHERE = {name: module for module, names in _HOME.items() for name in names}

__all__ = sorted(_WHERE)  # noqa: PLE0605

if TYPE_CHECKING:
    from .failures import attempt as attempt
    from .motion.drivers import Driver as Driver
    from .spectrum.cases import CASES as CASES
    from .spectrum.cases import Case as Case
    from .spectrum.routes import AutomaticJacobian as AutomaticJacobian
    from .spectrum.routes import Route as Route


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'stability.compare' has no attribute {name!r}")
    return getattr(import_module(f".{_WHERE[name]}", __name__), name)
