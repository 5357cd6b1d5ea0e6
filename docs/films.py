"""Films of the docs and the map of rings that turn back, in `docs/films/`: see `make pictures`."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import casadi as ca
import numpy as np
from PIL import Image, ImageSequence
from scipy.integrate import solve_ivp

import stability as st
from stability.figures.animate import save_gif

FOLDER = Path(__file__).resolve().parent / "films"
WIDTH, COLOURS, RATE = 480, 46, 12.5
"""Width of a kept film in dots, its colours, and frames in a second: it is then below 600 kB."""
RING, ROLLING = 0.97, 0.02
"""Inner radius of the ring, and its coefficient of rolling resistance."""


def kept(run: Any, path: Path, **options: Any) -> Path:
    """A film of a run, made small."""
    with TemporaryDirectory() as folder:
        large = st.animate(run, Path(folder) / "large.gif", fps=RATE, **options)
        with Image.open(large) as film:
            size = (WIDTH, round(WIDTH * film.height / film.width))
            frames = [
                f.convert("RGB").resize(size, Image.Resampling.LANCZOS)
                for f in ImageSequence.Iterator(film)
            ]
    middle = frames[len(frames) // 2].quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
    save_gif(path, iter(frames), middle, RATE)
    return path


def tippe_top(path: Path) -> Path:
    """A tippe top that turns over through its pole."""
    top = st.EccentricSphere(0.15, axial=0.4, transverse=0.4)
    start = {"theta": 0.1, "omega3": 4.0}
    times = np.linspace(70.0, 118.0, 1201)
    run = st.simulate(top, st.Viscous(0.3), start, times, pose=True, check=False)
    return kept(run, path, body=top, seconds=9)


def egg(path: Path) -> Path:
    """A spheroid that lies on its side, and rises on its end."""
    body = st.Spheroid(1.4)
    start = {"theta": math.pi / 2 - 0.05, "phi_dot": 5.0}
    times = np.linspace(20.0, 62.0, 2001)
    run = st.simulate(body, st.Viscous(0.3), start, times, pose=True, check=False)
    return kept(run, path, body=body, seconds=9)


def rolled(inner: float, start: dict[str, float], times: Any, rho: float) -> Any:
    """A ring that rolls without slip against rolling resistance, as `simulate` gives it without.

    The states are integrated with the equations of `slow_flow`, and take the places of the others.
    """
    ring = st.Disk.annulus(inner)
    body = st.Body(lambda t: ca.sin(t), axial=2 * ring.k, transverse=ring.k, name="thin ring")
    resistance = st.RollingResistance(rho)
    flow = st.slow_flow("circling", body=body, contact=st.Rough(), resistance=resistance)
    system = flow.disturbed
    numbers = [(flow.numbers | {flow.small: rho})[n] for n in system.parameters]
    seen = ca.vertcat(system.observables["normal_force"], system.observables["contact_force"])
    rates = ca.Function("rates", [system.x, system.p], [system.rhs])
    forces = ca.Function("forces", [system.x, system.p], [seen])

    def along(_: float, y: Any) -> Any:
        theta, theta_dot, phi_dot, omega3, phi = y[:5]
        speed = (theta_dot * math.sin(theta) - 1j * omega3) * np.exp(1j * phi)
        turn = [phi_dot, omega3 - phi_dot * math.cos(theta), speed.real, speed.imag]
        return np.concatenate([np.array(rates(y[:4], numbers)).ravel(), turn])

    first = [start[n] for n in system.states] + [0.0] * 4
    path = solve_ivp(along, times[[0, -1]], first, "DOP853", times, rtol=1e-10, atol=1e-12)
    names = "theta", "theta_dot", "phi_dot", "omega3", "phi", "psi", "centre_x", "centre_y"
    values = dict(zip(names, path.y, strict=True))
    towards = np.cos(values["theta"])
    values["contact_x"] = values["centre_x"] + towards * np.cos(values["phi"])
    values["contact_y"] = values["centre_y"] + towards * np.sin(values["phi"])
    pushes = np.array([np.array(forces(y, numbers)).ravel() for y in path.y[:4].T]).T
    values |= dict(zip(("normal_force", "force_x", "force_y"), pushes, strict=True))
    plain = st.simulate(ring, st.Rough(), start, times, pose=True, check=False)
    return plain.assign({n: plain[n].copy(data=v) for n, v in values.items()}).assign_coords(
        rho=rho
    )


def turning_start(inner: float) -> dict[str, float]:
    """A ring at 50°, whose centre would rest, with a kick that makes it nutate."""
    theta, k = math.radians(50), (1 + inner**2) / 4
    return {
        "theta": theta,
        "theta_dot": 0.7,
        "phi_dot": 1 / math.sqrt(k * math.sin(theta)),
        "omega3": 0.0,
    }


def ring(path: Path) -> Path:
    """A ring that turns back under rolling resistance."""
    run = rolled(RING, turning_start(RING), np.linspace(0.0, 96.0, 4001), ROLLING)
    return kept(run, path, seconds=12, contact_path=False)


def retrograde(path: Path) -> Path:
    """The map of rings that turn back."""
    from stability.figures.canvas import save_figure

    save_figure(st.plot_retrograde(st.retrograde_map()), path)
    return path


PICTURES: dict[str, Callable[[Path], Path]] = {
    "tippe-top.gif": tippe_top,
    "egg.gif": egg,
    "ring.gif": ring,
    "retrograde.png": retrograde,
}
"""What is kept, and the function that makes it."""


def main() -> int:
    """Make the pictures that are named, or all."""
    for name in sys.argv[1:] or PICTURES:
        path = PICTURES[name](FOLDER / name)
        print(f"{path.relative_to(FOLDER.parents[1])}: {path.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
