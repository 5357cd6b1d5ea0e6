"""Stability of steady motions: which can be seen, for which parameters, and how do we know.

The public names are listed in `__all__`; each loads its module when it is first used, so that
importing the package costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.4.0"

_HOME = {
    "disk": ("Disk", "REAL_DISKS"),
    "contact": ("Smooth", "Viscous", "LinearViscous", "Rough", "Coulomb", "RegularisedCoulomb"),
    "system": ("System", "Condition"),
    "algebra": ("UPRIGHT",),
    "families": ("Family",),
    "steady": ("disk_family",),
    "equations": ("disk_system",),
    "continuation": ("branch", "Branch"),
    "query": ("spectrum",),
    "spectra": ("Spectrum",),
    "verdict": ("Verdict", "Nonlinear"),
    "crossings": ("BoundaryPoint", "Crossing", "Boundaries", "Unresolved"),
    "maps": ("stability_map", "boundaries"),
    "files": ("read_map", "write_map"),
    "stream": ("stream_map",),
    "exact": ("exact_polynomial", "Exact"),
    "passage": ("drift", "Drift"),
    "lines": ("hopf", "HopfPoint", "HopfKind"),
    "motion": ("simulate",),
    "survey": ("launch",),
    "animation": ("animate",),
    "outcome": ("Outcome",),
    "records": ("read_motion", "write_motion"),
    "compare.report": ("report",),
    "errors": ("StabilityError", "StabilityWarning"),
}
_WHERE = {name: module for module, names in _HOME.items() for name in names}

__all__ = sorted(_WHERE)  # noqa: PLE0605

if TYPE_CHECKING:
    from .algebra import UPRIGHT as UPRIGHT
    from .animation import animate as animate
    from .compare.report import report as report
    from .contact import Coulomb as Coulomb
    from .contact import LinearViscous as LinearViscous
    from .contact import RegularisedCoulomb as RegularisedCoulomb
    from .contact import Rough as Rough
    from .contact import Smooth as Smooth
    from .contact import Viscous as Viscous
    from .continuation import Branch as Branch
    from .continuation import branch as branch
    from .crossings import Boundaries as Boundaries
    from .crossings import BoundaryPoint as BoundaryPoint
    from .crossings import Crossing as Crossing
    from .crossings import Unresolved as Unresolved
    from .disk import REAL_DISKS as REAL_DISKS
    from .disk import Disk as Disk
    from .equations import disk_system as disk_system
    from .errors import StabilityError as StabilityError
    from .errors import StabilityWarning as StabilityWarning
    from .exact import Exact as Exact
    from .exact import exact_polynomial as exact_polynomial
    from .families import Family as Family
    from .files import read_map as read_map
    from .files import write_map as write_map
    from .lines import HopfKind as HopfKind
    from .lines import HopfPoint as HopfPoint
    from .lines import hopf as hopf
    from .maps import boundaries as boundaries
    from .maps import stability_map as stability_map
    from .motion import simulate as simulate
    from .outcome import Outcome as Outcome
    from .passage import Drift as Drift
    from .passage import drift as drift
    from .query import spectrum as spectrum
    from .records import read_motion as read_motion
    from .records import write_motion as write_motion
    from .spectra import Spectrum as Spectrum
    from .steady import disk_family as disk_family
    from .stream import stream_map as stream_map
    from .survey import launch as launch
    from .system import Condition as Condition
    from .system import System as System
    from .verdict import Nonlinear as Nonlinear
    from .verdict import Verdict as Verdict


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'stability' has no attribute {name!r}")
    value = getattr(import_module(f".{_WHERE[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_WHERE])
