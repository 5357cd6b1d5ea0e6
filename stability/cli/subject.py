"""What the options of a command are about: the disk, another body, or a system of one's own.

Every command takes the same options for it, and reads them here.
"""

from __future__ import annotations

import argparse
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..base.errors import ParameterError, absent, listed, shown
from ..bodies.families import FAMILIES, leaning
from .body_option import add_body, body_of, where_of
from .options import number
from .system_option import (
    doubles,
    exact_numbers,
    family_named,
    place,
    system_with_families,
)

CONTACTS = "smooth, viscous, linear-viscous, rough, creep-1 to creep-3"
MOTION_CONTACTS = (
    "viscous, linear-viscous, smooth, rough, creep-1 to creep-3 (viscous with the slip eliminated, "
    "for large mu), coulomb, coulomb-regularised"
)
SCALES = ("mass", "radius", "gravity")
NUMBERS = ("mu", "epsilon", "k", *SCALES, "length")
"""Options of numbers of the disk, other bodies and laws."""
OF_BODY = (
    "mu",
    "epsilon",
    "contact",
    "disk",
    "k",
    *SCALES,
    "length",
    "lean",
    "theta",
    "pole",
)
"""Options of the disk and of bodies, which a system of one's own does not have."""


# --- options ---


def add_subject(
    parser: argparse.ArgumentParser,
    words: Sequence[str] | None,
    *,
    motion: bool = False,
    place: bool = False,
) -> None:
    """Add the options that say what a command is about.

    Parameters
    ----------
    parser
        Parser of the command.
    words
        The command line, as for `add_body`.
    motion
        Whether the command is about motions, and not about members of a family.
    place
        Whether motions may start near a family, of which a body may have several.
    """
    if motion:
        parser.add_argument(
            "--system",
            metavar="MODULE:NAME",
            help="a system of your own in place of the disk, or a family of it: "
            "module:name, or file.py:name; it may settle on its families that the "
            "module names",
        )
    else:
        add_family(parser)
        parser.add_argument(
            "--system",
            metavar="MODULE:FAMILY",
            help="a family of your own in place of FAMILY: module:name, or file.py:name",
        )
    add_body(parser, words, place=place or not motion)
    parser.add_argument(
        "--contact",
        help=f"{MOTION_CONTACTS if motion else CONTACTS}, or "
        "module:Class for a law of your own (default viscous)",
    )
    parser.add_argument(
        "--mu",
        type=float,
        help="friction coefficient [s/m] (viscous; c = mu m g for linear)"
        + "; dry friction [-]" * motion,
    )
    if motion:
        parser.add_argument("--epsilon", type=float, help="slip speed of coulomb-regularised")
    parser.add_argument("--disk", help="a real disk: quarter, le-saux, gymnastics-hoop")
    parser.add_argument("--k", type=float, help="inertia factor in (0, 1/2] (default 1/4)")
    for name, of, unit in (
        ("mass", "body", "kg"),
        ("radius", "disk", "m"),
        ("gravity", "body", "m/s²"),
    ):
        parser.add_argument(
            f"--{name}",
            type=float,
            help=f"of the {of} [{unit}] (default 1; all three 1: dimensionless)",
        )
    add_numbers(
        parser, "a number by name, of the body, the law, or a system of your own; once for each"
    )


def add_family(parser: argparse.ArgumentParser) -> None:
    """Add the name of a family of the disk or of a body."""
    of = {f.name: f"{f.law} contact" if f.law else "of a body" * f.pole for f in FAMILIES.values()}
    names = [f"{name} ({only})" if only else name for name, only in of.items()]
    parser.add_argument("family", metavar="FAMILY", nargs="?", help=listed(names, "or"))


