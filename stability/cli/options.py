"""The parser of a command, options that commands share, and how an answer is printed."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn

from ..base.errors import ParameterError, listed, meant, shown
from ..base.exact_numbers import ratio_of_text
from ..base.types import Overwrite
from ..bodies.families import leaning
from ..storage.text import json_text
from .terminal import say

AXIS = "NAME:LO:HI:N[:log]"
"""How an axis is written."""
CERTIFY = "prove every verdict, in rational arithmetic or balls"
"""Help of an option."""
MOST_VALUES = 1000
"""Most numbers in a list of a table; each takes a line or more."""
RENAMED = {"--parameter": "--set"}
"""Options of earlier versions, and their names now."""


class _Parser(argparse.ArgumentParser):
    """A parser that answers a bad argument with one sentence and exit code 2."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options | {"allow_abbrev": False})
        # argparse reads -1e-3, -inf and -1,2 as options; here they are numbers, checked later
        self._negative_number_matcher = re.compile(r"^-(\d|\.\d|inf|nan).*$")
        self._texts: list[tuple[argparse.Action, Callable[[], str]]] = []

    def add_argument(self, *names: Any, **settings: Any) -> Any:
        """As argparse does; a help that is a function is called where help is asked for."""
        text = settings.get("help")
        if not callable(text):
            return super().add_argument(*names, **settings)
        action = super().add_argument(*names, **settings | {"help": ""})
        self._texts.append((action, text))
        return action

    def format_help(self) -> str:
        """The help, with the lists that it names read from their places."""
        for action, text in self._texts:
            action.help = text()
        return super().format_help()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does, but an unknown option is refused first, with the nearest known one.

        With --body an unknown option with a number is one of the numbers of the body.
        """
        words: list[str] = list(args or ())
        numbers: dict[str, float] = {}
        if self._subparsers is None:
            words, numbers = self._without_numbers(words)
        before = takewhile(lambda word: word != "--", words)
        if self._subparsers is not None:  # the words after the command are that parser's
            before = takewhile(lambda word: word.startswith("-"), before)
        for word in before:
            option = word.partition("=")[0]
            if word.startswith("--") and option not in self._option_string_actions:
                self.error(self._no_option(option))
        options, extra = super().parse_known_args(words, namespace)
        if extra:
            self.error(f"{extra[0]} belongs to no option")
        if self._subparsers is None:
            options.numbers, options.known = numbers, list(self._option_string_actions)
        return options, extra

    def _without_numbers(self, words: Sequence[str]) -> tuple[list[str], dict[str, float]]:
        """A command line without the numbers of its body, --NAME X or --NAME=X, and these."""
        options = self._option_string_actions
        if "--body" not in options or not any(w.partition("=")[0] == "--body" for w in words):
            return list(words), {}
        kept: list[str] = []
        numbers: dict[str, float] = {}
        rest = iter(words)
        for word in rest:
            option, equals, text = word.partition("=")
            if not option.startswith("--") or option == "--" or option in options:
                kept.append(word)
                continue
            name = option[2:].replace("-", "_")
            value = text if equals else next(rest, "")
            if name in numbers:
                self.error(f"{option} is given twice; give it once")
            parsed = _real(value)
            if parsed is None:
                near = nearest(option, options)
                other = f", and an option of the command is {near}" if near else ""
                self.error(f"{name} is {shown(value)}; a number is needed{other}")
            numbers[name] = parsed
        return kept, numbers

    def error(self, message: str) -> NoReturn:
        say(f"{message.rstrip('.')}; see `{self.prog} --help`.")
        raise SystemExit(2)

    def _no_option(self, wrong: str) -> str:
        """That there is no such option, and what to give in its place."""
        options = self._option_string_actions
        states = [wrong[2:].replace("-", "_")] if "--at" in options else []
        if states and states[0] in ("omega3", "phi_dot", "theta"):
            return f"{wrong} is not an option here; --at takes {states[0]} of the steady motion"
        if "--start" in options and wrong in ("--family", "--at", "--lean", "--tilt"):
            return f"{wrong} is not an option here; give the states at time 0: --theta and others"
        if wrong == "--lean":
            axis = ", or --x lean:LO:HI:N" * ("--x" in options)
            return (
                f"--lean is not an option here; give --at, for {leaning()} π/2 less the lean{axis}"
            )
        near = RENAMED.get(wrong) or nearest(wrong, options)
        return (
            f"{wrong} is not an option here; {near} is"
            if near
            else f"{wrong} is not an option here"
        )


def nearest(wrong: str, options: Iterable[str]) -> str:
    """The options for which a wrong one may stand: those that it begins, or one like it."""
    full = [n for n in options if n.startswith("--")]
    begun = [n for n in full if n.startswith(wrong)]
    like = meant(wrong[2:], [n[2:] for n in full])
    return listed(begun, "or") if begun else f"--{like}" if like else ""


# --- options that commands share ---


def overwriting(parser: argparse.ArgumentParser, what: str, *, same: bool = True) -> None:
    """The options that let a command replace files; `--force` is another name of the first."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--overwrite", "--force", dest="force", action="store_true", help=what)
    if same:
        text = "replace what the same command wrote, and nothing else"
        group.add_argument(
            "--overwrite-same",
            dest="force",
            action="store_const",
            const="same",
            default=False,
            help=text,
        )


