"""A question about a family: what may vary, in which units, and what it comes to dimensionless.

Everything inside runs dimensionless; a `Problem` is the one place that knows how the numbers a
user gives (`at`, `k`, `mu`, `mass`, `radius`, `gravity`, or the parameters of their own system)
become the family's parameters.  It does so over any number type, so that balls start from the exact
doubles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import checked
from ..base.errors import NameUnknownError, NoMemberError, ParameterError, shown
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.disk_polynomials import Exact
from ..systems.family import Family


def _one(_: Mapping[str, Any]) -> float:
    return 1.0


@dataclass(frozen=True, eq=False)
class Problem:
    """A family with the values of everything it depends on, in the user's units."""

    family: Family
    """The family."""
    values: Mapping[str, Any]
    """Value or array by name: at (or its parts), parameters, physical quantities."""
    dimensionless: bool
    """Whether the user's numbers are dimensionless."""
    reduce: Callable[[Mapping[str, Any], Callable[[Any], Any]], tuple[list[Any], list[Any], Any]]
    """(values, square root) → family parameters, parameters, unit of rate; over any number type."""
    speed: Callable[[Mapping[str, Any]], Any] = _one
    """Unit of speed from the values."""
    roundings: tuple[int, ...] = ()
    """Roundings behind each of (family parameters, parameters) when they are made dimensionless."""
    law: Contact | None = None
    """The contact law, for the disk."""
    exact: Exact | None = None
    """The characteristic polynomial over Q, where it is known."""

    @property
    def names(self) -> tuple[str, ...]:
        """What may be an axis."""
        return tuple(self.values)

    def arrays(self, values: Mapping[str, Any]) -> tuple[Floats, Floats, Floats, tuple[int, ...]]:
        """Dimensionless rows for broadcast values.

        Parameters
        ----------
        values
            Value or array by name.

        Returns
        -------
        a, q, rate, shape
            Family parameters (N, ·), parameters (N, ·), unit of rate (N,), and the broadcast shape.
        """
        shape = broadcast_shape(values)
        with np.errstate(all="ignore"):
            a, q, rate = self.reduce(values, np.sqrt)
        flat = [np.broadcast_to(v, shape).reshape(-1) for v in (*a, *q, rate)]
        count = math.prod(shape)
        columns = np.column_stack(flat).astype(float).reshape(count, -1)
        cut = len(a)
        if not (np.isfinite(columns).all() and (columns[:, -1] > 0).all()):
            raise ParameterError(
                "the dimensionless numbers overflow double precision; give values nearer to 1."
            )
        return columns[:, :cut], columns[:, cut:-1], columns[:, -1], shape

    def balls(self, values: Mapping[str, Any]) -> tuple[list[Any], list[Any]]:
        """Family parameters and parameters as balls around the exact doubles.

        Parameters
        ----------
        values
            Double by name.

        Returns
        -------
        a, q
        """
        from flint import arb

        exact = {name: arb(float(v)) for name, v in values.items()}
        a, q, _ = self.reduce(exact, lambda v: v.sqrt())
        return a, q

    def point(
        self, given: Mapping[str, Any], sine: Callable[[Mapping[str, Any]], Any] | None
    ) -> list[Any] | None:
        """What the exact polynomial depends on, over any number type: k, M, z, s.

        Parameters
        ----------
        given
            Number by name, in the user's units.
        sine
            sinθ from these numbers, or None to have only what is rational in them.

        Returns
        -------
        list or None
            Values of `exact.variables`; None if sinθ is needed and neither given nor exactly 1.
        """
        assert self.exact is not None
        v = given
        length = v["radius"] / v["gravity"]
        found = {"k": v["k"], "M": 1}
        if "mu" in v:
            found["M"] = v["mu"] * v["mu"] * (v["gravity"] * v["radius"])
        elif "c" in v:
            drag = v["c"] / v["mass"]
            found["M"] = drag * drag * length
        turn = next((n for n in ("phi_dot", "at") if n in v), None)
        if turn and "z" in self.exact.variables:
            if turn == "phi_dot" and np.any(np.equal(v[turn], 0)):
                raise NoMemberError(
                    f"{self.family.name} has no member at phi_dot = 0; give another phi_dot."
                )
            found["z"] = v[turn] * v[turn] * length
        if "s" in self.exact.variables:
            named = dict(v) if "theta" in v or "lean" in v else dict(v) | {"theta": v["at"]}
            if sine is None and not ("lean" in v and v["lean"] == 0):
                return None
            found["s"] = 1 if sine is None else sine(named)
        return [found[n] for n in self.exact.variables]

    def scale(self, given: Mapping[str, Any]) -> tuple[Any, Any]:
        """Unit of the exact polynomial's variable in the user's unit of rate.

        Parameters
        ----------
        given
            As in `point`.

        Returns
        -------
        scale, square
            λ = σ · scale, with scale mu g or c/m; without friction that is None, and λ² = σ² ·
            square with square g/R.
        """
        if "mu" in given:
            return given["mu"] * given["gravity"], None
        if "c" in given:
            return given["c"] / given["mass"], None
        return None, given["gravity"] / given["radius"]


