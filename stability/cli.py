"""The command line: a thin layer on the public names."""

from __future__ import annotations

import argparse
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

from . import __version__
from .cli_compare import add_arguments as add_compare
from .cli_motion import add_arguments
from .errors import ParameterError, StabilityError, StabilityWarning, shown
from .output import HELP, json_text
from .terminal import (
    LEAST_MEMORY,
    allowed_memory,
    check,
    drop_output,
    prepare,
    say,
    starved,
    stoppable,
)

FAMILY_HELP = "rolling, spinning, tumbling, circling (rough disk) or precession (smooth disk)"
MOST_VALUES = 1000
"""Numbers in a list of a table, each of which takes a line or more."""
CONTACTS = "smooth, viscous, linear-viscous, rough"


class _Parser(argparse.ArgumentParser):
    """A parser that answers a bad argument with one sentence and exit code 2."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # argparse takes -1e-3, -inf and -1,2 for options; here they are numbers to be judged
        self._negative_number_matcher = re.compile(r"^-(\d|\.\d|inf|nan).*$")

    def error(self, message: str) -> NoReturn:
        say(f"{message.rstrip('.')}; see `{self.prog} --help`.")
        raise SystemExit(2)


@contextmanager
def _warnings() -> Iterator[None]:
    """The package's own warnings as one line each on standard error."""
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
        Words after the program's name; those of the process when left out.

    Returns
    -------
    int
        0 done, 2 bad input, 130 interrupted (143 by SIGTERM, 129 by SIGHUP).

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
            # a library that is interrupted may raise what it likes: an import fails, a solver stops
            if stop.number or isinstance(reason, KeyboardInterrupt):
                told = str(reason) if isinstance(reason, KeyboardInterrupt) else ""
                say(f"{told or stop.sentence}.")
                return stop.code
            return _code(reason)
    return 0


def _run(arguments: Sequence[str] | None) -> None:
    try:
        options = _parser().parse_args(arguments)
        run: Callable[[argparse.Namespace], None] = options.run
        with _warnings():
            run(options)
    except SystemExit:  # after --help
        sys.stdout.flush()
        raise
    sys.stdout.flush()


def _code(reason: BaseException) -> int:
    """Say what went wrong; the exit code."""
    if isinstance(reason, StabilityError):
        say(str(reason))
    elif isinstance(reason, BrokenPipeError):  # the reader of our output has left, as it may
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


# --- commands ---


def _spectrum(options: argparse.Namespace) -> None:
    from .contact import law_named
    from .query import spectrum
    from .steady import AT

    if (options.at is None) == (options.lean is None):
        raise ParameterError("give --at, or for tumbling --lean, and not both.")
    disk = _disk(options)
    contact = law_named(options.contact, options.mu)
    at = None if options.at is None else _at(options.at)
    parts = AT.get(options.family, ("at",))
    if isinstance(at, list) and len(at) != len(parts):
        raise ParameterError(
            f"at is {shown(options.at)}; {options.family} takes {' and '.join(parts)}, "
            f"{len(parts)} number{'s' * (len(parts) > 1)}."
        )
    result = spectrum(
        options.family, at=at, lean=options.lean, disk=disk, contact=contact,
        certify=options.certify, escalate=not options.no_escalate,
    )  # fmt: skip
    parameters = {n: float(getattr(disk, n)) for n in ("mass", "radius", "k", "gravity")}
    if options.mu is not None:
        parameters["mu"] = options.mu
    record = {
        "family": options.family,
        "contact": options.contact,
        "parameters": parameters,
        "at": at if at is not None else float(result.at[0]),
        "eigenvalues": [[float(v.real) + 0.0, float(v.imag) + 0.0] for v in result.eigenvalues],
        "structural_zeros": result.structural_zeros,
        "abscissa": result.abscissa + 0.0,
        "verdict": result.verdict.word,
        "nonlinear": result.nonlinear.word,
        "abscissa_error": result.abscissa_error,
        "certified": result.certified,
        "radius": list(result.radius),
        "modes": list(result.modes.labels),
        "reason": result.reason,
        "unit": "√(g/R)" if disk.dimensionless else "1/s",
    }
    if options.lean is not None:
        record["lean"] = options.lean
    if options.json:
        print(json_text(record))
        return
    if at is None:
        where = [f"lean = {options.lean:g}"]
    else:
        given = at if isinstance(at, list) else [at]
        where = [f"{n} = {v:g}" for n, v in zip(AT[options.family], given, strict=True)]
    rest = [
        f"{n} = {v:g}" for n, v in parameters.items() if n in ("k", "mu") or not disk.dimensionless
    ]
    print(f"{options.family}, {options.contact} contact, at {', '.join([*where, *rest])}")
    print(f"verdict     {result.verdict.value}")
    print(f"nonlinear   {result.nonlinear.value}")
    print(f"reason      {result.reason}")
    print(f"eigenvalues [{record['unit']}]")
    for value, r, label in zip(result.eigenvalues, result.radius, result.modes.labels, strict=True):
        off = f"   within {r:.0e}" if result.certified else ""
        print(f"  {value.real + 0.0:+.12e} {value.imag + 0.0:+.12e}i{off}   {label}")


