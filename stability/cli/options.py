"""Options that commands share, and their help."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from inspect import Parameter, signature
from typing import Any, NoReturn

from ..base.errors import NameUnknownError, ParameterError, StabilityError, listed, meant, shown
from ..bodies.thin_disk.disk_families import FAMILIES, leaning
from .system_option import contents
from .terminal import say

MOST_VALUES = 1000
"""Most numbers in a list of a table; each takes a line or more."""

CONTACTS = (
    "smooth, viscous, linear-viscous, rough, creep-1 to creep-3, or module:Class for a law of "
    "your own"
)
PARAMETER_HELP = "a number of a law of your own, or of --system, by name; once for each"


def of_own_body(words: Sequence[str]) -> bool:
    """Whether a command line names a user's body, whose numbers are options too."""
    joined = zip(words, [*words, ""][1:], strict=True)
    return any(":" in (w if w.startswith("--body=") else n if w == "--body" else "")
               for w, n in joined)  # fmt: skip


class _Parser(argparse.ArgumentParser):
    """A parser that answers a bad argument with one sentence and exit code 2."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # argparse reads -1e-3, -inf and -1,2 as options; here they are numbers, checked later
        self._negative_number_matcher = re.compile(r"^-(\d|\.\d|inf|nan).*$")

    def parse_args(self, *arguments: Any) -> Any:  # type: ignore[override]
        """Options; those that no parser knows are numbers of a user's body, if one is named."""
        options, options.rest = self.parse_known_args(*arguments)
        return options

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; a command refuses an option that it does not know by itself."""
        found, extra = super().parse_known_args(args, namespace)
        if extra and ":" not in (getattr(found, "body", None) or ""):
            self.error(f"unrecognized arguments: {' '.join(extra)}")
        return found, extra

    def error(self, message: str) -> NoReturn:
        member = re.search(r"unrecognized arguments: .*?--(omega3|phi[-_]dot|theta)\b", message)
        if member:
            typed, name = member[1], member[1].replace("-", "_")
            message = f"--{typed} is not an option here; --at takes {name} of the steady motion"
        wrong = re.match(r"unrecognized arguments: (--[\w-]+)", message)
        if wrong and not member and self._instead(wrong[1]):
            message = f"{wrong[1]} is not an option here{self._instead(wrong[1])}"
        say(f"{message.rstrip('.')}; see `{self.prog} --help`.")
        raise SystemExit(2)

    def _instead(self, wrong: str) -> str:
        """What to give in place of an option that does not exist."""
        if wrong == "--lean":
            axis = ", or --x lean:LO:HI:N" * ("--x" in self._option_string_actions)
            return f"; give --at, for {leaning()} π/2 less the lean{axis}"
        known = [n[2:] for n in self._option_string_actions if n.startswith("--")]
        near = meant(wrong[2:], known)
        return f"; --{near} is" if near else ""


def _family(parser: argparse.ArgumentParser) -> None:
    names = [f.name + (f" ({f.law} disk)" if f.law else "") for f in FAMILIES.values()]
    parser.add_argument("family", metavar="FAMILY", nargs="?", help=listed(names, "or"))


def _member(parser: argparse.ArgumentParser) -> None:
    names: dict[tuple[str, ...], list[str]] = {}
    for family in FAMILIES.values():
        names.setdefault(family.at, []).append(family.name)
    one = listed([at[0] for at in names if len(at) == 1], "or")
    several = [f"for {listed(n)} {','.join(at).upper()}" for at, n in names.items() if len(at) > 1]
    parser.add_argument("--at", help="; ".join([one, *several]))
    help_ = f"for {leaning()}, in place of --at: π/2 - theta, 0 is upright"
    parser.add_argument("--lean", type=float, help=help_)


def overwriting(parser: argparse.ArgumentParser, what: str) -> None:
    """The option that lets a command replace files; `--force` is its other name."""
    parser.add_argument("--overwrite", "--force", dest="force", action="store_true", help=what)


def _physics(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--mu", type=float, help="friction coefficient [s/m] (viscous; c = mu m g for linear)"
    )
    parser.add_argument("--contact", help=f"{CONTACTS} (default viscous)")
    parser.add_argument("--parameter", action="append", metavar="NAME=X", help=PARAMETER_HELP)
    parser.add_argument("--disk", help="a real disk: quarter, le-saux, gymnastics-hoop")
    parser.add_argument("--k", type=float, help="inertia factor in (0, 1/2] (default 1/4)")
    add_scales(parser)
    parser.add_argument("--certify", action="store_true",
                        help="prove every verdict, in rational arithmetic or balls")  # fmt: skip


def add_scales(parser: argparse.ArgumentParser) -> None:
    """Options of the mass, radius and gravity of a body.

    Parameters
    ----------
    parser
        Parser of a command.
    """
    for name, of, unit in (("mass", "body", "kg"), ("radius", "disk", "m"),
                           ("gravity", "body", "m/s²")):  # fmt: skip
        parser.add_argument(
            f"--{name}", type=float,
            help=f"of the {of} [{unit}] (default 1; all three 1: dimensionless)",
        )  # fmt: skip


def contact_of(
    options: argparse.Namespace, *, motion: bool = False, swept: Collection[str] = ()
) -> Any:
    """The contact law that the options name; a parameter swept by an axis gets the value 1."""
    from ..bodies.law_names import class_named, law_named

    options.contact = options.contact or "viscous"
    law = class_named(options.contact, motion=motion)
    own = {p.name for p in law.parameters}
    given = {n: 1.0 for n in swept if n in own}
    for text in options.parameter or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--parameter is {shown(text)}; give NAME=NUMBER.")
        if name in given:
            raise ParameterError(f"{name} is given twice; give it once.")
        given[name] = _number(value, name)
    if given and set(given) <= set(swept) and options.mu is None:
        return law
    epsilon = getattr(options, "epsilon", None)
    return law_named(options.contact, options.mu, motion=motion, epsilon=epsilon, others=given)


def _disk(options: argparse.Namespace) -> Any:
    from ..bodies.disk import Disk

    given = {n: getattr(options, n) for n in ("mass", "radius", "k", "gravity")}
    given = {n: v for n, v in given.items() if v is not None}
    if options.disk is None:
        return Disk(**given)
    if given:
        raise ParameterError(f"--{next(iter(given))} and --disk are both given; give one of them.")
    return Disk.named(options.disk)


def _number(text: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ParameterError(f"{name} is {shown(text)}; a number is needed.") from None


def _at(text: str) -> float | list[float]:
    parts = [_number(part, "at") for part in str(text).split(",")]
    return parts[0] if len(parts) == 1 else parts


def _list(text: str) -> list[float]:
    if text.count(",") >= MOST_VALUES:
        raise argparse.ArgumentTypeError(
            f"{text.count(',') + 1} numbers are given, at most {MOST_VALUES}; make several tables"
        )
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{shown(text)} is not a comma-separated list of numbers"
        ) from None


def _axis(text: str, which: str) -> Any:
    parts = text.split(":")
    if len(parts) not in (4, 5):
        raise ParameterError(f"{which} is {shown(text)}; give NAME:LO:HI:N or NAME:LO:HI:N:log.")
    name, low, high, count, *rest = parts
    try:
        number = int(count)
    except ValueError:
        raise ParameterError(
            f"{which} is {shown(text)}, with {shown(count)} points; a whole number is needed."
        ) from None
    ends = [_number(v, f"an end of {which} {shown(text)}") for v in (low, high)]
    return (name, *ends, number, *rest)


def _axis_ends(text: str, which: str) -> tuple[str, float, float]:
    parts = text.split(":")
    if len(parts) != 3:
        raise ParameterError(f"{which} is {shown(text)}; give NAME:START:STOP.")
    return parts[0], _number(parts[1], which), _number(parts[2], which)


def _picture(path: str, force: bool) -> Any:
    from ..storage.targets import PICTURES, check_suffix, check_target

    return check_target(check_suffix(path, PICTURES, "--plot"), overwrite=force)


def _shape_options() -> dict[str, list[str]]:
    """Numbers of named bodies, each with its bodies and their defaults, from their signatures."""
    from ..bodies.round_body.shapes.named import NAMED

    found: dict[str, list[str]] = {}
    for body, make in NAMED.items():
        for name, number in _numbers_of(make).items():
            usual = number.default
            known = type(usual) is float
            found.setdefault(name, []).append(f"{body} (default {usual:g})" if known else body)
    return found


def _numbers_of(make: Callable[..., Any]) -> dict[str, Parameter]:
    """The parameters of a body's function that have a name."""
    every = signature(make).parameters
    return {n: p for n, p in every.items() if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)}


