"""Films only: a motion as GIF or MP4, or as a page on which a reader turns and plays it."""

from __future__ import annotations

from .canvas import figure_style  # isort: skip

import json
import os
from collections.abc import Callable
from importlib import resources
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import callback, flag, positive
from ..base.errors import ParameterError, shown
from ..base.quantities import unit_of
from ..bodies.round_body.body import Body
from ..motion.dataset import FORMAT
from ..motion.result import BY_CODE
from ..storage.files import atomic_write
from ..storage.targets import FILMS, check_suffix, check_target
from .film import (
    FINE,
    LINEAR,
    POSED,
    BodyCamera,
    Camera,
    caption_of,
    inner_radius,
    on_page,
    placed,
    resample,
    write_gif,
    write_mp4,
)
from .single_run import events_of

if TYPE_CHECKING:
    import xarray


KEPT = (
    "time",
    "event_time",
    "event_kind",
    "event_launch",
    "outcome",
    "evidence",
    "mass",
    "radius",
    "gravity",
    "k",
)
"""Variables that a film needs in addition to `POSED` and `LINEAR`."""
SHORTEST, LONGEST = 4.0, 20.0
"""Range of a film's length when `seconds` is left out [s]."""
MOST_FRAMES, MOST_SAMPLES = 10_000, 20_000
"""Most frames in a film; most samples in a page, which thins a longer motion evenly."""


def animate(
    dataset: xarray.Dataset,
    path: str | os.PathLike[str],
    *,
    fps: float = 25,
    seconds: float | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
    body: Body | None = None,
    contact_path: bool = True,
) -> FilePath:
    """Write a motion as a film (.gif, .mp4) or as a page to turn and play (.html).

    Parameters
    ----------
    dataset
        A single run from `simulate` with `pose=True`.
    path
        File to write; its suffix names the format.
    fps
        Frames in a second, at most 100.  A GIF counts in hundredths of a second: it takes the
        nearest possible rate, at most 50.  A page draws as fast as the screen.
    seconds
        Length of the film [s]; when left out the length of the motion, within 4 to 20.
    overwrite
        Whether an existing file may be replaced.
    progress
        Called with (frames done, frames in all).
    body
        The `Body` of the dataset, whose shape is drawn; None for a disk.  The dataset's times must
        be so close that the body turns less than half round between two.
    contact_path
        Whether the path of the contact point is drawn.  Without it the path of the centre is drawn
        more strongly, and in a film from above too; a page has a switch.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ParameterError
        If the dataset is not a single run with pose and two samples, or a number is not accepted.
    FileError
        If the file cannot be written, or MP4 is asked for without ffmpeg.  No half-written file
        is left.

    Source: drawn from the dataset alone; each text is measured: tests/figures.

    Examples
    --------
    >>> from pathlib import Path
    >>> import tempfile, stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.4}, 3.0, pose=True)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.animate(run, Path(folder) / "fall.html").name
    'fall.html'
    """
    callback(progress)
    motion = _single(dataset, body)
    suffix = check_suffix(path, FILMS).suffix.lower()
    check_target(path, overwrite=overwrite)
    first, last = motion["time"][[0, -1]]
    length, rate = min(max(last - first, SHORTEST), LONGEST), _number("fps", fps, 100.0)
    if seconds is not None:
        length = _number("seconds", seconds, 3600.0)
    if suffix == ".gif":
        rate = 100 / max(2, round(100 / rate))
    if suffix != ".html" and rate * length > MOST_FRAMES:
        count = f"{rate * length:.6g} frames"
        raise ParameterError(f"fps × seconds is {count}; at most {MOST_FRAMES} are drawn.")
    paths = {"contact_path": flag("contact_path", contact_path)}
    report = progress or (lambda *_: None)
    with atomic_write(path, overwrite=overwrite) as draft:
        if suffix == ".html":
            page = _page(dataset, motion, length, body, **paths)
            draft.write_text(page, encoding="utf-8")
            report(1, 1)
            return FilePath(path)
        frames = max(2, round(rate * length))
        times, pace = np.linspace(first, last, (frames - 1) * FINE + 1), (last - first) / length
        with figure_style({}):
            if body is None:
                scene = Camera(resample(motion, times), dataset, pace, **paths)
            else:
                scene = BodyCamera(placed(motion, body, times), dataset, pace, body, **paths)
            (write_gif if suffix == ".gif" else write_mp4)(draft, scene, rate, report)
    return FilePath(path)


def _number(name: str, value: Any, most: float) -> float:
    number = positive(name, value)
    if not isinstance(number, float) or not 1e-3 <= number <= most:
        raise ParameterError(f"{name} is {value}; give one number from 0.001 to {most:g}.")
    return number


