"""The theorems by short name; every notebook of theorems shows its part of them."""

from __future__ import annotations

from collections.abc import Callable

from .disk.boundary_shape import boundary_shape
from .disk.case import disk_case
from .disk.dry_friction import dry_friction
from .disk.flutter import spinning_elliptic
from .disk.settling import settling
from .disk.tumbling import tumbling
from .painleve import painleve
from .pole.steady import steady_at_poles
from .pole.vertical import vertical_conservative, vertical_viscous
from .proof import Theorem
from .rolling import rolling_conservative, rolling_viscous
from .spinning import spinning_conservative, spinning_low, spinning_viscous
from .steady_motions import branches, rough_and_smooth, steady_motions
from .tumbling import energy_decides, surfaces_neutral, tumbling_static

BODIES: dict[str, Callable[[], Theorem]] = {
    "steady-motions": steady_motions,
    "steady-at-poles": steady_at_poles,
    "rough-smooth": rough_and_smooth,
    "branches": branches,
    "rolling-conservative": rolling_conservative,
    "rolling-viscous": rolling_viscous,
    "spinning-conservative": spinning_conservative,
    "spinning-viscous": spinning_viscous,
    "spinning-low": spinning_low,
    "vertical-conservative": vertical_conservative,
    "vertical-viscous": vertical_viscous,
    "tumbling-static": tumbling_static,
    "surfaces": surfaces_neutral,
    "energy": energy_decides,
    "painleve": painleve,
}
"""Functions that prove a theorem about every body."""
DISK: dict[str, Callable[[], Theorem]] = {
    "case": disk_case,
    "settling": settling,
    "spinning-elliptic": spinning_elliptic,
    "tumbling": tumbling,
    "tumbling-shape": boundary_shape,
    "dry-friction": dry_friction,
}
"""Functions that prove a theorem about the disk."""
