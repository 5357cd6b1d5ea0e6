"""What the options of a command are about: the disk, another body, or a system of one's own.

Every command takes the same options for it, and reads them here.
"""

from __future__ import annotations

import argparse
import io
import os
import runpy
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from fractions import Fraction
from importlib import import_module
from inspect import Parameter, signature
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, StabilityError, absent, listed, shown
from ..base.exact_numbers import ratio_of_text, written
from ..base.quantities import readable
from ..base.user_code import imported
from ..bodies.families import FAMILIES, leaning
from .options import number

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
            law = {} if isinstance(self.law, type) else self.law.given
            own = {**self.thing.given, **law}
            found = {n: v for n, v in found.items() if n in own}
        return {n: v for n, v in found.items() if n not in swept}

    def place(self, numbers: Mapping[str, Any]) -> str:
        """Numbers as text; without mass, length and gravity where these are 1."""
        if self.thing is None:
            units = self.family.system.units
            named = {
                n: "" if units.get(n, "1") == "1" else f" {readable(units[n])}" for n in numbers
            }
            return ", ".join(f"{n} = {written(v)}{named[n]}" for n, v in numbers.items())
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
        from ..bodies.subject import check_names

        check_names(options.family, sorted(swept), options.contact)
    law = _contact_of(options, given, swept=swept)
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


def _contact_of(
    options: argparse.Namespace,
    given: Mapping[str, float],
    *,
    motion: bool = False,
    swept: Collection[str] = (),
) -> Any:
    """The contact law that the options name; a coefficient that an axis has gets the value 1."""
    from ..bodies.contact_laws import class_named, law_named

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
    found: dict[str, float] = {}
    direct = {*NUMBERS, *(_shape_options() if options.body else ())} & vars(options).keys() - {
        "solid"
    }
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
    law = _contact_of(options, given, motion=True, swept={*(swept or ()), *coefficients})
    return {"disk": disk_of(options) if body is None else body, "contact": law}


# --- a body by its name and numbers ---


ACCURACY = "tolerance"
"""Argument of a body's function that is no number of its shape."""


def _shape_options() -> dict[str, list[str]]:
    """Numbers of named bodies, each with its bodies and their defaults, from their signatures."""
    from ..bodies.round_body.shapes.named import NAMED

    found: dict[str, list[str]] = {}
    for body, make in NAMED.items():
        for name, entry in _numbers_of(make).items():
            usual = entry.default
            known = type(usual) is float
            found.setdefault(name, []).append(f"{body} (default {usual:g})" if known else body)
    return found


def _numbers_of(make: Callable[..., Any]) -> dict[str, Parameter]:
    """The parameters of a body's function that have a name."""
    every = signature(make).parameters
    return {
        n: p
        for n, p in every.items()
        if n != ACCURACY and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    }


def add_body(
    parser: argparse.ArgumentParser, words: Sequence[str] | None, *, place: bool = True
) -> None:
    """Add the option for a body of revolution, and those for its numbers.

    Parameters
    ----------
    parser
        Parser of a command.
    words
        The command line; where it names no body nor asks for help, the options are left out, since
        their signatures load CasADi.  They are added where it is not known.
    place
        Whether the command is about members of a family, of which a body may have several.
    """
    parser.set_defaults(body=None)
    if words is not None and not any(w.startswith(("--b", "-h", "--h")) for w in words):
        return
    from ..bodies.round_body.shapes.named import NAMED

    bodies = ", ".join(
        " ".join(
            [
                body,
                *(f"--{n} X" for n, p in _numbers_of(make).items() if p.default is p.empty),
                *(f"[--{n} X]" for n, p in _numbers_of(make).items() if type(p.default) is float),
            ]
        )
        for body, make in NAMED.items()
    )
    group = parser.add_argument_group(
        "bodies of revolution",
        "in place of the disk, such as --body torus --tube 0.2",
    )
    group.add_argument(
        "--body",
        metavar="NAME",
        help=f"{bodies}; or module:name or file.py:name "
        "of a body of your own, or of a function that returns one, each of whose "
        "numbers is an option --NAME X",
    )
    for name, owners in _shape_options().items():
        of = listed([f"of {owner}" for owner in owners], "or")
        if name == "solid":
            group.add_argument("--solid", action="store_true", default=None, help=f"{of} (default)")
            group.add_argument("--hollow", action="store_false", dest="solid", help=of)
        else:
            group.add_argument(f"--{name}", type=float, help=of)
    group.add_argument("--length", type=float, help="unit of the body's numbers [m] (default 1)")
    if place:
        group.add_argument("--theta", type=float, help="where it rolls, if at several inclinations")
        group.add_argument("--pole", help="for vertical: its theta, 0 or pi (default 0)")


