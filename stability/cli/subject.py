"""What a command is about: a body under a contact law, or a system of the user.

Every command takes the same options for it.  They are read here once, into a `CommandSubject`,
which holds the arguments of the public functions and what an answer says of the body or system.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from ..base.errors import NameUnknownError, ParameterError, absent, listed, shown
from ..base.exact_numbers import ratio_of_text, written
from ..base.quantities import Kind, behind, rate_unit
from ..bodies.contact_laws import MOTION_LAWS, class_named, law_named
from ..bodies.disk import REAL_DISKS, Disk
from ..bodies.families import FAMILIES, leaning
from ..bodies.quantities import THIN, round_quantities
from .body import add_body, middles, round_body
from .modules import family_named, system_with_families
from .options import given, number, real, values

SCALES = {"mass": ("body", "kg"), "radius": ("disk", "m"), "gravity": ("body", "m/s²")}
"""Options of dimensional numbers: of what, and their units."""
COEFFICIENTS = ("mu", "epsilon")
"""Numbers of contact laws that have an option; others are given by --set."""
NUMBERS = (*COEFFICIENTS, "k", *SCALES, "length")
"""Options of numbers of the disk, other bodies and laws."""
PLACE = "module:name, or file.py:name"
"""Where something of the user is."""
STATES = {
    "theta": "angle of the symmetry axis from the vertical [rad], π/2 is upright (needed)",
    "theta_dot": "its rate (default 0, as below)",
    "phi_dot": "precession rate",
    "omega3": "angular velocity along the symmetry axis",
    "slip_x": "slip of the contact point across the disk",
    "slip_y": "slip along the disk's tangent",
}
"""Options of the start of a disk or body, in the order of its states."""
RESISTANCES = {
    "rolling_resistance": ("RHO", "moment -RHO·N·ω along the plane, against rolling [m s]"),
    "pivoting_resistance": ("SIGMA", "moment -SIGMA·N·ω about the vertical [m s]"),
    "air_torque": ("DRAG", "moment -DRAG·ω, the drag of air [N m s]"),
}
"""Options for moments that add to the contact law, of a disk or a body."""
OF_DISK = ("mass", "radius", "k", "gravity")
"""Numbers of the disk."""
OF_BODY = (
    *NUMBERS,
    *("contact", "disk", "lean", "theta", "pole", "solid"),
    *(*STATES, "pose", "film", *RESISTANCES),
)
"""Options of the disk and of bodies, which a system of one's own does not have."""


# --- options ---


def add_subject(
    parser: argparse.ArgumentParser,
    *,
    motion: bool = False,
    place: bool | None = None,
    system: str = "",
    numbers: str = "",
) -> None:
    """Add the options that say what a command is about.

    Parameters
    ----------
    parser
        Parser of the command.
    motion
        Whether the command is about motions, and not about members of a family.
    place
        Whether a place of a family is named, of which a body may have several; where None, as it is
        for members of a family.
    system, numbers
        Help of --system and --set, where it says more.
    """
    name, of_system = "MODULE:FAMILY", "a family of your own in place of FAMILY"
    if motion:
        name, of_system = "MODULE:NAME", "a system of your own in place of the disk, or a family"
        system = system or f"{of_system} of it: {PLACE}; it may settle on its families there"
    else:
        add_family(parser)
    parser.add_argument("--system", metavar=name, help=system or f"{of_system}: {PLACE}")
    add_body(parser, place=not motion if place is None else place)
    add_contact(parser, motion=motion)
    dry = f"its mu [-] is that of --contact coulomb{'' if motion else ', for simulate and scene'}"
    mu = (
        "friction coefficient of F = -mu N v [s/m] (viscous; linear-viscous: F = -c v, c = mu m g)"
        f"; no dry friction: {dry}"
    )
    epsilon = {"--epsilon": ("EPSILON", "slip speed of coulomb-regularised")} if motion else {}
    scales = {
        f"--{scale}": (
            scale.upper(),
            f"of the {of} [{unit}]; mass, length and gravity all, or none: dimensionless",
        )
        for scale, (of, unit) in SCALES.items()
    }
    inertia = "inertia factor in (0, 1/2] (default 1/4)"
    values(parser, real, {"--mu": ("MU", mu), **epsilon, "--k": ("K", inertia), **scales})
    parser.add_argument("--disk", help=f"a real disk: {', '.join(REAL_DISKS)}")
    text = "a number by name, of the body, the law, or a system of your own; once for each"
    add_numbers(parser, numbers or text)


