"""Films only: a motion as GIF or MP4, or as a page that can be turned and played."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from importlib import import_module, resources
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import CubicHermiteSpline

from .disk import positive
from .errors import FileError, ParameterError
from .files import check_target, whole
from .trajectory import outcome_of

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]

BLUE, PALE, VERMILION, GREY, INK = "#0072B2", "#7db8da", "#D55E00", "#8a8a8a", "#222222"
SUFFIXES = (".gif", ".mp4", ".html")
SHORTEST, LONGEST = 4.0, 20.0
"""Range of a film's length when none is asked [s]."""
MOST_FRAMES = 10_000
MOST_SAMPLES = 20_000
"""Samples in a page; a longer motion is thinned evenly."""
SIZE, DPI = (7.2, 5.0), 100
"""Frame [in] and dots per inch; both products are even, as video codecs ask."""
ELEVATION, ASIDE, DISTANCE = math.radians(24), math.radians(42), 16.0
"""Camera: above the plane, aside of the disk's axis at the start, and how far off [R]."""
WIDEST, CLOSE = 7.0, 4.0
"""Half width of the view [R]: the widest that takes in the whole path, and when following."""
THIN = 0.93
"""Inner radius drawn for a hoop [R], whose own would leave nothing to see."""
POSED = ("theta", "phi", "psi", "centre_x", "centre_y")
LINEAR = (
    "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y", "normal_force", "force_x", "force_y",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Geometry:
    """Where the disk is in space at n instants; vectors have shape (n, 3), Z up."""

    radius: float
    """Radius R."""
    psi: Floats
    """Angle of the mark on the disk from `towards`."""
    towards: Floats
    """1̂, from the centre to the contact point."""
    along: Floats
    """2̂ = ŷ, horizontal along the rim."""
    axis: Floats
    """3̂, the symmetry axis."""
    centre: Floats
    """Centre of the disk."""
    contact: Floats
    """Contact point."""
    slip: Floats
    """Velocity of the rim's material point at the contact."""
    force: Floats
    """Force of the plane on the disk."""

    def points(self, angle: Any, share: Any = 1.0) -> Floats:
        """Points fixed in the disk.

        Parameters
        ----------
        angle
            Angles from the mark about the axis, shape (m,) [rad].
        share
            Distances from the centre, shape (m,) or one for all [R].

        Returns
        -------
        ndarray
            Shape (n, m, 3).
        """
        turn = self.psi[:, None] + np.asarray(angle, dtype=float)
        reach = self.radius * np.broadcast_to(np.asarray(share, dtype=float), turn.shape)
        return np.asarray(
            self.centre[:, None]
            + (reach * np.cos(turn))[..., None] * self.towards[:, None]
            + (reach * np.sin(turn))[..., None] * self.along[:, None]
        )


def geometry(motion: Mapping[Any, Any]) -> Geometry:
    """The disk in space from angles, path, slip and contact force.

    Parameters
    ----------
    motion
        A single run from `simulate` with `pose=True`, or its series by name.

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
    s = {n: np.atleast_1d(np.asarray(motion[n], dtype=float)) for n in (*POSED, *LINEAR)}
    radius = float(np.asarray(motion["radius"]))
    zero = np.zeros_like(s["theta"])
    out = np.stack([np.cos(s["phi"]), np.sin(s["phi"]), zero], axis=-1)
    along = np.stack([-np.sin(s["phi"]), np.cos(s["phi"]), zero], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    cosine, sine = np.cos(s["theta"])[:, None], np.sin(s["theta"])[:, None]
    towards = cosine * out - sine * up
    centre = np.stack([s["centre_x"], s["centre_y"], radius * sine[:, 0]], axis=-1)

    def in_space(x: str, y: str) -> Floats:
        return np.asarray(s[x][:, None] * out + s[y][:, None] * along)

    return Geometry(
        radius, s["psi"], towards, along, sine * out + cosine * up, centre,
        centre + radius * towards, in_space("slip_x", "slip_y"),
        in_space("force_x", "force_y") + s["normal_force"][:, None] * up,
    )  # fmt: skip


def resample(motion: Mapping[Any, Any], times: Floats) -> dict[str, Any]:
    """A motion at other times: its pose by cubics through values and rates, the rest by lines.

    Parameters
    ----------
    motion
        As for `geometry`, with `time`.
    times
        Times within those of the motion, shape (n,).

    Returns
    -------
    dict
        The series by name, with `time` and `radius`.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Rough(), {"theta": 1.5, "omega3": 2.0}, 2.0, pose=True)
    >>> bool(resample(run, run.time.values[::2])["phi"][-1] == run.phi[-1])
    True
    """
    t = np.asarray(motion["time"], dtype=float)
    found: dict[str, Any] = {"time": times, "radius": float(np.asarray(motion["radius"]))}
    for name, rate in _rates(motion).items():
        found[name] = CubicHermiteSpline(t, np.asarray(motion[name], dtype=float), rate)(times)
    # between coarse samples a cubic may pass beyond flat, where the disk would be under the plane
    found["theta"] = np.clip(found["theta"], 0.0, math.pi)
    for name in LINEAR:
        found[name] = np.interp(times, t, np.asarray(motion[name], dtype=float))
    return found


def _rates(motion: Mapping[Any, Any]) -> dict[str, Floats]:
    """Rates of the pose; ṡ = vA − ω × R1̂ gives those of the centre."""
    s = {n: np.asarray(motion[n], dtype=float) for n in (*POSED, *LINEAR)}
    radius = float(np.asarray(motion["radius"]))
    x = s["slip_x"] + radius * s["theta_dot"] * np.sin(s["theta"])
    y = s["slip_y"] - radius * s["omega3"]
    cosine, sine = np.cos(s["phi"]), np.sin(s["phi"])
    spin = s["omega3"] - s["phi_dot"] * np.cos(s["theta"])
    rates = (s["theta_dot"], s["phi_dot"], spin, x * cosine - y * sine, x * sine + y * cosine)
    return dict(zip(POSED, rates, strict=True))


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
    if suffix not in SUFFIXES:
        raise FileError(f"the file name ends in {suffix!r}; give .gif, .mp4 or .html.")
    span = float(motion["time"][-1] - motion["time"][0])
    length = min(max(span, SHORTEST), LONGEST)
    if seconds is not None:
        length = _number("seconds", seconds)
    rate = _number("fps", fps)
    if rate > 100:
        raise ParameterError(f"fps is {rate:g}; at most 100 frames in a second are drawn.")
    if suffix == ".html":
        page = _page(dataset, motion, length)
        with whole(path, overwrite=overwrite) as beside:
            beside.write_text(page, encoding="utf-8")
        if progress is not None:
            progress(1, 1)
        return FilePath(path)
    if suffix == ".gif":
        rate = 100 / max(2, round(100 / rate))
    if rate * length > MOST_FRAMES:
        raise ParameterError(
            f"fps × seconds is {rate * length:.6g} frames; at most {MOST_FRAMES} are drawn."
        )
    write = _mp4(_ffmpeg()) if suffix == ".mp4" else _gif
    frames = np.linspace(motion["time"][0], motion["time"][-1], max(2, round(rate * length)))
    with whole(path, overwrite=overwrite) as beside:
        scene = _Scene(resample(motion, frames), dataset, span / length)
        try:
            write(beside, scene, rate, progress or (lambda done, total: None))
        finally:
            plt.close(scene.figure)
    return FilePath(path)


def _number(name: str, value: Any) -> float:
    number = positive(name, value)
    if not isinstance(number, float):
        raise ParameterError(f"{name} has {number.size} values; give one positive number.")
    return number


def _single(dataset: Any) -> dict[str, Any]:
    """The series of a single run with pose, or a sentence why not."""
    import xarray

    if not isinstance(dataset, xarray.Dataset) or "theta" not in dataset:
        raise ParameterError(f"dataset is {type(dataset).__name__}; give what simulate returns.")
    if "phi" not in dataset:
        raise ParameterError("the dataset has no pose; call simulate with pose=True.")
    if dataset.theta.dims != ("time",):
        shape = [n for d, n in dataset.theta.sizes.items() if d != "time"]
        raise ParameterError(
            f"the dataset has launches of shape {tuple(shape)}; take one, as by isel(launch=0)."
        )
    kept = slice(None)
    if "running" in dataset:  # one of several: after its end it only holds its last state
        kept = slice(0, int((dataset.running.values == 1).sum()))
    motion = {n: dataset[n].values[kept].astype(float) for n in ("time", *POSED, *LINEAR)}
    if len(motion["time"]) < 2:
        count = len(motion["time"])
        raise ParameterError(f"the dataset has {count} sample(s) of the motion; give at least 2.")
    if not all(np.isfinite(v).all() for v in motion.values()):
        raise ParameterError("the dataset has numbers that are not finite; give finite ones.")
    if not (np.diff(motion["time"]) > 0).all():
        raise ParameterError("the times of the dataset do not rise; give rising times.")
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
        self.time, self.theta = motion["time"], motion["theta"]
        self.seen, self.inner = geometry(motion), _inner(dataset)
        self.unit = _unit(dataset, "time")
        self.figure = plt.figure(figsize=SIZE, dpi=DPI, facecolor="white")
        self.axes = self.figure.add_axes((0, 0, 1, 1))
        self.axes.axis("off")
        self._aim(float(motion["phi"][0]) + ASIDE)
        self.grid = self.axes.add_collection(LineCollection([], linewidths=0.8))
        self.shadow = self._patch("#00000026", "none")
        (self.trail,) = self.axes.plot([], [], color=VERMILION, lw=1.6)
        (self.behind,) = self.axes.plot([], [], color=GREY, lw=0.9)
        self.body = self._patch(BLUE, "#004a75")
        self.mark = self._patch(VERMILION, "none")
        (self.ticks,) = self.axes.plot([], [], color="white", lw=1.0)
        (self.before,) = self.axes.plot([], [], color=GREY, lw=0.9)
        (self.spot,) = self.axes.plot([], [], "o", color=INK, ms=3.5)
        put = self.figure.text
        self.clock = put(0.03, 0.94, "", fontsize=12, color=INK)
        self.angle = put(0.03, 0.895, "", fontsize=9, color="#555555")
        put(0.97, 0.94, f"1 s of film = {pace:.3g} {self.unit}", fontsize=9, color="#555555",
            ha="right")  # fmt: skip
        put(0.03, 0.03, _caption(dataset), fontsize=9, color="#555555")
        put(0.97, 0.895, f"outcome: {outcome_of(dataset).word}", fontsize=9, color="#555555",
            ha="right")  # fmt: skip

    def _patch(self, face: str, edge: str) -> PathPatch:
        patch = PathPatch(Path([[0.0, 0.0]]), facecolor=face, edgecolor=edge, linewidth=1.2)
        return self.axes.add_patch(patch)

    def _aim(self, azimuth: float) -> None:
        """Camera and limits: the whole path if it fits, else one that follows the disk."""
        c, s = math.cos(azimuth), math.sin(azimuth)
        ce, se = math.cos(ELEVATION), math.sin(ELEVATION)
        self.to_camera = np.array([ce * c, ce * s, se])
        self.screen = np.array([[-s, c, 0.0], [-se * c, -se * s, ce]])
        radius, centre = self.seen.radius, self.seen.centre
        ground = centre * [1, 1, 0] + [0, 0, 0.5 * radius]
        middle = (ground.min(axis=0) + ground.max(axis=0)) / 2
        spread = np.abs((ground - middle) @ self.screen.T).max(axis=0) / radius + 1.5
        aspect = SIZE[0] / SIZE[1]
        half = max(float(spread[0]), float(spread[1]) * aspect, 0.7 * CLOSE)
        self.target = np.broadcast_to(middle, centre.shape)
        if half > WIDEST:
            half = CLOSE
            # a camera that lags a little keeps the grid calm; it never loses the disk
            lag = max(1, len(ground) // 15)
            padded = np.pad(ground, ((lag, lag), (0, 0)), mode="edge")
            window = np.ones(2 * lag + 1) / (2 * lag + 1)
            calm = np.stack([np.convolve(p, window, "valid") for p in padded.T], axis=-1)
            self.target = ground - np.clip(ground - calm, -1.2 * radius, 1.2 * radius)
        self.half = half
        self.axes.set_xlim(-half * radius, half * radius)
        self.axes.set_ylim(-half * radius / aspect, half * radius / aspect)

    def _project(self, points: Floats, frame: int) -> Floats:
        away = points - self.target[frame]
        # a camera inside the view would see the grid turned inside out
        distance = max(DISTANCE, 3 * self.half) * self.seen.radius
        return np.asarray(
            away @ self.screen.T * (distance / (distance - away @ self.to_camera))[..., None]
        )

    def _lines(self, frame: int) -> None:
        """The plane's grid about the target, one square for each R, fading outwards."""
        radius, reach = self.seen.radius, math.ceil(1.7 * self.half)
        steps = np.arange(-reach, reach + 1.0)
        a, b = np.meshgrid(steps, steps[:-1], indexing="ij")
        pieces = np.stack([np.stack([a, b], -1), np.stack([a, b + 1], -1)], -2).reshape(-1, 2, 2)
        pieces = np.concatenate([pieces, pieces[..., ::-1]])
        origin = np.round(self.target[frame, :2] / radius)
        pieces = (pieces + origin) * radius
        far = np.linalg.norm(pieces.mean(axis=1) - self.target[frame, :2], axis=1)
        colours = np.tile(to_rgba(GREY), (len(pieces), 1))
        colours[:, 3] = 0.5 * np.clip(1 - far / (reach * radius), 0, 1)
        flat = np.concatenate([pieces, np.zeros((len(pieces), 2, 1))], axis=-1)
        self.grid.set_segments(list(self._project(flat, frame)))
        self.grid.set_color([tuple(c) for c in colours])

    def show(self, frame: int) -> None:
        """Put everything where it is at a frame."""
        seen, turn = self.seen, np.linspace(0, 2 * math.pi, 73)
        here = Geometry(seen.radius, *(getattr(seen, n)[frame : frame + 1] for n in _VECTORS))
        rims = [here.points(turn)[0]]
        if self.inner:
            rims.append(here.points(turn[::-1], self.inner)[0])
        self._lines(frame)
        self.shadow.set_path(self._outline([r * [1, 1, 0] for r in rims], frame))
        self.body.set_path(self._outline(rims, frame))
        # the two faces differ, so that the eye can tell which one it sees
        eye = self.target[frame] + DISTANCE * seen.radius * self.to_camera
        side = np.sign((eye - here.centre[0]) @ here.axis[0])
        self.body.set_facecolor(BLUE if side > 0 else PALE)
        wide = np.linspace(-1, 1, 9) * (0.1 + 0.12 * self.inner)
        ends = np.repeat([1.0, self.inner], len(wide))
        wedge = here.points(np.concatenate([wide, wide[::-1]]), ends)[0]
        self.mark.set_path(self._outline([np.vstack([wedge, wedge[:1]])], frame))
        quarter = np.repeat([0.5, 1.0, 1.5], 3) * math.pi
        spokes = self._project(here.points(quarter, [self.inner, 1.0, np.nan] * 3)[0], frame)
        self.ticks.set_data(spokes[:, 0], spokes[:, 1])
        past = seen.centre[: frame + 1]
        nearer = (past - here.centre[0]) @ here.axis[0] * side > 0
        path, trail = self._project(past, frame), self._project(seen.contact[: frame + 1], frame)
        self.trail.set_data(trail[:, 0], trail[:, 1])
        self.behind.set_data(path[:, 0], path[:, 1])
        self.before.set_data(np.where(nearer, path[:, 0], np.nan), path[:, 1])
        self.spot.set_data(trail[-1:, 0], trail[-1:, 1])
        self.clock.set_text(f"t = {self.time[frame]:.2f} {self.unit}")
        self.angle.set_text(f"θ = {math.degrees(self.theta[frame]):.1f}°")

    def _outline(self, loops: list[Floats], frame: int) -> Path:
        return Path.make_compound_path(
            *(Path(self._project(loop, frame), closed=True) for loop in loops)
        )


