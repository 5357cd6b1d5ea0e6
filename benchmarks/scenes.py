"""Scenes: what the least model costs and how far it is from the truth, measured here.

`make bench` runs it.  For each file of examples/scenes: time, estimate and true error of every
model.  Then the answer against the full model with its neighbours, in turns, so that a busy machine
hits both alike; medians of the ratios.  Last, stiff launches to 1e-10 against their stored truth.
`--choice 200` asks of 200 random scenes whether the cheapest rung was taken.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from timing import in_turns

import stability as st
from stability.bodies.newton_euler import STATES
from stability.compare.motion.reference_motions import scene as known_motion
from stability.scene.chart import chart

EXAMPLES = Path(__file__).resolve().parents[1] / "examples" / "scenes"
STIFF = ("stiff-300", "stiff-10000", "stiff-100000")


def leaning(
    contact: st.Contact, horizon: float, theta: float, omega3: float, **more: Any
) -> st.Scene:
    """A scene of a disk that leans and rolls; `more` has other rates, or a tolerance."""
    tolerance = more.pop("tolerance", 1e-6)
    start = {"theta": theta, "omega3": omega3, **more}
    return st.Scene(contact=contact, start=start, horizon=horizon, tolerance=tolerance)


REDUCED = {
    "friction 3000": leaning(st.Viscous(3e3), 20.0, 1.3, 2.0),
    "friction 1e5": leaning(st.Viscous(1e5), 20.0, 1.3, 2.0),
    "near rolling, long": leaning(st.Viscous(0.3), 1000.0, 1.5706, 2.2),
    "friction 3e3, long": leaning(st.Viscous(3e3), 200.0, 1.3, 2.0, tolerance=1e-8),
    "friction 1e5, long": leaning(st.Viscous(1e5), 200.0, 1.3, 2.0, tolerance=1e-8),
    "near rolling, stiff": leaning(st.Viscous(300.0), 1000.0, 1.5706, 1.2),
    "drift of rolling": st.Scene(
        contact=st.Viscous(1.0),
        horizon=1e4,
        tolerance=1e-4,
        start=st.launch("rolling", at=1.8, tilt=3e-3),
    ),
    "steady spinning": st.Scene(
        contact=st.Viscous(0.3), horizon=100.0, start=st.launch("spinning", at=3.0, tilt=0.0)
    ),
}
"""Scenes that a reduced model answers."""
WHOLE = {
    "friction 0.3": leaning(st.Viscous(0.3), 100.0, 1.2, 1.2),
    "friction 30": leaning(st.Viscous(30.0), 100.0, 1.2, 1.2),
    "smooth": leaning(st.Smooth(), 100.0, 1.2, 1.2, phi_dot=1.0),
    "rough": leaning(st.Rough(), 100.0, 1.2, 1.2, phi_dot=1.0),
    "dry friction": leaning(st.Coulomb(0.15), 10.0, 1.12, -1.45, slip_x=-0.49),
}
"""Scenes that the full model alone answers."""


def pairs(
    one: Callable[[], Any], other: Callable[[], Any], turns: int
) -> tuple[float, float, float]:
    """Median times of two calls in turns, and the median of their ratios."""
    one(), other()  # what they compile is not counted
    times = in_turns({"one": one, "other": other}, turns)
    each = [a / b for a, b in zip(times["one"], times["other"], strict=True)]
    return (
        statistics.median(times["one"]),
        statistics.median(times["other"]),
        statistics.median(each),
    )


def examples(out: Path | None) -> None:
    """The ladder of each example, and its chart."""
    for path in sorted(EXAMPLES.glob("*.toml")):
        scene = st.Scene.from_toml(path)
        found = chart(scene)
        print(f"{path.stem}: {found.sentence}")
        print(
            f"  the answer took {1e3 * float(found.answer_cost):.2f} ms; tolerance "
            f"{scene.tolerance:g}, spread {float(found.spread):.2g}"
        )
        for i in range(found.sizes["model"]):
            one = found.isel(model=i)
            mark = "*" if bool(one.chosen) else " "
            print(
                f" {mark}{str(one.model.values):<24}{1e3 * float(one.cost):9.2f} ms   estimate "
                f"{float(one.estimate):8.1e}  true {float(one.true_error):8.1e}  "
                f"{str(one.why.values)[:60]}"
            )
        if out is not None:
            scene.plot(out / f"{path.stem}.png", overwrite=True)


def ratios(scenes: dict[str, st.Scene], heading: str, turns: int) -> None:
    """Time of answer() over that of simulate() with its neighbours, at the same tolerance."""
    print(heading)
    for name, scene in scenes.items():
        told = scene.answer()

        # the loosest tolerance of simulate whose stated error is that of the scene
        def run(tolerance: float, scene: st.Scene = scene) -> Any:
            return st.simulate(
                scene.disk, scene.contact, scene.start, [scene.horizon], tolerance=tolerance
            )

        # the loosest tolerance of simulate whose stated error is that of the scene
        tolerance = scene.tolerance
        while float(run(tolerance).final_error) > scene.tolerance and tolerance > 1e-14:
            tolerance /= 10
        mine, full, ratio = pairs(scene.answer, lambda t=tolerance: run(t), turns)
        print(
            f"  {name:<20}{told.model:<14}{1e3 * mine:9.2f} ms   full model at {tolerance:.0e} "
            f"{1e3 * full:9.2f} ms   ratio {ratio:.3f}"
        )


def stiff(turns: int) -> None:
    """Stiff launches to 1e-10: time, and the error against two integrations in many digits."""
    print("stiff launches to 1e-10, against their stored truth")
    for name in STIFF:
        motion = known_motion(name)
        scene = st.Scene(
            disk=motion.disk(),
            contact=motion.contact(),
            tolerance=1e-10,
            start=dict(zip(STATES, motion.start, strict=True)),
            horizon=float(motion.times[-1]),
        )
        told = scene.answer()
        final = np.array([told.value[n] for n in STATES])
        true = motion.states[-1]
        error = float((np.abs(final - true) / np.maximum(1, np.abs(true))).max())
        costs = [scene.answer().cost for _ in range(turns)]
        print(
            f"  {name:<14}{told.model:<10}{1e3 * statistics.median(costs):9.2f} ms   estimate "
            f"{told.estimate:.1e}   true {error:.1e}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="folder for the charts of the examples")
    parser.add_argument("--large", action="store_true", help="more turns")
    parser.add_argument(
        "--choice",
        type=int,
        metavar="N",
        help="instead: N random scenes, every rung against the choice",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random scenes")
    options = parser.parse_args()
    if options.choice is not None:
        from choices import report

        report(options.choice, options.seed)
        return
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
    turns = 41 if options.large else 11
    examples(options.out)
    ratios(REDUCED, "reduced models: answer() over the full model, the same accuracy", turns)
    ratios(WHOLE, "the full model alone will do: answer() over the full model", turns)
    for tolerance in (1e-4, 1e-9):
        some = {n: replace(s, tolerance=tolerance) for n, s in WHOLE.items()}
        ratios(some, f"the same to {tolerance:g}", turns)
    stiff(turns)


if __name__ == "__main__":
    main()
