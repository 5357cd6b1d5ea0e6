"""Maps, launches and the atlas by any executor: the same numbers, bit for bit, and no remains."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import own_systems
import pytest
import xarray
from executors import Distributed
from kills import MARK, alive, soon

import stability as st
from stability.atlas.build import atlas
from stability.atlas.page import BODIES, drawn
from stability.jobs.pipeline import shared

AXES: dict[str, Any] = {"x": ("at", 0.05, 1.5, 15), "y": ("mu", 0.1, 5, 12)}
KINDS = ("threads", "processes", "distributed")
RANDOM = np.random.default_rng(20261122)
STARTS = np.array([1.4, 0, 0, 1.2, 0, 0]) + RANDOM.uniform(-0.05, 0.05, (9, 6)) * [
    1,
    1,
    1,
    1,
    1e-3,
    1e-3,
]
LAWS = {
    "heyoka": st.Viscous(0.3),
    "stiff": st.Viscous(3000.0),
    "dry": st.Coulomb(0.2),
    "smooth": st.Smooth(),
}


@pytest.fixture(scope="module")
def pools() -> Iterator[dict[str, Executor]]:
    with ExitStack() as stack:
        enter = stack.enter_context
        yield {
            "threads": enter(ThreadPoolExecutor(8)),
            "processes": enter(ProcessPoolExecutor(1, get_context("spawn"))),
            "distributed": enter(Distributed()),
        }


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many pieces to a map."""
    monkeypatch.setattr("stability.maps.cells.BAND", 30)
    monkeypatch.setattr("stability.maps.cells.CHUNK", 13)
    monkeypatch.setattr("stability.maps.stream.BAND", 30)


