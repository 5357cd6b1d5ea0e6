"""Reference values of tests/data, each file with its source."""

import json
from pathlib import Path
from typing import Any

DATA = Path(__file__).parents[1] / "data"


def spectra() -> list[dict[str, Any]]:
    """The sixteen spectra to 25 digits."""
    found: list[dict[str, Any]] = json.loads((DATA / "spectra.json").read_text())["spectra"]
    return found


def beyond() -> dict[str, Any]:
    """The independent derivation of slow drift and of flutter on lines of steady motions."""
    found: dict[str, Any] = json.loads((DATA / "beyond.json").read_text())
    return found


def trajectories() -> list[dict[str, Any]]:
    """Five motions from an inertial-frame quaternion formulation, 12 digits."""
    found: list[dict[str, Any]] = json.loads((DATA / "trajectories.json").read_text())["motions"]
    return found


def coulomb() -> list[dict[str, Any]]:
    """Motions with dry friction from an inertial formulation, each with its error estimate."""
    found: list[dict[str, Any]] = json.loads((DATA / "coulomb.json").read_text())["scenes"]
    return found


def corners() -> list[dict[str, Any]]:
    """States at rest from which dry friction has more than one continuation, or none."""
    found: list[dict[str, Any]] = json.loads((DATA / "coulomb_corners.json").read_text())["states"]
    return found


def closed() -> dict[str, Any]:
    """Rough and smooth motions by quadrature of their integrals, 20 digits."""
    found: dict[str, Any] = json.loads((DATA / "closed.json").read_text())["motions"]
    return found
