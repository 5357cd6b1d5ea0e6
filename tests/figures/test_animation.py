"""Films show the motion that was computed: geometry against kinematics, files whole or absent."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from figure_audit import drawn, faults, linear, luminance
from film_page import motion_of
from PIL import Image

import stability as st
from stability.bodies.contact_laws import Contact
from stability.figures import animate as animation
from stability.figures.animate import animate, geometry, resample
from stability.figures.canvas import COLUMN

LAWS = [st.Viscous(0.3), st.Rough(), st.Coulomb(0.2), st.Smooth()]
START = {"theta": 1.3, "theta_dot": 0.1, "phi_dot": 0.4, "omega3": 1.5}


def launch(law: Any = None, disk: Any = None, last: float = 3.0, count: int = 61) -> Any:
    times, law = np.linspace(0, last, count), law or st.Viscous(0.3)
    start = START | ({"slip_y": 0.1} if law.name == "coulomb" else {})
    return st.simulate(disk or st.Disk(), law, start, times, pose=True)


@pytest.mark.few(2)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("radius", [1.0, 0.3])
def test_the_contact_point_is_on_the_plane_and_one_radius_from_the_centre(
    law: Contact, radius: float
) -> None:
    run = launch(law, st.Disk(k=0.3, mass=1.0, radius=radius, gravity=1.0))
    seen = geometry(run)
    np.testing.assert_allclose(seen.contact[:, 2], 0, atol=1e-15)
    np.testing.assert_allclose(seen.contact[:, 0], run.contact_x, atol=1e-14)
    np.testing.assert_allclose(seen.contact[:, 1], run.contact_y, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(seen.contact - seen.centre, axis=1), radius)
    # no point of the rim is lower, and every one is in the plane normal to the axis
    rim = seen.points(np.linspace(0, 2 * math.pi, 50))
    assert rim[..., 2].min() > -1e-14
    np.testing.assert_allclose(np.linalg.norm(rim - seen.centre[:, None], axis=-1), radius)
    away = np.einsum("nmi,ni->nm", rim - seen.centre[:, None], seen.axis)
    np.testing.assert_allclose(away, 0, atol=1e-14)


def test_the_axes_are_a_right_handed_frame_and_the_axis_leans_by_theta() -> None:
    run = launch()
    seen = geometry(run)
    np.testing.assert_allclose(np.cross(seen.axis, seen.towards), seen.along, atol=1e-14)
    np.testing.assert_allclose(np.arccos(seen.axis[:, 2]), run.theta, atol=1e-14)


@pytest.mark.parametrize("law", [st.Viscous(0.3), st.Rough(), st.Smooth()], ids=lambda x: x.name)
def test_the_rim_at_the_contact_moves_with_the_slip(law: Contact) -> None:
    """By central differences of a material point; the slip is turned from (x̂, ŷ) by hand."""
    step = 1e-4
    middles = np.linspace(0.1, 2.5, 25)
    times = np.sort(np.concatenate([middles - step, middles, middles + step]))
    start = START | ({} if law.name == "rough" else {"slip_x": 0.3, "slip_y": -0.4})
    run = st.simulate(
        st.Disk(mass=1.0, radius=0.8, gravity=1.0),
        law,
        start,
        times,
        pose=True,
        tolerance=1e-13,
        method="dop853",
    )
    before, after = (geometry(run.isel(time=slice(i, None, 3))) for i in (0, 2))
    now = run.isel(time=slice(1, None, 3))
    angles = -now.psi.values  # the material points that are at the contact then
    each = np.arange(len(middles))
    velocity = (after.points(angles) - before.points(angles))[each, each] / (2 * step)
    turn = now.slip_x.values + 1j * now.slip_y.values
    slip = turn * np.exp(1j * now.phi.values)
    assert law.name == "rough" or abs(slip).min() > 1e-3
    np.testing.assert_allclose(velocity[:, 0], slip.real, atol=2e-6)
    np.testing.assert_allclose(velocity[:, 1], slip.imag, atol=2e-6)
    np.testing.assert_allclose(velocity[:, 2], 0, atol=2e-6)


def test_frames_between_the_samples_lie_on_the_motion() -> None:
    coarse, fine = launch(count=31), launch(count=301)
    found = resample(animation._single(coarse), fine.time.values)
    for name in animation.POSED:
        np.testing.assert_allclose(found[name], fine[name], atol=2e-5)


def test_a_gif_has_the_frames_asked_for_and_they_differ(tmp_path: Path) -> None:
    done: list[tuple[int, int]] = []
    path = animate(
        launch(), tmp_path / "a.gif", fps=10, seconds=0.6, progress=lambda *n: done.append(n)
    )
    assert path.stat().st_size > 0
    assert done == [(i, 6) for i in range(1, 7)]
    with Image.open(path) as film:
        assert (getattr(film, "n_frames", 1), film.info["duration"]) == (6, 100)
        pictures = []
        for i in range(6):
            film.seek(i)
            pictures.append(np.asarray(film.convert("RGB")).astype(int))
    # more than the clock changes: look at the middle of the picture only
    for a, b in zip(pictures, pictures[1:], strict=False):
        assert (abs(a - b)[80:-50] > 60).sum() > 100


@pytest.mark.few(1)
@pytest.mark.parametrize("spin", [1.5, 60.0])
def test_the_texts_of_a_film_are_readable_in_a_column(spin: float, tmp_path: Path) -> None:
    """At the size of print, and dark in the pixels of the GIF, whose colours are few."""
    coin = st.Disk.named("quarter")
    start = {"theta": 1.2, "omega3": spin * coin.rate}
    run = st.simulate(coin, st.Rough(), start, np.linspace(0, 0.2, 201), pose=True)
    motion = resample(animation._single(run), np.linspace(0, 0.2, 9))
    scene = animation.Camera(motion, run, 1.0)
    assert (scene.seat is not None) == (spin > 50)  # a camera that follows has an overview
    scene.show(1)
    assert faults(scene.figure, COLUMN) == []
    assert {t.get_color() for t, _ in drawn(scene.figure)} == {animation.INK}
    scene.figure.set_dpi(animation.DPI)
    boxes = [t.get_window_extent() for t in scene.figure.texts]
    film = animate(run, tmp_path / "a.gif", fps=10, seconds=0.2)
    with Image.open(film) as picture:
        picture.seek(1)
        pixels = np.asarray(picture.convert("RGB"))[::-1]
    for box in boxes:
        part = pixels[int(box.y0) + 1 : int(box.y1), int(box.x0) + 1 : int(box.x1)]
        grey = luminance(linear(part / 255))
        assert (grey.max() + 0.05) / (np.quantile(grey, 0.01) + 0.05) > 10


def test_the_caption_of_a_film_has_units() -> None:
    caption = animation.caption_of(launch(disk=st.Disk(mass=0.2, radius=0.3, gravity=9.81)))
    assert caption == (
        "viscous contact, mass = 0.2 kg, radius = 0.3 m, gravity = 9.81 m/s², k = 0.25, "
        "mu = 0.3 s/m of F = -μ N v"
    )
    assert (
        animation.caption_of(launch())
        == "viscous contact, k = 0.25, mu = 0.3 1/√(gR) of F = -μ N v"
    )


@pytest.mark.parametrize(
    "disk", [st.Disk(), st.Disk(k=0.4), st.Disk(k=0.5, mass=1, radius=0.1, gravity=1)]
)
@pytest.mark.parametrize("spin", [1.0, 60.0])
def test_the_whole_disk_is_in_every_frame(disk: st.Disk, spin: float) -> None:
    """With a camera at rest, and with one that follows a long path."""
    start = {"theta": 1.2, "omega3": spin}
    run = st.simulate(disk, st.Rough(), start, np.linspace(0, 2, 201), pose=True)
    motion = resample(animation._single(run), np.linspace(0, 2, 81))
    scene = animation.Camera(motion, run, 1.0)
    (x0, x1), (y0, y1) = scene.axes.get_xlim(), scene.axes.get_ylim()
    for frame in range(scene.frames):
        scene.show(frame)
        x, y = scene.body.get_path().vertices.T
        assert x0 < x.min() < x.max() < x1
        assert y0 < y.min() < y.max() < y1
    on_the_plane = (scene.grid, scene.shadow, scene.trail)
    assert scene.body.get_zorder() > max(part.get_zorder() for part in on_the_plane)


def test_an_mp4_is_made_where_ffmpeg_is(tmp_path: Path) -> None:
    try:
        animation._ffmpeg()
    except st.StabilityError:
        pytest.skip("no ffmpeg")
    path = animate(launch(), tmp_path / "a.mp4", fps=12.5, seconds=0.24)
    film = path.read_bytes()
    assert film[4:8] == b"ftyp"
    # the profile: Baseline, Main or High, which every player shows, and not High 4:4:4
    assert film[film.index(b"avcC") + 5] in (66, 77, 100)


def test_without_ffmpeg_a_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(animation.shutil, "which", lambda _: None)
    monkeypatch.setattr(animation, "import_module", missing)
    with pytest.raises(st.StabilityError, match=r"pip install '\.\[video\]'` from a checkout"):
        animate(launch(), tmp_path / "a.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.few(2)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_a_page_holds_the_motion_and_loads_nothing(law: Contact, tmp_path: Path) -> None:
    run = launch(law, st.Disk(k=0.4, mass=0.2, radius=0.3, gravity=9.81))
    path = animate(run, tmp_path / "a.html")
    text = path.read_text()
    assert not re.search(r"https?://|\bsrc=|@import|url\(|fetch\(|@MOTION@", text)
    data = motion_of(path)
    for name in ("time", *animation.POSED, *animation.LINEAR):
        np.testing.assert_allclose(data[name], run[name], rtol=1e-5, atol=1e-12)
    assert ("mode" in data) == (law.name == "coulomb")
    np.testing.assert_allclose(data["event_time"], run.event_time, rtol=1e-8)
    assert data["event_kind"] == list(run.event_kind.values)
    assert data["sentence"].startswith(run.attrs["outcome"])
    assert data["weight"] == pytest.approx(0.2 * 9.81)
    assert data["inner"] == pytest.approx(math.sqrt(0.6))
    assert "radius = 0.3 m" in data["caption"] and data["time_unit"] == "s"


def test_words_in_the_data_cannot_end_the_script_of_a_page(tmp_path: Path) -> None:
    run = launch()
    run.attrs["title"] = evil = '</script><script>alert("1")</script><!--'
    path = animate(run, tmp_path / "a.html")
    assert "alert" in path.read_text() and "<script>alert" not in path.read_text()
    assert motion_of(path)["title"] == evil


@pytest.mark.long
def test_a_page_thins_a_long_motion_evenly(tmp_path: Path) -> None:
    run = launch(st.Coulomb(0.2), last=1.0, count=animation.MOST_SAMPLES + 5)
    data = motion_of(animate(run, tmp_path / "a.html"))
    assert {len(data[n]) for n in ("time", "phi", "mode")} == {animation.MOST_SAMPLES}


def test_one_of_several_launches_can_be_taken(tmp_path: Path) -> None:
    start = {"theta": [1.2, 1.4], "omega3": 0.0}
    runs = st.simulate(st.Disk(), st.Smooth(), start, np.linspace(0, 5, 101), pose=True)
    data = motion_of(animate(runs.isel(launch=0), tmp_path / "a.html"))
    assert data["outcome"] == "flat" and data["time"][-1] < float(runs.end_time[0]) < 5


def test_what_cannot_be_drawn_is_refused_in_one_sentence_and_leaves_nothing(
    tmp_path: Path,
) -> None:
    run, bare = launch(), st.simulate(st.Disk(), st.Rough(), START, 1.0)
    several = st.simulate(st.Disk(), st.Rough(), {"theta": [1.0, 1.1]}, 0.1, pose=True)
    nan = run.copy(deep=True)
    nan["phi"][3] = math.nan
    cases: list[tuple[Any, str, dict[str, Any], str]] = [
        (bare, "a.gif", {}, "pose=True"),
        (several, "a.gif", {}, r"isel\(launch=i\)"),
        (run.isel(time=[0]), "a.gif", {}, "fewer than two samples"),
        (nan, "a.html", {}, "NaN"),
        (run.isel(time=[0, 2, 1]), "a.html", {}, "do not rise"),
        ({"theta": 1}, "a.gif", {}, "dataset is {'theta': 1}"),
        (run, "a.avi", {}, r"a\.avi; the name must end in .gif"),
        (run, "a", {}, "must end in .gif"),
        (run, "no/a.gif", {}, "does not exist"),
        (run, "a.gif", {"fps": 0}, "fps is 0"),
        (run, "a.gif", {"fps": 101}, "from 0.001 to 100"),
        (run, "a.gif", {"fps": [1, 2]}, "one number from"),
        (run, "a.gif", {"seconds": -1}, "seconds is -1"),
        (run, "a.html", {"seconds": math.nan}, "seconds is nan"),
        (run, "a.gif", {"seconds": 3000}, "150000 frames|75000 frames"),
    ]
    for dataset, name, options, said in cases:
        with pytest.raises(st.StabilityError, match=said) as caught:
            animate(dataset, tmp_path / name, **options)
        assert str(caught.value).endswith(".") and "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".gif", ".html"])
def test_an_existing_file_is_kept_unless_it_may_be_replaced(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text("kept")
    with pytest.raises(st.StabilityError, match="exists"):
        animate(launch(), path)
    assert path.read_text() == "kept"
    animate(launch(), path, seconds=0.2, overwrite=True)
    assert path.stat().st_size > 100 and list(tmp_path.iterdir()) == [path]


def test_a_film_that_is_stopped_leaves_nothing(tmp_path: Path) -> None:
    def stop(done: int, _: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(launch(), tmp_path / "a.gif", seconds=1, progress=stop)
    assert not list(tmp_path.iterdir())
