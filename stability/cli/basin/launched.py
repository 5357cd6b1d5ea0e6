"""What `stability basins` launches, from its options."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from ...base.errors import NameUnknownError, ParameterError, absent, listed, shown
from ..body_option import where_of
from ..options import _axis, number
from ..subject import moving, refuse_of_body

KINDS = {"uniform": "LOW:HIGH", "log": "LOW:HIGH", "normal": "MEAN:DEVIATION"}
"""Distributions of --sample, and their two numbers."""
NUMBERS = ("mu", "k", "mass", "radius", "gravity")
"""Options that may be axes too."""


def launched(options: argparse.Namespace) -> dict[str, Any]:
    """What is launched, and over which numbers, as arguments of `st.basins`.

    Parameters
    ----------
    options
        Parsed options of the command.

    Raises
    ------
    StabilityError
        In one sentence, if the options do not fit together.
    """
    varied = _varied(options)
    axes = [varied[n] for n in ("x", "y") if n in varied] + varied.get("more", [])
    names = [a[0] for a in axes] or list(varied["distribution"])
    held = _held(options, names)
    if options.system is not None:
        refuse_of_body(options, "family", "body")
        return varied | moving(options) | {"held": held}
    for name in NUMBERS:
        if name in (*names, *held) and getattr(options, name) is not None:
            twice = "as an axis" if name in names else "by --set"
            raise ParameterError(f"{name} is given as --{name} and {twice}; give it once.")
    options.family = options.family or ""
    found = moving(options, {a[0]: a for a in axes}, coefficients={*names, *held})
    where = {} if options.body is None else where_of(options)
    return varied | where | found | {"held": held, "family": options.family}


def _varied(options: argparse.Namespace) -> dict[str, Any]:
    """The axes, or the distribution of a random sample, its size and seed."""
    if options.sample:
        given = [f"--{n}" for n in ("x", "y", "more") if getattr(options, n)]
        if given:
            raise ParameterError(f"{given[0]} does not go with --sample; give axes or a sample.")
        if options.count is None:
            raise ParameterError("--count is missing; give the number of launches of the sample.")
        spread = dict(_distribution(text) for text in options.sample)
        if len(spread) < len(options.sample):
            raise ParameterError("--sample names a quantity twice; give each once.")
        return {"distribution": spread, "count": options.count, "seed": options.seed or 0}
    for name in ("count", "seed"):
        if getattr(options, name) is not None:
            raise ParameterError(f"--{name} belongs to --sample; leave it out.")
    missing = [f"--{n}" for n in ("x", "y") if getattr(options, n) is None]
    if missing:
        raise ParameterError(f"{absent(missing)}; give NAME:LO:HI:N, or a sample by --sample.")
    axes: dict[str, Any] = {n: _axis(getattr(options, n), f"--{n}") for n in ("x", "y")}
    return axes | {"more": [_axis(text, "--more") for text in options.more or ()]}


def _distribution(text: str) -> tuple[str, Any]:
    """Name and distribution of one quantity, from NAME:KIND:A:B."""
    from ...basin.statistics.samples import LogUniform, Normal, Uniform

    parts = text.split(":")
    if len(parts) != 4:
        each = listed([f"NAME:{kind}:{numbers}" for kind, numbers in KINDS.items()], "or")
        raise ParameterError(f"--sample is {shown(text)}; give {each}.")
    name, kind, *numbers = parts
    if kind not in KINDS:
        raise NameUnknownError(
            f"--sample has the kind {shown(kind)}; give {listed(list(KINDS), 'or')}."
        )
    a, b = (number(v, f"a number of --sample {shown(text)}") for v in numbers)
    return name, {"uniform": Uniform, "log": LogUniform, "normal": Normal}[kind](a, b)


def _held(options: argparse.Namespace, varied: Sequence[str]) -> dict[str, float]:
    """Numbers of --set by name; `at` is the one that names the family's members."""
    from ...bodies.families import at_name

    found: dict[str, float] = {}
    for text in options.set or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--set is {shown(text)}; give NAME=NUMBER.")
        if name == "at":
            name = at_name(options.family)
        if name in found:
            raise ParameterError(f"{name} is set twice; give it once.")
        if name in varied:
            raise ParameterError(f"{name} varies and is set; give it once.")
        found[name] = number(value, name)
    return found