def add_body(
    parser: argparse.ArgumentParser, words: Sequence[str] | None, *, motion: bool = False
) -> None:
    """Add the option for a body of revolution, and those for its numbers.

    Parameters
    ----------
    parser
        Parser of a command.
    words
        The command line; where it names no body nor asks for help, the options are left out, since
        their signatures load CasADi.  They are added where it is not known.
    motion
        Whether the command is about motions and not about a member of a family.
    """
    parser.set_defaults(body=None)
    if words is not None and not any(w.startswith(("--b", "-h", "--h")) for w in words):
        return
    from ..bodies.round_body.shapes.named import NAMED

    bodies = ", ".join(
        " ".join([
            body, *(f"--{n} X" for n, p in _numbers_of(make).items() if p.default is p.empty),
            *(f"[--{n} X]" for n, p in _numbers_of(make).items() if type(p.default) is float),
        ])
        for body, make in NAMED.items()
    )  # fmt: skip
    group = parser.add_argument_group(
        "bodies of revolution",
        "in place of the disk, such as --body torus --tube 0.2",
    )
    group.add_argument("--body", metavar="NAME", help=f"{bodies}; or module:name or file.py:name "
                       "of a body of your own, or of a function that returns one, each of whose "
                       "numbers is an option --NAME X")  # fmt: skip
    for name, owners in _shape_options().items():
        of = listed([f"of {owner}" for owner in owners], "or")
        if name == "solid":
            group.add_argument("--solid", action="store_true", default=None, help=f"{of} (default)")
            group.add_argument("--hollow", action="store_false", dest="solid", help=of)
        else:
            group.add_argument(f"--{name}", type=float, help=of)
    group.add_argument("--length", type=float, help="unit of the body's numbers [m] (default 1)")
    if not motion:
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
    from ..bodies.round_body.families import FAMILIES as KNOWN
    from ..bodies.round_body.shape import SCALES
    from ..bodies.round_body.shapes.named import NAMED

    for key in ("system", "disk", "k", "radius", "lean"):
        if getattr(options, key, None) is not None:
            raise ParameterError(f"--{key} does not go with --body; leave one of them out.")
    if getattr(options, "family", "") is None:
        raise ParameterError(f"FAMILY is missing; name one of {', '.join(KNOWN)}.")
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
    return {n: _number(v, n) for n, v in zip(names, words[1::2], strict=True)}


def _own_body(place: str, named: Collection[str]) -> Any:
    """A user's body, or the function that makes it."""
    from ..bodies.round_body.body import Body

    if ":" not in place:
        raise NameUnknownError(
            f"body is {shown(place)}; known are {', '.join(named)}, or give `module:body` or "
            "`file.py:body`."
        )
    module, name, table = contents("body", "body", place)
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


def numbers_of_body(body: Any, contact: Any) -> dict[str, float]:
    """Every number of a body and of its law by name: scales, shape, moments of inertia, law."""
    from ..bodies.round_body.shape import MOMENTS

    moments = dict(zip(MOMENTS, body.moments(), strict=True))
    law = {} if contact is None else contact.given
    return {n: float(v) for n, v in (body.constants | body.given | moments | law).items()}


def in_words(body: Any, numbers: Mapping[str, float]) -> str:
    """Numbers of a body as text; without mass, gravity and length where these are 1."""
    from ..bodies.round_body.shape import SCALES

    left = SCALES if body.dimensionless else ()
    return ", ".join(f"{n} = {v:g}" for n, v in numbers.items() if n not in left)
