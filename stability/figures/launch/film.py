"""Frames of a film: the disk on its plane, drawn for GIF and MP4."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
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
from PIL import Image
from scipy.ndimage import uniform_filter1d

from ...base.errors import FileError
from ...base.quantities import unit_of
from ...base.types import Floats
from ...bodies.quantities import PHYSICAL, SYSTEM, quantities_of
from ...motion.result import BY_CODE
from ..styled_figure import broken
from .pose import POSED, geometry

if TYPE_CHECKING:
    import xarray


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


def inner_radius(dataset: xarray.Dataset) -> float:
    """Inner radius to draw [R]: 0 for a disk, otherwise that of the annulus with this k."""
    return min(math.sqrt(max(4 * float(dataset.k) - 1, 0.0)), THIN)


def caption_of(dataset: xarray.Dataset) -> str:
    """The parameters in words, without mass, radius and gravity in a dimensionless motion."""
    plain, law = bool(dataset.attrs.get("dimensionless", 0)), str(dataset.attrs.get("contact", ""))
    units = {} if plain else {n: q.kind.suffix for n, q in quantities_of(SYSTEM + law).items()}
    shown = [
        f"{name} = {float(value):.6g}{units.get(str(name), '')}"
        for name, value in dataset.coords.items()
        if value.ndim == 0 and not (plain and name in (*PHYSICAL, "length"))
    ]
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
        message = "an .mp4 needs ffmpeg; `pip install stability[video]`, or take .gif."
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
