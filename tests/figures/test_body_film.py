"""Films and figures of bodies of revolution: the surface that is drawn, and what is refused."""

import html
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from film_page import motion_of
from PIL import Image
from scipy.spatial.transform import Rotation

import stability as st
from stability.figures.animate import BodyCamera, meridian, placed, surface
from stability.figures.motion import caption

TOP = st.EccentricSphere(0.15, axial=0.4, transverse=0.4, mass=1.0, length=2.0, gravity=2.0)
TIMES = np.linspace(0.0, 30.0, 601)


@pytest.fixture(scope="module")
def run():  # type: ignore[no-untyped-def]
    start = {"theta": 0.3, "omega3": 4.0}
    return st.simulate(TOP, st.Viscous(0.3), start, TIMES, pose=True, check=False)


def test_a_meridian_is_that_of_the_surface() -> None:
    r, z, _ = meridian(st.Spheroid(1.3, mass=1.0, gravity=1.0, length=0.5))
    assert (r / 0.5) ** 2 + (z / 0.65) ** 2 == pytest.approx(np.ones(len(r)), abs=1e-12)
    r, z, theta = meridian(st.Torus(0.2))
    assert np.hypot(r - 1, z) == pytest.approx(np.full(len(r), 0.2), abs=1e-12)
    assert (z[np.argmin(theta)], z[np.argmax(theta)]) == pytest.approx((-0.2, 0.2), abs=1e-8)


def test_the_drawn_surface_touches_the_plane_at_the_contact_point(run) -> None:  # type: ignore[no-untyped-def]
    names = "time", "theta", "phi", "psi", "centre_x", "centre_y", "contact_x", "contact_y"
    series = {n: run[n].values for n in names}
    motion = placed(series, TOP, np.linspace(0.0, 30.0, 97))
    scene = BodyCamera(motion, run, 1.0, TOP)
    for i in range(0, 97, 8):
        points = scene.points.reshape(-1, 3) @ motion["turn"][i].T + scene.seen.centre[i]
        lowest = points[np.argmin(points[:, 2])]
        assert lowest[2] == pytest.approx(0.0, abs=0.02)  # the grid of points is coarse
        assert lowest[:2] == pytest.approx(scene.seen.contact[i, :2], abs=0.25)
    # the body that is drawn turns about its axis as the motion says
    near = placed(series, TOP, TIMES[40:42])["turn"]
    turned = Rotation.from_matrix(near[1] @ near[0].T).as_rotvec() / (TIMES[41] - TIMES[40])
    assert turned @ near[0][:, 2] == pytest.approx(float(run.omega3[40]), abs=5e-3)


