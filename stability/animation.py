"""Films only: a motion as GIF or MP4, or as a page that can be turned and played."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module, resources
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, cast

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.colors import to_rgba
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import CubicHermiteSpline
from scipy.ndimage import uniform_filter1d

from .disk import positive
from .errors import FileError, ParameterError
from .files import check_target, whole
from .outcome import BY_CODE

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]
Report = Callable[[int, int], None]

BLUE, PALE, EDGE, VERMILION = "#0072B2", "#7db8da", "#004a75", "#D55E00"
GREY, INK, WORDS = "#7a7a7a", "#222222", "#555555"
SHORTEST, LONGEST = 4.0, 20.0
"""Range of a film's length when none is asked [s]."""
MOST_FRAMES, MOST_SAMPLES = 10_000, 20_000
"""Frames in a film; samples in a page, which thins a longer motion evenly."""
FINE = 8
"""Steps of the drawn path for each frame."""
SIZE, DPI = (7.2, 5.0), 100
"""Frame [in] and dots per inch; both products are even, as video codecs ask."""
ELEVATION, ASIDE, WIDEST, CLOSE = math.radians(24), math.radians(42), 7.0, 4.0
"""Camera: above the plane, and aside of the axis at the start; half width of the view [R], the
widest that takes in the whole path, and when following."""
THIN = 0.93
"""Inner radius drawn for a hoop [R], whose own would leave nothing to see."""
POSED = ("theta", "phi", "psi", "centre_x", "centre_y")
LINEAR = (
    "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y", "normal_force", "force_x", "force_y",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Geometry:
    """Where the disk is in space at n instants; Z is up, vectors have shape (n, 3)."""

    radius: float
    psi: Floats
    """Angle of the mark from `towards`; next 1̂ to the contact point, 2̂ along the rim, 3̂."""
    towards: Floats
    along: Floats
    axis: Floats
    centre: Floats
    contact: Floats

    def points(self, angle: Any, share: Any = 1.0) -> Floats:
        """Points fixed in the disk by angle from the mark [rad] and distance [R]; (n, m, 3)."""
        turn = (self.psi[:, None] + np.asarray(angle, dtype=float))[..., None]
        arm = np.cos(turn) * self.towards[:, None] + np.sin(turn) * self.along[:, None]
        reach = self.radius * np.asarray(share, dtype=float).reshape(-1, 1)
        return np.asarray(self.centre[:, None] + reach * arm)


def geometry(motion: Mapping[Any, Any]) -> Geometry:
    """The disk in space from its angles and the path of its centre.

    Parameters
    ----------
    motion
        A single run from `simulate` with `pose=True`, one time of it, or its series by name.

    Returns
    -------
    Geometry

    Examples
    --------
    >>> import stability as st
    >>> seen = geometry(st.simulate(st.Disk(), st.Rough(), {"theta": 1.2}, 2.0, pose=True))
    >>> float(abs(seen.contact[:, 2]).max()) < 1e-15
    True
    """
    theta, phi, psi, x, y = (np.atleast_1d(np.asarray(motion[n], dtype=float)) for n in POSED)
    radius, zero = float(motion["radius"]), np.zeros_like(theta)
    out = np.stack([np.cos(phi), np.sin(phi), zero], axis=-1)
    along = np.stack([-np.sin(phi), np.cos(phi), zero], axis=-1)
    cosine, sine = np.cos(theta)[:, None], np.sin(theta)[:, None]
    up = np.array([0.0, 0.0, 1.0])
    towards, axis = cosine * out - sine * up, sine * out + cosine * up
    centre = np.stack([x, y, radius * np.sin(theta)], axis=-1)
    return Geometry(radius, psi, towards, along, axis, centre, centre + radius * towards)


def _resample(motion: dict[str, Any], times: Floats) -> dict[str, Any]:
    """A motion at other times: its pose by cubics through values and rates, the rest by lines."""
    found = {n: np.interp(times, motion["time"], motion[n]) for n in LINEAR}
    for name, rate in _rates(motion).items():
        found[name] = CubicHermiteSpline(motion["time"], motion[name], rate)(times)
    # between coarse samples a cubic may pass beyond flat, where the disk would be under the plane
    found["theta"] = np.clip(found["theta"], 0.0, math.pi)
    return found | {"time": times, "radius": motion["radius"]}


def _rates(motion: dict[str, Any]) -> dict[str, Floats]:
    """Rates of the pose; ṡ = vA − ω × R1̂ gives those of the centre."""
    theta, phi, omega3, radius = (motion[n] for n in ("theta", "phi", "omega3", "radius"))
    x = motion["slip_x"] + radius * motion["theta_dot"] * np.sin(theta)
    y = motion["slip_y"] - radius * omega3
    spin = omega3 - motion["phi_dot"] * np.cos(theta)
    centre = x * np.cos(phi) - y * np.sin(phi), x * np.sin(phi) + y * np.cos(phi)
    return dict(zip(POSED, (motion["theta_dot"], motion["phi_dot"], spin, *centre), strict=True))


def animate(
    dataset: xarray.Dataset,
    path: str | os.PathLike[str],
    *,
    fps: float = 25,
    seconds: float | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> FilePath:
    """Write a motion as a film (.gif, .mp4), or as a page to turn and play (.html).

    Parameters
    ----------
    dataset
        A single run from `simulate` with `pose=True`.
    path
        File to write; its suffix says what.
    fps
        Frames in a second, at most 100; a GIF counts in hundredths of a second and takes the
        nearest it can, at most 50.  A page draws as fast as the screen.
    seconds
        Length of the film [s]; when left out the motion's own, within 4 to 20.
    overwrite
        Whether an existing file may be replaced.
    progress
        Called with (frames done, frames in all).

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ParameterError
        If the dataset is not a single run with pose and two samples, or a number is not accepted.
    FileError
        If the file cannot be written, or MP4 is asked for without ffmpeg; nothing is left
        half-written.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.4}, 3.0, pose=True)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     animate(run, FilePath(folder) / "fall.html").name
    'fall.html'
    """
    motion = _single(dataset)
    check_target(path, overwrite=overwrite)
    suffix = FilePath(path).suffix.lower()
    if suffix not in (".gif", ".mp4", ".html"):
        raise FileError(f"the file name ends in {suffix!r}; give .gif, .mp4 or .html.")
    first, last = motion["time"][[0, -1]]
    length, rate = min(max(last - first, SHORTEST), LONGEST), _number("fps", fps, 100.0)
    if seconds is not None:
        length = _number("seconds", seconds, 3600.0)
    if suffix == ".gif":
        rate = 100 / max(2, round(100 / rate))
    if suffix != ".html" and rate * length > MOST_FRAMES:
        count = f"{rate * length:.6g} frames"
        raise ParameterError(f"fps × seconds is {count}; at most {MOST_FRAMES} are drawn.")
    report = progress or (lambda *_: None)
    with whole(path, overwrite=overwrite) as beside:
        if suffix == ".html":
            beside.write_text(_page(dataset, motion, length), encoding="utf-8")
            report(1, 1)
            return FilePath(path)
        frames = max(2, round(rate * length))
        fine = _resample(motion, np.linspace(first, last, (frames - 1) * FINE + 1))
        scene = _Scene(fine, dataset, (last - first) / length)
        try:
            (_gif if suffix == ".gif" else _mp4)(beside, scene, rate, report)
        finally:
            plt.close(scene.figure)
    return FilePath(path)


def _number(name: str, value: Any, most: float) -> float:
    number = positive(name, value)
    if not isinstance(number, float) or number > most:
        raise ParameterError(f"{name} is {value}; give one positive number, at most {most:g}.")
    return number


def _single(dataset: Any) -> dict[str, Any]:
    """The series of a single run with pose, or a sentence why not."""
    import xarray

    if not isinstance(dataset, xarray.Dataset) or "theta" not in dataset:
        raise ParameterError(f"dataset is {type(dataset).__name__}; give what simulate returns.")
    if "phi" not in dataset:
        raise ParameterError("the dataset has no pose; call simulate with pose=True.")
    if dataset.theta.dims != ("time",):
        sizes = dict(dataset.theta.sizes)
        raise ParameterError(f"the dataset has sizes {sizes}; take one launch by isel(launch=0).")
    # one of several holds its last state after its end
    kept = int((dataset.running == 1).sum()) if "running" in dataset else None
    motion = {n: dataset[n].values[:kept].astype(float) for n in ("time", *POSED, *LINEAR)}
    if (count := len(motion["time"])) < 2:
        raise ParameterError(f"the dataset has {count} sample(s) of the motion; give at least 2.")
    finite = all(np.isfinite(v).all() for v in motion.values())
    if not finite or not (np.diff(motion["time"]) > 0).all():
        raise ParameterError("the dataset has NaN or times that do not rise; give a whole motion.")
    return motion | {"radius": float(dataset.radius)}


def _inner(dataset: xarray.Dataset) -> float:
    """Inner radius to draw [R]: 0 for a disk, that of the annulus with this k otherwise."""
    return min(math.sqrt(max(4 * float(dataset.k) - 1, 0.0)), THIN)


def _unit(dataset: xarray.Dataset, name: str) -> str:
    attributes = dataset[name].attrs
    return str(attributes.get("unit_in_words", attributes.get("units", "")))


def _caption(dataset: xarray.Dataset) -> str:
    """The parameters, in words; the scales only where they are not 1."""
    plain = bool(dataset.attrs.get("dimensionless", 0))
    units = {"mass": " kg", "radius": " m", "gravity": " m/s²"}
    shown = [
        f"{name} = {float(value):.6g}{units.get(str(name), '')}"
        for name, value in dataset.coords.items()
        if value.ndim == 0 and not (plain and name in units)
    ]
    return f"{dataset.attrs.get('contact', '')} contact, {', '.join(shown)}"


class _Scene:
    """The figure of a film, its camera, and everything in it; `show` puts it at a frame."""

    def __init__(self, motion: dict[str, Any], dataset: xarray.Dataset, pace: float) -> None:
        self.motion, self.seen = motion, geometry(motion)
        self.frames = (len(motion["time"]) - 1) // FINE + 1
        self.unit, self.inner = _unit(dataset, "time"), _inner(dataset)
        self.figure = plt.figure(figsize=SIZE, dpi=DPI, facecolor="white")
        self.axes = self.figure.add_axes((0, 0, 1, 1))
        self.axes.axis("off")
        self._aim(float(motion["phi"][0]) + ASIDE)
        (self.grid,) = self.axes.plot([], [], color="#d9d9d9", lw=0.8)
        # in the order of drawing: the disk hides what lies on the plane, for all of it is above
        self.shadow = self._patch("#00000026", "none")
        (self.trail,) = self.axes.plot([], [], color=VERMILION, lw=1.6)
        (self.path,) = self.axes.plot([], [], color=GREY, lw=0.9)
        self.body = self._patch(BLUE, EDGE)
        self.mark = self._patch(VERMILION, "none")
        (self.ticks,) = self.axes.plot([], [], color="white", lw=1.0)
        (self.spot,) = self.axes.plot([], [], "o", color=INK, ms=3.5)
        put = partial(self.figure.text, fontsize=9, color=WORDS)
        self.clock = put(0.03, 0.94, "", fontsize=12, color=INK)
        self.places = int(np.clip(2 - np.floor(np.log10(pace)), 0, 12))
        put(0.97, 0.94, f"1 s of film = {pace:.3g} {self.unit}", ha="right")
        put(0.97, 0.895, f"outcome: {BY_CODE[int(dataset.outcome)].word}", ha="right")
        put(0.03, 0.03, _caption(dataset))

    def _patch(self, face: str, edge: str) -> PathPatch:
        patch = PathPatch(Path([[0.0, 0.0]]), facecolor=face, edgecolor=edge, linewidth=1.2)
        self.axes.add_patch(patch)
        return patch

    def _aim(self, azimuth: float) -> None:
        """Camera and limits: the whole path if it fits, else one that follows the disk."""
        (c, ce), (s, se) = np.cos([azimuth, ELEVATION]), np.sin([azimuth, ELEVATION])
        self.to_camera = np.array([ce * c, ce * s, se])
        self.screen = np.array([[-s, c, 0.0], [-se * c, -se * s, ce]]).T
        radius, aspect = self.seen.radius, SIZE[0] / SIZE[1]
        ground = self.seen.centre * [1, 1, 0] + [0, 0, 0.6 * radius]
        middle = (ground.min(axis=0) + ground.max(axis=0)) / 2
        spread = np.abs((ground - middle) @ self.screen).max(axis=0) / radius + [1.2, 1.6]
        self.half = max(float(spread[0]), float(spread[1]) * aspect, 0.7 * CLOSE)
        self.target = np.broadcast_to(middle, ground.shape)
        if self.half > WIDEST:
            self.half = CLOSE
            # a camera that lags a little keeps the grid calm; it never loses the disk
            calm = uniform_filter1d(ground, max(3, len(ground) // 8), axis=0, mode="nearest")
            self.target = ground - np.clip(ground - calm, -1.2 * radius, 1.2 * radius)
        x, y = self.half * radius, self.half * radius / aspect
        self.axes.set(xlim=(-x, x), ylim=(-y, y))

    def _lines(self, target: Floats) -> Floats:
        """The plane's grid about the target, one square for each R, beyond the frame."""
        reach = math.ceil(2.3 * self.half)
        across = np.repeat(np.arange(-reach, reach + 1.0), 3)
        ends = np.tile([-reach, reach, np.nan], 2 * reach + 1)
        lines = np.vstack([np.stack([across, ends], -1), np.stack([ends, across], -1)])
        lines = (lines + np.round(target[:2] / self.seen.radius)) * self.seen.radius
        return np.pad(lines, ((0, 0), (0, 1)))

    def play(self, report: Report) -> Iterator[Any]:
        """Show each frame in turn; the canvas, to be drawn."""
        for frame in range(self.frames):
            self.show(frame)
            yield self.figure.canvas
            report(frame + 1, self.frames)

    def show(self, frame: int) -> None:
        """Put everything where it is at a frame."""
        i, turn = frame * FINE, np.linspace(0, 2 * math.pi, 73)
        here = geometry({n: self.motion[n][i] for n in POSED} | {"radius": self.seen.radius})
        target = self.target[i]

        def flat(points: Floats) -> Floats:
            return np.asarray((points - target) @ self.screen)

        def outline(*loops: Floats) -> Path:
            return Path.make_compound_path(*(Path(flat(p), closed=True) for p in loops))

        rims = [here.points(turn)[0]]
        if self.inner:
            rims.append(here.points(turn[::-1], self.inner)[0])
        self.grid.set_data(*flat(self._lines(target)).T)
        self.shadow.set_path(outline(*(rim * [1, 1, 0] for rim in rims)))
        self.body.set_path(outline(*rims))
        # the two faces differ, so that the eye can tell which one it sees
        self.body.set_facecolor(BLUE if self.to_camera @ here.axis[0] > 0 else PALE)
        wide = np.linspace(-1, 1, 9) * (0.1 + 0.12 * self.inner)
        ends = np.repeat([1.0, self.inner, 1.0], [9, 9, 1])
        wedge = here.points(np.concatenate([wide, wide[::-1], wide[:1]]), ends)[0]
        self.mark.set_path(outline(wedge))
        quarter = np.repeat([0.5, 1.0, 1.5], 3) * math.pi
        self.ticks.set_data(*flat(here.points(quarter, [self.inner, 1.0, np.nan] * 3)[0]).T)
        self.trail.set_data(*flat(self.seen.contact[: i + 1]).T)
        self.path.set_data(*flat(self.seen.centre[: i + 1]).T)
        self.spot.set_data(*flat(here.contact).T)
        time, lean = self.motion["time"][i], math.degrees(self.motion["theta"][i])
        self.clock.set_text(f"t = {time:.{self.places}f} {self.unit},  θ = {lean:.1f}°")


def _gif(path: FilePath, scene: _Scene, rate: float, report: Report) -> None:
    # one palette for all frames, undithered: still parts stay still, and the file small
    colours = np.array([to_rgba(c)[:3] for c in (BLUE, PALE, EDGE, VERMILION, GREY, INK)])
    mixed = 1 + np.linspace(0, 1, 32)[:, None, None] * (colours - 1)
    palette = Image.fromarray((255 * mixed).round().astype(np.uint8)).quantize(256)

    def pictures() -> Iterator[Image.Image]:
        for canvas in scene.play(report):
            canvas.draw()
            picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
            yield picture.quantize(palette=palette, dither=Image.Dither.NONE)

    film, pause = pictures(), round(1000 / rate)
    with path.open("wb") as file:  # for Pillow leaves its own open if a frame fails
        next(film).save(file, "GIF", save_all=True, append_images=film, duration=pause, loop=0)


def _ffmpeg() -> str:
    """The ffmpeg program, from the system or from a package."""
    try:
        return str(shutil.which("ffmpeg") or import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        message = "an .mp4 needs ffmpeg; `pip install stability[video]`, or take .gif."
        raise FileError(message) from None


def _mp4(path: FilePath, scene: _Scene, rate: float, report: Report) -> None:
    program, speed = _ffmpeg(), cast(int, rate)  # it takes fractions too
    writer = FFMpegWriter(fps=speed, codec="libx264", extra_args=["-movflags", "+faststart"])
    try:
        with plt.rc_context({"animation.ffmpeg_path": program}):
            with writer.saving(scene.figure, str(path), DPI):
                for _ in scene.play(report):
                    writer.grab_frame()
    except (subprocess.CalledProcessError, BrokenPipeError):
        raise FileError(f"{program} could not make the film; take .gif.") from None


def _page(dataset: xarray.Dataset, motion: dict[str, Any], length: float) -> str:
    """The page: the template with the motion in it."""
    times, series = motion["time"], motion
    if len(times) > MOST_SAMPLES:
        series = _resample(motion, np.linspace(times[0], times[-1], MOST_SAMPLES))
    data: dict[str, Any] = {n: _digits(series[n], 9) for n in ("time", *POSED)}
    data |= {n: _digits(series[n], 6) for n in LINEAR}
    if "mode" in dataset:
        at = np.searchsorted(times, series["time"], side="right") - 1
        data["mode"] = dataset["mode"].values[at].astype(int).tolist()
    if "running" not in dataset:  # else the log is that of all launches
        data["event_time"] = _digits(dataset.event_time.values, 9)
        data["event_kind"] = [str(k) for k in dataset.event_kind.values]
    outcome = BY_CODE[int(dataset.outcome)]
    data |= {
        "title": str(dataset.attrs.get("title", "motion of a disk")),
        "caption": _caption(dataset), "outcome": outcome.word, "sentence": outcome.value,
        "evidence": str(dataset.evidence.values), "seconds": length,
        "weight": float(dataset.mass * dataset.gravity),
        "radius": motion["radius"], "inner": _inner(dataset),
        "time_unit": _unit(dataset, "time"), "force_unit": _unit(dataset, "normal_force"),
    }  # fmt: skip
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    template = resources.files(__package__).joinpath("data/animation.html")
    # no "<" in the data, so that nothing in it can end the script element
    return template.read_text(encoding="utf-8").replace("@MOTION@", text.replace("<", "\\u003c"))


def _digits(values: Any, digits: int) -> list[float]:
    return [float(f"{v:.{digits}g}") for v in values]