def _map(options: argparse.Namespace) -> None:
    from .cells import remove_parts
    from .contact import LAWS, law_named
    from .files import named, together, whole, write_map
    from .maps import stability_map
    from .targets import NETCDF, check_suffix, check_target, path_text

    x, y = _axis(options.x, "--x"), _axis(options.y, "--y")
    swept = {x[0], y[0]}
    for name in ("at", "k", "mu", "mass", "radius", "gravity"):
        if name in swept and getattr(options, name) is not None:
            raise ParameterError(f"{name} is given as --{name} and as an axis; give it once.")
    if options.levels is not None and not options.certify:
        raise ParameterError("--levels goes with --certify; leave it out or certify.")
    disk = _disk(options)
    contact: Any
    if "mu" in swept and options.contact in LAWS:
        contact = LAWS[options.contact]
    else:
        contact = law_named(options.contact, options.mu)
    out = check_suffix(options.out, NETCDF, "--out")
    targets = [check_target(out, overwrite=options.force)]
    if options.plot is not None:
        targets.append(_picture(options.plot, options.force))
        if targets[0].resolve() == targets[1].resolve():
            raise ParameterError(f"--out and --plot are both {shown(options.out)}; give two files.")
    at = None if options.at is None else _at(options.at)
    if options.verdict_only:
        _stream(options, x, y, disk, contact, at)
        return
    try:
        with _bar("cells") as progress:
            dataset = stability_map(
                options.family, x=x, y=y, disk=disk, contact=contact, at=at,
                certify=options.certify, levels=options.levels, modes=options.modes,
                progress=progress,
                checkpoint=options.checkpoint,
            )  # fmt: skip
        with together():
            if options.plot:
                with whole(targets[1], overwrite=options.force) as picture:
                    _draw(dataset, picture)
            write_map(dataset, targets[0], overwrite=options.force)
    except KeyboardInterrupt:
        if options.checkpoint is None or targets[0] in named():
            raise
        raise KeyboardInterrupt(
            f"interrupted; finished cells are kept in {path_text(options.checkpoint)}: give the "
            "same command again to go on"
        ) from None
    if options.checkpoint is not None:
        remove_parts(options.checkpoint)
    from .verdict import CODES

    counts = {v.word: int((dataset.verdict == c).sum()) for v, c in CODES.items()}
    record: dict[str, Any] = {
        "out": str(targets[0]),
        "plot": str(targets[1]) if options.plot else None,
        "verdicts": counts,
        "boundary_points": dataset.sizes["boundary_point"],
        "boundary_unresolved": int(dataset.attrs["boundary_unresolved"]),
    }
    if options.certify:
        record["certified"] = True
        record["proved_area"] = float(dataset.attrs["box_proved"])
    if options.json:
        print(json_text(record))
        return
    cells = ", ".join(f"{n} {word}" for word, n in counts.items() if n)
    proved = f"; {dataset.attrs['box_comment']}" if options.certify else ""
    print(
        f"{' and '.join(map(str, targets))}: {cells}; {record['boundary_points']} boundary points"
        + proved
    )


