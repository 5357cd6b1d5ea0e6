"""The command line: a thin layer on the public names."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

from ..base.errors import ParameterError, StabilityError, StabilityWarning
from ..base.version import __version__
from ..storage.text import HELP, json_text
from . import basins, cite, compare, explore, export, scene, simulate, table
from .map import _boundaries, _map
from .options import _Parser, _Unasked, of_own_body, overwriting, scheduling
from .spectrum import _spectrum
from .subject import add_member, add_subject
from .terminal import (
    LEAST_MEMORY,
    allowed_memory,
    drop_output,
    prepare,
    progress_bar,
    say,
    starved,
    stoppable,
)

CERTIFY = "prove every verdict, in rational arithmetic or balls"
"""Help of an option."""


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
    rolling, viscous contact, at omega3 = 1.8, k = 0.25, mu = 0.3
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
                told = str(reason) if isinstance(reason, KeyboardInterrupt) else ""
                say(f"{told or stop.sentence}.")
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
        options = parser.parse_args(arguments)
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


def _atlas(options: argparse.Namespace) -> None:
    if options.bodies and options.draft is not None:
        raise ParameterError("--draft belongs to the atlas of the disk; leave it or --bodies out.")
    finer = {} if options.resolution is None else {"resolution": options.resolution}
    with progress_bar("figures") as progress:
        from ..atlas.bodies import atlas_of_bodies
        from ..atlas.build import atlas
        from ..atlas.page import summary

        if options.bodies:
            page = atlas_of_bodies(options.out, overwrite=options.force, progress=progress, **finer)
        else:
            page = atlas(
                options.out, draft=options.draft, overwrite=options.force, progress=progress,
                **finer,
            )  # fmt: skip
    if options.json:
        print(json_text(summary(page)))
    else:
        print(f"open {page}")


# --- arguments ---


def _parser(words: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """The parser of all commands, for a command line."""
    parser = _Parser(
        prog="stability",
        description="Which steady motions of a thin disk on a plane can be seen?",
        epilog="example: stability spectrum rolling --at 1.8 --mu 0.3",
    )
    parser.add_argument("--version", action="version", version=f"stability {__version__}")

    def empty_unless_named(**given: Any) -> _Parser:
        named = not words or given["prog"].split()[-1] in words
        return (_Parser if named else _Unasked)(**given)

    kind = cast("type[_Parser]", empty_unless_named)
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND",
                                     parser_class=kind)  # fmt: skip

    def command(name: str, run: Any, what: str, *examples: str) -> argparse.ArgumentParser:
        shown = "; ".join(f"example: {one}" for one in examples)
        sub: argparse.ArgumentParser = commands.add_parser(
            name, help=what, description=f"{what}.", epilog=shown,
            allow_abbrev=not of_own_body(words or ()),
        )  # fmt: skip
        sub.set_defaults(run=run)
        sub.add_argument("--json", action="store_true", help=HELP)
        return sub

    sub = command("spectrum", _spectrum, "Eigenvalues and verdict of one steady motion",
                  "stability spectrum tumbling --at 0.5 --mu 0.3 --json",
                  "stability spectrum spinning --body torus --tube 0.2 --at 2 --mu 0.3",
                  "stability spectrum --system examples/bicycle.py:upright --at 5 --set "
                  "g=9.81 --certify")  # fmt: skip
    add_subject(sub, words)
    add_member(sub)
    sub.add_argument("--no-escalate", action="store_true",
                     help="leave undecided what double precision does not decide")  # fmt: skip
    sub.add_argument("--certify", action="store_true", help=CERTIFY)

    sub = command("map", _map, "Verdict and growth rate over two parameters",
                  "stability map spinning --x at:0.5:5:400 --y mu:0.01:10:300:log "
                  "--out spinning.nc --plot spinning.png",
                  "stability map spinning --body torus --x at:0.5:5:80 --y tube:0.05:0.5:60 "
                  "--mu 0.3 --out torus.nc",
                  "stability map --system examples/bicycle.py:upright --x v:0.1:10:200 "
                  "--y g:1:20:100 --out bicycle.nc --plot bicycle.png",
                  "stability map spinning --x at:0.5:5:20000 --y mu:0.01:10:20000:log "
                  "--out large.zarr --scheduler processes --workers 8")  # fmt: skip
    add_subject(sub, words)
    for axis in ("--x", "--y"):
        sub.add_argument(axis, required=True, metavar="NAME:LO:HI:N[:log]",
                         help="axis: at, lean, k, mu, mass, radius or gravity; with --body or "
                         "--system one of the family's own quantities, such as tube")  # fmt: skip
    sub.add_argument("--at", default=None, help="what names the member, where it is no axis")
    sub.add_argument("--certify", action="store_true", help=CERTIFY)
    sub.add_argument("--out", required=True, metavar="F.nc",
                     help="NetCDF file to write; F.zarr is a folder that a map of any size is "
                     "computed into, chunk by chunk, and the same command goes on")  # fmt: skip
    sub.add_argument("--plot", metavar="F.png", help="figure to write (PNG, PDF or SVG)")
    sub.add_argument("--levels", type=int, metavar="L",
                     help="with --certify: halve the map this often at most")  # fmt: skip
    sub.add_argument(
        "--modes", action="store_true", help="keep all eigenvalues, not only the first"
    )
    sub.add_argument("--points", action="store_true",
                     help="find, mark and list points of codimension two")  # fmt: skip
    sub.add_argument("--verdict-only", action="store_true",
                     help="proved verdicts alone, streamed to the file, however large")  # fmt: skip
    sub.add_argument("--checkpoint", metavar="DIR",
                     help="keep finished cells there, to go on after an interruption")  # fmt: skip
    scheduling(sub, None)
    overwriting(sub, "replace existing files")

    sub = command("boundaries", _boundaries,
                  "Every change of verdict along one axis, proved, and whether these are all",
                  "stability boundaries spinning --axis at:0.1:5:9 --mu 0.97",
                  "stability boundaries rolling --body spheroid --aspect 0.5 --axis omega3:0.1:3:9 "
                  "--contact rough",
                  "stability boundaries --system examples/bicycle.py:upright --axis v:0.1:10:50 "
                  "--set g=9.81 --json")  # fmt: skip
    add_subject(sub, words)
    sub.add_argument("--axis", required=True, metavar="NAME:LO:HI:N[:log]",
                     help="axis, both ends included; N points are scanned where pieces of it stay "
                     "without proof")  # fmt: skip
    sub.add_argument("--at", default=None, help="what names the member, where it is no axis")
    sub.add_argument("--certify", action="store_true", help=CERTIFY)

    sub = command("atlas", _atlas, "The families' diagrams for disk, annulus and hoop, or for "
                  "other bodies of revolution", "stability atlas --out atlas",
                  "stability atlas --bodies --out bodies")  # fmt: skip
    sub.add_argument("--bodies", action="store_true",
                     help="torus, spheroids, eccentric sphere, thick disk and egg, a page for "
                     "each; finished figures are kept in DIR.parts until all are done")  # fmt: skip
    sub.add_argument("--out", required=True, metavar="DIR", help="folder to write")
    sub.add_argument("--resolution", type=int, metavar="N",
                     help="points along the family's axis (default 400, of bodies 96)")  # fmt: skip
    sub.add_argument("--draft", action=argparse.BooleanOptionalAction, default=None,
                     help="the diagrams alone, as PNG, without loci and PDFs; the default below "
                     "100 points, not with --bodies")  # fmt: skip
    overwriting(sub, "replace files in an existing folder")

    sub = command("explore", explore.run, "The diagrams alive in a browser: one page, no network",
                  *explore.EXAMPLES)  # fmt: skip
    add_subject(sub, words)
    sub.add_argument("--at", default=None, help="member that is shown at first")
    explore.add_arguments(sub)
    overwriting(sub, "replace an existing file")

    sub = command("simulate", simulate.run,
                  "Launch a disk, another body, or a system, and say what becomes of it",
                  "stability simulate --theta 1.47 --omega3 1.2 --mu 0.3 --time 100 "
                  "--out run.nc --plot run.png --film run.html",
                  "stability simulate --body eccentric-sphere --offset 0.15 --theta 0.1 --omega3 5 "
                  "--mu 0.3 --time 200 --points 2001 --film top.gif",
                  "stability simulate --system examples/watt_governor.py:running --start "
                  "x=1,y=0,z=1.4 --set e=0.8 --set a=0.5 --set b=0.5 "
                  "--time 200")  # fmt: skip
    simulate.add_arguments(sub, words)

    sub = command("basins", basins.run,
                  "Which launch ends where, over two numbers or a random sample",
                  *basins.EXAMPLES)  # fmt: skip
    basins.add_arguments(sub, words)

    sub = command("scene", scene.run, "A scene of a TOML file, answered by the least model",
                  "stability scene examples/scenes/rolled-coin.toml --json")  # fmt: skip
    scene.add_arguments(sub)

    table.add_arguments(command(
        "table", table.run, "A table, recomputed: families, conditions, drift, hopf, …",
        "stability table --list",
        "stability table conditions --k 0.25,0.5 --mu 0.1,1,10",
        "stability table drift --k 0.25 --mu 0.3 --out drift.tex",
        "stability table painleve --body torus --tube 0.2",
        "stability table conditions --system examples/bicycle.py:upright --positive v,g --decimals",
        "stability table hopf --system examples/railway_wheelset.py:centred --x v:1:50:50 "
        "--set m=1",
    ), words)  # fmt: skip
    what = "A system or family for LaTeX, C, AUTO-07p or BifurcationKit.jl"
    export.add_arguments(command("export", export.run, what, *export.EXAMPLES), words)
    what = "What to cite for this package, or for a file that it wrote"
    bibtex = "stability cite --bibtex"
    cite.add_arguments(command("cite", cite.run, what, bibtex, "stability cite map.nc"))
    for name, what, example in (
        ("chart", "Time against error, by every route to a spectrum or a motion",
         "stability chart spectrum --out chart"),
        ("failures", "Hard cases against every method: right, degraded, wrong, refused, crashed",
         "stability failures --out failures"),
        ("report", "Both charts and the catalogue of failures on one page",
         "stability report --out report"),
    ):  # fmt: skip
        sub = command(name, compare.run, what, example)
        sub.set_defaults(command=name)
        compare.add_arguments(sub, chart=name == "chart")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