_VECTORS = [field.name for field in fields(Geometry) if field.name != "radius"]
Report = Callable[[int, int], None]


def _gif(path: FilePath, scene: _Scene, rate: float, progress: Report) -> None:
    total = len(scene.time)

    def pictures() -> Iterator[Image.Image]:
        palette: Image.Image | None = None
        for frame in range(total):
            scene.show(frame)
            canvas: Any = scene.figure.canvas
            canvas.draw()
            picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
            # one palette for all, undithered: still parts stay still, and the file small
            palette = palette or picture.quantize(96, dither=Image.Dither.NONE)
            yield picture.quantize(palette=palette, dither=Image.Dither.NONE)
            progress(frame + 1, total)

    film = pictures()
    next(film).save(
        path, format="GIF", save_all=True, append_images=film, duration=round(1000 / rate), loop=0
    )


def _ffmpeg() -> str:
    """The ffmpeg program, from the system or from a package."""
    found = shutil.which("ffmpeg")
    if found is None:
        try:
            found = str(import_module("imageio_ffmpeg").get_ffmpeg_exe())
        except (ImportError, RuntimeError):
            raise FileError(
                "an .mp4 needs ffmpeg, which was not found; install it by "
                "`pip install stability[video]`, or take .gif."
            ) from None
    return found


