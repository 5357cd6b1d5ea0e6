"""The command `basins`: many launches, and which one ends where."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.checks import whole_number
from ..base.errors import FileError, NameUnknownError, ParameterError, absent, listed, shown
from ..base.printing import two_digits
from ..bodies.families import FAMILIES, at_name
from .options import (
    AXIS,
    answer,
    axes_of,
    axis_of,
    flags,
    number,
    overwriting,
    plotting,
    real,
    save,
    scheduling,
    step_error,
    targets_of,
    values,
    whole,
)
from .subject import (
    add_box,
    add_resistances,
    add_subject,
    box_of,
    named_texts,
    options_subject,
    resistances_of,
)
from .terminal import progress_bar, say

if TYPE_CHECKING:
    from ..basin.basins import Plan
    from ..basin.cost import Cost

EXAMPLES = (
    "stability basins --family spinning --x at:0.1:3:200 --y tilt:0.01:1.2:160 --mu 0.3 "
    "--time 200 --out spinning.zarr --plot spinning.png",
    "stability basins --x omega3:0:3:400 --y theta:0.1:1.5:300 --set phi_dot=0.5 --mu 0.3 "
    "--time 100 --out launches.zarr --dry-run",
    "stability basins --sample theta:uniform:0.1:1.5 --sample omega3:normal:2:0.1 --count 100000 "
    "--mu 0.3 --time 100 --out sample.zarr --scheduler dask",
    "stability basins --body eccentric-sphere --offset 0.3 --axial 0.4 --transverse 0.4 --family "
    "vertical --x at:0.2:6:48 --y tilt:0.02:1.2:32 --mu 0.3 --time 400 --out top.zarr "
    "--plot top.png",
    "stability basins --system examples/watt_governor.py:running --x x:0.5:1.5:40 --y y:-1:1:40 "
    "--set z=1.4 --set e=0.8 --set a=0.5 --set b=0.5 --time 200 --out governor.zarr",
    "stability basins --system examples/watt_governor.py:governor --x x:0.5:1.5:40 --y y:-1:1:40 "
    "--set z=1.4 --set e=0.8 --set a=0.5 --set b=0.5 --box x=0.1:3 --box y=-1:1 --box z=0.1:5 "
    "--time 200 --out governor.zarr",
)

TIMES = ("days", 86400.0), ("h", 3600.0), ("min", 60.0), ("s", 1.0)
SIZES = ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)
"""Units of times and of sizes, in seconds and bytes."""
FEW = 0.7
"""Share of a time below which it is stated what is left without the slow launches."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    axis = (
        "axis: a state at the start (theta, phi_dot, omega3, …), a number of the body (k) or of "
        "the law (mu); with --family also tilt, and at for what names its members"
    )
    values(parser, str, {"--x": (AXIS, axis), "--y": (AXIS, axis)})
    kinds = ", ".join(f"NAME:{kind}:{numbers}" for kind, numbers in KINDS.items())
    sample = f"a random sample in place of axes: {kinds}; once for each quantity"
    repeated = {
        "--more": (AXIS, "a further axis; once for each"),
        "--sample": ("NAME:KIND:A:B", sample),
    }
    values(parser, str, repeated, action="append")
    counts = {
        "--count": ("N", "launches of the sample"),
        "--seed": ("S", "of the sample (default 0); launch i of a seed is always the same"),
        "--chunk": ("N", "launches of a chunk, the work of a worker (default 4096)"),
    }
    values(parser, whole, counts)
    lines = ", ".join(f.name for f in FAMILIES.values() if f.line)
    poles = listed([f.name for f in FAMILIES.values() if f.pole], "or")
    family = f"launch near {lines} or, of a body, {poles}, the axis tilted"
    parser.add_argument("--family", help=family)
    add_subject(parser, motion=True, place=True)
    add_resistances(parser)
    add_box(parser, "of a system: launches may settle on the equilibria in it; ")
    parser.add_argument("--time", type=real, required=True, metavar="T", help="last time")
    step_error(parser)
    check = "run each launch once: no error estimate, half the time"
    dry = "say what it would cost, from a few launches, and stop"
    flags(parser, {"--no-check": check, "--dry-run": dry})
    store = "Zarr store; finished launches are kept there, and the same command goes on"
    parser.add_argument("--out", required=True, metavar="STORE.zarr", help=store)
    plotting(parser)
    levels = (
        "halve the steps of a map this often along the borders between ends; the store gets the "
        "borders, and the figure shows them"
    )
    parser.add_argument("--levels", type=whole, default=0, metavar="L", help=levels)
    scheduling(parser)
    replaced = "replace a store that was made with other arguments, and an existing figure"
    overwriting(parser, replaced)