def add_member(parser: argparse.ArgumentParser) -> None:
    """Add what names a member of a family."""
    names: dict[tuple[str, ...], list[str]] = {}
    for family in FAMILIES.values():
        names.setdefault(family.at, []).append(family.name)
    one = listed([at[0] for at in names if len(at) == 1], "or")
    several = [f"for {listed(n)} {','.join(at).upper()}" for at, n in names.items() if len(at) > 1]
    parser.add_argument("--at", help="; ".join([one, *several]))
    help_ = f"for {leaning()}, in place of --at: π/2 - theta, 0 is upright"
    parser.add_argument("--lean", type=float, help=help_)


def add_numbers(parser: argparse.ArgumentParser, text: str) -> None:
    """Add the option of numbers by name; `--parameter` is its older name."""
    parser.add_argument("--set", action="append", metavar="NAME=NUMBER", help=text)
    parser.add_argument("--parameter", dest="set", action="append", help=argparse.SUPPRESS)


# --- members of a family ---


@dataclass(frozen=True)
class Subject:
    """A family and its numbers, as the options of a command name them."""

    family: Any
    """The name of a family of the disk or a body, or a user's `Family`."""
    arguments: dict[str, Any]
    """Arguments of `spectrum`, `boundaries`, `stability_map`, `stream_map` without the family."""
    thing: Any = None
    """The disk or body; None for a user's system."""
    law: Any = None
    """The contact law or, where an axis has its coefficients, its class."""

    @property
    def numbers(self) -> dict[str, Any]:
        """Every number of the body and its law, or of the system, by name."""
        if self.thing is None:
            return {n: float(v) for n, v in self.arguments["parameters"].items()}
        law = {} if isinstance(self.law, type) else self.law.given
        return {n: float(v) for n, v in (body_numbers(self.thing) | law).items()}

    @property
    def who(self) -> dict[str, Any]:
        """System or body, family, and contact, for a record."""
        if self.thing is None:
            return {"system": self.family.system.name, "family": self.family.name}
        of = {"body": self.thing.name} if hasattr(self.thing, "name") else {}
        return {**of, "family": self.family, "contact": self.law.name}

    @property
    def title(self) -> str:
        """Family, body and contact in words."""
        if self.thing is None:
            return f"{self.family.system.name}, {self.family.name}"
        of = f" of {self.thing.name}" if hasattr(self.thing, "name") else ""
        return f"{self.family}{of}, {self.law.name} contact"

    def beyond(self, swept: Collection[str]) -> dict[str, float]:
        """The numbers that no axis has; without moments of inertia that depend on an axis."""
        found = self.numbers
        if set(swept) & set(getattr(self.thing, "shape", ())):
            own = (
                {**self.thing.given, **self.law.given}
                if not isinstance(self.law, type)
                else (self.thing.given)
            )
            found = {n: v for n, v in found.items() if n in own}
        return {n: v for n, v in found.items() if n not in swept}

    def place(self, numbers: Mapping[str, Any]) -> str:
        """Numbers as text; without mass, length and gravity where these are 1."""
        if self.thing is None:
            return place(self.family, numbers)
        left = (*SCALES, "length") if self.thing.dimensionless else ()
        return ", ".join(f"{n} = {v:.15g}" for n, v in numbers.items() if n not in left)


def body_numbers(thing: Any) -> dict[str, Any]:
    """Every number of a disk or body by name: scales, shape, moments of inertia."""
    from ..bodies.disk import Disk
    from ..bodies.round_body.shape import MOMENTS

    if isinstance(thing, Disk):
        return {n: getattr(thing, n) for n in ("mass", "radius", "k", "gravity")}
    moments = dict(zip(MOMENTS, thing.moments(), strict=True))
    return {**thing.constants, **thing.given, **moments}


