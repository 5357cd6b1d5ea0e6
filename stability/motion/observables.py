"""Observables along a path."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..algebra.program import Program
from ..base.errors import DomainError
from ..base.types import Floats
from ..bodies.model import Model
from ..bodies.thin_disk.disk_model import disk_model
from ..integrators.stick_slip import REST, STICKING
from .starts import Starts

ENERGY_ERROR = (
    "largest |audit| over the energy at the start",
    "largest |audit| over the largest sum of |x dE/dx| of the states, or the energy lost",
)
"""Definition of the energy error: of a disk, of a user's system."""


@lru_cache(maxsize=64)
def _observer(model: Model) -> Program:
    """Program of every series from states and parameters."""
    system, values = model.system, list(model.series.values())
    return Program(ca.Function("observer", [system.x, system.p], [ca.densify(ca.vertcat(*values))]))


@lru_cache(maxsize=64)
def _slopes(model: Model) -> Program:
    system = model.system
    slopes = ca.densify(ca.jacobian(model.series["energy"], system.x)).T
    return Program(ca.Function("slopes", [system.x, system.p], [slopes]))


def _energy_slopes(model: Model, states: Floats, p: Floats) -> Floats:
    """Gradient of the energy, shape (…, n)."""
    x, q = list(np.moveaxis(states, -1, 0)), list(np.moveaxis(p, -1, 0))
    return np.asarray(_slopes(model).arrays([x, q], states.shape[:-1])[0][..., 0])


def observe(
    model: Model, states: Floats, p: Floats, modes: Floats | None = None,
    heading: Floats | None = None,
) -> dict[str, Floats]:  # fmt: skip
    """The observables of states.

    Parameters
    ----------
    model
        Model of the body or system.
    states
        Entries of y, of which those of the system's states count, shape (…, n).
    p
        Parameters of the system, shape (…, m).
    modes
        Sliding or sticking, shape (…), for dry friction.
    heading
        Direction of the slip where it is zero but sets in, shape (…) [rad].

    Returns
    -------
    dict
        Arrays of shape (…) by name.
    """
    if not model.series:
        return {}
    if heading is not None:
        still = np.hypot(states[..., 4], states[..., 5]) < REST
        states = states.copy()
        states[still, 4] = REST * np.cos(heading[still])
        states[still, 5] = REST * np.sin(heading[still])
    own = len(model.system.states)
    x, q = list(np.moveaxis(states[..., :own], -1, 0)), list(np.moveaxis(p, -1, 0))
    values = _observer(model).arrays([x, q], states.shape[:-1])[0][..., 0]
    if modes is not None and (modes == STICKING).any():
        sticking = modes == STICKING
        held = [list(np.moveaxis(states[sticking][:, :4], -1, 0)),
                [np.broadcast_to(p[..., 0], modes.shape)[sticking]]]  # fmt: skip
        rough = _observer(disk_model("rough"))
        values[sticking] = rough.arrays(held, (int(sticking.sum()),))[0][..., 0]
    return dict(zip(model.series, np.moveaxis(values, -1, 0), strict=True))


def require_values(system: str, found: dict[str, Floats]) -> None:
    """Refuse an observable that has no value at a sample.

    Parameters
    ----------
    system
        Name of the system.
    found
        Series by name.
    """
    for name, values in found.items():
        if not np.isfinite(values).all():
            raise DomainError(
                f"{system}: {name} has no value somewhere on the way; give the system a condition "
                "that ends the run before, or leave the observable out."
            )


def account(launches: Starts, y: Floats, series: dict[str, Floats]) -> Floats:
    """Error of the energy account of each launch, over a measure of the energy.

    For the disk the measure is the energy at the start, which is positive.  The energy of a user's
    system may have any zero: there the measure is the largest Σ |x ∂E/∂x| or energy lost.

    Parameters
    ----------
    launches
        Launches with an energy account.
    y
        Entries of y, shape (N, t, n).
    series
        Series by name in the user's units, shape (N, t).

    Returns
    -------
    ndarray
        Shape (N,).
    """
    audit = np.abs(series["audit"]).max(axis=-1)
    if launches.law is not None:
        scale = launches.energies * launches.scales["energy"]
    else:
        x = y[..., : len(launches.model.states)]
        share = np.abs(x * _energy_slopes(launches.model, x, launches.p[:, None, :])).sum(axis=-1)
        scale = np.maximum(share, np.abs(series["dissipated"])).max(axis=-1)
        scale = np.where(scale > 0, scale, 1.0)
    return np.asarray(audit / scale)