def add_contact(parser: argparse.ArgumentParser, *, motion: bool = False, of: str = "") -> None:
    """Add the name of a contact law; `of` says where it counts."""
    laws = ", ".join(n for n, law in MOTION_LAWS.items() if motion or law.linearises)
    text = f"{of}{laws}, or module:Class for a law of your own (default viscous)"
    parser.add_argument("--contact", help=text)


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
    single = listed([at[0] for at in names if len(at) == 1], "or")
    several = [f"for {listed(n)} {','.join(at).upper()}" for at, n in names.items() if len(at) > 1]
    parser.add_argument("--at", help="; ".join([single, *several]))
    help_ = f"for {leaning()}, in place of --at: π/2 - theta, 0 is upright"
    parser.add_argument("--lean", type=real, help=help_)


def add_launch(parser: argparse.ArgumentParser) -> None:
    """Add the options of one launch: states, subject, and moments against it."""
    values(parser, real, {_option(name): ("X", text) for name, text in STATES.items()})
    start = "with --system: every state by name, such as q=0.1,v=0"
    parser.add_argument("--start", metavar="NAME=X,…", help=start)
    add_subject(parser, motion=True)
    add_resistances(parser)


def add_resistances(parser: argparse.ArgumentParser) -> None:
    """Add the options of moments against rolling and turning."""
    values(parser, real, {_option(name): texts for name, texts in RESISTANCES.items()})


def resistances_of(options: argparse.Namespace) -> list[Any] | None:
    """The resistances of a command; None where none is given."""
    from ..bodies.resistance import RESISTANCES as KINDS

    values = ((kind, getattr(options, name)) for name, kind in KINDS.items())
    return [kind(value) for kind, value in values if value is not None] or None


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def add_numbers(parser: argparse.ArgumentParser, text: str) -> None:
    """Add the option of numbers by name."""
    parser.add_argument("--set", action="append", metavar="NAME=NUMBER", help=text)


# --- the subject ---


@dataclass(frozen=True)
class CommandSubject:
    """A body under a contact law or a user's system, and a family of it, as the options name them.

    What differs between them is read here once; commands ask these fields alone.
    """

    family: Any
    """The name of a family, a user's `Family`, or None where no family is asked about."""
    arguments: dict[str, Any]
    """Body and law or system, member and numbers, as arguments of the public functions."""
    who: dict[str, Any]
    """System or body, family, and contact, for a record."""
    title: str
    """The same in words."""
    law: str = ""
    """The contact law with its formula; empty for a system."""
    names: tuple[str, ...] = ()
    """Names of the numbers that name a member."""
    member: dict[str, Any] = field(default_factory=dict)
    """The member, for a record; without `at` where an axis or a lean names it."""
    at: dict[str, Any] = field(default_factory=dict)
    """What names the member, each number by its own name."""
    numbers: dict[str, Any] = field(default_factory=dict)
    """Every other number of the body and its law, or of the system, by name."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Unit of each number, in words where it is dimensionless."""
    rate: str = "1"
    """Unit of eigenvalues and frequencies."""
    scales: str = ""
    """The units of all numbers in words; empty for a system, which has units of its own."""
    dimensionless: bool = False
    """Whether numbers have no unit, by choice of the units of the body."""
    shape: Collection[str] = ()
    """Numbers of the shape."""
    derived: Collection[str] = ()
    """Numbers that follow from those of the shape, and change with them."""
    states: tuple[str, ...] = ()
    """States of a motion."""
    energy: str = "the size of its terms"
    """To what an error of the energy is compared."""
    equations: Callable[[], Any] | None = None
    """The family, or the system, with every number as a variable."""

    def beyond(self, swept: Collection[str]) -> dict[str, Any]:
        """The numbers that no axis has; without those that follow from an axis."""
        left = {*swept, *(self.derived if set(swept) & set(self.shape) else ())}
        return {n: v for n, v in self.numbers.items() if n not in left}

    def own_name(self, axis: str) -> str:
        """Name of an axis; of `at` that of the number which it means."""
        return self.names[0] if axis == "at" and len(self.names) == 1 else axis

    def place(self, numbers: Mapping[str, Any]) -> str:
        """Numbers with their units, without mass, length and gravity where these are 1.

        Parameters
        ----------
        numbers
            Numbers by name.
        """
        left = (*SCALES, "length") if self.dimensionless else ()
        return ", ".join(
            f"{n} = {_digits(v)}{behind(self.units.get(n, '1'))}"
            for n, v in numbers.items()
            if n not in left
        )


