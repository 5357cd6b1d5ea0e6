"""Launches of what moves: a disk, another body, or a user's system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import ArrayLike

from ..base.errors import ParameterError, shown
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..systems.sources.numeric import NumericSystem
from ..systems.system import System
from .round_starts import gather_round
from .starts import Starts
from .system_starts import gather_system

Moving = Disk | Body | System
"""What moves."""


def moving(first: Any, body: Any = None) -> Moving:
    """What moves: the first argument of a call, or `body`, or else the uniform disk.

    Parameters
    ----------
    first, body
        As for `simulate`.

    Raises
    ------
    ParameterError
        If both are given, or it is none.
    """
    if body is not None:
        if first is not None:
            raise ParameterError("body is given, and disk too; give one of them.")
        if not isinstance(body, (Body, Disk)):
            raise ParameterError(
                f"body is {shown(body)}; give a stability.Body or a stability.Disk."
            )
        return body
    if isinstance(first, NumericSystem):
        raise ParameterError(first.no_graph)
    if first is not None and not isinstance(first, (Disk, Body, System)):
        raise ParameterError(f"disk is {shown(first)}; give a stability.Disk, a Body or a System.")
    return Disk() if first is None else first


def launches_of(
    thing: Moving,
    contact: Any,
    start: Any,
    times: ArrayLike,
    *,
    families: Any = (),
    resistance: Any = None,
    pose: bool = False,
    mark: bool = False,
) -> Starts:
    """The launches of a call, checked and dimensionless.

    Parameters
    ----------
    thing
        What moves.
    contact, start, times, families, resistance, pose
        As for `simulate`.
    mark
        Whether a start that does not exist is marked, in place of an error.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.
    """
    if isinstance(thing, System):
        if resistance is not None:
            raise ParameterError(
                "resistance belongs to a disk or a body; put it into the equations of a system."
            )
        if pose:
            raise ParameterError("pose is True, and only a disk has one; leave it out.")
        return gather_system(thing, contact, start, times, families, mark=mark)
    if not isinstance(families, Sequence) or families:
        raise ParameterError("families belong to a stability.System; leave them out.")
    return gather_round(thing, contact, start, times, resistance=resistance, pose=pose, mark=mark)