def _stream(options: argparse.Namespace, x: Any, y: Any, disk: Any, contact: Any, at: Any) -> None:
    from .files import read_map
    from .stream import stream_map

    for name in ("plot", "certify", "modes", "checkpoint"):
        if getattr(options, name):
            raise ParameterError(
                f"--{name} does not go with --verdict-only; leave one of them out."
            )
    with _bar("cells") as progress:
        path = stream_map(
            options.family, x=x, y=y, out=options.out, disk=disk, contact=contact, at=at,
            overwrite=options.force, progress=progress,
        )  # fmt: skip
    with read_map(path, lazy=True) as dataset:
        record = {"out": str(path), "cells": dataset.verdict.size, "method": dataset.method}
    if options.json:
        print(json_text(record))
    else:
        print(f"{path}: {record['cells']} verdicts; {record['method']}")


def _draw(dataset: Any, target: Any) -> None:
    from .canvas import save_figure
    from .plots import diagram

    figure = diagram(dataset, title=str(dataset.attrs["title"]).split(":")[0])
    save_figure(figure, target)


def _atlas(options: argparse.Namespace) -> None:
    from .atlas import atlas, summary

    with _bar("diagrams") as progress:
        page = atlas(
            options.out, resolution=options.resolution, force=options.force, progress=progress
        )
    if options.json:
        print(json_text(summary(page)))
    else:
        print(f"open {page}")


def _simulate(options: argparse.Namespace) -> None:
    from .cli_motion import run

    run(options, _disk(options), _bar)


def _compare(options: argparse.Namespace) -> None:
    from .cli_compare import run

    run(options, _bar)


def _table(options: argparse.Namespace) -> None:
    from .errors import NameUnknownError
    from .tables import TABLES, records, text

    if options.name not in TABLES:
        raise NameUnknownError(f"table is {shown(options.name)}; known are {', '.join(TABLES)}.")
    settings = _table_settings(options)
    formulas: list[Any] = []
    with _bar("lines") as progress:
        if options.name in ("conditions", "hopf", "launches"):
            settings["progress"] = progress
        rows = [] if options.latex else records(options.name, **settings)
        if options.name == "conditions":
            from .formulas import rows as formula_rows

            laws = settings.get("laws", ("smooth", "viscous", "rough"))
            formulas = formula_rows(laws, settings.get("k", (0.25, 0.5)), progress)
    if options.latex:
        from .formulas import latex

        print("\n\n".join(latex(f) for f in formulas))
        return
    if options.json:
        from dataclasses import asdict

        body: dict[str, Any] = {
            "table": options.name,
            "heading": f"{TABLES[options.name]} (recomputed)",
            "rows": rows,
        }
        if formulas:
            body["formulas"] = [asdict(f) for f in formulas]
        print(json_text(body))
        return
    disk = settings.get("disk")
    if formulas:
        from .tables import formula_lines

        print("\n".join(formula_lines(formulas)))
    print(text(options.name, rows, "√(g/R)" if disk is None or disk.dimensionless else "rad/s"))


def _table_settings(options: argparse.Namespace) -> dict[str, Any]:
    """Options of a table as arguments of its function; what does not belong is refused."""
    from .contact import law_named
    from .disk import Disk

    name = options.name
    settings: dict[str, Any] = {}
    if options.latex and (name != "conditions" or options.json):
        raise ParameterError("--latex goes with `table conditions`, without --json.")
    _table_launch(options, settings)
    if name not in ("conditions", "drift", "hopf", "launches"):
        for key in ("k", "mu", "contact", "mass", "radius", "gravity"):
            if getattr(options, key) is not None:
                raise ParameterError(
                    f"--{key} goes with `table conditions`, `drift`, `hopf` and `launches` only; "
                    "leave it out."
                )
        return settings
    for key in ("k", "mu"):
        if getattr(options, key) is not None:
            settings[key] = getattr(options, key)
    if options.contact is not None:
        law_named(options.contact, None if options.mu is None else options.mu[0], needed=False)
        key = "laws" if name == "conditions" else "law"
        settings[key] = [options.contact] if name == "conditions" else options.contact
    scales = {n: getattr(options, n) for n in ("mass", "radius", "gravity")}
    settings["disk"] = Disk(**{n: v for n, v in scales.items() if v is not None})
    if "k" in settings:
        Disk(k=settings["k"])
    return settings


