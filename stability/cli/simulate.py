"""The command `simulate`: a thin layer on the public names."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, absent
from ..base.quantities import Kind
from ..integrators.registry import PLACES
from ..storage.text import json_text
from .options import overwriting, step_error, targets
from .subject import (
    add_subject,
    body_numbers,
    doubles,
    exact_numbers,
    moving,
    refuse_of_body,
    require,
)
from .terminal import progress_bar, waiting

MOST = 10_000_000
"""Most samples of a run."""
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


def add_arguments(parser: argparse.ArgumentParser, words: Sequence[str] | None = None) -> None:
    """Arguments of `stability simulate`.

    Parameters
    ----------
    parser
        The command's parser.
    words
        As for `add_body`.
    """
    for name, text in STATES.items():
        parser.add_argument(_option(name), type=float, metavar="X", help=text)
    parser.add_argument(
        "--start", metavar="NAME=X,…", help="with --system: every state by name, such as q=0.1,v=0"
    )
    add_subject(parser, words, motion=True)
    for name, (letter, text) in RESISTANCES.items():
        parser.add_argument(_option(name), type=float, metavar=letter, help=text)
    parser.add_argument("--time", type=float, metavar="T", help="last time (needed)")
    parser.add_argument(
        "--points", type=int, default=None, metavar="N", help="samples from 0 to T (default 201)"
    )
    parser.add_argument("--method", default="auto", help=", ".join(("auto", *PLACES)))
    step_error(parser)
    parser.add_argument(
        "--max-seconds",
        type=float,
        default=8.0,
        metavar="S",
        help="computing time after which it gives up (default 8)",
    )
    parser.add_argument(
        "--no-check",
        action="store_true",
        help="do not run the neighbours of each launch, which tell the error of its end: faster",
    )
    parser.add_argument("--pose", action="store_true", help="φ, ψ and the paths in the plane too")
    parser.add_argument("--out", metavar="F.nc", help="NetCDF file to write")
    parser.add_argument("--plot", metavar="F.png", help="figure to write (PNG, PDF or SVG)")
    parser.add_argument("--film", metavar="F.html", help="animation to write (GIF, MP4 or HTML)")
    overwriting(parser, "replace existing files")


def run(options: argparse.Namespace) -> None:
    """Simulate one launch, write the files of the options, and print the outcome.

    Parameters
    ----------
    options
        Parsed options of `add_arguments`.
    """
    from ..storage.files import together

    _check(options)
    files = targets(options, "write")
    with waiting("integrating"):
        launch = moving(options)
        thing = launch["disk"] if options.system is None else None
        launch |= _start_of_body(options) if thing is not None else _start(options, launch["disk"])
        from ..motion.simulate import simulate

        dataset = simulate(
            times=_times(options),
            method=options.method,
            tolerance=options.tolerance,
            check=not options.no_check,
            max_seconds=options.max_seconds,
            **launch,
        )
    with together():
        _draw(options, dataset, files, thing)
        if options.out is not None:
            from ..motion.files import write_motion

            write_motion(dataset, files["out"], overwrite=options.force)
    _report(options, dataset, thing, files)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _start_of_body(options: argparse.Namespace) -> dict[str, Any]:
    """Start and resistances of a disk or body, as arguments of `simulate`."""
    from ..bodies import resistance

    kinds = (resistance.RollingResistance, resistance.PivotingResistance, resistance.AirTorque)
    given = zip(kinds, (getattr(options, n) for n in RESISTANCES), strict=True)
    return {
        "start": [getattr(options, name) or 0.0 for name in STATES],
        "pose": options.pose or options.film is not None or options.plot is not None,
        "resistance": [kind(value) for kind, value in given if value is not None] or None,
    }


def _start(options: argparse.Namespace, system: Any) -> dict[str, Any]:
    """Start and numbers of a user's system, as arguments of `simulate`."""
    start = exact_numbers("start", options.start.split(","), system.states, system.name)
    given = exact_numbers("set", options.set, system.parameters, system.name)
    require(given, system.parameters)
    return {"start": doubles(start), "contact": doubles(given)}


def _check(options: argparse.Namespace) -> None:
    """Refuse options that do not go together, before anything is imported."""
    if options.system is not None and options.body is None:
        refuse_of_body(options, *STATES, "pose", "film", *RESISTANCES)
        _need(options, "start", "time")
        return
    if options.start is not None:
        raise ParameterError("--start belongs to --system; a disk takes --theta and the others.")
    _need(options, "theta", "time")


def _need(options: argparse.Namespace, *names: str) -> None:
    missing = [f"--{name}" for name in names if getattr(options, name) is None]
    if missing:
        what = f"a number{' each' * (len(missing) > 1)}"
        if "--start" in missing:
            what = "NAME=NUMBER for each state" + ", and a last time" * (len(missing) > 1)
        raise ParameterError(f"{absent(missing)}; give {what}.")


def _times(options: argparse.Namespace) -> Any:
    """A last time, or evenly spaced times."""
    import numpy as np

    if options.points is None:
        return options.time
    if not 2 <= options.points <= MOST or not 0 < options.time < float("inf"):
        raise ParameterError(
            f"--points is {options.points} and --time {options.time:g}; give at least 2 "
            f"points, {MOST} at most, and a finite time above 0."
        )
    return np.linspace(0.0, options.time, options.points)