def pendulum() -> st.Family:
    """A system of a user's, with an unknown to be solved for: the graph route."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    rates = ca.vertcat(x[1], p[2] - p[0] * ca.sin(x[0]) - p[1] * x[1])
    system = st.System(
        "pendulum", x, p, rates, states=("angle", "rate"), parameters=("gravity", "drag", "torque")
    )
    return st.Family(
        system,
        "leaning",
        at=("torque",),
        held={"rate": 0},
        unknown={"angle": 0.1},
        equations=("rate",),
        typical={"torque": 0.3, "drag": 0.3},
    )


def leaning(**how: Any) -> xarray.Dataset:
    axes: dict[str, Any] = {"x": ("torque", 0.1, 0.9, 10), "y": ("drag", 0.01, 2, 8)}
    return st.stability_map(pendulum(), **axes, gravity=1.0, modes=True, **how)


def launches(law: str, **how: Any) -> xarray.Dataset:
    starts = STARTS[:3] if law == "dry" else STARTS
    return st.simulate(st.Disk(), LAWS[law], starts, np.linspace(0, 6, 4), **how)


class Told(list[tuple[int, int]]):
    """Progress, which rises to the total."""

    def __call__(self, done: int, total: int) -> None:
        self.append((done, total))

    def rises_to(self, total: int) -> bool:
        return self == sorted(self) and self[-1] == (total, total)


@pytest.mark.few(1)
@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("kind", KINDS)
def test_a_map_is_the_same_by_every_executor(kind: str, pools: dict[str, Executor]) -> None:
    told = Told()
    how: dict[str, Any] = {"executor": pools[kind], "workers": 2}
    found = st.stability_map("tumbling", **AXES, **how, progress=told, boundaries=False)
    own = st.stability_map("tumbling", **AXES, boundaries=False)
    assert found.drop_attrs().identical(own.drop_attrs())
    assert told.rises_to(180)
    assert leaning(**how).drop_attrs().identical(leaning().drop_attrs())


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("kind", KINDS)
def test_a_stream_is_the_same_by_every_executor(
    kind: str, pools: dict[str, Executor], tmp_path: Path
) -> None:
    told = Told()
    files = [
        st.stream_map(
            "tumbling",
            **AXES,
            out=tmp_path / "a.nc",
            executor=pools[kind],
            workers=2,
            progress=told,
        ),
        st.stream_map("tumbling", **AXES, out=tmp_path / "b.nc"),
    ]
    found, own = (st.read_map(file).drop_attrs() for file in files)
    assert found.identical(own)
    assert told.rises_to(180)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "law",
    ["stiff", "dry", *(pytest.param(n, marks=pytest.mark.long) for n in ("heyoka", "smooth"))],
)
@pytest.mark.parametrize("kind", KINDS)
def test_launches_are_the_same_by_every_executor(
    kind: str, law: str, pools: dict[str, Executor]
) -> None:
    told = Told()
    found = launches(law, executor=pools[kind], workers=2, progress=told)
    own = launches(law)
    assert found.drop_attrs().identical(own.drop_attrs())
    assert told.rises_to(len(own.launch))


def test_an_executor_ends_its_pieces_out_of_order(pools: dict[str, Executor]) -> None:
    pool = pools["distributed"]
    assert isinstance(pool, Distributed)
    before = len(pool.order)
    launches("smooth", executor=pool, workers=2, method="lsoda")
    ended = pool.order[before:]
    assert len(ended) > 9
    assert ended != sorted(ended)


def test_each_thread_reads_one_copy_and_keeps_few() -> None:
    gate = threading.Barrier(8)

    def worker(i: int) -> set[int]:
        gate.wait()
        return {id(ask()) for _ in range(50)} | {id(asks[i]()) for _ in range(3)}

    family = pendulum()
    with ThreadPoolExecutor(8) as pool:
        ask = shared(family, pool)
        asks = [shared({"k": i}, pool) for i in range(8)]
        seen = list(pool.map(worker, range(8)))
    assert all(len(copies) == 2 for copies in seen)
    assert len(set.union(*seen)) == 16
    assert ask() is not family
    assert str(ask().system.rhs) == str(family.system.rhs)


@pytest.mark.long
@pytest.mark.usefixtures("small")
def test_eight_threads_at_once_give_the_numbers_of_one() -> None:
    """Each new pool reads its own copies, and builds its own graphs, in eight threads at once."""
    maps, stiff = leaning(workers=1), launches("stiff")
    for _ in range(5):
        with ThreadPoolExecutor(8) as pool:
            assert leaning(executor=pool).drop_attrs().identical(maps.drop_attrs())
            many = launches("stiff", executor=pool)
            assert many.drop_attrs().identical(stiff.drop_attrs())


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files in place of figures, of one body and two families."""
    monkeypatch.setattr("stability.atlas.build.BODIES", {"disk": BODIES["disk"]})
    ranges = {name: drawn()[name] for name in ("rolling", "spinning")}
    for module in ("build", "page"):
        monkeypatch.setattr(f"stability.atlas.{module}.drawn", lambda: ranges)
    monkeypatch.setattr(
        "stability.figures.canvas.save",
        lambda _, stem, __: stem.with_suffix(".png").write_text("x"),
    )
    monkeypatch.setattr("stability.figures.diagram.plot_map", lambda *_, **__: None)
    monkeypatch.setattr("stability.figures.loci.plot_locus", lambda *_, **__: None)


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_the_atlas_is_the_same_by_an_executor(tmp_path: Path) -> None:
    told = Told()
    with Distributed() as pool:
        atlas(tmp_path / "a", resolution=8, draft=False, executor=pool, workers=2, progress=told)
    atlas(tmp_path / "b", resolution=8, draft=False, workers=1)
    assert told.rises_to(7)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]
    one, other = ({p.name for p in (tmp_path / n).iterdir()} for n in "ab")
    assert one == other
    tables = [(tmp_path / n / "boundaries.csv").read_text() for n in "ab"]
    assert tables[0] == tables[1]


