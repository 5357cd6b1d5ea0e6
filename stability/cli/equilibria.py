"""The command `equilibria`: every steady state of a user's system in a box."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from ..base.errors import ParameterError, listing, shown
from .modules import system_with_families
from .options import answer, number, values
from .subject import PLACE, doubles, exact_numbers, named_texts, require
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
    box = "low and high end of a state, or one number at which it is held; once for each"
    values(parser, str, {"--box": ("NAME=LO:HI", box)}, action="append", required=True)
    values(parser, str, {"--set": ("NAME=X", "a parameter, once for each")}, action="append")


def run(options: argparse.Namespace) -> None:
    """Print every equilibrium, and whether these are all."""
    system, _ = system_with_families(options.system)
    numbers = exact_numbers("set", options.set, system.parameters, system.name)
    require(numbers, system.parameters)
    box = {n: _ends(n, text) for n, text in named_texts("box", options.box).items()}
    with waiting("searching"):
        equilibria = system.equilibria(box, **doubles(numbers))
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


def _ends(name: str, text: str) -> Any:
    parts = [number(part, f"--box {name}") for part in text.split(":")]
    if len(parts) > 2:
        raise ParameterError(f"--box {name} is {shown(text)}; give LO:HI, or one number.")
    return parts[0] if len(parts) == 1 else tuple(parts)


def _lines(equilibria: Any) -> Iterator[str]:
    given = {**equilibria.parameters, **equilibria.held}
    where = ", ".join(f"{n} from {a:g} to {b:g}" for n, (a, b) in equilibria.box.items())
    yield f"{equilibria.system.name}, {where}" + f", at {listing(given, given.values())}" * bool(
        given
    )
    for state, verdict in zip(equilibria, equilibria.verdicts, strict=True):
        yield f"  {', '.join(f'{n} = {v:.12g}' for n, v in state.items())}   {verdict.word}"
    yield equilibria.statement
