"""Films only: a motion as GIF or MP4, or as a page on which a reader turns and plays it."""

from __future__ import annotations

from .canvas import figure_style  # isort: skip

import json
import math
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module, resources
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import FFMpegWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import CubicHermiteSpline
from scipy.ndimage import uniform_filter1d
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation, Slerp

from ..base.checks import callback, flag, instance, positive
from ..base.errors import FileError, ParameterError, shown
from ..base.quantities import behind, unit_of
from ..base.types import Floats, Overwrite
from ..base.version import install_line
from ..bodies.quantities import PHYSICAL
from ..bodies.round_body.body import Body
from ..motion.result import BY_CODE
from ..storage.files import atomic_write
from ..storage.origin import origin_of
from ..storage.targets import FILMS, check_suffix, check_target
from .motion import _quantities
from .single_run import events_of, one_launch
from .styled_figure import broken

if TYPE_CHECKING:
    import xarray


SHORTEST, LONGEST = 4.0, 20.0
"""Range of a film's length when `seconds` is left out [s]."""
MOST_FRAMES, MOST_SAMPLES = 10_000, 20_000
"""Most frames in a film; most samples in a page, which thins a longer motion evenly."""
Report = Callable[[int, int], None]
BLUE, PALE, EDGE, VERMILION = "#0072B2", "#7db8da", "#004a75", "#D55E00"
GREY, INK = "#7a7a7a", "#222222"
SMALL, LARGE, LETTERS = 14, 18, 60
"""Sizes of text [pt of the frame, of which a phone shows half], and letters in a line."""
HALO = [withStroke(linewidth=3, foreground="white")]
FINE = 8
"""Steps of the drawn path between two frames."""
SIZE, DPI = (7.2, 5.0), 100
"""Frame [in] and dots per inch; width and height in dots are even, as video codecs require."""
ELEVATION, ASIDE, WIDEST, CLOSE = math.radians(24), math.radians(42), 7.0, 4.0
"""Angles of the camera [rad]: above the plane, and from the disk's axis at the start.  Half widths
of the view [R]: the largest that shows the whole path, and that of a camera which follows."""
THIN = 0.93
"""Largest inner radius drawn [R]: the true one of a hoop, 1, would leave nothing to see."""
POSED = ("theta", "phi", "psi", "centre_x", "centre_y")
"""Series that place the disk."""
LINEAR = (
    "theta_dot",
    "phi_dot",
    "omega3",
    "slip_x",
    "slip_y",
    "normal_force",
    "force_x",
    "force_y",
)
"""Series that are interpolated by lines."""
STRIPES, ROUND, ALONG = 6, 48, 61
"""Stripes along the surface; points round it and along a meridian."""
CAP, WEDGE = 0.55, 2
"""Half opening of the coloured cap at the end of the axis, as an angle of normals [rad]; on a flat
end a wedge shows the turning: its half width, in points round the axis."""