def _digits(value: Any) -> str:
    """A number that was written exactly as it was written, and a double in 15 digits."""
    return written(value) if isinstance(value, Fraction) else f"{value:.15g}"


def options_subject(
    options: argparse.Namespace,
    axes: Mapping[str, Any] | None = None,
    *,
    held: Collection[str] = (),
    motion: bool = False,
    exact: bool = False,
    shown_first: bool = False,
) -> CommandSubject:
    """What the options are about, with all its numbers but those of the axes.

    Parameters
    ----------
    options
        Parsed options.
    axes
        The axes by name; None where the options name one member or launch.
    held
        Names of numbers that --set gives apart, as in `basins`.
    motion
        Whether it is launched, and not a member of a family.
    exact
        Whether numbers of a family of one's own stay exactly what was written.
    shown_first
        Whether numbers name a point that is shown at first, so that axes may name them too, and the
        law may lack its own.

    Raises
    ------
    StabilityError
        In one sentence, if the options do not fit together.
    """
    swept = dict(axes or {})
    single = axes is None
    if options.system is not None and options.body is None:
        if motion:
            return _system_launched(options)
        named = {} if shown_first else swept
        return _system_subject(options, named, single=single, exact=exact or single)
    numbers = {} if held else set_numbers(options)
    if not shown_first:
        for name in swept:
            refuse_option(options, name, "as an axis")
    for name in held:
        refuse_option(options, name, "by --set")
    body = body_of(options, swept)
    member = {} if motion else _member(options, needed=single and not shown_first)
    free = () if shown_first else (*swept, *held)
    law = _law_of(options, numbers, free, motion=motion, needed=not shown_first)
    return _body_subject(options, body, law, member, swept)


# --- a body ---


@dataclass(frozen=True)
class _Body:
    """The disk or another body, with what an answer says of it."""

    body: Any
    argument: str
    """Name of its argument in the public functions."""
    name: str
    """Name of a body; empty for the disk, which needs none."""
    numbers: dict[str, Any]
    """Every number of it by name."""
    family: Callable[..., Any]
    """The function of name and law that makes a family of it."""
    derived: Collection[str] = ()
    """Those that are not given but follow from others."""
    shape: Collection[str] = ()
    """Those that are its shape."""


def _body_subject(
    options: argparse.Namespace,
    body: _Body,
    law: Any,
    member: Mapping[str, Any],
    swept: Mapping[str, Any],
) -> CommandSubject:
    """The body under its law, with its member or its launch."""
    kind: Any = law if isinstance(law, type) else type(law)
    numbers = body.numbers | ({} if law is kind else law.given)
    family = getattr(options, "family", None)
    names = FAMILIES[family].at if family in FAMILIES else ()
    left = [n for n in names if n not in swept]
    at = dict(zip(left, np.ravel(member.get("at", [])), strict=False))
    at |= {n: v for n, v in member.items() if n == "lean"}
    launch = _launch_of(options) if hasattr(options, "start") else where_of(options)
    plain = body.body.dimensionless and not {*SCALES, "length"} & set(swept)
    quantities = round_quantities(
        body.name or THIN, kind, body.shape, [*names, *at, *numbers, *swept]
    )
    who = {"body": body.name, "family": family, "contact": kind.name}
    subject = " of ".join(filter(None, [family, body.name])) or "disk"
    return CommandSubject(
        family=family,
        arguments={body.argument: body.body, "contact": law, **member, **launch},
        who={word: name for word, name in who.items() if name},
        title=f"{subject}, {kind.name} contact",
        law=_law_in_words(options, kind),
        names=names,
        member={**member, **where_of(options)},
        at=at,
        numbers=numbers,
        units={n: q.kind.label(dimensionless=plain) for n, q in quantities.items()},
        rate=Kind.GROWTH_RATE.label(dimensionless=plain),
        scales=scales_of(body.body),
        dimensionless=plain,
        shape=body.shape,
        derived=body.derived,
        states=tuple(STATES),
        energy="the initial energy",
        equations=lambda: body.family(family, law, **where_of(options)),
    )


