"""The command `boundaries`: every change of verdict along one axis."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

from ..base.errors import ParameterError
from ..base.quantities import behind
from .options import AXIS, CERTIFY, answer, axis_of, flags
from .subject import CommandSubject, add_subject, doubles, options_subject
from .terminal import waiting

EXAMPLES = (
    "stability boundaries spinning --axis at:0.1:5:9 --mu 0.97",
    "stability boundaries rolling --body spheroid --aspect 0.5 --axis omega3:0.1:3:9 "
    "--contact rough",
    "stability boundaries --system examples/bicycle.py:upright --axis v:0.1:10:50 --set g=9.81 "
    "--json",
)
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_subject(parser)
    axis = "axis, both ends included; N points are scanned where pieces of it stay without proof"
    parser.add_argument("--axis", required=True, metavar=AXIS, help=axis)
    parser.add_argument("--at", help="what names the member, where it is no axis")
    flags(parser, {"--certify": CERTIFY})


def run(options: argparse.Namespace) -> None:
    """Print every boundary, and whether these are all."""
    axis = axis_of(options.axis, "--axis")
    if options.certify:
        raise ParameterError("every boundary here is proved; leave --certify out.")
    with waiting("searching"):
        from ..boundary.changes import boundaries

        subject = options_subject(options, {axis[0]: axis}, exact=True)
        found = boundaries(subject.family, axis=axis, **subject.arguments)
    record: dict[str, Any] = {
        **subject.who,
        "parameters": doubles(subject.beyond((axis[0],))),
        **subject.member,
        "axis": axis[0],
        "low": axis[1],
        "high": axis[2],
        "boundaries": [
            {
                "value": b.value,
                "error": b.error,
                "crossing": b.crossing.word,
                "frequency": b.frequency,
                "frequencies": list(b.frequencies),
                "stable_below": b.stable_below,
                "good": b.good.word,
            }
            for b in found
        ],
        "touching": list(found.touching),
        "complete": found.complete,
        "unresolved": [u._asdict() for u in found.unresolved],
        "statement": found.statement(axis[0]),
        "citation": found.citation,
    }
    answer(options, record, _lines(subject, axis, found))


def _lines(subject: CommandSubject, axis: Sequence[Any], found: Any) -> Iterator[str]:
    from ..base.verdict import Verdict
    from ..tables.beyond_linear import to_bound

    name = subject.own_name(axis[0])
    unit = behind(subject.units.get(name, "1"))
    place = subject.place({**subject.at, **subject.beyond((axis[0], name))})
    where = f"{subject.title}, along {name} from {axis[1]:g} to {axis[2]:g}{unit}"
    yield where + f", at {place}" * bool(place)
    if subject.law:
        yield subject.law
    for b in found:
        side = "below" if b.stable_below else "above"
        word = "not unstable" if b.good is Verdict.UNDECIDED else b.good.word
        rates = b.frequencies or ((b.frequency,) if b.frequency else ())
        pair = ", ".join(f"{w:.12g}" for w in rates)
        several = "frequencies" if b.frequencies else "frequency"
        turning = f", {several} {pair}{behind(subject.rate)}" if pair else ""
        kind = b.crossing.word.replace("_", " ")
        yield f"  {name} = {to_bound(b.value, b.error)}{unit}   {kind}, {word} {side}{turning}"
    yield found.statement(name)