def animate(
    dataset: xarray.Dataset,
    path: str | os.PathLike[str],
    *,
    fps: float = 25,
    seconds: float | None = None,
    overwrite: Overwrite = False,
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
        Whether an existing file may be replaced; "same": if the same call wrote it.
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
    asked = {"dataset": dataset, "fps": rate, "seconds": length, "body": body} | paths
    origin = origin_of("animate", asked, dataset.attrs.get("citation", ""))
    with atomic_write(path, overwrite=overwrite, origin=origin) as draft:
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
    data = one_launch(dataset, (*POSED, *LINEAR)).data
    if body is not None:
        instance("body", body, Body, "give a stability.Body")
    named = data.attrs.get("body")
    if named != (None if body is None else body.name):
        raise ParameterError(
            f"the dataset is of {named or 'a disk'}; give "
            + (f"body=, the Body that is called {named}." if named else "no body.")
        )
    if body is not None:
        _check_numbers(dataset, body)
    names = ("time", *POSED, *LINEAR, *(("contact_x", "contact_y") if body else ()))
    motion = {n: data[n].values.astype(float) for n in names}
    finite = all(np.isfinite(v).all() for v in motion.values())
    if not finite or not (np.diff(motion["time"]) > 0).all():
        raise ParameterError("the dataset has NaN or times that do not rise; give a whole motion.")
    return motion if body else motion | {"radius": float(data.radius)}


def _check_numbers(dataset: xarray.Dataset, body: Body) -> None:
    """Refuse a body whose numbers are not those of the motion, since its shape would be another."""
    for name, value in body.given.items():
        if np.size(value) > 1:
            raise ParameterError(
                f"{name} of the body is {shown(value)}; give the body with the numbers of the one "
                "launch that is drawn."
            )
        stored = dataset[name].values if name in dataset.variables else np.asarray(value)
        if stored.ndim == 0 and not np.isclose(stored, value, rtol=1e-9, atol=0.0).all():
            raise ParameterError(
                f"{name} of the body is {float(np.ravel(value)[0]):g} and that of the dataset "
                f"{float(stored):g}; give the body of the dataset."
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
    """The body and its shape at times of the page.

    `turn` holds quaternions (x, y, z, w) whose signs do not jump.  Centre, contact point and forces
    are along fixed axes.
    """
    pose = placed(motion, body, times)
    turn = Rotation.from_matrix(pose["turn"]).as_quat()
    jumps = np.sum(turn[1:] * turn[:-1], axis=1) < 0
    turn[1:] *= np.where(np.cumsum(jumps) % 2, -1.0, 1.0)[:, None]
    # x̂ turns with phi: forces are turned into fixed axes before they are interpolated
    force = (motion["force_x"] + 1j * motion["force_y"]) * np.exp(1j * motion["phi"])
    across = {"normal_force": motion["normal_force"], "push_x": force.real, "push_y": force.imag}
    series = {n: np.interp(times, motion["time"], v) for n, v in across.items()}
    names = "theta", "centre_x", "centre_y", "contact_x", "contact_y", "time", "phi"
    series |= {n: pose[n] for n in names} | {"centre_z": pose["placed"].centre[:, 2]}
    data: dict[str, Any] = {n: _digits(v, 9) for n, v in series.items()}
    data["turn"] = [_digits(row, 9) for row in turn]
    shape = surface(body)
    normal = {"across": np.sin(shape.theta), "along": -np.cos(shape.theta)}
    rows = {"r": shape.r, "z": shape.z} | normal
    data["shape"] = {n: _digits(v, 6) for n, v in rows.items()}
    data["shape"]["mark"] = shape.mark.astype(int).tolist()
    return data | {"radius": float(body.length), "size": pose["placed"].radius}


def _digits(values: Any, digits: int) -> list[float]:
    return [float(f"{v:.{digits}g}") for v in values]


def inner_radius(dataset: xarray.Dataset) -> float:
    """Inner radius to draw [R]: 0 for a disk, otherwise that of the annulus with this k."""
    return min(math.sqrt(max(4 * float(dataset.k) - 1, 0.0)), THIN)


def caption_of(dataset: xarray.Dataset) -> str:
    """The parameters in words, without mass, radius and gravity in a dimensionless motion."""
    plain, law = bool(dataset.attrs.get("dimensionless", 0)), str(dataset.attrs.get("contact", ""))
    quantities = _quantities(dataset)
    shown = []
    for name, value in dataset.coords.items():
        if value.ndim or (plain and name in (*PHYSICAL, "length")):
            continue
        unit, formula = str(value.attrs.get("units", "1")), ""
        if quantity := quantities.get(str(name)):
            unit = quantity.kind.label(dimensionless=plain)
            formula = f" of {quantity.formula}" * bool(quantity.formula)
        shown.append(f"{name} = {float(value):.6g}{behind(unit)}{formula}")
    return f"{law} contact, {', '.join(shown)}"


class Camera:
    """The figure of a film, its camera and all drawn parts; `show` moves these to a frame."""

    fine = FINE

    def __init__(
        self,
        motion: dict[str, Any],
        dataset: xarray.Dataset,
        pace: float,
        seen: Any = None,
        *,
        contact_path: bool = True,
    ) -> None:
        self.motion, self.seen = motion, geometry(motion) if seen is None else seen
        self.contact_path = contact_path
        self.frames = (len(motion["time"]) - 1) // FINE + 1
        self.unit, self.inner = (
            unit_of(dataset.time.attrs),
            inner_radius(dataset) if seen is None else 0.0,
        )
        self.figure = Figure(figsize=SIZE, dpi=DPI, facecolor="white")
        FigureCanvasAgg(self.figure)
        self.axes = self.figure.add_axes((0, 0, 1, 1))
        self.axes.axis("off")
        self._aim(float(motion["phi"][0]) + ASIDE)
        (self.grid,) = self.axes.plot([], [], color="#d9d9d9", lw=0.8)
        self.shadow = self._patch("#00000026", "none")
        (self.trail,) = self.axes.plot([], [], color=VERMILION, lw=1.6)
        strong: dict[str, Any] = (
            {"color": GREY, "lw": 0.9} if contact_path else {"color": VERMILION, "lw": 1.6}
        )
        (self.path,) = self.axes.plot([], [], **strong)
        self.body = self._patch(BLUE, EDGE)
        self.mark = self._patch(VERMILION, "none")
        (self.ticks,) = self.axes.plot([], [], color="white", lw=1.0)
        (self.spot,) = self.axes.plot([], [], "o", color=INK, ms=3.5)
        # the disk hides everything on the plane, since the whole disk is above it
        layers = (self.grid, self.shadow, self.trail, self.path, self.body, self.mark, self.ticks)
        for order, artist in enumerate((*layers, self.spot)):
            artist.set_zorder(order)
        put = partial(self.figure.text, fontsize=SMALL, color=INK, path_effects=HALO)
        self.clock = put(0.02, 0.975, "", fontsize=LARGE, va="top")
        self.places = int(np.clip(2 - np.floor(np.log10(pace)), 0, 12))
        word = BY_CODE[int(dataset.outcome)].word
        put(
            0.98,
            0.975,
            f"1 s of film = {pace:.3g} {self.unit}\noutcome: {word}",
            ha="right",
            va="top",
        )
        put(0.02, 0.02, broken(caption_of(dataset), lambda line: len(line) <= LETTERS), va="bottom")
        self.seat = self._overview(strong) if self.follows or not contact_path else None

    def _overview(self, strong: dict[str, Any]) -> Any:
        """The whole path from above in a corner; the disk in it."""
        inset = self.figure.add_axes((0.74, 0.6, 0.24, 0.25), zorder=9)
        if self.contact_path:
            inset.plot(*self.seen.contact[:, :2].T, color=VERMILION, lw=1.3)
        inset.plot(*self.seen.centre[:, :2].T, **strong | {"lw": 0.9})
        inset.set_aspect("equal", adjustable="datalim")
        inset.margins(0.12)
        inset.set(xticks=[], yticks=[], facecolor="white")
        (seat,) = inset.plot([], [], "o", color=BLUE, mec="white", ms=8)
        return seat

    def _patch(self, face: str, edge: str) -> PathPatch:
        patch = PathPatch(Path([[0.0, 0.0]]), facecolor=face, edgecolor=edge, linewidth=1.2)
        self.axes.add_patch(patch)
        return patch

    def _aim(self, azimuth: float) -> None:
        """Set camera and limits: show the whole path if it fits, otherwise follow the disk."""
        (c, ce), (s, se) = np.cos([azimuth, ELEVATION]), np.sin([azimuth, ELEVATION])
        self.to_camera = np.array([ce * c, ce * s, se])
        self.screen = np.array([[-s, c, 0.0], [-se * c, -se * s, ce]]).T
        radius, aspect = self.seen.radius, SIZE[0] / SIZE[1]
        ground = self.seen.centre * [1, 1, 0] + [0, 0, 0.6 * radius]
        middle = (ground.min(axis=0) + ground.max(axis=0)) / 2
        spread = np.abs((ground - middle) @ self.screen).max(axis=0) / radius + [1.2, 1.6]
        self.half = max(float(spread[0]), float(spread[1]) * aspect, 0.7 * CLOSE)
        self.half *= 1 if self.contact_path else 1.2  # room for the path from above
        self.target = np.broadcast_to(middle, ground.shape)
        self.follows = self.half > WIDEST
        if self.follows:
            self.half = CLOSE
            # a camera that lags a little keeps the grid calm; the clip keeps the disk in view
            calm = uniform_filter1d(ground, max(3, len(ground) // 8), axis=0, mode="nearest")
            self.target = ground - np.clip(ground - calm, -1.2 * radius, 1.2 * radius)
        x, y = self.half * radius, self.half * radius / aspect
        self.axes.set(xlim=(-x, x), ylim=(-y, y))

    def _lines(self, target: Floats) -> Floats:
        """Grid of the plane around the target, in squares of side R, beyond the frame."""
        reach = math.ceil(2.3 * self.half)
        across = np.repeat(np.arange(-reach, reach + 1.0), 3)
        ends = np.tile([-reach, reach, np.nan], 2 * reach + 1)
        lines = np.vstack([np.stack([across, ends], -1), np.stack([ends, across], -1)])
        lines = (lines + np.round(target[:2] / self.seen.radius)) * self.seen.radius
        return np.pad(lines, ((0, 0), (0, 1)))

    def play(self, report: Report) -> Iterator[Any]:
        """Show each frame in turn, and yield the canvas to draw."""
        for frame in range(self.frames):
            self.show(frame)
            yield self.figure.canvas
            report(frame + 1, self.frames)

    def show(self, frame: int) -> None:
        """Move all parts to their places at a frame."""
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
        # the two faces differ in colour, so that a viewer can tell which one is seen
        self.body.set_facecolor(BLUE if self.to_camera @ here.axis[0] > 0 else PALE)
        wide = np.linspace(-1, 1, 9) * (0.1 + 0.12 * self.inner)
        ends = np.repeat([1.0, self.inner, 1.0], [9, 9, 1])
        wedge = here.points(np.concatenate([wide, wide[::-1], wide[:1]]), ends)[0]
        self.mark.set_path(outline(wedge))
        quarter = np.repeat([0.5, 1.0, 1.5], 3) * math.pi
        self.ticks.set_data(*flat(here.points(quarter, [self.inner, 1.0, np.nan] * 3)[0]).T)
        self.follow(i, here.contact)

    def follow(self, i: int, contact: Floats) -> None:
        """Move the paths, the contact point and the clock to a step."""
        target = self.target[i]

        def flat(points: Floats) -> Floats:
            return np.asarray((points - target) @ self.screen)

        if self.contact_path:
            self.trail.set_data(*flat(self.seen.contact[: i + 1]).T)
        self.path.set_data(*flat(self.seen.centre[: i + 1]).T)
        self.spot.set_data(*flat(contact).T)
        if self.seat is not None:
            here = contact if self.contact_path else self.seen.centre[i : i + 1]
            self.seat.set_data(*here[:, :2].T)
        time, lean = self.motion["time"][i], math.degrees(self.motion["theta"][i])
        self.clock.set_text(f"t = {time:.{self.places}f} {self.unit},  θ = {lean:.1f}°")


def write_gif(path: FilePath, scene: Camera, rate: float, report: Report) -> None:
    """Write a scene as a GIF.

    Parameters
    ----------
    path
        File to write.
    scene
        Figure of the film.
    rate
        Frames in a second.
    report
        Called with (frames done, frames in all).
    """
    # one palette for all frames, undithered: still parts do not flicker, and the file is small
    colours = np.array([to_rgba(c)[:3] for c in (BLUE, PALE, EDGE, VERMILION, GREY, INK)])
    mixed = 1 + np.linspace(0, 1, 32)[:, None, None] * (colours - 1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((255 * mixed).round().astype(np.uint8).tobytes())

    def pictures() -> Iterator[Image.Image]:
        for canvas in scene.play(report):
            canvas.draw()
            yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")

    save_gif(path, pictures(), palette, rate)


def save_gif(
    path: FilePath, pictures: Iterator[Image.Image], palette: Image.Image, rate: float
) -> None:
    """Save pictures as a GIF that repeats.

    Parameters
    ----------
    path
        File to write.
    pictures
        The frames, in full colour.
    palette
        A picture with the colours of all frames.
    rate
        Frames in a second.
    """
    few = (p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures)
    pause = round(1000 / rate)
    with path.open("wb") as file:  # a file opened by Pillow stays open if a frame fails
        next(few).save(file, "GIF", save_all=True, append_images=few, duration=pause, loop=0)


def _ffmpeg() -> str:
    """The ffmpeg program, from the system or from a package."""
    try:
        return str(shutil.which("ffmpeg") or import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        message = f"an .mp4 needs ffmpeg; {install_line('video')}, or take .gif."
        raise FileError(message) from None


def write_mp4(path: FilePath, scene: Camera, rate: float, report: Report) -> None:
    """Write a scene as an MP4.

    Parameters
    ----------
    path, scene, rate, report
        As for `write_gif`.

    Raises
    ------
    FileError
        If ffmpeg is missing or fails.
    """
    program, speed = _ffmpeg(), cast(int, rate)  # the writer takes fractions too
    # 4:2:0, which every player shows; the index in front, so that a web page starts at once
    options = ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    writer = FFMpegWriter(fps=speed, codec="libx264", extra_args=options)
    try:
        with rc_context({"animation.ffmpeg_path": program}):
            with writer.saving(scene.figure, str(path), DPI):
                for _ in scene.play(report):
                    writer.grab_frame()
    except (subprocess.CalledProcessError, BrokenPipeError):
        raise FileError(f"{program} could not make the film; take .gif.") from None


@dataclass(frozen=True, eq=False)
class Geometry:
    """Place of the disk in space at n times; Z is up, vectors have shape (n, 3)."""

    radius: float
    """R, in the unit of the motion."""
    psi: Floats
    """Angle of the mark from `towards`, shape (n,) [rad]."""
    towards: Floats
    """1̂, from the centre to the contact point."""
    along: Floats
    """2̂, along the rim and level."""
    axis: Floats
    """3̂, the symmetry axis."""
    centre: Floats
    """The centre."""
    contact: Floats
    """The contact point."""

    def points(self, angle: Any, share: Any = 1.0) -> Floats:
        """Points fixed in the disk at every time.

        Parameters
        ----------
        angle
            Angle from the mark, shape (m,) [rad].
        share
            Distance from the centre, shape (m,) or () [R].

        Returns
        -------
        ndarray
            Shape (n, m, 3).
        """
        turn = (self.psi[:, None] + np.asarray(angle, dtype=float))[..., None]
        arm = np.cos(turn) * self.towards[:, None] + np.sin(turn) * self.along[:, None]
        reach = self.radius * np.asarray(share, dtype=float).reshape(-1, 1)
        return np.asarray(self.centre[:, None] + reach * arm)


def geometry(motion: Mapping[Any, Any]) -> Geometry:
    """The disk in space from its angles and the path of its centre.

    Parameters
    ----------
    motion
        A single run from `simulate` with `pose=True`, one time of a run, or its series by name.

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


def resample(motion: dict[str, Any], times: Floats) -> dict[str, Any]:
    """A motion at other times: the pose by cubics through values and rates, the rest by lines.

    Parameters
    ----------
    motion
        Series by name: `time`, `POSED`, `LINEAR`, and the radius.
    times
        Times within those of the motion, shape (n,).

    Returns
    -------
    dict
        The same series at these times.
    """
    series = {n: np.interp(times, motion["time"], motion[n]) for n in LINEAR}
    for name, rate in _rates(motion).items():
        series[name] = CubicHermiteSpline(motion["time"], motion[name], rate)(times)
    # between coarse samples a cubic may overshoot flat, and put the disk under the plane
    series["theta"] = np.clip(series["theta"], 0.0, math.pi)
    return series | {"time": times, "radius": motion["radius"]}


def _rates(motion: dict[str, Any]) -> dict[str, Floats]:
    """Rates of the pose; ṡ = vA − ω × R1̂ gives the rates of the centre."""
    theta, phi, omega3, radius = (motion[n] for n in ("theta", "phi", "omega3", "radius"))
    x = motion["slip_x"] + radius * motion["theta_dot"] * np.sin(theta)
    y = motion["slip_y"] - radius * omega3
    spin = omega3 - motion["phi_dot"] * np.cos(theta)
    centre = x * np.cos(phi) - y * np.sin(phi), x * np.sin(phi) + y * np.cos(phi)
    return dict(zip(POSED, (motion["theta_dot"], motion["phi_dot"], spin, *centre), strict=True))


@dataclass(frozen=True, eq=False)
class Placed:
    """Path of a body, as a camera needs it."""

    radius: float
    """Largest distance of the surface from the centre."""
    centre: Floats
    """The centre, shape (n, 3)."""
    contact: Floats
    """The contact point, shape (n, 3)."""


def meridian(body: Body) -> tuple[Floats, Floats, Floats]:
    """The meridian about the centre of mass: distance from the axis, place along it, inclination.

    Parameters
    ----------
    body
        The body; its numbers are single ones.

    Returns
    -------
    r, z, theta
        Shapes (m,) [m, m, rad].  The point touches the plane when the axis is inclined by theta.

    Examples
    --------
    >>> from stability.bodies.round_body.shapes.named import EccentricSphere
    >>> r, z, _ = meridian(EccentricSphere(0.2))
    >>> bool(abs(r**2 + (z - 0.2) ** 2 - 1).max() < 1e-12)
    True
    """
    low, high = body.between
    theta = np.linspace(low, high, ALONG)
    theta[[0, -1]] += [1e-9, -1e-9]  # the height may have no value at its ends
    h, slope = body.height_at(theta), body.height_at(theta, 1)
    size, s, c = float(body.length), np.sin(theta), np.cos(theta)
    return size * (h * s + slope * c), size * (slope * s - h * c), theta


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """The closed surface that is drawn: rows along the meridian."""

    r: Floats
    """Distance from the axis, shape (m,) [m]."""
    z: Floats
    """Place along the axis from the centre of mass, shape (m,) [m]."""
    theta: Floats
    """Inclination at which the row touches the plane, shape (m,) [rad]."""
    mark: NDArray[np.bool_]
    """Coloured points, shape (m, ROUND)."""


def surface(body: Body) -> DrawnSurface:
    """The surface of a body: the other half where the two are equal, and its flat ends.

    Parameters
    ----------
    body
        The body; its numbers are single ones.

    Examples
    --------
    >>> from stability.bodies.round_body.shapes.named import ThickDisk
    >>> seen = surface(ThickDisk(0.4))
    >>> round(float(seen.z.min()), 12), round(float(seen.z.max()), 12), float(seen.r[-1])
    (-0.2, 0.2, 0.0)
    """
    r, z, theta = meridian(body)
    if theta[-1] < math.pi / 2 + CAP:  # a height up to upright is that of a body with equal halves
        r, z = np.concatenate([r, r[::-1]]), np.concatenate([z, -z[::-1]])
        theta = np.concatenate([theta, math.pi - theta[::-1]])
    flat = r[-1] > 1e-6 * r.max()
    if flat:
        r, z = np.concatenate([[0.0], r, [0.0]]), np.concatenate([z[:1], z, z[-1:]])
        theta = np.concatenate([[0.0], theta, [math.pi]])
    around = np.arange(ROUND)
    near = np.minimum(around, ROUND - around) <= WEDGE if flat else np.full(ROUND, True)
    upper = theta > (math.pi / 2 if flat else theta[-1] - CAP)
    return DrawnSurface(r, z, theta, upper[:, None] & near)


def placed(motion: Mapping[str, Floats], body: Body, times: Floats) -> dict[str, Any]:
    """A motion at other times: the attitude by turns about fixed axes, the rest by lines.

    Parameters
    ----------
    motion
        Series of a run with pose.
    body
        The body.
    times
        Times within those of the motion, shape (n,).
    """
    names = "theta", "centre_x", "centre_y", "contact_x", "contact_y"
    series: dict[str, Any] = {n: np.interp(times, motion["time"], motion[n]) for n in names}
    angles = np.stack([motion[n] for n in ("phi", "theta", "psi")], axis=-1)
    series["turn"] = Slerp(motion["time"], Rotation.from_euler("ZYZ", angles))(times).as_matrix()
    series["theta"] = np.arccos(np.clip(series["turn"][:, 2, 2], -1.0, 1.0))
    height = body.length * np.asarray(body.height_at(series["theta"]))
    flat = np.zeros_like(times)
    r, z, _ = meridian(body)
    series["placed"] = Placed(
        float(np.hypot(r, z).max()),
        np.stack([series["centre_x"], series["centre_y"], height], axis=-1),
        np.stack([series["contact_x"], series["contact_y"], flat], axis=-1),
    )
    return series | {"time": times, "phi": motion["phi"][:1]}


class BodyCamera(Camera):
    """The figure of a film of a body."""

    def __init__(
        self,
        motion: dict[str, Any],
        dataset: xarray.Dataset,
        pace: float,
        body: Body,
        *,
        contact_path: bool = True,
    ) -> None:
        super().__init__(motion, dataset, pace, motion["placed"], contact_path=contact_path)
        shape = surface(body)
        angle = np.linspace(0, 2 * math.pi, ROUND, endpoint=False)
        self.points = _turned(shape.r, shape.z, angle)
        self.normals = _turned(np.sin(shape.theta), -np.cos(shape.theta), angle)
        self.marked = shape.mark.ravel()

    def show(self, frame: int) -> None:
        """Move all parts to their places at a frame."""
        i = frame * self.fine
        turn, target = self.motion["turn"][i], self.target[i]
        points = self.seen.centre[i] + self.points.reshape(-1, 3) @ turn.T
        facing = self.normals.reshape(-1, 3) @ turn.T @ self.to_camera > 0
        flat = (points - target) @ self.screen
        self.grid.set_data(*((self._lines(target) - target) @ self.screen).T)
        self.shadow.set_path(_outline((points * [1, 1, 0] - target) @ self.screen))
        self.body.set_path(_outline(flat))
        self.body.set_facecolor(BLUE)
        self.mark.set_path(_outline(flat[facing & self.marked]))
        seen = np.where(facing[:, None], flat, np.nan).reshape(-1, ROUND, 2)
        lines = seen[:, :: ROUND // STRIPES].transpose(1, 0, 2)
        gaps = np.full((len(lines), 1, 2), np.nan)
        self.ticks.set_data(*np.concatenate([lines, gaps], axis=1).reshape(-1, 2).T)
        self.follow(i, self.seen.contact[i : i + 1])


def _turned(r: Floats, z: Floats, angle: Floats) -> Floats:
    """Points of a surface of revolution, shape (m, angles, 3)."""
    rows = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(z, np.ones_like(angle))
    return np.stack(rows, axis=-1)


def _outline(points: Floats) -> Path:
    """The convex outline of points of the picture; nothing where they lie on a line."""
    if len(points) >= 3:
        with suppress(QhullError):  # an edge on which the eye looks along a flat end
            return Path(points[ConvexHull(points).vertices], closed=True)
    return Path([[0.0, 0.0]])
