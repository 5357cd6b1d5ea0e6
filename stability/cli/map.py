"""The command `map`: verdict and growth rate over two parameters."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, shown
from .options import (
    AXIS,
    CERTIFY,
    answer,
    axes_of,
    dataset_help,
    flags,
    overwriting,
    plotting,
    save,
    scheduling,
    targets_of,
    values,
    whole,
)
from .subject import CommandSubject, add_box, add_subject, box_of, doubles, options_subject
from .terminal import progress_bar

EXAMPLES = (
    "stability map spinning --x at:0.5:5:400 --y mu:0.01:10:300:log --out spinning.nc "
    "--plot spinning.png",
    "stability map spinning --body torus --x at:0.5:5:80 --y tube:0.05:0.5:60 --mu 0.3 "
    "--out torus.nc",
    "stability map --system examples/bicycle.py:upright --x v:0.1:10:200 --y g:1:20:100 "
    "--out bicycle.nc --plot bicycle.png",
    "stability map spinning --x at:0.5:5:20000 --y mu:0.01:10:20000:log --out large.zarr "
    "--scheduler processes --workers 8",
)
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_subject(parser)
    axis = (
        "axis: at, lean, k, mu, mass, radius or gravity; with --body or --system one of the "
        "family's own quantities, such as tube"
    )
    values(parser, str, {"--x": (AXIS, axis), "--y": (AXIS, axis)}, required=True)
    parser.add_argument("--at", help="what names the member, where it is no axis")
    parser.add_argument(
        "--out",
        required=True,
        metavar="F.nc",
        help=dataset_help(  # type: ignore[arg-type]
            "write",
            "chunks",
            more="; F.zarr is a folder that a map of any size is computed into, chunk by chunk, "
            "and the same command goes on",
        ),
    )
    plotting(parser)
    add_box(parser, "of a system: count in each cell the equilibria in it, by proof; ")
    levels = "with --certify: halve the map this often at most"
    parser.add_argument("--levels", type=whole, metavar="L", help=levels)
    flags(
        parser,
        {
            "--certify": CERTIFY,
            "--modes": "keep all eigenvalues, not only the first",
            "--unstable": "count the unstable eigenvalues in each cell, and name regions by them",
            "--points": "find, mark and list points of codimension two",
            "--verdict-only": "proved verdicts alone, streamed to the file, however large",
        },
    )
    checkpoint = "keep finished cells there, to go on after an interruption"
    parser.add_argument("--checkpoint", metavar="DIR", help=checkpoint)
    scheduling(parser, None)
    overwriting(parser, "replace existing files")


def run(options: argparse.Namespace) -> None:
    """Compute a map, write it and its figure, and print what it holds."""
    from ..storage.datasets import format_to_write

    axes = axes_of(options, "x", "y")
    if options.levels is not None and not options.certify:
        raise ParameterError("--levels belongs to --certify; leave it out or certify.")
    folder = format_to_write(options.out, *_ways(options), option="--out").folder
    if options.verdict_only or folder:
        _stream(options, axes)
        return
    with progress_bar("cells") as progress:
        from ..jobs.pipeline import resumable
        from ..maps.stability_map import stability_map
        from ..storage.files import named

        subject = options_subject(options, {axis[0]: axis for axis in axes.values()})
        targets = _targets(options)
        try:
            dataset = stability_map(
                subject.family,
                **axes,
                certify=options.certify,
                levels=options.levels,
                modes=options.modes,
                unstable=options.unstable,
                points=options.points,
                box=box_of(options),
                progress=progress,
                checkpoint=options.checkpoint,
                executor=options.scheduler,
                workers=options.workers,
                **subject.arguments,
            )
            _write(options, dataset, targets)
        except KeyboardInterrupt:
            if options.checkpoint is None or targets["out"] in named():
                raise
            with resumable(options.checkpoint):
                raise
    if options.checkpoint is not None:
        from ..storage.pieces import remove_parts

        remove_parts(options.checkpoint)
    _report(options, subject, axes, dataset, targets)


def _report(
    options: argparse.Namespace,
    subject: CommandSubject,
    axes: Mapping[str, Any],
    dataset: Any,
    targets: Mapping[str, Path],
) -> None:
    """Print what the map holds."""
    from ..base.verdict import CODES
    from ..maps.dataset import points_of
    from ..storage.targets import path_text
    from ..tables.beyond_linear import point_records, point_text

    counts = {v.word: int((dataset.verdict == c).sum()) for v, c in CODES.items()}
    record: dict[str, Any] = {
        "out": str(targets["out"]),
        "plot": str(targets["plot"]) if options.plot else None,
        **subject.who,
        "parameters": doubles(subject.beyond([axis[0] for axis in axes.values()])),
        **subject.member,
        "verdicts": counts,
        "boundary_points": dataset.sizes["boundary_point"],
        "boundary_unresolved": int(dataset.attrs["boundary_unresolved"]),
        "citation": dataset.attrs["citation"],
    }
    cells = ", ".join(f"{n} {word}" for word, n in counts.items() if n)
    wrote = " and ".join(map(path_text, targets.values()))
    lines = [f"{wrote}: {cells}; {record['boundary_points']} boundary points"]
    if "evidence" in dataset.attrs:
        record["evidence"] = dataset.attrs["evidence"]
        lines[0] += f"; {dataset.attrs['evidence'].partition(':')[0]}"
    if options.certify:
        record |= {"certified": True, "proved_area": float(dataset.attrs["box_proved"])}
        lines[0] += f"; {dataset.attrs['box_comment']}"
    if "equilibria" in dataset:
        number = dataset.equilibria
        sure = number.where(number >= 0)
        record["equilibria"] = [int(sure.min()), int(sure.max())] if sure.count() else None
        record["equilibria_proved"] = int(sure.count())
        words = "from {} to {}".format(*record["equilibria"]) if sure.count() else "not known"
        lines.append(
            f"equilibria in the box: {words}; proved in {int(sure.count())} of {sure.size} cells"
        )
    points = points_of(dataset)
    if points is not None:
        record["points"] = point_records(points)
        lines.append(point_text(str(dataset.attrs["family"]), points))
    answer(options, record, lines)


def _ways(options: argparse.Namespace) -> tuple[str, str]:
    """The ways to write a map, one of which its format needs."""
    return ("rows" if options.verdict_only else "write"), "chunks"


def _targets(options: argparse.Namespace) -> dict[str, Path]:
    """The map and the figure to write, checked before anything is computed."""
    return targets_of(options, *_ways(options))


def _write(options: argparse.Namespace, dataset: Any, targets: Mapping[str, Path]) -> None:
    from ..maps.files import write_map
    from ..storage.files import together

    with together():
        if "plot" in targets:
            from ..figures.diagram import plot_map

            title = str(dataset.attrs["title"]).split(":")[0]
            figure = plot_map(dataset, title=title, unstable=options.unstable)
            save(figure, targets["plot"], overwrite=options.force)
        write_map(dataset, targets["out"], overwrite=options.force)


def _stream(options: argparse.Namespace, axes: Mapping[str, Any]) -> None:
    """Compute a map of any size into its file or folder."""
    with progress_bar("cells") as progress:
        from ..maps.files import read_map
        from ..maps.stream import stream_map
        from ..storage.targets import path_text

        subject = options_subject(options, {axis[0]: axis for axis in axes.values()})
        _targets(options)
        for name in ("plot", "points", "certify", "modes", "unstable", "box", "checkpoint"):
            if getattr(options, name):
                raise ParameterError(
                    f"--{name} does not go with --verdict-only; leave one of them out."
                    if options.verdict_only
                    else f"--{name} does not go with --out {shown(options.out)}, which is written "
                    "in chunks and goes on by itself; leave it out, or give --out F.nc."
                )
        path = stream_map(
            subject.family,
            **axes,
            out=options.out,
            growth=not options.verdict_only,
            executor=options.scheduler,
            workers=options.workers,
            overwrite=options.force,
            progress=progress,
            **subject.arguments,
        )
    with read_map(path, lazy=True) as dataset:
        record = {
            "out": str(path),
            "cells": dataset.verdict.size,
            "method": dataset.method,
            "citation": dataset.attrs["citation"],
        }
    what = "verdicts" if options.verdict_only else "verdicts and growth rates"
    answer(options, record, [f"{path_text(path)}: {record['cells']} {what}; {record['method']}"])