def _single(dataset: Any, body: Any = None) -> dict[str, Any]:
    """The series of a single run with pose; an error in one sentence for other datasets."""
    import xarray

    if not isinstance(dataset, xarray.Dataset) or dataset.attrs.get("format") != FORMAT:
        raise ParameterError(f"dataset is {type(dataset).__name__}; give what simulate returns.")
    if name := dataset.attrs.get("system"):
        raise ParameterError(
            f"the dataset is of {name}, and films show a disk; draw it with plot_motion."
        )
    if body is not None and not isinstance(body, Body):
        raise ParameterError(f"body is {shown(body)}; give a stability.Body.")
    known = dataset.attrs.get("body")
    if known != (None if body is None else body.name):
        raise ParameterError(
            f"the dataset is of {known or 'a disk'}; give "
            + (f"body=, the Body that is called {known}." if known else "no body.")
        )
    if body is not None:
        _check_numbers(dataset, body)
    if "phi" not in dataset:
        raise ParameterError("the dataset has no pose; call simulate with pose=True.")
    series = (*POSED, *LINEAR, *(("contact_x", "contact_y") if body else ()))
    needed = [n for n in (*series, *KEPT) if body is None or n not in ("radius", "k")]
    lost = [n for n in needed if n not in dataset.variables]
    if lost:
        raise ParameterError(
            f"the dataset has no {lost[0]}; give what simulate returns, unchanged."
        )
    if dataset.theta.dims != ("time",):
        sizes = dict(dataset.theta.sizes)
        raise ParameterError(f"the dataset has sizes {sizes}; take one launch by isel(launch=0).")
    # a launch out of several repeats its last state after its end
    kept = int((dataset.running == 1).sum()) if "running" in dataset else None
    motion = {n: dataset[n].values[:kept].astype(float) for n in ("time", *series)}
    if (count := len(motion["time"])) < 2:
        raise ParameterError(f"the dataset has {count} sample(s) of the motion; give at least 2.")
    finite = all(np.isfinite(v).all() for v in motion.values())
    if not finite or not (np.diff(motion["time"]) > 0).all():
        raise ParameterError("the dataset has NaN or times that do not rise; give a whole motion.")
    return motion if body else motion | {"radius": float(dataset.radius)}


def _check_numbers(dataset: xarray.Dataset, body: Body) -> None:
    """Refuse a body whose numbers are not those of the motion, since its shape would be another."""
    for name, value in body.given.items():
        if np.size(value) > 1:
            raise ParameterError(
                f"{name} of the body is {shown(value)}; give the body with the numbers of the one "
                "launch that is drawn."
            )
        known = dataset[name].values if name in dataset.variables else np.asarray(value)
        if known.ndim == 0 and not np.isclose(known, value, rtol=1e-9, atol=0.0).all():
            raise ParameterError(
                f"{name} of the body is {float(np.ravel(value)[0]):g} and that of the dataset "
                f"{float(known):g}; give the body of the dataset."
            )


def _page(
    dataset: xarray.Dataset,
    motion: dict[str, Any],
    length: float,
    body: Body | None,
    *,
    contact_path: bool,
) -> str:
    """Text of the page: the template with the motion in it."""
    times = motion["time"]
    if len(times) > MOST_SAMPLES:
        times = np.linspace(times[0], times[-1], MOST_SAMPLES)
    data = _disk_data(dataset, motion, times) if body is None else _body_data(motion, times, body)
    if "mode" in dataset:
        at = np.searchsorted(motion["time"], times, side="right") - 1
        data["mode"] = dataset["mode"].values[at].astype(int).tolist()
    log = events_of(dataset)
    data["event_time"] = _digits([time for time, _ in log], 9)
    data["event_kind"] = [word for _, word in log]
    outcome = BY_CODE[int(dataset.outcome)]
    data |= {
        "title": str(dataset.attrs.get("title", "motion of a disk")),
        "caption": caption_of(dataset),
        "outcome": outcome.word,
        "sentence": outcome.value,
        "evidence": str(dataset.evidence.values),
        "seconds": length,
        "trail": contact_path,
        "weight": float(dataset.mass * dataset.gravity),
        "time_unit": unit_of(dataset.time.attrs),
        "force_unit": unit_of(dataset.normal_force.attrs),
    }
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    template = resources.files(__package__).joinpath("animation.html")
    # no "<" in the data, so that no text can end the script element
    return template.read_text(encoding="utf-8").replace("@MOTION@", text.replace("<", "\\u003c"))


def _disk_data(dataset: xarray.Dataset, motion: dict[str, Any], times: Any) -> dict[str, Any]:
    """The disk at times of the page."""
    series = motion if len(times) == len(motion["time"]) else resample(motion, times)
    data: dict[str, Any] = {n: _digits(series[n], 9) for n in ("time", *POSED)}
    data |= {n: _digits(series[n], 6) for n in LINEAR}
    return data | {"radius": motion["radius"], "inner": inner_radius(dataset)}


def _body_data(motion: dict[str, Any], times: Any, body: Body) -> dict[str, Any]:
    """The body and its shape at times of the page."""
    series = on_page(motion, body, times)
    shape, turn = series.pop("shape"), series.pop("turn")
    size = series.pop("size")
    data: dict[str, Any] = {n: _digits(v, 9) for n, v in series.items()}
    data["turn"] = [_digits(row, 9) for row in turn]
    normal = {"across": np.sin(shape.theta), "along": -np.cos(shape.theta)}
    rows = {"r": shape.r, "z": shape.z} | normal
    data["shape"] = {n: _digits(v, 6) for n, v in rows.items()}
    data["shape"]["mark"] = shape.mark.astype(int).tolist()
    return data | {"radius": float(body.length), "size": size}


def _digits(values: Any, digits: int) -> list[float]:
    return [float(f"{v:.{digits}g}") for v in values]
