"""Options that commands share, and their help."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from ..base.errors import ParameterError, meant, shown
from ..bodies.families import leaning
from .terminal import say

MOST_VALUES = 1000
"""Most numbers in a list of a table; each takes a line or more."""


def of_own_body(words: Sequence[str]) -> bool:
    """Whether a command line names a user's body, whose numbers are options too."""
    joined = zip(words, [*words, ""][1:], strict=True)
    return any(
        ":" in (w if w.startswith("--body=") else n if w == "--body" else "") for w, n in joined
    )


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


class _Unasked(_Parser):
    """A command that the line does not name: a line of help, without the time its options take."""

    def add_argument(self, *_: Any, **__: Any) -> Any:
        """Nothing."""


def overwriting(parser: argparse.ArgumentParser, what: str) -> None:
    """The option that lets a command replace files; `--force` is its other name."""
    parser.add_argument("--overwrite", "--force", dest="force", action="store_true", help=what)


def step_error(parser: argparse.ArgumentParser) -> None:
    """The error that commands of motions allow in a step."""
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e-9,
        metavar="E",
        help="error allowed in a step (default 1e-9)",
    )


def scheduling(parser: argparse.ArgumentParser, default: str | None = "threads") -> None:
    """Options of the workers of a job; `default` is the scheduler where none is given."""
    parser.add_argument(
        "--scheduler",
        metavar="WHERE",
        default=default,
        help="threads (default), processes, dask, or the address of a scheduler of "
        "dask such as tcp://127.0.0.1:8786",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="workers (default: all cores)")


def number(text: str, name: str) -> float:
    """A number that an option gives, by the name that a message uses."""
    try:
        return float(text)
    except ValueError:
        raise ParameterError(f"{name} is {shown(text)}; a number is needed.") from None


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
        points = int(count)
    except ValueError:
        raise ParameterError(
            f"{which} is {shown(text)}, with {shown(count)} points; a whole number is needed."
        ) from None
    ends = [number(v, f"an end of {which} {shown(text)}") for v in (low, high)]
    return (name, *ends, points, *rest)


def targets(options: argparse.Namespace, *ways: str) -> dict[str, Path]:
    """The files that a command writes by `--out`, `--plot` and `--film`, checked at first.

    Parameters
    ----------
    options
        Parsed options.
    *ways
        Ways to write the dataset, one of which its format needs: see `formats_for`.
    """
    from ..storage.datasets import dataset_target
    from ..storage.targets import FILMS, PICTURES, check_suffix, check_target

    found: dict[str, Path] = {}
    for name, endings in (("out", ()), ("plot", PICTURES), ("film", FILMS)):
        path, option = getattr(options, name, None), f"--{name}"
        if path is None:
            continue
        if name == "out":
            target = dataset_target(path, *ways, overwrite=options.force, option=option)
        else:
            target = check_target(check_suffix(path, endings, option), overwrite=options.force)
        if target.resolve() in [t.resolve() for t in found.values()]:
            raise ParameterError(
                f"{option} is {shown(path)}, which another file has; give two names."
            )
        found[name] = target
    return found