def _law_in_words(options: argparse.Namespace, law: Any) -> str:
    """The law and its formula; where mu came without a law, also what it is not."""
    words = f"{law.name}: {law.formula}" if law.formula else str(law.name)
    if options.contact is None:
        words += ", taken because no --contact is given; dry friction is --contact coulomb"
        words += "" if hasattr(options, "start") else ", in simulate and scene"
    return words


def scales_of(body: Any) -> str:
    """The units of a body's numbers in words."""
    return f"dimensionless ({ones_of(body)})" if body.dimensionless else "SI"


def ones_of(body: Any) -> str:
    """What is 1 where the numbers of a body have no unit."""
    return f"m = {'R' if hasattr(body, 'radius') else 'length'} = g = 1"


def _member(options: argparse.Namespace, *, needed: bool) -> dict[str, Any]:
    """What names a member of a family by its name: `at` or `lean`, or nothing for an axis."""
    family = options.family
    if family is None:
        raise ParameterError(
            f"FAMILY is missing; name one of {', '.join(FAMILIES)}, or give --system MODULE:FAMILY."
        )
    if ":" in family:
        raise ParameterError(f"FAMILY is {shown(family)}; give --system {family} instead.")
    member = given(options, "at", "lean")
    remedy = f"give --at, or for {leaning()} --lean"
    if len(member) > 1:
        raise ParameterError(f"--at and --lean are both given; {remedy}, and not both.")
    if needed and not member:
        raise ParameterError(f"at is missing; {remedy}.")
    if "at" in member:
        parts = [number(part, "at") for part in options.at.split(",")]
        if len(parts) > 1 and family in FAMILIES:
            _count(options.at, len(parts), FAMILIES[family].at, family)
        member["at"] = parts if len(parts) > 1 else parts[0]
    return member


def _count(text: str, count: int, names: Sequence[str], owner: str) -> None:
    if count != len(names):
        raise ParameterError(
            f"at is {shown(text)}; {owner} takes {' and '.join(names)}, "
            f"{len(names)} number{'s' * (len(names) > 1)}."
        )


def where_of(options: argparse.Namespace) -> dict[str, Any]:
    """What tells members apart whose numbers are the same: an inclination, or a pole."""
    where = given(options, "theta", "pole")
    return where | ({"pole": 0} if where.get("pole") == "0" else {})


def refuse_option(options: argparse.Namespace, name: str, how: str) -> None:
    """Refuse a number that has an option of its own too."""
    if name in given(options, "at", *NUMBERS) | options.numbers:
        raise ParameterError(f"{name} is given as --{name} and {how}; give it once.")


def body_of(options: argparse.Namespace, swept: Mapping[str, Any]) -> _Body:
    """The disk or the body that the options name.

    Parameters
    ----------
    options
        Parsed options.
    swept
        Axes by name, (name, low, high, …); a number of the shape on one of them needs no value.
    """
    if options.body is None:
        _refuse_round(options)
        disk = _disk_of(options, swept)
        return _Body(disk, "disk", "", {n: getattr(disk, n) for n in OF_DISK}, _family_of_disk)
    from ..bodies.round_body.shape import MOMENTS

    body = round_body(options, swept)
    moments = dict(zip(MOMENTS, body.moments(), strict=True))
    numbers = {**body.constants, **body.given, **moments}
    derived = [n for n in numbers if n not in body.given]
    return _Body(body, "body", body.name, numbers, body.family, derived, tuple(body.shape))


def _refuse_round(options: argparse.Namespace) -> None:
    """Refuse options that the disk does not take."""
    place = () if hasattr(options, "start") else ("theta", "pole")
    for name in given(options, "length", "solid", *place):
        word = "solid or --hollow" if name == "solid" else name
        member = "; --at takes theta of the steady motion" * (name == "theta")
        raise ParameterError(f"--{word} is given without --body; leave it out{member}.")


def _family_of_disk(name: str, law: Any) -> Any:
    from ..bodies.subject import disk_family

    return disk_family(name, law)


def _disk_of(options: argparse.Namespace, swept: Mapping[str, Any]) -> Disk:
    numbers = given(options, *OF_DISK)
    if options.disk is None:
        return Disk(**numbers, **middles(swept, SCALES, numbers))
    for name in numbers:
        raise ParameterError(f"--{name} and --disk are both given; give one of them.")
    return Disk.named(options.disk)