def plotting(parser: argparse.ArgumentParser, what: str = "") -> None:
    """The option of a figure; `what` says which one."""
    text = f"figure to write (PNG, PDF or SVG){what}"
    parser.add_argument("--plot", metavar="F.png", help=text)


def step_error(parser: argparse.ArgumentParser) -> None:
    """The error that commands of motions allow in a step."""
    text = "error allowed in a step (default 1e-9)"
    parser.add_argument("--tolerance", type=real, default=1e-9, metavar="E", help=text)


def scheduling(parser: argparse.ArgumentParser, default: str | None = "threads") -> None:
    """Options of the workers of a job; `default` is the scheduler where none is given."""
    where = (
        "threads (default), processes, dask, or the address of a scheduler of dask such as "
        "tcp://127.0.0.1:8786"
    )
    parser.add_argument("--scheduler", metavar="WHERE", default=default, help=where)
    parser.add_argument("--workers", type=whole, metavar="N", help="workers (default: all cores)")


def flags(parser: argparse.ArgumentParser, texts: Mapping[str, str]) -> None:
    """Options without a value, with their help."""
    for name, text in texts.items():
        parser.add_argument(name, action="store_true", help=text)


def values(
    parser: argparse.ArgumentParser,
    kind: Any,
    texts: Mapping[str, tuple[str, str]],
    **settings: Any,
) -> None:
    """Options with a value of one kind, each with the value's name and its help."""
    for name, (value, text) in texts.items():
        parser.add_argument(name, type=kind, metavar=value, help=text, **settings)


def dataset_help(*ways: str, more: str = "") -> Callable[[], str]:
    """The help of an option that names a dataset to write in one of some ways, with its endings."""

    def text() -> str:
        from ..storage.formats import formats_for

        endings = [ending for format_ in formats_for(*ways) for ending in format_.endings]
        return f"dataset to write, by its ending: {', '.join(endings)}{more}"

    return text


# --- what they hold ---


def given(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Those of the options that the command has and that the line gives, by name."""
    every = {name: getattr(options, name, None) for name in names}
    return {name: value for name, value in every.items() if value is not None}


def real(text: str) -> float:
    """A number, as the type of an option: a decimal, or a fraction of integers such as 1/4.

    A fraction is the nearest double, as a decimal is.
    """
    value = _real(text)
    if value is None:
        raise argparse.ArgumentTypeError(
            f"{shown(text)} is no number; give one such as 0.25 or 1/4"
        )
    return value


def whole(text: str) -> int:
    """A whole number, as the type of an option."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{shown(text)} is no whole number") from None


def _real(text: str) -> float | None:
    try:
        return float(ratio_of_text("", text)) if "/" in text else float(text)
    except ValueError:
        return None


def number(text: str, name: str) -> float:
    """A number that an option gives, by the name that a message uses."""
    value = _real(text)
    if value is None:
        raise ParameterError(f"{name} is {shown(text)}; a number is needed.")
    return value