def _draw(options: argparse.Namespace, dataset: Any, files: dict[str, Path], thing: Any) -> None:
    from ..storage.files import atomic_write

    if "plot" in files:
        with waiting("drawing"), atomic_write(files["plot"], overwrite=options.force) as draft:
            from ..figures.canvas import save_figure
            from ..figures.motion import plot_motion

            save_figure(plot_motion(dataset), draft)
    if "film" in files:
        with progress_bar("frames") as progress:
            from ..figures.animate import animate

            body = None if options.body is None else thing
            animate(dataset, files["film"], overwrite=options.force, progress=progress, body=body)


def _errors(dataset: Any) -> dict[str, float | None]:
    """Estimated errors of the end; None where the dataset has no estimate."""
    if "final_error" not in dataset:
        return {"final_error": None, "end_time_error": None}
    return {n: float(dataset[n]) for n in ("final_error", "end_time_error")}


def _report(options: argparse.Namespace, dataset: Any, disk: Any, files: dict[str, Path]) -> None:
    from ..motion.result import BY_CODE
    from ..storage.targets import path_text

    outcome = BY_CODE[int(dataset.outcome)]
    audited = "energy_error" in dataset
    record: dict[str, Any] = {
        "final": {name: float(dataset[name][-1]) for name in _states(dataset, disk)},
        "time": float(dataset.end_time),
        "outcome": outcome.word,
        "energy_error": float(dataset.energy_error) if audited else None,
        **_errors(dataset),
        "evidence": str(dataset.evidence.values),
        "nearest": _nearest(dataset, disk),
        "events": [
            {"time": float(t), "kind": str(k)}
            for t, k in zip(dataset.event_time.values, dataset.event_kind.values, strict=True)
        ],
        **_named(options, dataset, disk),
        "method": dataset.attrs["method"],
        "method_reason": dataset.attrs["method_reason"],
        "tolerance": options.tolerance,
        "steps": int(dataset.steps),
        **_units(dataset, disk),
        "citation": dataset.attrs["citation"],
        "files": {name: str(path) for name, path in files.items()},
    }
    if options.json:
        print(json_text(record))
        return
    units = {name: _suffix(dataset, disk, name) for name in ("time", *record["final"])}
    final = (f"{name} = {value:.9g}{units[name]}" for name, value in record["final"].items())
    print(f"outcome   {outcome.value}")
    print(f"evidence  {record['evidence']}")
    print(f"time      {record['time']:.9g}{units['time']}")
    print(f"final     {', '.join(final)}")
    for event in record["events"]:
        print(f"event     {event['kind']} at {event['time']:.9g}{units['time']}")
    if record["final_error"] is not None and record["final_error"] < float("inf"):
        print(f"error     of the final state: {record['final_error']:.1e}, estimated")
    if audited:
        of = "the initial energy" if disk is not None else "the size of its terms"
        print(f"energy    audited to {record['energy_error']:.1e} of {of}")
    print(f"method    {record['method']}, {record['steps']} steps: {record['method_reason']}")
    for path in files.values():
        print(f"wrote     {path_text(path)}")


def _states(dataset: Any, disk: Any) -> list[str]:
    return list(STATES) if disk is not None else json.loads(dataset.attrs["states"])


def _nearest(dataset: Any, disk: Any) -> dict[str, Any] | None:
    """The nearest steady motion; None where a system has none."""
    if "nearest_family" not in dataset:
        return None
    found: dict[str, Any] = {"family": str(dataset.nearest_family.values)}
    if disk is not None:
        found["at"] = float(dataset.nearest_at)
    else:
        member = dataset.nearest_member.values.tolist()
        found["member"] = dict(zip(_states(dataset, disk), member, strict=True))
    return found | {"distance": float(dataset.nearest_distance)}


def _named(options: argparse.Namespace, dataset: Any, disk: Any) -> dict[str, Any]:
    """What was launched."""
    if options.body is not None:
        numbers = json.loads(dataset.attrs["parameters"])
        moments = {n: float(v) for n, v in body_numbers(disk).items() if n not in numbers}
        return {"body": disk.name, "contact": options.contact, "parameters": numbers | moments}
    if disk is not None:
        return {"contact": options.contact}
    given = json.loads(dataset.attrs["parameters"])
    return {"system": dataset.attrs["system"], "parameters": given}


def _units(dataset: Any, disk: Any) -> dict[str, Any]:
    if disk is not None:
        one = "R" if hasattr(disk, "radius") else "length"
        return {"unit": f"dimensionless (m = {one} = g = 1)" if disk.dimensionless else "SI"}
    names = ("time", *_states(dataset, disk))
    return {"units": {n: dataset[n].attrs.get("units", "1") for n in names}}


def _suffix(dataset: Any, disk: Any, name: str) -> str:
    """The unit after a number: of time for a disk, of each state too for a system."""
    if disk is not None:
        return Kind.TIME.suffix if name == "time" and not disk.dimensionless else ""
    unit = dataset[name].attrs.get("units", "1")
    return "" if unit == "1" else f" {unit}"
