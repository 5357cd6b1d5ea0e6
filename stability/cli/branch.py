"""The command `branch`: a family followed round its folds, and where others cross it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from ..base.errors import ParameterError
from ..base.quantities import behind
from ..base.types import Floats
from .options import AXIS, answer, axis_of, flags
from .subject import CommandSubject, add_numbers, doubles, options_subject, require
from .terminal import waiting

EXAMPLES = (
    "stability branch --system examples/watt_governor.py:running --axis e:0.5:3:51 --set a=0.5 "
    "--set b=0.5",
    "stability branch --system examples/watt_governor.py:running --axis e:0.5:3:51 --set a=0.5 "
    "--set b=0.5 --arclength --json",
)
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    text = "the family: module:name, or file.py:name"
    parser.add_argument("--system", metavar="MODULE:FAMILY", required=True, help=text)
    axis = "the first number of the family's `at`: where to start, where to stop, how many members"
    parser.add_argument("--axis", required=True, metavar=AXIS.removesuffix("[:log]"), help=axis)
    add_numbers(parser, "a number by name; once for each")
    flags(parser, {"--arclength": "go round folds"})
    parser.set_defaults(family=None, body=None, at=None)  # what is followed is a user's family


def run(options: argparse.Namespace) -> None:
    """Print the ends of the branch, its folds, and the points where others cross it."""
    name, start, stop, points, *spacing = axis = axis_of(options.axis, "--axis")
    if spacing:
        raise ParameterError(f"--axis is {options.axis}; members are evenly spaced, give no log.")
    subject = options_subject(options, {name: axis})
    family = subject.family
    if name != family.at[0]:
        raise ParameterError(
            f"--axis names {name}; {family.name} is followed along {family.at[0]}."
        )
    require(subject.numbers, [n for n in (*family.at, *family.parameters) if n != name])
    with waiting("following"):
        from ..systems.continuation import branch

        numbers = doubles(subject.numbers)
        curve = branch(family, start, stop, points=points, arclength=options.arclength, **numbers)
    ends = [{"at": float(curve.at[i]), **_state(family, curve.state[i])} for i in (0, -1)]
    record = {
        **subject.who,
        "parameters": numbers,
        "axis": name,
        "members": len(curve.at),
        "first": ends[0],
        "last": ends[1],
        "complete": curve.complete,
        "ended": curve.ended,
        "folds": [{"value": p.value, **_state(family, p.state)} for p in curve.folds],
        "branch_points": [
            {"value": p.value, "kind": p.kind, **_state(family, p.state)}
            for p in curve.branch_points
        ],
        "citation": curve.citation,
    }
    answer(options, record, _lines(subject, name, record))


def _state(family: Any, state: Floats) -> dict[str, Any]:
    return {"states": dict(zip(family.system.states, map(float, state), strict=True))}


def _lines(subject: CommandSubject, name: str, record: dict[str, Any]) -> Iterator[str]:
    def place(value: float, states: dict[str, float]) -> str:
        numbers = {name: value, **states}
        units = (behind(subject.units.get(n, "1")) for n in numbers)
        return ", ".join(
            f"{n} = {v:.12g}{u}" for (n, v), u in zip(numbers.items(), units, strict=True)
        )

    beyond = subject.place(record["parameters"])
    yield f"{subject.title}, along {name}" + f", at {beyond}" * bool(beyond)
    yield f"first   {place(record['first']['at'], record['first']['states'])}"
    points = [("fold", p) for p in record["folds"]]
    points += [(p["kind"], p) for p in record["branch_points"]]
    for word, point in points:
        yield f"{word}   {place(point['value'], point['states'])}"
    yield f"last    {place(record['last']['at'], record['last']['states'])}"
    yield f"{record['members']} members; {record['ended']}"
    if not points:
        yield "no fold, and no other branch crosses between two members"