# --- a contact law, and numbers ---


def _law_of(
    options: argparse.Namespace,
    numbers: Mapping[str, float],
    free: Collection[str],
    *,
    motion: bool,
    needed: bool,
) -> Any:
    """The contact law, or its class where its coefficients have their values elsewhere.

    Parameters
    ----------
    options
        Parsed options.
    numbers
        Numbers of --set that have no option.
    free
        Names of axes, and of numbers that are held apart.
    motion
        Whether the law is for a motion.
    needed
        Whether the law must have its coefficients.
    """
    name = options.contact or "viscous"
    law = class_named(name, motion=motion)
    coefficients = {**numbers, **given(options, *COEFFICIENTS)}
    for n in free:
        if n in coefficients:
            raise ParameterError(f"{n} is given as a number and as an axis; give it once.")
    elsewhere = {n: 1.0 for n in free if law.alternatives(n)}
    if not coefficients and (elsewhere or not needed):
        return law
    coefficients |= elsewhere
    return law_named(name, coefficients.pop("mu", None), motion=motion, others=coefficients)


def set_numbers(options: argparse.Namespace) -> dict[str, float]:
    """Numbers of --set for which there is no option; others count as given by their option."""
    law = class_named(options.contact or "viscous", motion=True)
    coefficients: dict[str, float] = {}
    for name, text in named_texts("set", options.set).items():
        refuse_option(options, name, "by --set")
        value = number(text, name)
        if name in NUMBERS and hasattr(options, name):
            setattr(options, name, value)
        elif options.body is not None and not law.alternatives(name):
            options.numbers[name] = value
        else:
            coefficients[name] = value
    options.set = None
    return coefficients


def named_texts(
    option: str, texts: Iterable[str] | None, form: str = "NAME=NUMBER"
) -> dict[str, str]:
    """Texts NAME=NUMBER of an option, by name.

    Parameters
    ----------
    option
        The option that gives them, without dashes.
    texts
        The texts.
    form
        What each is.
    """
    out: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--{option} is {shown(text)}; give {form}.")
        if name in out:
            raise ParameterError(f"{name} is given twice; give it once.")
        out[name] = value
    return out


def add_box(parser: argparse.ArgumentParser, use: str = "", *, required: bool = False) -> None:
    """Add `--box`, whose equilibria are used for something that the help says first."""
    words = f"{use}low and high end of a state, or one number at which it is held; once for each"
    values(parser, str, {"--box": ("NAME=LO:HI", words)}, action="append", required=required)


def box_of(options: argparse.Namespace) -> dict[str, Any] | None:
    """The box of `--box`, or None."""
    texts = named_texts("box", options.box, "NAME=LO:HI")
    return {n: _ends(n, text) for n, text in texts.items()} or None


def _ends(name: str, text: str) -> Any:
    parts = [number(part, f"--box {name}") for part in text.split(":")]
    if len(parts) > 2:
        raise ParameterError(f"--box {name} is {shown(text)}; give LO:HI, or one number.")
    return parts[0] if len(parts) == 1 else tuple(parts)


def exact_numbers(
    option: str, texts: Iterable[str] | None, names: Collection[str], owner: str
) -> dict[str, Fraction]:
    """Numbers by name from texts NAME=NUMBER, exactly as they are written.

    Parameters
    ----------
    option, texts
        As for `named_texts`.
    names
        Names that are known.
    owner
        What has these names.
    """
    out: dict[str, Fraction] = {}
    for name, text in named_texts(option, texts).items():
        if name not in names:
            listing = ", ".join(names) or "none"
            raise NameUnknownError(f"--{option} names {shown(name)}; {owner} has {listing}.")
        out[name] = ratio_of_text(name, text)
    return out


