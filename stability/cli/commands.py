"""The command line: a thin layer on the public names."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ..base.errors import StabilityError, StabilityWarning
from ..base.version import __version__
from ..storage.text import HELP
from . import (
    atlas,
    basins,
    boundaries,
    branch,
    cite,
    compare,
    equilibria,
    explore,
    export,
    map,  # noqa: A004  # the name of the command
    scene,
    simulate,
    spectrum,
    table,
)
from .options import _Parser
from .terminal import LEAST_MEMORY, allowed_memory, drop_output, prepare, say, starved, stoppable

COMMANDS: dict[str, tuple[Any, str]] = {
    "spectrum": (spectrum, "Eigenvalues and verdict of one steady motion"),
    "map": (map, "Verdict and growth rate over two parameters"),
    "boundaries": (
        boundaries,
        "Every change of verdict along one axis, proved, and whether these are all",
    ),
    "branch": (branch, "A family followed round its folds, and where other branches cross it"),
    "equilibria": (
        equilibria,
        "Every steady state of a system of your own in a box, proved, and whether these are all",
    ),
    "atlas": (
        atlas,
        "The families' diagrams for disk, annulus and hoop, or for other bodies of revolution",
    ),
    "explore": (explore, "The diagrams alive in a browser: one page, no network"),
    "simulate": (
        simulate,
        "Launch a disk, another body, or a system, and say what becomes of it",
    ),
    "basins": (basins, "Which launch ends where, over two numbers or a random sample"),
    "scene": (scene, "A scene of a TOML file, answered by the least model"),
    "table": (table, "A table, recomputed: families, conditions, drift, hopf, …"),
    "export": (export, "A system or family for LaTeX, C, AUTO-07p or BifurcationKit.jl"),
    "cite": (cite, "What to cite for this package, or for a file that it wrote"),
    "chart": (compare.CHART, "Time against error, by every route to a spectrum or a motion"),
    "failures": (
        compare.CATALOGUE,
        "Hard cases against every method: right, degraded, wrong, refused, crashed",
    ),
    "report": (compare.REPORT, "Both charts and the catalogue of failures on one page"),
}
"""Every command: its module, with `EXAMPLES`, `add_arguments` and `run`, and what it does."""


@contextmanager
def _warnings() -> Iterator[None]:
    """Print each warning of the package as one line on standard error."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", StabilityWarning)
        plainly = warnings.showwarning

        def show(message: Any, category: Any, *rest: Any, **more: Any) -> None:
            if issubclass(category, StabilityWarning):
                say(f"note: {message}")
            else:
                plainly(message, category, *rest, **more)

        warnings.showwarning = show
        yield


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments
        Words after the program's name; the words of the process when left out.

    Returns
    -------
    int
        Exit code: 0 done, 2 bad input, 130 interrupted (143 by SIGTERM, 129 by SIGHUP).

    Examples
    --------
    >>> main(["spectrum", "rolling", "--at", "1.8", "--mu", "0.3"])  # doctest: +ELLIPSIS
    rolling, viscous contact, at omega3 = 1.8 √(g/R), k = 0.25, mu = 0.3 1/√(gR)
    law         viscous: F = -μ N v, taken because no --contact is given; dry friction is ...
    verdict     stable: ...
    """
    if not prepare():
        say("standard output is closed; lead it somewhere, if only to /dev/null.")
        return 2
    if allowed_memory() < LEAST_MEMORY:
        say(
            f"the process is allowed {allowed_memory() >> 20} MiB of memory (ulimit -v); the "
            f"libraries need {LEAST_MEMORY >> 20} MiB, allow it more."
        )
        return 2
    with stoppable() as stop:
        try:
            _run(arguments)
            stop.check()
        except BaseException as reason:
            # an interrupted library may raise any error: an import fails, a solver stops
            if stop.number or isinstance(reason, KeyboardInterrupt):
                text = str(reason) if isinstance(reason, KeyboardInterrupt) else ""
                say(f"{text or stop.sentence}.")
                return stop.code
            return _code(reason)
    return 0


def _run(arguments: Sequence[str] | None) -> None:
    try:
        words = sys.argv[1:] if arguments is None else arguments
        parser = _parser(words)
        if not words:
            parser.print_help()
            return
        options = parser.parse_args(words)
        run: Callable[[argparse.Namespace], None] = options.run
        with _warnings():
            run(options)
    except SystemExit:  # after --help, --version or a bad argument
        sys.stdout.flush()
        raise
    sys.stdout.flush()


def _code(reason: BaseException) -> int:
    """Print the error in one sentence, and return the exit code."""
    if isinstance(reason, StabilityError):
        say(str(reason))
    elif isinstance(reason, BrokenPipeError):  # the reader of the output has closed it: no error
        drop_output()
        return 0
    elif starved(reason):
        say("there is too little memory for this; ask for fewer points, or allow it more.")
    elif isinstance(reason, OSError):
        drop_output()
        say(f"the output cannot be written: {reason.strerror or reason}.")
    else:
        raise reason
    return 2


def _parser(words: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """The parser of a command line: of every command, with the options of those that it names."""
    parser = _Parser(
        prog="stability",
        description="Which steady motions of a thin disk on a plane can be seen?",
        epilog="example: stability spectrum rolling --at 1.8 --mu 0.3",
    )
    parser.add_argument("--version", action="version", version=f"stability {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, (module, what) in COMMANDS.items():
        examples = "; ".join(f"example: {line}" for line in module.EXAMPLES)
        command = commands.add_parser(name, help=what, description=f"{what}.", epilog=examples)
        command.set_defaults(run=module.run)
        if not words or name in words:  # the options of the others would take time
            command.add_argument("--json", action="store_true", help=HELP)
            module.add_arguments(command)
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
