"""The command `scene`: a scene of a TOML file, answered by the least model."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import ParameterError
from ..base.quantities import readable
from .options import answer as print_answer
from .options import dataset_help, flags, given, overwriting, plotting, real, targets_of, values
from .subject import add_resistances, ones_of, resistances_of, scales_of
from .terminal import progress_bar, waiting

if TYPE_CHECKING:
    from ..scene.answer import Answer
    from ..scene.scene import Scene

EXAMPLES = (
    "stability scene examples/scenes/rolled-coin.toml --json",
    "stability scene examples/scenes/spun-coin.toml --rolling-resistance 3e-5 --max-seconds 30",
)
"""Examples of the help."""
SPREAD = ("inputs", "moves", "outcomes", "contrary", "size", "wasted", "routes", "enough")
"""What is told of how inputs that are known roughly move an answer."""
GAP = 2
"""Spaces between two columns."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE.toml", help="the scene; see examples/scenes")
    verify = "run the full model at a finer tolerance too, and tell the true error"
    flags(parser, {"--verify": verify})
    only = (
        "run one model, with its error: steady, linearised, second-order, creep, or the name of "
        "the law"
    )
    motion = dataset_help("write", more="; the motion at many times, each within the tolerance")
    values(parser, str, {"--only": ("RUNG", only)})
    add_resistances(parser)
    seconds = "computing time after which a run gives up (default that of the file, or 8)"
    values(parser, real, {"--max-seconds": ("S", seconds)})
    parser.add_argument("--out", metavar="F.nc", help=motion)  # type: ignore[arg-type]
    chart = (
        "time against true error of every model; of several laws the first is taken for the truth"
    )
    plotting(parser, f": {chart}")
    overwriting(parser, "replace existing files")


def run(options: argparse.Namespace) -> None:
    """Answer the scene of a file, write the motion and the chart, and print the answer."""
    from ..storage.files import together

    with waiting():
        from ..scene.scene import Scene
        from ..scene.toml_file import titled

        title, arguments = titled(options.file)
        scene = Scene(**arguments | _changes(options, arguments))
        names = tuple(scene.quantities)
        _refuse(options, scene)
        targets, asked = targets_of(options, "write"), scene
        if "out" in targets and "path" not in names:
            scene = replace(scene, quantities=(*names, "path"))
        answer = scene.verify() if options.verify else scene.answer(only=options.only)
    with together():
        if "out" in targets:
            _write(options, answer, targets["out"], getattr(scene.disk, "name", "thin disk"))
        if "plot" in targets:
            with progress_bar("models") as progress:
                asked.plot(targets["plot"], overwrite=options.force, progress=progress)
    record = _record(title, scene, answer, names, options)
    print_answer(options, record, _lines(title, scene, answer, names, targets))