def where_of(options: argparse.Namespace) -> dict[str, Any]:
    """What tells members apart whose numbers are the same: an inclination, or a pole."""
    given: dict[str, Any] = {"theta": options.theta, "pole": options.pole}
    if given["pole"] == "0":
        given["pole"] = 0
    return {n: v for n, v in given.items() if v is not None}


def body_of(options: argparse.Namespace, swept: Mapping[str, Any]) -> Any | None:
    """The body that the options name, or None for the disk and for a system of one's own.

    Parameters
    ----------
    options
        Parsed options.
    swept
        Axes by name, (name, low, high, …); a number of the shape on one of them needs no value.
    """
    if options.body is None:
        return None
    from ..bodies.families import FAMILIES
    from ..bodies.round_body.shape import SCALES
    from ..bodies.round_body.shapes.named import NAMED

    for key in ("system", "disk", "k", "radius", "lean"):
        if getattr(options, key, None) is not None:
            raise ParameterError(f"--{key} does not go with --body; leave one of them out.")
    if getattr(options, "family", "") is None:
        raise ParameterError(f"FAMILY is missing; name one of {', '.join(FAMILIES)}.")
    given = {n: getattr(options, n) for n in _shape_options()}
    given = {n: v for n, v in given.items() if v is not None} | _pairs(options.rest)
    scales = {n: getattr(options, n) for n in SCALES if getattr(options, n) is not None}
    for name in sorted({*given, *scales} & set(swept)):
        raise ParameterError(f"{name} is given as --{name} and as an axis; give it once.")
    found: Any = NAMED.get(options.body)
    found = _own_body(options.body, NAMED) if found is None else found
    body = _made(options.body, found, given, swept)
    return replace(body, **scales) if scales else body


def _pairs(rest: Sequence[str]) -> dict[str, float]:
    """Numbers of a user's body from options that no parser knows: --NAME X or --NAME=X."""
    words = [part for word in rest for part in word.split("=", 1)]
    if len(words) % 2 or not all(w.startswith("--") for w in words[::2]):
        raise ParameterError(f"{' '.join(rest)} is no list of --NAME X, the numbers of a body.")
    names = [w[2:].replace("-", "_") for w in words[::2]]
    return {n: number(v, n) for n, v in zip(names, words[1::2], strict=True)}


def _own_body(place: str, named: Collection[str]) -> Any:
    """A user's body, or the function that makes it."""
    from ..bodies.round_body.body import Body

    if ":" not in place:
        raise NameUnknownError(
            f"body is {shown(place)}; known are {', '.join(named)}, or give `module:body` or "
            "`file.py:body`."
        )
    module, name, table = _contents("body", "body", place)
    found = table.get(name)
    if isinstance(found, Body) or (callable(found) and not isinstance(found, type)):
        return found
    bodies = sorted(n for n, v in table.items() if isinstance(v, Body)) or ["none"]
    raise NameUnknownError(
        f"{shown(name)} is no body of {module} and no function; its bodies are {', '.join(bodies)}."
    )


def _made(label: str, found: Any, given: dict[str, Any], swept: Mapping[str, Any]) -> Any:
    """A body with numbers given by options; one on an axis has the middle of the axis."""
    from ..bodies.round_body.body import Body

    if isinstance(found, Body):
        own = {n: v for n, v in found.given.items() if n not in ("mass", "gravity", "length")}
        _refuse_others(label, given, own)
        shape = {n: given.get(n, v) for n, v in found.shape.items()}
        moments = {n: v for n, v in given.items() if n not in shape}
        return replace(found, shape=shape, **moments)
    known = _numbers_of(found)
    _refuse_others(label, given, known)
    middle = {n: (a[1] + a[2]) / 2 for n, a in swept.items() if n in known}
    missing = [n for n, p in known.items() if p.default is p.empty and n not in {**given, **middle}]
    if missing:
        raise ParameterError(f"--{missing[0]} is missing; {label} needs it.")
    try:
        body = found(**given, **middle)
    except StabilityError:
        raise
    except Exception as error:  # a user's function may raise anything
        raise ParameterError(
            f"{label} makes no body of these numbers ({type(error).__name__}: {error})."
        ) from None
    if not isinstance(body, Body):
        raise ParameterError(f"{label} returns {shown(body)}; a stability.Body is needed.")
    every = {n: p.default for n, p in known.items()} | given | middle
    own = {n: v for n, v in every.items() if type(v) in (int, float) and n not in body.given}
    return replace(body, constants={**own, **body.constants}) if own else body