@pytest.mark.parametrize("value", [5, "threads", ThreadPoolExecutor])
def test_what_is_no_executor_is_refused_in_a_sentence(value: Any, tmp_path: Path) -> None:
    by_word = (
        lambda: st.stability_map("tumbling", **AXES, executor=value),
        lambda: st.stream_map("tumbling", **AXES, out=tmp_path / "m.nc", executor=value),
    )
    others = (
        lambda: launches("smooth", executor=value),
        lambda: atlas(tmp_path / "atlas", executor=value),
    )
    for call in (*(by_word if value != "threads" else ()), *others):
        with pytest.raises(st.StabilityError, match="executor is .*; give .*concurrent.futures.Ex"):
            call()
    assert not list(tmp_path.iterdir())


def test_a_law_that_cannot_be_sent_is_refused_in_a_sentence() -> None:
    class Local(st.Viscous):
        """Found in no module."""

        name = "local"

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(st.StabilityError, match="cannot be sent to the workers") as caught:
            st.stability_map("tumbling", **AXES, contact=Local(0.3), executor=pool)
    assert "define contact laws in a module" in str(caught.value)


# --- interruptions ---

VICTIM = """
import sys, time
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from multiprocessing import get_context
import stability as st
import stability.maps.cells as cells

def main():
    cells.BAND = 300
    with ProcessPoolExecutor(2, get_context(sys.argv[1])) if sys.argv[1] else nullcontext() as pool:
        if pool:  # both workers start first: one that never ran a piece is not ours
            [f.result() for f in [pool.submit(time.sleep, 1.0) for _ in range(2)]]
        st.stability_map("tumbling", x=("at", 0.05, 1.5, 200), y=("mu", 0.1, 5, 150), workers=2,
                         checkpoint="kept", executor=pool, boundaries=False)

if __name__ == "__main__":
    main()
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.parametrize(
    ("kind", "number"),
    [
        ("spawn", signal.SIGKILL),
        ("", signal.SIGINT),
        ("spawn", signal.SIGINT),
        ("fork", signal.SIGKILL),
    ],
)
def test_an_interrupted_map_leaves_no_process_and_is_resumed(
    kind: str, number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script, mark, kept = tmp_path / "victim.py", uuid.uuid4().hex, tmp_path / "kept"
    script.write_text(VICTIM)
    process = subprocess.Popen(
        [sys.executable, str(script), kind],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        env=os.environ | {MARK: mark, "PYTHONPATH": str(Path(st.__file__).parents[1])},
    )
    while process.poll() is None and len(list(kept.glob("*.npz"))) < 2:
        time.sleep(0.01)
    time.sleep(random.Random(number).uniform(0.0, 0.1))
    assert len(alive(mark)) >= (3 if kind else 1)
    process.send_signal(number)
    process.wait(60)
    assert soon(lambda: alive(mark), 20.0) == []
    process.communicate()
    assert process.returncode != 0
    finished = len(list(kept.glob("*.npz")))
    assert 2 <= finished < 100
    monkeypatch.setattr("stability.maps.cells.BAND", 300)
    axes: dict[str, Any] = {"x": ("at", 0.05, 1.5, 200), "y": ("mu", 0.1, 5, 150)}
    told = Told()
    resumed = st.stability_map("tumbling", **axes, checkpoint=kept, boundaries=False, progress=told)
    assert told.rises_to(30000)
    fresh = st.stability_map("tumbling", **axes, boundaries=False)
    assert resumed.drop_attrs().identical(fresh.drop_attrs())


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", ["threads", "processes"])
def test_launches_of_a_users_system_are_the_same(kind: str, pools: dict[str, Executor]) -> None:
    system, start = own_systems.pendulum(), {"angle": np.array([0.5, 1.5, 2.5]), "rate": 0.0}
    asked = (system, {"g": 2.0, "c": 0.3}, start, [1.0, 30.0])
    family = own_systems.hanging(system)
    plain = st.simulate(*asked, families=family)
    other = st.simulate(*asked, families=family, executor=pools[kind])
    assert np.array_equal(plain.angle.values, other.angle.values)
    assert np.array_equal(plain.outcome.values, other.outcome.values)