def members(
    options: argparse.Namespace, axes: Mapping[str, Any] | None = None, *, exact: bool = False
) -> Subject:
    """The family that the options name, with all its numbers but those of the axes.

    Parameters
    ----------
    options
        Parsed options.
    axes
        The axes by name; None where the options name one member.
    exact
        Whether numbers of a family of one's own stay exactly what was written.

    Raises
    ------
    StabilityError
        In one sentence, if the options do not fit together.
    """
    swept = dict(axes or {})
    if options.body is None and options.system is not None:
        return _of_system(options, own_family(options), swept, single=axes is None, exact=exact)
    given = set_numbers(options)
    body = body_of(options, swept)
    if body is None:
        _named(options)
    for name in ("at", "k", "mu", *SCALES):
        if name in swept and getattr(options, name) is not None:
            raise ParameterError(f"{name} is given as --{name} and as an axis; give it once.")
    at, lean = at_of(options), getattr(options, "lean", None)
    where = {} if body is None else where_of(options)
    if axes is None:
        if body is None and (at is None) == (lean is None):
            raise ParameterError(f"give --at, or for {leaning()} --lean, and not both.")
        _check_count(options, at)
    elif body is None:
        from ..spectra.arguments import check_names

        check_names(options.family, sorted(swept), options.contact)
    law = contact_of(options, given, swept=swept)
    thing = disk_of(options) if body is None else body
    arguments = {"body": thing, "contact": law, "at": at} | where
    if lean is not None:
        arguments["lean"] = lean
    return Subject(options.family, arguments, thing, law)


def _named(options: argparse.Namespace) -> None:
    """Refuse a missing family, or one of a user's in the place of a name."""
    if options.family is None:
        raise ParameterError(
            "FAMILY is missing; name one of the disk's, or give --system MODULE:FAMILY."
        )
    if ":" in options.family:
        raise ParameterError(
            f"FAMILY is {shown(options.family)}; give --system {options.family} instead."
        )


def own_family(options: argparse.Namespace) -> Any:
    """The family of --system; options of the disk and bodies must be absent."""
    family = getattr(options, "family", None)
    if family is not None:
        raise ParameterError(
            f"FAMILY is {shown(family)} and --system {shown(options.system)}; give one of them."
        )
    refuse_of_body(options)
    return family_named(options.system)


def refuse_of_body(options: argparse.Namespace, *more: str) -> None:
    """Refuse options of the disk and bodies with --system."""
    for key in (*OF_BODY, *more):
        given = getattr(options, key, None)
        if given is not None and given is not False:
            option = key.replace("_", "-")
            raise ParameterError(f"--{option} belongs to the disk; with --system leave it out.")


def _of_system(
    options: argparse.Namespace,
    family: Any,
    swept: Mapping[str, Any],
    *,
    single: bool,
    exact: bool,
) -> Subject:
    """A user's family with its numbers."""
    if options.at is not None and swept and (len(family.at) > 1 or family.at[0] in swept):
        raise ParameterError(
            f"--at means {' and '.join(family.at)} here; give what is no axis as --set NAME=NUMBER."
        )
    given = numbers_and_at(options, family)
    both = sorted(set(swept) & set(given))
    if both:
        raise ParameterError(f"{both[0]} is given as a number and as an axis; give it once.")
    if single:
        require(given, (*family.at, *family.parameters))
        given = {n: given[n] for n in (*family.at, *family.parameters)}
    return Subject(family, {"parameters": given if exact or single else doubles(given)})


def numbers_and_at(options: argparse.Namespace, family: Any) -> dict[str, Any]:
    """Every number that --at and --set give, by name, exactly as it is written."""
    from ..base.exact_numbers import ratio_of_text

    given = exact_numbers("set", options.set, (*family.at, *family.parameters), family.name)
    if options.at is None:
        return given
    parts = options.at.split(",")
    _count(options.at, len(parts), family.at, family.name)
    for name, text in zip(family.at, parts, strict=True):
        if name in given:
            raise ParameterError(f"{name} is given by --at and --set; give it once.")
        given[name] = ratio_of_text(name, text)
    return given


def require(given: Collection[str], names: Sequence[str]) -> None:
    """Refuse numbers of a system that are missing."""
    missing = [n for n in names if n not in given]
    if missing:
        how = " ".join(f"--set {n}=NUMBER" for n in missing)
        raise ParameterError(f"{absent(missing)}; give {how}.")


