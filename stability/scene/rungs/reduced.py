"""A user's reduced model as a rung: its error is its defect in the full model, carried along."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...base.checks import instance, real_numbers
from ...base.errors import ParameterError, shown
from ...base.types import Floats, Record, fields_of
from ...bodies.model import system_model
from ...integrators.flow import Flow, flow_of
from ...integrators.leg import Leg
from ...integrators.selection import dense
from ...systems.system import System
from .elements import Elements, carried
from .track import LaunchProblem, Refused, Track, relative

POINTS, STEPS = 14, 5
"""Points of an element, and steps of the integrator in it."""
GROWTH = 3.0
"""Exponent of growth within an element above which collocation does not carry an error."""
DOUBT = 0.5
"""Error, over 1 or the size of the state, above which a linear estimate of it says nothing."""


@dataclass(frozen=True, eq=False)
class ReducedModel(Record):
    """A model with fewer states than the full one, and the maps between their states.

    Parameters
    ----------
    name
        Name of the rung.
    system
        Its equations.
    down
        Function of (full states, full parameters) → (states, parameters) of this system, arrays.
    up
        Function of (states, parameters) of this system → full states, along the last axis.

    Raises
    ------
    ParameterError
        If the name is empty, or `down` or `up` is not a function.

    Source: docs/explanation/scenes.md; tests/scene/test_reduced_model.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> slow = st.System("slow", x, p, -p * x, states=("x",), parameters=("rate",))
    >>> st.results.ReducedModel("slow", slow, lambda x, p: (x[:1], p[:1]), lambda x, p: x).name
    'slow'
    """

    name: str
    """Name of the rung."""
    system: System
    """Its equations."""
    down: Callable[[Floats, Floats], tuple[Any, Any]]
    """Full states and parameters → states and parameters of this system."""
    up: Callable[[Floats, Floats], Any]
    """States, shape (…, n), and parameters of this system → full states, shape (…, s)."""

    __getstate__ = fields_of

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and self.name.strip() and self.name.isprintable()):
            raise ParameterError(f"the name of a reduced model is {shown(self.name)}; give a word.")
        instance("system", self.system, System, "give a stability.System")
        for word in ("down", "up"):
            if not callable(getattr(self, word)):
                raise ParameterError(
                    f"{word} is {shown(getattr(self, word))}; give a function of states and "
                    "parameters."
                )

    @cached_property
    def flow(self) -> Flow:
        """The system as a flow."""
        return flow_of(system_model(self.system))


def reduced(problem: LaunchProblem, model: ReducedModel) -> Track | Refused:
    """The track of a reduced model."""
    image = model.down(problem.start.copy(), problem.p.copy())  # a map may write into them
    if not isinstance(image, (tuple, list)) or len(image) != 2:
        raise ParameterError(
            f"down of {model.name} gives {shown(image)}; give the pair (states, parameters)."
        )
    x, p = (real_numbers(f"down of {model.name}", v) for v in image)
    flow = model.flow
    if x.shape != (len(model.system.states),) or p.shape != (len(model.system.parameters),):
        raise ParameterError(
            f"down of {model.name} gives shapes {x.shape} and {p.shape}; give "
            f"{len(model.system.states)} states and {len(model.system.parameters)} parameters."
        )
    span = np.array([0.0, problem.last])
    leg = Leg(flow, p, flow.pack(x), span, 1e-13, 1_000_000, problem.max_seconds)
    run = dense(leg)
    if not run.whole:
        return Refused(f"{model.name} ends before the horizon")
    edges = np.append(run.steps[:-1:STEPS], run.steps[-1])
    elements = Elements(edges, POINTS)
    count = len(model.system.states)

    def lifted(states: Floats) -> Floats:
        full = real_numbers(f"up of {model.name}", model.up(states[..., :count].copy(), p.copy()))
        if full.shape != (*states.shape[:-1], len(problem.start)):
            raise ParameterError(
                f"up of {model.name} gives shape {full.shape}; give {len(problem.start)} states "
                "along the last axis."
            )
        if not np.isfinite(full).all():
            raise ParameterError(f"up of {model.name} gives NaN or infinite states.")
        return full

    many = run.at(elements.times.ravel()).reshape(*elements.times.shape, -1)
    states = lifted(many)
    errors, growth = _errors(problem, elements, states)
    if growth > GROWTH:
        return Refused(
            f"the full model leaves {model.name} by a factor e^{growth:.3g} within an element"
        )
    if not np.isfinite(errors).all() or relative(errors, states).max() > DOUBT:
        return Refused(f"the defect of {model.name} grows beyond any linear estimate")
    size = relative(errors, states)
    if not problem.stands(states):
        return Refused("a condition of the full system fails on the way")
    tail = float(elements.tails(states).max())

    def at(asked: Floats) -> Floats:
        return elements.at(asked, states)

    times = problem.times
    return Track(
        times,
        at(times),
        elements.at(times, size[..., None])[:, 0] + tail,
        at,
        None,
        len(run.steps),
        (f"{model.name}, {count} state{'s' * (count > 1)}",),
        {"defect": float(size.max())},
    )


def _errors(problem: LaunchProblem, elements: Elements, states: Floats) -> tuple[Floats, float]:
    """The deviation of the full model from a path, and its largest growth in an element.

    The deviation is the defect of the path, carried by the linear equation along it.  Collocation
    damps a part that grows fast within an element, so such a path is refused.
    """
    n = problem.own
    flat = states.reshape(-1, states.shape[-1])[:, :n]
    many = np.broadcast_to(problem.p, (len(flat), len(problem.p)))
    system = problem.flow.system
    rates = system.rates(flat, many).reshape(*states.shape[:-1], n)
    slope = system.linearise(flat, many).reshape(*states.shape[:-1], n, n)
    defect = rates - elements.derivative(states[..., :n])
    errors = np.zeros(states.shape)
    errors[..., :n] = carried(elements, slope, defect, problem.start[:n] - states[0, 0, :n])
    growth = np.linalg.eigvals(slope).real.max(axis=(1, 2)) * elements.lengths
    return errors, float(growth.max())
