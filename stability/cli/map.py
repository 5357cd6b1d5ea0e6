"""The commands `map`, over two parameters, and `boundaries`, along one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, shown
from ..storage.text import json_text
from .options import _axis, targets
from .subject import members
from .terminal import progress_bar, waiting


def _map(options: argparse.Namespace) -> None:
    x, y = _axis(options.x, "--x"), _axis(options.y, "--y")
    if options.levels is not None and not options.certify:
        raise ParameterError("--levels belongs to --certify; leave it out or certify.")
    if options.verdict_only or _stored(options):
        _stream(options, x, y)
        return
    with progress_bar("cells") as progress:
        from ..jobs.pipeline import resumable
        from ..maps.dataset import points_of
        from ..maps.stability_map import stability_map
        from ..storage.files import named
        from ..storage.pieces import remove_parts
        from ..storage.targets import path_text
        from ..tables.beyond_linear import point_records, point_text

        subject = members(options, {axis[0]: axis for axis in (x, y)})
        files = targets(options, *_ways(options))
        try:
            dataset = stability_map(
                subject.family, x=x, y=y, certify=options.certify, levels=options.levels,
                modes=options.modes, points=options.points, progress=progress,
                checkpoint=options.checkpoint, executor=options.scheduler,
                workers=options.workers, **subject.arguments,
            )  # fmt: skip
            _write(options, dataset, files)
        except KeyboardInterrupt:
            if options.checkpoint is None or files["out"] in named():
                raise
            with resumable(options.checkpoint):
                raise
    if options.checkpoint is not None:
        remove_parts(options.checkpoint)
    from ..base.verdict import CODES

    counts = {v.word: int((dataset.verdict == c).sum()) for v, c in CODES.items()}
    record: dict[str, Any] = {
        "out": str(files["out"]),
        "plot": str(files["plot"]) if options.plot else None,
        **subject.who,
        "parameters": subject.beyond((x[0], y[0])),
        "verdicts": counts,
        "boundary_points": dataset.sizes["boundary_point"],
        "boundary_unresolved": int(dataset.attrs["boundary_unresolved"]),
        "citation": dataset.attrs["citation"],
    }
    if options.certify:
        record["certified"] = True
        record["proved_area"] = float(dataset.attrs["box_proved"])
    found = points_of(dataset)
    if found is not None:
        record["points"] = point_records(found)
    if options.json:
        print(json_text(record))
        return
    cells = ", ".join(f"{n} {word}" for word, n in counts.items() if n)
    proved = f"; {dataset.attrs['box_comment']}" if options.certify else ""
    wrote = " and ".join(map(path_text, files.values()))
    print(f"{wrote}: {cells}; {record['boundary_points']} boundary points" + proved)
    if found is not None:
        print(point_text(str(dataset.attrs["family"]), found))


def _ways(options: argparse.Namespace) -> tuple[str, str]:
    """The ways to write a map, one of which its format needs."""
    return ("rows" if options.verdict_only else "write"), "chunks"


def _stored(options: argparse.Namespace) -> bool:
    """Whether the map goes to a folder of chunks."""
    from ..storage.datasets import format_to_write

    return format_to_write(options.out, *_ways(options), option="--out").folder


def _write(options: argparse.Namespace, dataset: Any, files: dict[str, Path]) -> None:
    from ..maps.files import write_map
    from ..storage.files import atomic_write, together

    with together():
        if options.plot:
            with atomic_write(files["plot"], overwrite=options.force) as picture:
                _draw(dataset, picture)
        write_map(dataset, files["out"], overwrite=options.force)


def _stream(options: argparse.Namespace, x: Any, y: Any) -> None:
    with progress_bar("cells") as progress:
        from ..maps.files import read_map
        from ..maps.stream import stream_map
        from ..storage.targets import path_text

        subject = members(options, {axis[0]: axis for axis in (x, y)})
        targets(options, *_ways(options))
        for name in ("plot", "points", "certify", "modes", "checkpoint"):
            if getattr(options, name):
                raise ParameterError(
                    f"--{name} does not go with --verdict-only; leave one of them out."
                    if options.verdict_only else
                    f"--{name} does not go with --out {shown(options.out)}, which is written in "
                    "chunks and goes on by itself; leave it out, or give --out F.nc."
                )  # fmt: skip
        path = stream_map(
            subject.family, x=x, y=y, out=options.out, growth=not options.verdict_only,
            executor=options.scheduler, workers=options.workers, overwrite=options.force,
            progress=progress, **subject.arguments,
        )  # fmt: skip
    with read_map(path, lazy=True) as dataset:
        record = {"out": str(path), "cells": dataset.verdict.size, "method": dataset.method,
                  "citation": dataset.attrs["citation"]}  # fmt: skip
    if options.json:
        print(json_text(record))
    else:
        what = "verdicts" if options.verdict_only else "verdicts and growth rates"
        print(f"{path_text(path)}: {record['cells']} {what}; {record['method']}")


def _draw(dataset: Any, target: Any) -> None:
    from ..figures.canvas import save_figure
    from ..figures.diagram import plot_map

    figure = plot_map(dataset, title=str(dataset.attrs["title"]).split(":")[0])
    save_figure(figure, target)


def _boundaries(options: argparse.Namespace) -> None:
    axis = _axis(options.axis, "--axis")
    if options.certify:
        raise ParameterError("every boundary here is proved; leave --certify out.")
    with waiting("searching"):
        from ..base.verdict import Verdict
        from ..boundary.changes import boundaries
        from ..tables.beyond_linear import to_bound

        subject = members(options, {axis[0]: axis}, exact=True)
        found = boundaries(subject.family, axis=axis, **subject.arguments)
    numbers = subject.beyond((axis[0],))
    record: dict[str, Any] = {
        **subject.who,
        "parameters": numbers,
        "axis": axis[0],
        "low": axis[1],
        "high": axis[2],
        "boundaries": [
            {"value": b.value, "error": b.error, "crossing": b.crossing.word,
             "frequency": b.frequency, "frequencies": list(b.frequencies),
             "stable_below": b.stable_below, "good": b.good.word}
            for b in found
        ],
        "touching": list(found.touching),
        "complete": found.complete,
        "unresolved": [u._asdict() for u in found.unresolved],
        "statement": found.statement(axis[0]),
        "citation": found.citation,
    }  # fmt: skip
    if options.json:
        print(json_text(record))
        return
    exact = subject.arguments["parameters"] if subject.thing is None else numbers
    at = subject.place(exact)
    where = f"{subject.title}, along {axis[0]} from {axis[1]:g} to {axis[2]:g}"
    print(where + f", at {at}" * bool(at))
    for b in found:
        side = "below" if b.stable_below else "above"
        word = "not unstable" if b.good is Verdict.UNDECIDED else b.good.word
        pair = f", frequency {b.frequency:.12g}" if b.frequency else ""
        if b.frequencies:
            pair = f", frequencies {', '.join(f'{w:.12g}' for w in b.frequencies)}"
        kind = b.crossing.word.replace("_", " ")
        print(f"  {axis[0]} = {to_bound(b.value, b.error)}   {kind}, {word} {side}{pair}")
    print(record["statement"])
