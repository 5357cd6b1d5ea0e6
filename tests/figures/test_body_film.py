"""Films and figures of bodies of revolution: the surface that is drawn, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

import stability as st
from stability.figures.launch.body_film import BodyCamera, meridian, placed
from stability.figures.launch.caption import caption

TOP = st.EccentricSphere(0.15, axial=0.4, transverse=0.4, length=2.0, gravity=2.0)
TIMES = np.linspace(0.0, 30.0, 601)


@pytest.fixture(scope="module")
def run():  # type: ignore[no-untyped-def]
    start = {"theta": 0.3, "omega3": 4.0}
    return st.simulate(TOP, st.Viscous(0.3), start, TIMES, pose=True, check=False)


def test_a_meridian_is_that_of_the_surface() -> None:
    r, z, _ = meridian(st.Spheroid(1.3, length=0.5))
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
    with pytest.raises(st.StabilityError, match="a page shows a disk"):
        st.animate(run, tmp_path / "top.html", body=TOP)
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
