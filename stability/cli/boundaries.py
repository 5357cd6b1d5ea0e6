"""The command `boundaries`: every change of verdict along one axis, or every crossing."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

from ..base.errors import ParameterError
from ..base.printing import in_brackets
from ..base.quantities import behind
from .options import AXIS, CERTIFY, FORMS, answer, axis_of, check_form, flags
from .subject import CommandSubject, add_subject, doubles, options_subject
from .terminal import waiting

EXAMPLES = (
    "stability boundaries spinning --axis at:0.1:5:9 --mu 0.97",
    "stability boundaries rolling --body spheroid --aspect 0.5 --axis omega3:0.1:3:9 "
    "--contact rough",
    "stability boundaries rolling --axis at:0.1:5:9 --mu 1 --every",
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
    every = "list each crossing of the imaginary axis, with the number of unstable eigenvalues"
    flags(parser, {"--every": f"{every} on both sides", "--certify": CERTIFY, **FORMS})


def run(options: argparse.Namespace) -> None:
    """Print every boundary, and whether these are all."""
    check_form(options)
    axis = axis_of(options.axis, "--axis")
    if options.certify:
        raise ParameterError("every boundary here is proved; leave --certify out.")
    with waiting("searching"):
        from ..boundary.changes import boundaries

        subject = options_subject(options, {axis[0]: axis}, exact=True)
        every: Any = options.every
        changes = boundaries(subject.family, axis=axis, every=every, **subject.arguments)
    record: dict[str, Any] = {
        **subject.who,
        "parameters": doubles(subject.beyond((axis[0],))),
        **subject.member,
        "axis": axis[0],
        "low": axis[1],
        "high": axis[2],
        changes.several: [
            {
                name: value.word if name in ("crossing", "good", "evidence") else value
                for name, value in vars(b).items()
            }
            for b in changes
        ],
        "touching": list(changes.touching),
        "complete": changes.complete,
        "unresolved": [u._asdict() for u in changes.unresolved],
        "throughout": changes.throughout if options.every else changes.constant or None,
        "statement": changes.statement(axis[0]),
        "citation": changes.citation,
    }
    forms = {
        "csv": lambda: _csv(subject, axis, changes),
        "latex": lambda: _latex(subject, axis, changes),
    }
    answer(options, record, _lines(subject, axis, changes), forms)


def _csv(subject: CommandSubject, axis: Sequence[Any], changes: Any) -> str:
    """The boundaries with every number that was held, in columns of their own."""
    from ..storage.text import csv_text

    name = subject.own_name(axis[0])
    held = doubles({**subject.at, **subject.beyond((axis[0], name))})
    header, rows = changes.flat()
    header[0] = f"{name}{in_brackets(changes.unit)}"
    header += [f"{n}{in_brackets(subject.units.get(n, '1'))}" for n in held]
    return csv_text(header, [[*row, *held.values()] for row in rows])


def _latex(subject: CommandSubject, axis: Sequence[Any], changes: Any) -> str:
    from ..tables.results import boundaries_table

    assert subject.equations is not None
    quantities = subject.equations().system.quantities
    name = subject.own_name(axis[0])
    return boundaries_table(changes, _head(subject, axis), name, quantities).to_latex()


def _head(subject: CommandSubject, axis: Sequence[Any]) -> str:
    """What was asked, with every number that was held."""
    name = subject.own_name(axis[0])
    unit = behind(subject.units.get(name, "1"))
    place = subject.place({**subject.at, **subject.beyond((axis[0], name))})
    where = f"{subject.title}, along {name} from {axis[1]:g} to {axis[2]:g}{unit}"
    return where + f", at {place}" * bool(place)


def _lines(subject: CommandSubject, axis: Sequence[Any], changes: Any) -> Iterator[str]:
    name = subject.own_name(axis[0])
    yield _head(subject, axis)
    if subject.law:
        yield subject.law
    for b in changes:
        yield f"  {name} = {b.words(subject.units.get(name, '1'), subject.rate)}"
    if not changes and not changes.constant:
        yield "  none"
    yield changes.statement(name)
