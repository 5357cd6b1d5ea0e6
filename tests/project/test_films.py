"""The films of the docs are made by their command, are small, and show what the docs say."""

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageChops
from ring_motion import Ring
from scipy.integrate import solve_ivp

ROOT = Path(__file__).resolve().parents[2]
FILMS: dict[str, Any] = runpy.run_path(str(ROOT / "docs" / "films.py"))
MOVING = [name for name in FILMS["PICTURES"] if name.endswith(".gif")]


def test_every_film_is_kept_and_small() -> None:
    assert {p.name for p in FILMS["FOLDER"].iterdir()} == set(FILMS["PICTURES"])
    for path in FILMS["FOLDER"].iterdir():
        assert path.stat().st_size < 600_000, path.name
        assert f"films/{path.name}" in (ROOT / "docs" / "explanation" / "bodies.md").read_text()


@pytest.mark.long
@pytest.mark.parametrize("name", MOVING)
def test_a_film_is_that_of_its_command(name: str, tmp_path: Path) -> None:
    """Frames agree but for a few dots at edges, which depend on the machine's last digits."""
    new = FILMS["PICTURES"][name](tmp_path / name)
    with Image.open(new) as film, Image.open(FILMS["FOLDER"] / name) as kept:
        assert (film.n_frames, film.size) == (kept.n_frames, kept.size)
        pictures = []
        for frame in range(0, kept.n_frames, 10):
            film.seek(frame)
            kept.seek(frame)
            pictures.append(kept.convert("RGB"))
            apart = np.asarray(ImageChops.difference(film.convert("RGB"), pictures[-1]))
            assert (apart.max(axis=-1) > 60).mean() < 2e-3
        moved = np.asarray(ImageChops.difference(pictures[0], pictures[-1])).max(axis=-1) > 60
        assert moved.mean() > 5e-3  # a test that compares a still picture would show nothing


@pytest.mark.long
def test_the_ring_of_the_film_moves_as_by_hand_and_turns_back() -> None:
    start, times = FILMS["turning_start"](FILMS["RING"]), np.linspace(0.0, 60.0, 601)
    run = FILMS["rolled"](FILMS["RING"], start, times, FILMS["ROLLING"])
    ring = Ring((1 + FILMS["RING"] ** 2) / 4, rho=FILMS["ROLLING"])
    first = [start[n] for n in ("theta", "theta_dot", "phi_dot", "omega3")] + [0.0, 0.0, 0.0]
    path = solve_ivp(
        lambda _, y: ring.rates(y), (0, 60), first, "DOP853", times, rtol=1e-10, atol=1e-12
    )
    for name, row in zip(
        ("theta", "theta_dot", "phi_dot", "omega3", "phi", "centre_x", "centre_y"),
        path.y,
        strict=True,
    ):
        np.testing.assert_allclose(run[name], row, rtol=1e-6, atol=1e-6)
    assert abs(run.contact_x - run.centre_x).max() < 1 and run.attrs["contact"] == "rough"
    seen, turn = ring.mean_path(*(start[n] for n in ("theta", "phi_dot", "theta_dot")), 0.12)
    assert turn[:3].min() > 0 and turn[-8:].max() < 0