def at_of(options: argparse.Namespace) -> float | list[float] | None:
    """The numbers of --at."""
    if options.at is None:
        return None
    parts = [number(part, "at") for part in str(options.at).split(",")]
    return parts[0] if len(parts) == 1 else parts


def _check_count(options: argparse.Namespace, at: Any) -> None:
    """Refuse more or fewer numbers than name a member."""
    if options.family in FAMILIES and isinstance(at, list):
        _count(options.at, len(at), FAMILIES[options.family].at, options.family)


def _count(text: str, count: int, names: Sequence[str], owner: str) -> None:
    if count != len(names):
        raise ParameterError(
            f"at is {shown(text)}; {owner} takes {' and '.join(names)}, "
            f"{len(names)} number{'s' * (len(names) > 1)}."
        )


# --- bodies and laws ---


def disk_of(options: argparse.Namespace) -> Any:
    """The disk that the options name."""
    from ..bodies.disk import Disk

    every = {n: getattr(options, n, None) for n in ("mass", "radius", "k", "gravity")}
    given: dict[str, float] = {n: v for n, v in every.items() if v is not None}
    if options.disk is None:
        return Disk(**given)
    if given:
        raise ParameterError(f"--{next(iter(given))} and --disk are both given; give one of them.")
    return Disk.named(options.disk)


def contact_of(
    options: argparse.Namespace,
    given: Mapping[str, float],
    *,
    motion: bool = False,
    swept: Collection[str] = (),
) -> Any:
    """The contact law that the options name; a coefficient that an axis has gets the value 1."""
    from ..bodies.law_names import class_named, law_named

    options.contact = options.contact or "viscous"
    law = class_named(options.contact, motion=motion)
    own = {p.name for p in law.parameters}
    coefficients = {n: 1.0 for n in swept if n in own}
    for name, value in given.items():
        if name in coefficients:
            raise ParameterError(f"{name} is given as a number and as an axis; give it once.")
        coefficients[name] = value
    if coefficients and set(coefficients) <= set(swept) and options.mu is None:
        return law
    epsilon = getattr(options, "epsilon", None)
    return law_named(
        options.contact, options.mu, motion=motion, epsilon=epsilon, others=coefficients
    )


def set_numbers(options: argparse.Namespace) -> dict[str, float]:
    """Numbers of --set for which there is no option; others count as given by their option."""
    from .body_option import shape_names

    found: dict[str, float] = {}
    direct = {*NUMBERS, *(shape_names() if options.body else ())} & vars(options).keys()
    seen: set[str] = set()
    for text in options.set or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--set is {shown(text)}; give NAME=NUMBER.")
        if name in seen:
            raise ParameterError(f"{name} is given twice; give it once.")
        seen.add(name)
        if name not in direct:
            found[name] = number(value, name)
        elif getattr(options, name) is not None:
            raise ParameterError(f"{name} is given as --{name} and by --set; give it once.")
        else:
            setattr(options, name, number(value, name))
    options.set = None
    return found


# --- motions ---


def moving(
    options: argparse.Namespace,
    swept: Mapping[str, Any] | None = None,
    *,
    coefficients: Collection[str] = (),
) -> dict[str, Any]:
    """What moves, as arguments of `simulate` or `basins`: body and law, or system and families.

    Parameters
    ----------
    options
        Parsed options.
    swept
        Axes by name.
    coefficients
        Names that have their values elsewhere, as launches of `basins` have.
    """
    if options.system is not None and options.body is None:
        system, families = system_with_families(options.system)
        return {"disk": system, "families": families}
    given = {} if coefficients else set_numbers(options)
    body = body_of(options, swept or {})
    law = contact_of(options, given, motion=True, swept={*(swept or ()), *coefficients})
    return {"disk": disk_of(options) if body is None else body, "contact": law}