def _changes(options: argparse.Namespace, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """What the options give in place of what the file states."""
    changes: dict[str, Any] = given(options, "max_seconds")
    if (asked := resistances_of(options)) is not None:
        kinds = {type(resistance) for resistance in asked}
        kept = [
            resistance
            for resistance in arguments.get("resistance", ())
            if type(resistance) not in kinds
        ]
        changes["resistance"] = [*kept, *asked]
    return changes


def _refuse(options: argparse.Namespace, scene: Scene) -> None:
    """Refuse options that do not fit the scene or one another."""
    from ..base.checks import known
    from ..base.errors import listed
    from ..scene.questions import QUESTIONS
    from ..scene.rungs.near_steady import LINEARISED, SECOND, STEADY

    if options.plot is not None and not set(scene.quantities) <= set(QUESTIONS):
        raise ParameterError(
            f"--plot is given and the scene asks for {listed(scene.quantities)}, of linear motion; "
            "its chart is of motions."
        )
    if options.verify and options.only is not None:
        raise ParameterError("--verify and --only are both given; give one of them.")
    asked = "--verify" if options.verify else "--only"
    if not options.verify and options.only is None:
        return
    if isinstance(scene.contact, Mapping):
        raise ParameterError(
            f"{asked} is given and the scene has {len(scene.contact)} laws; it needs a scene with "
            "one law."
        )
    if options.only is not None and set(scene.quantities) <= set(QUESTIONS):
        known("--only", options.only, (STEADY, LINEARISED, SECOND, "creep", scene.contact.name))


def _write(options: argparse.Namespace, answer: Answer, target: Path, name: str) -> None:
    """Write the motion; those under several laws along the dimension `law`."""
    import xarray

    from ..storage.datasets import write_dataset

    parts = {n: a.path for n, a in _parts(answer).items() if a.path is not None}
    if not parts:
        raise ParameterError(f"--out has no motion to write: {answer.sentence}")
    if answer.parts:
        # a motion that ends before the others has no values after its end
        dataset = xarray.concat(
            list(parts.values()), "law", join="outer", combine_attrs="drop_conflicts"
        ).assign_coords(law=("law", list(parts), {"long_name": "contact law"}))
        dataset.attrs["title"] = f"{name} under several contact laws"
        dataset.attrs["citation"] = answer.citation
        dataset.attrs["model"] = ", ".join(answer.parts[n].model for n in parts)
    else:
        [dataset] = parts.values()
    write_dataset(dataset, target, overwrite=options.force)


def _parts(answer: Answer) -> dict[str, Answer]:
    """The answers under each law by name; the answer itself where there is one law."""
    return dict(answer.parts) or {answer.model: answer}


def _by_name(value: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Values by quantity, whether one or several were asked for."""
    if isinstance(value, dict) and set(value) & set(names):
        return value
    return {names[0]: value}


def _asked(value: Any, names: tuple[str, ...]) -> Any:
    """A value or an error by quantity, as Python gives it, without what `--out` has added."""
    if not isinstance(value, dict) or not set(names) & set(value):
        return value
    kept = {n: _columns(value[n]) for n in names if n in value}
    return next(iter(kept.values())) if len(names) == 1 else kept


def _columns(value: Any) -> Any:
    """A path as columns of numbers; any other value unchanged."""
    if not hasattr(value, "data_vars"):
        return value
    return {str(n): value[n].values for n in ("time", *value.data_vars)}


# --- for a program ---


def _record(
    title: str, scene: Scene, answer: Answer, names: tuple[str, ...], options: argparse.Namespace
) -> dict[str, Any]:
    """The answer as one object."""
    several = bool(answer.parts)
    value = (
        {n: _asked(_columns(v), names) for n, v in answer.value.items()}
        if several
        else (_asked(_columns(answer.value), names))
    )
    plain = scene.disk.dimensionless
    record: dict[str, Any] = {
        "title": title,
        "quantities": list(names),
        "value": value,
        **_about(answer, names),
        "tolerance": answer.tolerance,
        "horizon": scene.horizon,
        "unit": scales_of(scene.disk),
        "units": _units(answer, names, plain=plain),
        "citation": answer.citation,
    }
    if several:
        record["laws"] = {n: _about(a, names) for n, a in answer.parts.items()}
    if options.verify:
        record["true_error"] = _asked(answer.true_error, names)
    files = {
        n: str(getattr(options, n)) for n in ("out", "plot") if getattr(options, n) is not None
    }
    if files:
        record["files"] = files
    return record


def _about(answer: Answer, names: tuple[str, ...]) -> dict[str, Any]:
    """The model of an answer, and what is known of its error."""
    spread = answer.spread
    return {
        "model": answer.model,
        "estimate": _asked(answer.estimate, names),
        "until": answer.until,
        "sentence": answer.sentence,
        "notes": answer.notes,
        "rungs": [asdict(r) for r in answer.rungs],
        "spread": None if spread is None else {n: getattr(spread, n) for n in SPREAD},
        "cost": answer.cost,
    }


def _units(answer: Answer, names: tuple[str, ...], *, plain: bool) -> dict[str, str]:
    """Units in words of all numbers of the answer."""
    from ..bodies.newton_euler import STATES
    from ..bodies.quantities import QUANTITIES
    from ..scene.questions import QUESTIONS

    kinds = {n: q.kind for n, q in QUESTIONS.items() if n in names and q.kind is not None}
    if {"final", "path"} & set(names):
        motions = [a.motion[0].launches.model for a in _parts(answer).values() if a.motion]
        quantities = {n: model.quantities[n] for model in motions for n in model.states}
        kinds |= {n: q.kind for n, q in (quantities or {n: QUANTITIES[n] for n in STATES}).items()}
        kinds["time"] = QUANTITIES["time"].kind
    return {n: kind.label(dimensionless=plain) for n, kind in kinds.items()}


# --- for a reader ---


def _lines(
    title: str,
    scene: Scene,
    answer: Answer,
    names: tuple[str, ...],
    targets: Mapping[str, Path],
) -> Iterator[str]:
    """The title, the answer in words, a table of the values, every ladder, and the files."""
    from ..storage.targets import path_text

    yield from _table_and_ladders(title, scene, answer, names)
    if targets:
        yield ""
    for path in targets.values():
        yield f"wrote {path_text(path)}"


def _table_and_ladders(
    title: str, scene: Scene, answer: Answer, names: tuple[str, ...]
) -> Iterator[str]:
    yield from (title, *answer.setting, "", answer.sentence)
    columns = _parts(answer)
    if all(part.model == "none" for part in columns.values()):
        return
    yield ""
    rows = {"model": [part.model for part in columns.values()]}
    units = _units(answer, names, plain=scene.disk.dimensionless)
    digits = max(3, 2 - math.floor(math.log10(scene.tolerance)))
    for name in names:
        cells = [_cells(part, name, names, units, digits) for part in columns.values()]
        for label in dict.fromkeys(n for cell in cells for n in cell):
            rows[label] = [cell.get(label, "") for cell in cells]
    head = {"": list(columns)} if answer.parts else {}
    yield from _table(head | rows)
    yield ""
    of = getattr(scene.disk, "name", "disk")
    yield (
        f"Errors are over 1 or the size of the value, in units of the {of} ({ones_of(scene.disk)})."
    )
    for name, part in columns.items():
        yield ""
        if answer.parts:
            yield f"{name}: {part.sentence}"
        if part.rungs:
            yield part.ladder()


def _cells(
    answer: Answer, name: str, names: tuple[str, ...], units: Mapping[str, str], digits: int
) -> dict[str, str]:
    """The rows of a quantity in the column of one answer."""
    from ..scene.linear import EVERY

    if answer.model == "none":
        return {name: "-"}
    every = names if "path" in names or answer.path is None else (*names, "path")
    value = _by_name(answer.value, every)[name]
    cells = {}
    if name == "final":
        for state, number in value.items():
            cells[f"{state} [{readable(units[state])}]"] = answer.number(
                state, number, name, digits
            )
    elif name == "path":
        cells["path"] = f"{value.sizes['time']} samples"
    elif isinstance(value, float):
        unit = f" [{readable(units[name])}]" if name in units else ""
        cells[f"{name}{unit}"] = answer.number(name, value, name, digits)
    else:
        unknown = value is None and not math.isfinite(_by_name(answer.estimate, every)[name])
        cells[name] = "not known" if unknown else value or EVERY[name].none
    for label, errors in (("error", answer.estimate), ("true error", answer.true_error)):
        if errors is not None:
            size = _by_name(errors, every)[name]
            text = f"{size:.1e}"
            if not size and not isinstance(value, float):  # a word is right or not known to be
                text = _sure(answer) if errors is answer.estimate else "0"
            cells[f"  {label} of {name}"] = text if math.isfinite(size) else "not known"
    return cells


def _sure(answer: Answer) -> str:
    """How a word without error is called."""
    spread = answer.spread
    return "certain, for the inputs as given" if spread and spread.contrary else "certain"


def _table(rows: Mapping[str, list[str]]) -> Iterator[str]:
    """Rows of cells in columns of equal width."""
    first = max(map(len, rows)) + GAP
    widths = [max(map(len, column)) + GAP for column in zip(*rows.values(), strict=True)]
    for label, cells in rows.items():
        text = "".join(f"{c:<{w}}" for c, w in zip(cells, widths, strict=True))
        yield f"{label:<{first}}{text}".rstrip()
