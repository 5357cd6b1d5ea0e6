"""The thin disk to the last digit: its numbers and exact data.

Run as a script with an older version on PYTHONPATH, it writes tests/data/disk_bits.json; that file
is of commit b9451fe, the last of version 0.4.0 before there were other bodies.
"""

from __future__ import annotations

import hashlib
import json
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

import stability as st

PLACE = Path(__file__).parents[1] / "data" / "disk_bits.json"
STATE, NUMBERS = [1.1, 0.3, -0.7, 1.3, 0.2, -0.4], [0.3, 0.45]
LAWS = ("smooth", "viscous", "linear-viscous", "rough", "coulomb", "coulomb-regularised")
POLYNOMIALS = ("bodies", "disk_polynomials.json")


def _bits(values: Any) -> list[str]:
    found = np.atleast_1d(values).ravel()
    if np.iscomplexobj(found):
        found = found.view(float)
    return [float(v).hex() for v in found]


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def data() -> str:
    """Digest of the exact polynomials."""
    place = files("stability").joinpath(*POLYNOMIALS)
    return _digest(place.read_bytes())


def numbers() -> dict[str, Any]:
    """Rates, spectra, boundaries, motions and a map, as the hexadecimal digits of doubles."""
    found: dict[str, Any] = {}
    for law in LAWS[:4]:
        system = st.disk_system(law)
        x, p = STATE[: len(system.states)], NUMBERS[: len(system.parameters)]
        found[f"rates {law}"] = _bits(system.rates(x, p))
        found[f"slopes {law}"] = _bits(system.linearise(x, p))
    for family, at, mu in (
        ("rolling", 1.7, 0.3),
        ("spinning", 2.9, 0.6),
        ("tumbling", 0.8, 0.4),
        ("tumbling", 1.2, 2),
        ("circling", (0.9, 1.3), 1),
        ("precession", (0.9, 1.3), 1),
    ):
        laws = {"circling": [st.Rough()], "precession": [st.Smooth()]}.get(
            family, [st.Viscous(mu), st.LinearViscous(mu), st.Smooth(), st.Rough()]
        )
        for law in laws:
            one = st.spectrum(family, at=at, disk=st.Disk(k=0.3), contact=law)
            found[f"{family} {at} {law.name}"] = [
                *_bits(one.eigenvalues),
                *_bits(one.states),
                one.verdict.word,
            ]
    coin = st.Disk(k=0.25, mass=0.02, radius=0.1, gravity=9.81)
    one = st.spectrum("rolling", at=12.0, disk=coin, contact=st.Viscous(0.3))
    found["rolling in SI"] = _bits(one.eigenvalues)
    for family, low, high, mu in (
        ("rolling", 0.1, 6.0, 0.3),
        ("spinning", 0.1, 9.0, 0.7),
        ("tumbling", 0.05, 1.5, 1.2),
    ):
        edges = st.boundaries(family, axis=("at", low, high, 60), contact=st.Viscous(mu))
        found[f"boundaries {family}"] = [
            [b.value.hex(), b.error.hex(), b.stable_below] for b in edges
        ]
    for law in (st.Viscous(0.3), st.Rough()):
        start = {"theta": 1.2, "phi_dot": 0.5, "omega3": 1.1}
        run = st.simulate(
            st.Disk(k=0.3),
            law,
            start,
            [0.0, 1.0, 5.0],
            method="dop853",
            tolerance=1e-12,
            check=False,
        )
        names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
        found[f"motion {law.name}"] = _bits([float(run[n][-1]) for n in names])
    found["map"] = _digest(
        np.ascontiguousarray(
            st.stability_map(
                "tumbling",
                x=("theta", 0.1, 1.5, 40),
                y=("mu", 0.1, 2, 30),
                disk=st.Disk(k=0.3),
                contact=st.Viscous,
            ).verdict.values
        ).tobytes()
    )
    return found


def everything() -> dict[str, Any]:
    """All of it."""
    return {"data": data(), "numbers": numbers()}


if __name__ == "__main__":
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else PLACE
    place.write_text(
        json.dumps({"source": "commit b9451fe, version 0.4.0"} | everything(), indent=1)
    )