def _table_launch(options: argparse.Namespace, settings: dict[str, Any]) -> None:
    """The options of `table drift` and `table launches`."""
    name = options.name
    if options.tilt is not None:
        if name not in ("drift", "launches"):
            raise ParameterError(
                "--tilt goes with `table drift` and `launches` only; leave it out."
            )
        if name == "launches" and len(options.tilt) > 1:
            raise ParameterError(f"--tilt is {options.tilt}; `table launches` takes one tilt.")
        settings["tilt"] = options.tilt[0] if name == "launches" else options.tilt
    for key in ("at", "time"):
        if getattr(options, key) is not None:
            if name != "launches":
                raise ParameterError(f"--{key} goes with `table launches` only; leave it out.")
            settings[key] = getattr(options, key)


# --- arguments ---


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="stability",
        description="Which steady motions of a thin disk on a plane can be seen?",
        epilog="example: stability spectrum rolling --at 1.8 --mu 0.3",
    )
    parser.add_argument("--version", action="version", version=f"stability {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND",
                                     parser_class=_Parser)  # fmt: skip

    def command(name: str, run: Any, what: str, example: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(
            name, help=what, description=f"{what}.", epilog=f"example: {example}"
        )
        sub.set_defaults(run=run)
        sub.add_argument("--json", action="store_true", help=HELP)
        return sub

    sub = command("spectrum", _spectrum, "Eigenvalues and verdict of one steady motion",
                  "stability spectrum tumbling --at 0.5 --mu 0.3 --json")  # fmt: skip
    sub.add_argument("family", metavar="FAMILY", help=FAMILY_HELP)
    sub.add_argument(
        "--at", help="omega3, phi_dot, or theta; for circling and precession THETA,PHI_DOT"
    )
    sub.add_argument(
        "--lean", type=float, help="for tumbling, in place of --at: π/2 - theta, 0 is upright"
    )
    sub.add_argument("--no-escalate", action="store_true",
                     help="leave undecided what double precision does not decide")  # fmt: skip
    _physics(sub)

    sub = command("map", _map, "Verdict and growth rate over two parameters",
                  "stability map spinning --x at:0.5:5:400 --y mu:0.01:10:300:log "
                  "--out spinning.nc --plot spinning.png")  # fmt: skip
    sub.add_argument("family", metavar="FAMILY", help=FAMILY_HELP)
    for axis in ("--x", "--y"):
        sub.add_argument(axis, required=True, metavar="NAME:LO:HI:N[:log]",
                         help="axis: at, k, mu, mass, radius or gravity")  # fmt: skip
    sub.add_argument("--at", default=None, help="family parameter, where it is no axis")
    _physics(sub)
    sub.add_argument("--out", required=True, metavar="F.nc", help="NetCDF file to write")
    sub.add_argument("--plot", metavar="F.png", help="figure to write (PNG, PDF or SVG)")
    sub.add_argument("--levels", type=int, metavar="L",
                     help="with --certify: halve the map this often at most")  # fmt: skip
    sub.add_argument(
        "--modes", action="store_true", help="keep all eigenvalues, not only the first"
    )
    sub.add_argument("--verdict-only", action="store_true",
                     help="proved verdicts alone, streamed to the file, however large")  # fmt: skip
    sub.add_argument("--checkpoint", metavar="DIR",
                     help="keep finished cells there, to go on after an interruption")  # fmt: skip
    sub.add_argument("--force", action="store_true", help="replace existing files")

    sub = command("atlas", _atlas, "The three families' diagrams for disk, annulus and hoop",
                  "stability atlas --out atlas")  # fmt: skip
    sub.add_argument("--out", required=True, metavar="DIR", help="folder to write")
    sub.add_argument("--resolution", type=int, default=400, metavar="N",
                     help="points along the family's axis (default 400)")  # fmt: skip
    sub.add_argument("--force", action="store_true", help="replace files in an existing folder")

    sub = command("simulate", _simulate, "Launch a disk, and say what becomes of it",
                  "stability simulate --theta 1.47 --omega3 1.2 --mu 0.3 --time 100 "
                  "--out run.nc --plot run.png --film run.html")  # fmt: skip
    add_arguments(sub)

    sub = command("table", _table, "A table, recomputed: families, conditions, drift, hopf, …",
                  "stability table conditions --k 0.25,0.5 --mu 0.1,1,10")  # fmt: skip
    sub.add_argument(
        "name",
        metavar="NAME",
        help="families, conditions, drift, hopf, launches or completeness",
    )
    sub.add_argument("--k", type=_list, help="inertia factors, comma-separated")
    sub.add_argument("--mu", type=_list, help="friction coefficients, comma-separated")
    sub.add_argument("--tilt", type=_list, help="tilts of `table drift` and `launches` in rad")
    sub.add_argument("--at", type=_list, help="initial angular velocities of `table launches`")
    sub.add_argument("--time", type=float, help="length of a run of `table launches`")
    sub.add_argument("--latex", action="store_true", help="formulas of `table conditions` as LaTeX")
    sub.add_argument("--contact", help=f"one law of {CONTACTS}")
    for name in ("mass", "radius", "gravity"):
        sub.add_argument(f"--{name}", type=float, help="of the disk")
    for name, what, example in (
        ("chart", "Time against error, by every route to a spectrum or a motion",
         "stability chart spectrum --out chart"),
        ("failures", "Hard cases against every method: right, degraded, wrong, refused, crashed",
         "stability failures --out failures"),
        ("report", "Both charts and the catalogue of failures on one page",
         "stability report --out report"),
    ):  # fmt: skip
        sub = command(name, _compare, what, example)
        sub.set_defaults(command=name)
        add_compare(sub, chart=name == "chart")
    return parser


def _physics(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--mu", type=float, help="friction coefficient (viscous; c = mu m g for linear)"
    )
    parser.add_argument("--contact", default="viscous", help=f"{CONTACTS} (default viscous)")
    parser.add_argument("--disk", help="a real disk: quarter, le-saux, gymnastics-hoop")
    parser.add_argument("--k", type=float, help="inertia factor in (0, 1/2] (default 1/4)")
    for name in ("mass", "radius", "gravity"):
        parser.add_argument(f"--{name}", type=float, help="of the disk (default 1)")
    parser.add_argument("--certify", action="store_true",
                        help="prove every verdict, in rational arithmetic or balls")  # fmt: skip


def _disk(options: argparse.Namespace) -> Any:
    from .disk import Disk

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
            f"{which} has {shown(count)} points; a whole number is needed."
        ) from None
    return (name, _number(low, which), _number(high, which), number, *rest)


def _picture(path: str, force: bool) -> Any:
    from .targets import PICTURES, check_suffix, check_target

    return check_target(check_suffix(path, PICTURES, "--plot"), overwrite=force)


@contextmanager
def _bar(unit: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on standard error, shown once the work has taken a second."""
    from tqdm import tqdm

    if sys.stderr is None:
        yield lambda *_: None
        return
    bar = tqdm(total=None, unit=f" {unit}", delay=1, disable=None, leave=False, file=sys.stderr)

    def update(done: int, total: int) -> None:
        check()
        if bar.total != total:
            bar.reset(total)
        bar.update(done - bar.n)

    try:
        yield update
    finally:
        bar.close()


if __name__ == "__main__":
    raise SystemExit(main())