def _mp4(program: str) -> Callable[[FilePath, _Scene, float, Report], None]:
    def write(path: FilePath, scene: _Scene, rate: float, progress: Report) -> None:
        total = len(scene.time)
        writer = FFMpegWriter(fps=rate, codec="libx264", extra_args=["-movflags", "+faststart"])
        with plt.rc_context({"animation.ffmpeg_path": program}):
            try:
                with writer.saving(scene.figure, str(path), DPI):
                    for frame in range(total):
                        scene.show(frame)
                        writer.grab_frame()
                        progress(frame + 1, total)
            except (subprocess.CalledProcessError, BrokenPipeError):
                raise FileError(f"{program} could not make the film; take .gif.") from None

    return write


def _page(dataset: xarray.Dataset, motion: dict[str, Any], length: float) -> str:
    """The page: the template with the motion in it."""
    if len(motion["time"]) > MOST_SAMPLES:
        ends = motion["time"][[0, -1]]
        thinned = np.linspace(ends[0], ends[1], MOST_SAMPLES)
        series: dict[str, Any] = resample(motion, thinned)
    else:
        series = motion
    data: dict[str, Any] = {n: _digits(series[n], 9) for n in ("time", *POSED)}
    data |= {f"{n}_rate": _digits(v, 6) for n, v in _rates(series).items()}
    data |= {n: _digits(series[n], 6) for n in ("normal_force", "force_x", "force_y")}
    if "mode" in dataset:
        at = np.searchsorted(motion["time"], series["time"], side="right") - 1
        data["mode"] = dataset["mode"].values[at].astype(int).tolist()
    if "running" not in dataset:  # else the log is that of all launches
        data["event_time"] = _digits(dataset.event_time.values, 9)
        data["event_kind"] = [str(k) for k in dataset.event_kind.values]
    plain = bool(dataset.attrs.get("dimensionless", 0))
    weight = 1.0 if plain else float(dataset.mass * dataset.gravity)
    outcome = outcome_of(dataset)
    data |= {
        "title": str(dataset.attrs.get("title", "motion of a disk")),
        "caption": _caption(dataset), "outcome": outcome.word, "sentence": outcome.value,
        "evidence": str(dataset.evidence.values), "seconds": length, "weight": weight,
        "radius": motion["radius"], "inner": _inner(dataset),
        "time_unit": _unit(dataset, "time"), "force_unit": _unit(dataset, "normal_force"),
    }  # fmt: skip
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    template = resources.files(__package__).joinpath("data/animation.html")
    # no "<" in the data, so that nothing in it can end the script element
    return template.read_text(encoding="utf-8").replace("@MOTION@", text.replace("<", "\\u003c"))


def _digits(values: Any, digits: int) -> list[float]:
    return [float(f"{v:.{digits}g}") for v in values]