def broadcast_shape(values: Mapping[str, Any]) -> tuple[int, ...]:
    """The common shape of arrays.

    Parameters
    ----------
    values
        Value or array by name.

    Returns
    -------
    tuple of int

    Raises
    ------
    ParameterError
        If they do not broadcast.
    """
    shapes = {n: np.shape(v) for n, v in values.items() if np.shape(v)}
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        listed = ", ".join(f"{n} {s}" for n, s in shapes.items())
        raise ParameterError(
            f"the arrays do not broadcast: their shapes are {listed}; make them fit."
        ) from None


def system_problem(
    family: Family, at: ArrayLike | None, parameters: Mapping[str, ArrayLike]
) -> Problem:
    """The question about a family of a user's own system; numbers are taken as they are.

    Parameters
    ----------
    family
        The family.
    at
        Family parameter (last axis its parts, if there are several), or None where it is an axis.
    parameters
        The system's other parameters by name.

    Returns
    -------
    Problem

    Raises
    ------
    NameUnknownError
        If a parameter is missing or unknown.
    """
    for name in parameters:
        if at is not None and name in family.at:
            raise ParameterError(f"{name} is given as at and by name; give it once.")
        if name not in (*family.parameters, *family.at):
            raise NameUnknownError(
                f"{shown(name)} is not a parameter of {family.name}; known are "
                f"{', '.join((*family.parameters, *family.at)) or 'none'}."
            )
    values: dict[str, Any] = {n: checked(n, v) for n, v in parameters.items()}
    keys = family.at
    if at is not None:
        given = np.asarray(checked("at", at), dtype=float)
        if len(keys) > 1 and (given.ndim == 0 or given.shape[-1] != len(keys)):
            raise ParameterError(
                f"at has shape {given.shape}; for {family.name} its last axis must hold "
                f"{len(keys)} values ({', '.join(keys)})."
            )
        columns = [given] if len(keys) == 1 else list(np.moveaxis(given, -1, 0))
        values |= {key: _scalar(c) for key, c in zip(keys, columns, strict=True)}

    exact = (0,) * (len(family.at) + len(family.parameters))
    return Problem(family, values, False, partial(_reduce, family), roundings=exact)


def _reduce(
    family: Family,
    v: Mapping[str, Any],
    root: Callable[[Any], Any],  # noqa: ARG001
) -> tuple[list[Any], list[Any], Any]:
    missing = [n for n in (*family.at, *family.parameters) if n not in v]
    if missing:
        raise NameUnknownError(f"{shown(missing[0])} is missing; {family.name} needs its value.")
    return [v[k] for k in family.at], [v[n] for n in family.parameters], 1.0


def _scalar(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else value
