"""The command `simulate`: a thin layer on the public names."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError
from ..base.quantities import behind, unit_of
from .options import (
    answer,
    dataset_help,
    flags,
    overwriting,
    plotting,
    real,
    save,
    step_error,
    targets_of,
    whole,
)
from .subject import CommandSubject, add_launch, options_subject
from .terminal import progress_bar, waiting

EXAMPLES = (
    "stability simulate --theta 1.47 --omega3 1.2 --mu 0.3 --time 100 --out run.nc --plot run.png "
    "--film run.html",
    "stability simulate --body eccentric-sphere --offset 0.15 --theta 0.1 --omega3 5 --mu 0.3 "
    "--time 200 --points 2001 --film top.gif",
    "stability simulate --system examples/watt_governor.py:running --start x=1,y=0,z=1.4 "
    "--set e=0.8 --set a=0.5 --set b=0.5 --time 200",
)
"""Examples of the help."""
MOST = 10_000_000
"""Most samples of a run."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_launch(parser)
    parser.add_argument("--time", type=real, metavar="T", help="last time (needed)")
    parser.add_argument(
        "--points", type=whole, metavar="N", help="samples from 0 to T (default 201)"
    )
    parser.add_argument("--method", default="auto", help=_methods)  # type: ignore[arg-type]
    step_error(parser)
    seconds = "computing time after which it gives up (default 8)"
    parser.add_argument("--max-seconds", type=real, default=8.0, metavar="S", help=seconds)
    check = "do not run the neighbours of each launch, which tell the error of its end: faster"
    flags(parser, {"--no-check": check, "--pose": "φ, ψ and the paths in the plane too"})
    parser.add_argument("--out", metavar="F.nc", help=dataset_help("write"))  # type: ignore[arg-type]
    plotting(parser)
    parser.add_argument("--film", metavar="F.html", help="animation to write (GIF, MP4 or HTML)")
    overwriting(parser, "replace existing files")


def _methods() -> str:
    from ..integrators.registry import PLACES

    return f"auto, {', '.join(PLACES)}"


def run(options: argparse.Namespace) -> None:
    """Simulate one launch, write the files of the options, and print the outcome."""
    from ..storage.files import together

    targets = targets_of(options, "write")
    with waiting("integrating"):
        subject = options_subject(options, motion=True)
        from ..motion.simulate import simulate

        dataset = simulate(
            times=_times(options),
            method=options.method,
            tolerance=options.tolerance,
            check=not options.no_check,
            max_seconds=options.max_seconds,
            **subject.arguments,
        )
    with together():
        _draw(options, dataset, targets, subject)
        if "out" in targets:
            from ..motion.files import write_motion

            write_motion(dataset, targets["out"], overwrite=options.force)
    record = _record(options, dataset, subject, targets)
    answer(options, record, _lines(record, dataset, targets, subject))


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


def _draw(
    options: argparse.Namespace, dataset: Any, targets: Mapping[str, Path], subject: CommandSubject
) -> None:
    if "plot" in targets:
        with waiting("drawing"):
            from ..figures.motion import plot_motion

            save(plot_motion(dataset), targets["plot"], overwrite=options.force)
    if "film" in targets:
        with progress_bar("frames") as progress:
            from ..figures.animate import animate

            body = subject.arguments.get("body")
            animate(dataset, targets["film"], overwrite=options.force, progress=progress, body=body)


def _record(
    options: argparse.Namespace, dataset: Any, subject: CommandSubject, targets: Mapping[str, Path]
) -> dict[str, Any]:
    from ..motion.result import BY_CODE

    errors = {n: float(dataset[n]) if n in dataset else None for n in ERRORS}
    return {
        "final": {name: float(dataset[name].values[-1]) for name in subject.states},
        "time": float(dataset.end_time),
        "outcome": BY_CODE[int(dataset.outcome)].word,
        **errors,
        "evidence": str(dataset.evidence.values),
        "nearest": _nearest(dataset, subject),
        "events": [
            {"time": float(t), "kind": str(k)}
            for t, k in zip(dataset.event_time.values, dataset.event_kind.values, strict=True)
        ],
        **subject.who,
        "parameters": json.loads(dataset.attrs["parameters"])
        | {n: float(subject.numbers[n]) for n in subject.derived},
        "method": dataset.attrs["method"],
        "method_reason": dataset.attrs["method_reason"],
        "tolerance": options.tolerance,
        "steps": int(dataset.steps),
        **_units(dataset, subject),
        "citation": dataset.attrs["citation"],
        "files": {name: str(path) for name, path in targets.items()},
    }


ERRORS = ("energy_error", "final_error", "end_time_error")
"""Estimates that a dataset may have."""


def _lines(
    record: Mapping[str, Any], dataset: Any, targets: Mapping[str, Path], subject: CommandSubject
) -> Iterator[str]:
    from ..motion.result import BY_CODE
    from ..storage.targets import path_text

    def written(name: str, value: float) -> str:
        unit = unit_of(dataset[name].attrs)
        return f"{value:.9g}{behind(unit)}"

    final = (f"{name} = {written(name, value)}" for name, value in record["final"].items())
    yield f"outcome   {BY_CODE[int(dataset.outcome)].value}"
    yield f"evidence  {record['evidence']}"
    yield f"time      {written('time', record['time'])}"
    yield f"final     {', '.join(final)}"
    for event in record["events"]:
        yield f"event     {event['kind']} at {written('time', event['time'])}"
    if record["final_error"] is not None and record["final_error"] < float("inf"):
        yield f"error     of the final state: {record['final_error']:.1e}, estimated"
    if record["energy_error"] is not None:
        yield f"energy    audited to {record['energy_error']:.1e} of {subject.energy}"
    if subject.law:
        yield f"launch    {subject.title}, {subject.place(subject.numbers)}".rstrip(", ")
        yield f"law       {subject.law}"
    yield f"method    {record['method']}, {record['steps']} steps: {record['method_reason']}"
    for path in targets.values():
        yield f"wrote     {path_text(path)}"


def _nearest(dataset: Any, subject: CommandSubject) -> dict[str, Any] | None:
    """The nearest steady motion; None where a system has none."""
    if "nearest_family" not in dataset:
        return None
    nearest: dict[str, Any] = {"family": str(dataset.nearest_family.values)}
    if "nearest_at" in dataset:
        nearest["at"] = float(dataset.nearest_at)
    else:
        member = dataset.nearest_member.values.tolist()
        nearest["member"] = dict(zip(subject.states, member, strict=True))
    return nearest | {"distance": float(dataset.nearest_distance)}


def _units(dataset: Any, subject: CommandSubject) -> dict[str, Any]:
    """The units of all numbers in words, or that of each number."""
    if subject.scales:
        return {"unit": subject.scales}
    names = ("time", *subject.states)
    return {"units": {n: dataset[n].attrs.get("units", "1") for n in names}}