def _refuse_others(label: str, given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            word = "solid or --hollow" if name == "solid" else name
            own = " or ".join(f"--{n}" for n in known) or "no numbers"
            own = own.replace("--solid", "--solid or --hollow")
            raise ParameterError(f"--{word} is no number of {label}; it takes {own}.")


# --- a family or a system in a module of the user ---


def family_named(place: str) -> Any:
    """The family at `module:name` or `file.py:name`; what the module prints is dropped.

    Parameters
    ----------
    place
        Module on Python's path or in this folder, or a file; then the name of a `Family`.

    Returns
    -------
    Family

    Raises
    ------
    NameUnknownError
        If there is no such module, or no family of that name in it.
    """
    from ..systems.family import Family

    module, name, table = _contents("system", "family", place)
    if not isinstance(table.get(name), Family):
        names = sorted(n for n, v in table.items() if isinstance(v, Family)) or ["none"]
        raise NameUnknownError(
            f"{shown(name)} is no family of {module}; its families are {', '.join(names)}."
        )
    found: Any = table[name]
    return found


def _contents(option: str, what: str, place: str) -> tuple[str, str, dict[str, Any]]:
    """Module, name, and all names of the module, from `module:name` or `file.py:name`."""
    module, colon, name = place.rpartition(":")
    dotted = all(part.isidentifier() for part in module.split("."))
    if not colon or not name.isidentifier() or not (dotted or module.endswith(".py")):
        raise NameUnknownError(
            f"{option} is {shown(place)}; give `module:{what}` or `file.py:{what}`."
        )
    folder = os.path.dirname(module) if module.endswith(".py") else os.getcwd()

    def names_of() -> dict[str, Any]:
        with redirect_stdout(io.StringIO()):
            if module.endswith(".py"):
                return runpy.run_path(module)
            return vars(import_module(module))

    table = imported(
        option,
        place,
        names_of,
        folder or os.getcwd(),
        f"give a module on Python's path or a file, and a {what} in it",
    )
    return module, name, table


def system_with_families(place: str) -> tuple[Any, list[Any]]:
    """The system at `module:name` or `file.py:name`, and its families in the same module.

    Parameters
    ----------
    place
        Module on Python's path or in this folder, or a file; then the name of a `System`, or of a
        `Family`, whose system is meant.

    Returns
    -------
    system
        The system.
    families
        The families of it that the module names, each once.

    Raises
    ------
    NameUnknownError
        If there is no such module, or no system or family of that name in it.
    """
    from ..systems.equations import Equations
    from ..systems.family import Family

    module, name, table = _contents("system", "name", place)
    found = table.get(name)
    system = found.system if isinstance(found, Family) else found
    if not isinstance(system, Equations):
        known = (n for n, v in table.items() if isinstance(v, Equations | Family))
        names = sorted(known) or ["none"]
        raise NameUnknownError(
            f"{shown(name)} is no system and no family of {module}; these are {', '.join(names)}."
        )
    own = [f for f in table.values() if isinstance(f, Family) and f.system == system]
    return system, list(dict.fromkeys(own))


def exact_numbers(
    option: str, texts: Iterable[str] | None, names: Collection[str], owner: str
) -> dict[str, Fraction]:
    """Numbers by name from texts NAME=NUMBER, exactly as they are written.

    Parameters
    ----------
    option
        The option that gives them, without dashes.
    texts
        The texts.
    names
        Names that are known.
    owner
        What has these names.
    """
    out: dict[str, Fraction] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--{option} is {shown(text)}; give NAME=NUMBER.")
        if name in out:
            raise ParameterError(f"{name} is given twice; give it once.")
        if name not in names:
            known = ", ".join(names) or "none"
            raise NameUnknownError(f"--{option} names {shown(name)}; {owner} has {known}.")
        out[name] = ratio_of_text(name, value)
    return out


def doubles(given: Mapping[str, Fraction]) -> dict[str, Any]:
    """Numbers as their nearest doubles."""
    return {n: float(v) for n, v in given.items()}