def test_a_film_of_a_tippe_top_is_written(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = st.animate(run, tmp_path / "top.gif", body=TOP, seconds=1, fps=4)
    with Image.open(path) as film:
        assert film.n_frames >= 4
    for change, sentence in (
        ({}, "give body=, the Body that is called eccentric sphere"),
        ({"body": 3}, "body is 3; give a stability.Body"),
        ({"body": st.Torus(0.2)}, "the dataset is of eccentric sphere"),
    ):
        with pytest.raises(st.StabilityError, match=sentence):
            st.animate(run, tmp_path / "other.gif", **change)
    disk = st.simulate(st.Disk(), st.Rough(), {"theta": 1.2}, 0.2, pose=True)
    with pytest.raises(st.StabilityError, match="the dataset is of a disk; give no body"):
        st.animate(disk, tmp_path / "disk.gif", body=TOP)


def test_a_figure_and_its_caption_name_the_body(run) -> None:  # type: ignore[no-untyped-def]
    said = caption(run)
    assert said.startswith("Motion of an eccentric sphere with viscous contact (offset = 0.15")
    assert "L = 2 m" in said and "disk" not in said
    assert st.plot_motion(run).axes
    assert run.nearest_at.attrs["long_name"].endswith("or omega_Z")
    disk = st.simulate(st.Disk(), st.Rough(), {"theta": 1.2}, 0.2, pose=True)
    assert caption(disk).startswith("Motion of a disk with rough contact")


def test_a_page_of_a_body_holds_the_states_of_the_run(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = st.animate(run, tmp_path / "top.html", body=TOP)
    assert not re.search(r"https?://|\bsrc=|@import|url\(|fetch\(|@MOTION@", path.read_text())
    data = motion_of(path)
    turn = Rotation.from_quat(data["turn"]).as_matrix()
    axis = np.stack([run.axis_x, run.axis_y, run.axis_z], axis=1)
    np.testing.assert_allclose(turn[:, :, 2], axis, atol=1e-8)
    # the part about the axis: psi from the direction that phi and theta give by hand
    phi, theta, psi = (run[n].values for n in ("phi", "theta", "psi"))
    level = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=1)
    down = np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)], 1)
    first = np.cos(psi)[:, None] * down + np.sin(psi)[:, None] * level
    np.testing.assert_allclose(turn[:, :, 0], first, atol=1e-7)
    assert (np.sum(np.diff(data["turn"], axis=0) ** 2, axis=1) < 2).all()  # no sign jumps
    for name in ("time", "centre_x", "centre_y", "contact_x", "contact_y", "normal_force"):
        np.testing.assert_allclose(data[name], run[name], rtol=1e-8, atol=1e-12)
    height = TOP.length * np.asarray(TOP.height_at(theta))
    np.testing.assert_allclose(data["centre_z"], height, rtol=1e-7)
    push = (run.force_x.values + 1j * run.force_y.values) * np.exp(1j * phi)
    np.testing.assert_allclose(
        np.array(data["push_x"]) + 1j * np.array(data["push_y"]), push, rtol=1e-7, atol=1e-12
    )
    shape = data["shape"]  # a sphere of radius 2 whose centre lies 0.3 above the centre of mass
    away = np.hypot(shape["r"], np.array(shape["z"]) - 0.3)
    np.testing.assert_allclose(away, 2.0, rtol=1e-5)
    assert np.shape(shape["mark"])[0] == len(shape["r"]) and data["radius"] == 2.0


@pytest.mark.browser
def test_a_browser_shows_the_angle_of_the_run(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no browser")
    path = st.animate(run, tmp_path / "top.html", body=TOP)
    options = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--virtual-time-budget=500",
        f"--user-data-dir={tmp_path / 'profile'}",
        "--dump-dom",
    ]
    command = [browser, *options, f"file://{path}#t=22.5"]
    seen = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
    found = re.search(r'id="theta">([\d.]+)°', html.unescape(seen))
    assert found
    theta = np.degrees(float(run.theta.sel(time=22.5, method="nearest")))
    assert float(found[1]) == pytest.approx(theta, abs=0.06)


def test_flat_ends_are_closed_and_marked_by_a_wedge() -> None:
    coin = surface(st.ThickDisk(0.4))  # its height is that of one half
    assert (coin.z.min(), coin.z.max()) == pytest.approx((-0.2, 0.2))
    assert (coin.r[0], coin.r[-1], coin.r.max()) == pytest.approx((0.0, 0.0, 1.0))
    assert coin.mark[-1].sum() == 5 and not coin.mark[coin.theta < 1.5].any()
    egg = surface(st.Spheroid(1.4))
    assert egg.mark[-1].all() and len(egg.r) == len(meridian(st.Spheroid(1.4))[0])


@pytest.mark.long
def test_every_frame_of_a_thick_disk_is_drawn(tmp_path: Path) -> None:
    """In some, the eye looks along a flat end, and the wedge is a line."""
    body = st.ThickDisk(0.5)
    start = {"theta": 1.2, "omega3": 1.2, "phi_dot": 0.1}
    times = np.linspace(0, 8, 401)
    rolling = st.simulate(body, st.Viscous(0.3), start, times, pose=True, check=False)
    path = st.animate(rolling, tmp_path / "a.gif", body=body, fps=10, seconds=2)
    with Image.open(path) as film:
        assert film.n_frames == 20


def test_a_film_without_the_contact_path_shows_the_centre_from_above(run) -> None:  # type: ignore[no-untyped-def]
    names = "time", "theta", "phi", "psi", "centre_x", "centre_y", "contact_x", "contact_y"
    motion = placed({n: run[n].values for n in names}, TOP, np.linspace(0.0, 30.0, 97))
    scene = BodyCamera(motion, run, 1.0, TOP, contact_path=False)
    scene.show(5)
    assert len(scene.trail.get_xdata()) == 0 and len(scene.path.get_xdata()) == 41
    assert np.ravel(scene.seat.get_data()) == pytest.approx(scene.seen.centre[40, :2])