def run(options: argparse.Namespace) -> None:
    """Predict the cost, run the launches, write the store and the figure.

    Parameters
    ----------
    options
        Parsed options of `add_arguments`.
    """
    with progress_bar("launches") as progress:
        plan, out, picture = _planned(options)
        cost = _cost(plan, out, options)
        if not options.dry_run:
            if cost.launches or cost.border:
                say(_in_words(cost))
            from ..basin.basins import run as fill
            from ..basin.dataset import lost

            kept = fill(
                plan,
                out,
                options.force,
                options.scheduler,
                options.workers,
                progress,
                options.levels,
                cost.border,
            )
            dataset, numbers = kept.dataset(), lost(kept)
            if picture is not None:
                from ..figures.basins import plot_basins

                save(plot_basins(dataset), picture, overwrite=options.force)
    if options.dry_run:
        answer(options, {"cost": _record(cost)}, [_in_words(cost)])
        return
    _report(options, dataset, cost, out, picture, numbers)


def _planned(options: argparse.Namespace) -> tuple[Plan, Path, Path | None]:
    """The plan and the targets, checked before anything is computed."""
    from ..basin.basins import MOST_LEVELS, planned

    files = targets_of(options, "chunks")
    picture = files.get("plot")
    if picture is not None and options.more:
        raise ParameterError("--plot draws a map of two axes or a sample; leave it out.")
    whole_number("levels", options.levels, 0, MOST_LEVELS)
    if options.levels and (options.sample or options.more):
        raise ParameterError("--levels refines a map of two axes; leave it out.")
    plan = planned(
        horizon=options.time,
        tolerance=options.tolerance,
        check=not options.no_check,
        chunk=options.chunk,
        **_launched(options),
    )
    return plan, files["out"], picture


def _cost(plan: Plan, out: Path, options: argparse.Namespace) -> Cost:
    """The expected cost of what the store does not hold yet."""
    from ..basin.cost import predict
    from ..jobs.dask import workers_of

    missing, levels = None, options.levels
    if out.is_dir() and any(out.iterdir()):
        from ..basin.basins import store_of

        try:
            store = store_of(plan, out)
            missing = store.missing()
            if not missing and store.dataset().attrs.get("border_levels") == levels:
                levels = 0  # they are there
        except FileError:
            if not options.force:
                raise
    number = workers_of(options.scheduler, options.workers)
    return predict(plan, number, missing, levels=levels)


def _record(cost: Cost) -> dict[str, Any]:
    return {
        "launches": cost.launches,
        "border_launches": cost.border,
        "stored": cost.stored,
        "tried": cost.sampled,
        "computing_seconds": cost.computing,
        "seconds": cost.seconds,
        "seconds_of_all_but_single_launches": cost.least,
        "workers": cost.workers,
        "store_bytes": cost.size,
    }


def _in_words(cost: Cost) -> str:
    stored = f", {cost.stored} are there" * bool(cost.stored)
    if not cost.launches and not cost.border:
        return f"0 launches to run{stored}"
    workers = f"{cost.workers} worker{'s' * (cost.workers > 1)}"
    border = f" and about {cost.border} along borders" * bool(cost.border)
    rest = ""
    if cost.least < FEW * cost.seconds:
        rest = f" ({_time(cost.least)} for all but a few launches that are decided one by one)"
    return (
        f"{cost.launches} launches to run{border}{stored}: {_time(cost.seconds)} with {workers}"
        f"{rest}, {_time(cost.computing)} of computing; store about "
        f"{two_digits(cost.size, SIZES)}; by {cost.sampled} launches that were tried"
    )


def _time(seconds: float) -> str:
    """A time to two digits.

    Examples
    --------
    >>> [_time(s) for s in (0.2, 42.3, 312.0, 9000.0, 1e6)]
    ['under 1 s', 'about 42 s', 'about 5.2 min', 'about 2.5 h', 'about 12 days']
    """
    return f"about {two_digits(seconds, TIMES)}" if seconds >= 1 else "under 1 s"


def _report(
    options: argparse.Namespace,
    dataset: Any,
    cost: Cost,
    out: Path,
    picture: Path | None,
    numbers: tuple[int, ...],
) -> None:
    from ..basin.dataset import told_of_lost
    from ..motion.result import BY_CODE
    from ..storage.targets import path_text

    codes = dataset.outcome.values
    counts = {o.word: int((codes == c).sum()) for c, o in BY_CODE.items()}
    record = {
        "out": str(out),
        "plot": None if picture is None else str(picture),
        "launches": int(codes.size),
        "outcomes": counts,
        "cost": _record(cost),
        "lost": list(numbers),
        "citation": dataset.attrs["citation"],
        **_borders(dataset),
    }
    ends = ", ".join(f"{n} {word}" for word, n in counts.items() if n)
    wrote = " and ".join(path_text(p) for p in (out, picture) if p is not None)
    parts = [f"{wrote}: {ends}", told_of_lost(numbers), _sensitivity(record)]
    answer(options, record, ["; ".join(part for part in parts if part)])


