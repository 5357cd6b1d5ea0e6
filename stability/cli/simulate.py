"""The command `simulate`: a thin layer on the public names."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, absent, shown
from ..base.quantities import Kind
from ..storage.json_text import json_text
from .options import PARAMETER_HELP, contact_of, overwriting
from .terminal import progress_bar, waiting

CONTACTS = (
    "viscous, linear-viscous, smooth, rough, creep-1 to creep-3 (viscous with the slip eliminated, "
    "for large mu), coulomb, coulomb-regularised, or module:Class for a law of your own"
)
MOST = 10_000_000
"""Most samples of a run."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `stability simulate`.

    Parameters
    ----------
    parser
        The command's parser.
    """
    helps = {
        "theta": "angle of the symmetry axis from the vertical [rad], π/2 is upright (needed)",
        "theta-dot": "its rate", "phi-dot": "precession rate",
        "omega3": "angular velocity along the symmetry axis",
        "slip-x": "slip of the contact point across the disk",
        "slip-y": "slip along the disk's tangent",
    }  # fmt: skip
    for name, text in helps.items():
        parser.add_argument(f"--{name}", type=float, default=None if name == "theta" else 0.0,
                            metavar="X", help=text)  # fmt: skip
    parser.add_argument("--mu", type=float, help="friction coefficient")
    parser.add_argument("--epsilon", type=float, help="slip speed of coulomb-regularised")
    parser.add_argument("--contact", default="viscous", help=f"{CONTACTS} (default viscous)")
    parser.add_argument("--parameter", action="append", metavar="NAME=X", help=PARAMETER_HELP)
    parser.add_argument("--disk", help="a real disk: quarter, le-saux, gymnastics-hoop")
    parser.add_argument("--k", type=float, help="inertia factor in (0, 1/2] (default 1/4)")
    for name in ("mass", "radius", "gravity"):
        parser.add_argument(f"--{name}", type=float, help="of the disk (default 1)")
    parser.add_argument("--time", type=float, metavar="T", help="last time (needed)")
    parser.add_argument("--points", type=int, default=None, metavar="N",
                        help="samples from 0 to T (default 201)")  # fmt: skip
    parser.add_argument("--method", default="auto",
                        help="auto, heyoka, dop853, lsoda, radau, bdf, cvodes, idas")  # fmt: skip
    parser.add_argument("--tolerance", type=float, default=1e-9, metavar="E",
                        help="error allowed in a step (default 1e-9)")  # fmt: skip
    parser.add_argument("--max-seconds", type=float, default=8.0, metavar="S",
                        help="computing time after which it gives up (default 8)")  # fmt: skip
    parser.add_argument("--no-check", action="store_true",
                        help="do not run the neighbours of each launch, which tell the error "
                        "of its end: faster")  # fmt: skip
    parser.add_argument("--pose", action="store_true", help="φ, ψ and the paths in the plane too")
    parser.add_argument("--out", metavar="F.nc", help="NetCDF file to write")
    parser.add_argument("--plot", metavar="F.png", help="figure to write (PNG, PDF or SVG)")
    parser.add_argument("--film", metavar="F.html", help="animation to write (GIF, MP4 or HTML)")
    overwriting(parser, "replace existing files")


def run(options: argparse.Namespace, disk: Any) -> None:
    """Simulate one launch, write the files of the options, and print the outcome.

    Parameters
    ----------
    options
        Parsed options of `add_arguments`.
    disk
        The disk.
    """
    from ..storage.files import together

    missing = [f"--{name}" for name in ("theta", "time") if getattr(options, name) is None]
    if missing:
        raise ParameterError(f"{absent(missing)}; give a number{' each' * (len(missing) > 1)}.")
    contact = contact_of(options, motion=True)
    targets = _targets(options)
    with waiting("integrating"):
        dataset = _simulated(options, disk, contact)
    with together():
        _draw(options, dataset, targets)
        if options.out is not None:
            from ..motion.netcdf import write_motion

            write_motion(dataset, targets["out"], overwrite=options.force)
    _report(options, dataset, disk, targets)


def _simulated(options: argparse.Namespace, disk: Any, contact: Any) -> Any:
    """The dataset of the motion."""
    import numpy as np

    from ..bodies.thin_disk.disk_equations import STATES
    from ..motion.simulate import simulate

    start = [getattr(options, name) for name in STATES]
    times: Any = options.time
    if options.points is not None:
        if not 2 <= options.points <= MOST or not 0 < options.time < float("inf"):
            raise ParameterError(
                f"--points is {options.points} and --time {options.time:g}; give at least 2 "
                f"points, {MOST} at most, and a finite time above 0."
            )
        times = np.linspace(0.0, options.time, options.points)
    pose = options.pose or options.film is not None or options.plot is not None
    return simulate(
        disk, contact, start, times, method=options.method, tolerance=options.tolerance, pose=pose,
        check=not options.no_check, max_seconds=options.max_seconds,
    )  # fmt: skip


def _targets(options: argparse.Namespace) -> dict[str, Path]:
    """The files to write, checked before anything is computed."""
    from ..storage.targets import DATASETS, FILMS, PICTURES, check_suffix, check_target

    kinds = {"out": DATASETS, "plot": PICTURES, "film": FILMS}
    targets: dict[str, Path] = {}
    for name in ("out", "plot", "film"):
        path = getattr(options, name)
        if path is None:
            continue
        target = check_target(check_suffix(path, kinds[name], f"--{name}"), overwrite=options.force)
        if target.resolve() in [t.resolve() for t in targets.values()]:
            raise ParameterError(
                f"--{name} is {shown(path)}, which another file has; give two names."
            )
        targets[name] = target
    return targets


def _draw(options: argparse.Namespace, dataset: Any, targets: dict[str, Path]) -> None:
    from ..storage.files import atomic_write

    if "plot" in targets:
        with waiting("drawing"), atomic_write(targets["plot"], overwrite=options.force) as draft:
            from ..figures.canvas import save_figure
            from ..figures.launch.motion import plot_motion

            save_figure(plot_motion(dataset), draft)
    if "film" in targets:
        with progress_bar("frames") as progress:
            from ..figures.launch.animate import animate

            animate(dataset, targets["film"], overwrite=options.force, progress=progress)


def _errors(dataset: Any) -> dict[str, float | None]:
    """Estimated errors of the end; None where the dataset has no estimate."""
    if "final_error" not in dataset:
        return {"final_error": None, "end_time_error": None}
    return {n: float(dataset[n]) for n in ("final_error", "end_time_error")}


def _report(options: argparse.Namespace, dataset: Any, disk: Any, targets: dict[str, Path]) -> None:
    from ..bodies.thin_disk.disk_equations import STATES
    from ..motion.result import BY_CODE
    from ..storage.targets import path_text

    outcome = BY_CODE[int(dataset.outcome)]
    final = {name: float(dataset[name][-1]) for name in STATES}
    record: dict[str, Any] = {
        "final": final,
        "time": float(dataset.end_time),
        "outcome": outcome.word,
        "energy_error": float(dataset.energy_error),
        **_errors(dataset),
        "evidence": str(dataset.evidence.values),
        "nearest": {
            "family": str(dataset.nearest_family.values),
            "at": float(dataset.nearest_at),
            "distance": float(dataset.nearest_distance),
        },
        "events": [
            {"time": float(t), "kind": str(k)}
            for t, k in zip(dataset.event_time.values, dataset.event_kind.values, strict=True)
        ],
        "contact": options.contact,
        "method": dataset.attrs["method"],
        "method_reason": dataset.attrs["method_reason"],
        "tolerance": options.tolerance,
        "steps": int(dataset.steps),
        "unit": "dimensionless (m = R = g = 1)" if disk.dimensionless else "SI",
        "files": {name: str(path) for name, path in targets.items()},
    }
    if options.json:
        print(json_text(record))
        return
    unit = "" if disk.dimensionless else Kind.TIME.suffix
    print(f"outcome   {outcome.value}")
    print(f"evidence  {record['evidence']}")
    print(f"time      {record['time']:.9g}{unit}")
    print("final     " + ", ".join(f"{name} = {value:.9g}" for name, value in final.items()))
    for event in record["events"]:
        print(f"event     {event['kind']} at {event['time']:.9g}{unit}")
    if record["final_error"] is not None and record["final_error"] < float("inf"):
        print(f"error     of the final state: {record['final_error']:.1e}, estimated")
    print(f"energy    audited to {record['energy_error']:.1e} of the initial energy")
    print(f"method    {record['method']}, {record['steps']} steps: {record['method_reason']}")
    for path in targets.values():
        print(f"wrote     {path_text(path)}")