def numbers(text: str) -> list[float]:
    """A list of numbers, as the type of an option."""
    if text.count(",") >= MOST_VALUES:
        raise argparse.ArgumentTypeError(
            f"{text.count(',') + 1} numbers are given, at most {MOST_VALUES}; make several tables"
        )
    parts = [_real(part) for part in text.split(",")]
    if None in parts:
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a comma-separated list of numbers")
    return [part for part in parts if part is not None]


def words_of(text: str | None) -> tuple[str, ...]:
    """The words of a list that is separated by commas; none where it is left out."""
    return tuple(text.split(",")) if text else ()


def axis_of(text: str, which: str, *, points: bool = True) -> Any:
    """An axis as a tuple: its name, its ends, its number of points if it has one, and its spacing.

    Parameters
    ----------
    text
        What the option holds.
    which
        The option.
    points
        Whether the number of points is given too.
    """
    form = "NAME:LO:HI:N" if points else "NAME:LO:HI"
    name, *parts = text.split(":")
    ends, rest = parts[:2], parts[2:]
    count, spacing = (rest[:1], rest[1:]) if points else ([], rest)
    if len(ends) < 2 or len(count) != points or len(spacing) > 1:
        raise ParameterError(f"{which} is {shown(text)}; give {form} or {form}:log.")
    try:
        whole = [int(n) for n in count]
    except ValueError:
        raise ParameterError(
            f"{which} is {shown(text)}, with {shown(count[0])} points; a whole number is needed."
        ) from None
    limits = [number(v, f"an end of {which} {shown(text)}") for v in ends]
    return (name, *limits, *whole, *spacing)


def axes_of(options: argparse.Namespace, *names: str, points: bool = True) -> dict[str, Any]:
    """The axes that are given, by the names of their options."""
    return {
        name: axis_of(text, f"--{name}", points=points)
        for name, text in given(options, *names).items()
    }


def targets_of(options: argparse.Namespace, *ways: str, out: Sequence[str] = ()) -> dict[str, Path]:
    """The files of `--out`, `--plot` and `--film`, checked before anything is computed.

    Parameters
    ----------
    options
        Parsed options.
    *ways
        Ways to write a dataset, one of which the format of `--out` needs: see `formats_for`.
    out
        Endings of `--out` where it is no dataset.
    """
    from ..storage.datasets import dataset_target
    from ..storage.targets import FILMS, PICTURES, check_suffix, check_target

    targets: dict[str, Path] = {}
    for name, text in given(options, "out", "plot", "film").items():
        endings, option = {"out": out, "plot": PICTURES, "film": FILMS}[name], f"--{name}"
        if endings:
            target = check_target(check_suffix(text, endings, option), overwrite=options.force)
        else:
            target = dataset_target(text, *ways, overwrite=options.force, option=option)
        if target.resolve() in [t.resolve() for t in targets.values()]:
            raise ParameterError(
                f"{option} is {shown(text)}, which another file has; give two names."
            )
        targets[name] = target
    return targets


# --- the answer ---


FORMS = {
    "--csv": "print CSV: one header line with units, all digits",
    "--latex": "print LaTeX, with booktabs",
}
"""Further forms of an answer that is a table."""


def check_form(options: argparse.Namespace) -> None:
    """Refuse two forms of one answer."""
    asked = [f"--{form}" for form in ("json", "csv", "latex") if getattr(options, form)]
    if len(asked) > 1:
        raise ParameterError(f"{asked[0]} and {asked[1]} are both given; give one of them.")


def answer(
    options: argparse.Namespace,
    record: Any,
    lines: Iterable[str],
    forms: Mapping[str, Callable[[], str]] | None = None,
) -> None:
    """Print the answer: one JSON object with `--json`, otherwise lines.

    Parameters
    ----------
    options
        Parsed options.
    record
        The JSON object.
    lines
        The lines.
    forms
        Makers of the answer in each of `FORMS`, by the name of its option.
    """
    for form, make in (forms or {}).items():
        if getattr(options, form):
            print(make().rstrip("\n"))
            return
    if options.json:
        print(json_text(record))
        return
    for line in lines:
        print(line)


def save(figure: Any, target: Path, *, overwrite: Overwrite) -> None:
    """Write a figure."""
    from ..figures.canvas import save_figure

    save_figure(figure, target, overwrite=overwrite)