def _borders(dataset: Any) -> dict[str, Any]:
    """What refined borders say of sensitivity, for the record."""
    if "border_levels" not in dataset.attrs:
        return {}
    borders = {n: v for n, v in dataset.attrs.items() if str(n).startswith("border_exponent")}
    if "border_sensitive" in dataset:
        marked = dataset.border_sensitive.values
        counts = {
            word: int((marked == flag).sum()) for flag, word in ((1, "sensitive"), (2, "open"))
        }
        borders |= {"border_blocks": int(marked.size)}
        borders |= {f"border_{word}_blocks": count for word, count in counts.items()}
    return borders


def _sensitivity(record: dict[str, Any]) -> str:
    """The same in words."""
    words = []
    if "border_exponent" in record:
        low, high = record["border_exponent_interval"]
        exponent = record["border_exponent"]
        words.append(f"uncertainty exponent {exponent:.2f} [{low:.2f}, {high:.2f}]")
    if record.get("border_blocks"):
        some, all_ = record["border_sensitive_blocks"], record["border_blocks"]
        words.append(f"{some} of {all_} blocks along borders sensitive")
        if record["border_open_blocks"]:
            words.append(f"{record['border_open_blocks']} open (a longer --time decides)")
    return ", ".join(words)


KINDS = {"uniform": "LOW:HIGH", "log": "LOW:HIGH", "normal": "MEAN:DEVIATION"}
"""Distributions of --sample, and their two numbers."""


def _launched(options: argparse.Namespace) -> dict[str, Any]:
    """What is launched, and over which numbers, as arguments of `st.basins`."""
    varied = _varied(options)
    axes = [varied[n] for n in ("x", "y") if n in varied] + varied.get("more", [])
    names = [axis[0] for axis in axes] or list(varied["distribution"])
    held = _held(options, names)
    swept = {n: axis for n, axis in zip(names, axes or names, strict=True)}
    subject = options_subject(options, swept, held=held, motion=True)
    against = resistances_of(options)
    arguments = varied | subject.arguments | {"held": held, "family": options.family or ""}
    box = box_of(options)
    if box is not None:
        arguments |= {"box": box, "families": ()}  # in place of those of the file
    return arguments | ({} if against is None else {"resistance": against})


def _varied(options: argparse.Namespace) -> dict[str, Any]:
    """The axes, or the distribution of a random sample, its size and seed."""
    if options.sample:
        axes = [f"--{n}" for n in ("x", "y", "more") if getattr(options, n)]
        if axes:
            raise ParameterError(f"{axes[0]} does not go with --sample; give axes or a sample.")
        if options.count is None:
            raise ParameterError("--count is missing; give the number of launches of the sample.")
        spread = dict(_distribution(text) for text in options.sample)
        if len(spread) < len(options.sample):
            raise ParameterError("--sample names a quantity twice; give each once.")
        return {"distribution": spread, "count": options.count, "seed": options.seed or 0}
    for name in ("count", "seed"):
        if getattr(options, name) is not None:
            raise ParameterError(f"--{name} belongs to --sample; leave it out.")
    missing = [f"--{n}" for n in ("x", "y") if getattr(options, n) is None]
    if missing:
        raise ParameterError(f"{absent(missing)}; give NAME:LO:HI:N, or a sample by --sample.")
    more = [axis_of(text, "--more") for text in options.more or ()]
    return axes_of(options, "x", "y") | {"more": more}


def _distribution(text: str) -> tuple[str, Any]:
    """Name and distribution of one quantity, from NAME:KIND:A:B."""
    from ..basin.statistics.samples import LogUniform, Normal, Uniform

    parts = text.split(":")
    if len(parts) != 4:
        each = listed([f"NAME:{kind}:{numbers}" for kind, numbers in KINDS.items()], "or")
        raise ParameterError(f"--sample is {shown(text)}; give {each}.")
    name, kind, *numbers = parts
    if kind not in KINDS:
        raise NameUnknownError(
            f"--sample has the kind {shown(kind)}; give {listed(list(KINDS), 'or')}."
        )
    a, b = (number(v, f"a number of --sample {shown(text)}") for v in numbers)
    return name, {"uniform": Uniform, "log": LogUniform, "normal": Normal}[kind](a, b)


def _held(options: argparse.Namespace, varied: Sequence[str]) -> dict[str, float]:
    """Numbers of --set by name; `at` is the one that names the family's members."""
    held: dict[str, float] = {}
    for word, text in named_texts("set", options.set).items():
        name = at_name(options.family) if word == "at" else word
        if name in held:
            raise ParameterError(f"{name} is set twice; give it once.")
        if name in varied:
            raise ParameterError(f"{name} varies and is set; give it once.")
        held[name] = number(text, name)
    return held
