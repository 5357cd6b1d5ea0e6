"""The command `equilibria`: every steady state of a user's system in a box."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from ..base.errors import listing
from .modules import system_with_families
from .options import answer, values
from .subject import PLACE, add_box, box_of, doubles, exact_numbers, require
from .terminal import waiting

EXAMPLES = (
    "stability equilibria --system examples/watt_governor.py:governor --box x=0.1:3 --box y=-1:1 "
    "--box z=0.1:5 --set e=0.4 --set a=0.5 --set b=0.5",
    "stability equilibria --system examples/watt_governor.py:governor --box x=0.1:3 --box y=0 "
    "--box z=0.1:5 --set e=0.4 --set a=0.5 --set b=0.5 --json",
)
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--system", required=True, metavar="MODULE:NAME", help=f"a system, or its family: {PLACE}"
    )
    add_box(parser, required=True)
    values(parser, str, {"--set": ("NAME=X", "a parameter, once for each")}, action="append")


def run(options: argparse.Namespace) -> None:
    """Print every equilibrium, and whether these are all."""
    system, _ = system_with_families(options.system)
    numbers = exact_numbers("set", options.set, system.parameters, system.name)
    require(numbers, system.parameters)
    with waiting("searching"):
        equilibria = system.equilibria(box_of(options) or {}, **doubles(numbers))
    record = {
        "system": system.name,
        "parameters": doubles(numbers),
        "box": {n: list(ends) for n, ends in equilibria.box.items()},
        "held": dict(equilibria.held),
        "equilibria": [
            {
                "state": state,
                "error": dict(zip(system.states, errors.tolist(), strict=True)),
                "verdict": verdict.word,
            }
            for state, errors, verdict in zip(
                equilibria, equilibria.errors, equilibria.verdicts, strict=True
            )
        ],
        "complete": equilibria.complete,
        "unresolved": [part._asdict() for part in equilibria.unresolved],
        "statement": equilibria.statement,
        "citation": equilibria.citation,
    }
    answer(options, record, _lines(equilibria))


def _lines(equilibria: Any) -> Iterator[str]:
    numbers = {**equilibria.parameters, **equilibria.held}
    where = ", ".join(f"{n} from {a:g} to {b:g}" for n, (a, b) in equilibria.box.items())
    yield (
        f"{equilibria.system.name}, {where}"
        + f", at {listing(numbers, numbers.values())}" * bool(numbers)
    )
    for state, verdict in zip(equilibria, equilibria.verdicts, strict=True):
        yield f"  {', '.join(f'{n} = {v:.12g}' for n, v in state.items())}   {verdict.word}"
    yield equilibria.statement