def doubles(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers as their nearest doubles."""
    return {n: float(v) for n, v in numbers.items()}


def require(numbers: Collection[str], names: Sequence[str]) -> None:
    """Refuse numbers of a system that are missing."""
    missing = [n for n in names if n not in numbers]
    if missing:
        how = " ".join(f"--set {n}=NUMBER" for n in missing)
        raise ParameterError(f"{absent(missing)}; give {how}.")


# --- a launch ---


def _launch_of(options: argparse.Namespace) -> dict[str, Any]:
    """Start, pose and resistances of one launch of a body, as arguments of `simulate`."""
    if options.start is not None:
        raise ParameterError("--start belongs to --system; a disk takes --theta and the others.")
    _needed(options, "theta")
    return {
        "start": [getattr(options, name) or 0.0 for name in STATES],
        "pose": options.pose or options.film is not None or options.plot is not None,
        "resistance": resistances_of(options),
    }


def _needed(options: argparse.Namespace, *names: str) -> None:
    """Refuse a launch whose start or last time is missing."""
    missing = [f"--{name}" for name in (*names, "time") if getattr(options, name) is None]
    if missing:
        what = f"a number{' each' * (len(missing) > 1)}"
        if "--start" in missing:
            what = "NAME=NUMBER for each state" + ", and a last time" * (len(missing) > 1)
        raise ParameterError(f"{absent(missing)}; give {what}.")


# --- a family or a system of the user ---


def refuse_of_body(options: argparse.Namespace, *more: str) -> None:
    """Refuse options of the disk and bodies with --system."""
    for key, value in given(options, *OF_BODY, *more).items():
        if value is not False or key == "solid":  # which --hollow sets to False
            raise ParameterError(f"{_option(key)} belongs to the disk; with --system leave it out.")


def family_of_user(options: argparse.Namespace) -> Any:
    """The family of --system; options of the disk and bodies must be absent."""
    refuse_of_body(options)
    family = getattr(options, "family", None)
    if family is not None:
        raise ParameterError(
            f"FAMILY is {shown(family)} and --system {shown(options.system)}; give one of them."
        )
    return family_named(options.system)


def _system_subject(
    options: argparse.Namespace, swept: Mapping[str, Any], *, single: bool, exact: bool
) -> CommandSubject:
    """A user's family with its numbers."""
    family = family_of_user(options)
    if swept and options.at is not None and (len(family.at) > 1 or family.at[0] in swept):
        raise ParameterError(
            f"--at means {' and '.join(family.at)} here; give what is no axis as --set NAME=NUMBER."
        )
    numbers = _numbers_and_at(options, family)
    both = sorted(set(swept) & set(numbers))
    if both:
        raise ParameterError(f"{both[0]} is given as a number and as an axis; give it once.")
    if single:
        require(numbers, (*family.at, *family.parameters))
        numbers = {n: numbers[n] for n in (*family.at, *family.parameters)}
    at = {n: numbers[n] for n in family.at} if single else {}
    return CommandSubject(
        family=family,
        arguments={"parameters": numbers if exact else doubles(numbers)},
        who={"system": family.system.name, "family": family.name},
        title=f"{family.system.name}, {family.name}",
        names=tuple(family.at),
        member={"at": doubles(at)} if single else {},
        at=at,
        numbers={n: v for n, v in numbers.items() if n not in at},
        units=family.system.units,
        rate=rate_unit(family.system.units),
        equations=lambda: family,
    )


def _numbers_and_at(options: argparse.Namespace, family: Any) -> dict[str, Fraction]:
    """Every number that --at and --set give, by name, exactly as it is written."""
    numbers = exact_numbers("set", options.set, (*family.at, *family.parameters), family.name)
    if getattr(options, "at", None) is None:
        return numbers
    parts = options.at.split(",")
    _count(options.at, len(parts), family.at, family.name)
    for name, text in zip(family.at, parts, strict=True):
        if name in numbers:
            raise ParameterError(f"{name} is given by --at and --set; give it once.")
        numbers[name] = ratio_of_text(name, text)
    return numbers


def _system_launched(options: argparse.Namespace) -> CommandSubject:
    """A user's system with the families on which it may settle, and its start."""
    launched = hasattr(options, "start")
    refuse_of_body(options, "family")
    if launched:
        _needed(options, "start")
    system, families = system_with_families(options.system)
    arguments = {"disk": system, "families": families}
    if launched:
        start = exact_numbers("start", options.start.split(","), system.states, system.name)
        numbers = exact_numbers("set", options.set, system.parameters, system.name)
        require(numbers, system.parameters)
        arguments |= {"start": doubles(start), "contact": doubles(numbers)}
    return CommandSubject(
        family=None,
        arguments=arguments,
        who={"system": system.name},
        title=system.name,
        units=system.units,
        states=tuple(system.states),
        equations=lambda: system,
    )
