"""Stores filled by workers that may be killed: the same bytes, and nothing done twice."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, nullcontext, suppress
from functools import partial
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

import chunk_work
import numpy as np
import pytest
from chunk_work import (
    LAYOUT,
    VARIABLES,
    Logged,
    blank,
    cells,
    done,
    others_kept,
    store,
    tree,
    undisturbed,
    values,
)
from executors import Distributed
from kills import MARK, alive, soon

import stability as st
from stability.jobs.dask import engine
from stability.jobs.filling import fill
from stability.jobs.pipeline import Pool, here, threads
from stability.jobs.processes import processes
from stability.storage.chunks import Layout, Memory

SEED = int(os.environ.get("STABILITY_SEED", "20261123"))
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
POOLS: dict[str, Callable[[], AbstractContextManager[Executor | None]]] = {
    "own threads": nullcontext,
    "threads": lambda: ThreadPoolExecutor(2),
    "processes": lambda: processes(2),
    "pool": lambda: ProcessPoolExecutor(2, get_context("spawn")),
    "distributed": Distributed,
}
STARTED = ("processes", "pool")
"""Those that take a second to start; the fast suite has the first where workers are killed."""


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=pytest.mark.long if k in STARTED else ()) for k in POOLS]
)
def test_a_store_is_the_same_by_every_executor(kind: str, tmp_path: Path) -> None:
    kept, log, told = store(tmp_path / "a.zarr"), tmp_path / "log", []
    with POOLS[kind]() as pool:
        found = fill(
            kept,
            Logged(str(log)),
            blank=blank,
            executor=pool,
            workers=2,
            progress=lambda *pair: told.append(pair),
        )
        memory = Memory(LAYOUT, VARIABLES)
        fill(memory, Logged(os.devnull), blank=blank, executor=pool, workers=2)
    assert tree(kept.folder) == undisturbed(tmp_path / "b.zarr")
    assert sorted(done(log)) == sorted(
        f"{i}.{j} 0 {LAYOUT.count((i, j))}" for i, j in LAYOUT.blocks()
    )
    assert (found.stored, found.computed, found.lost, found.ended) == (0, 90, (), 0)
    assert len(found.seconds) == 15
    assert told[0] == (0, 90)
    assert told == sorted(told)
    assert told[-1] == (90, 90)
    assert np.array_equal(memory.dataset().time.values.ravel(), values(np.arange(90))["time"])


def test_only_what_is_missing_is_computed(tmp_path: Path) -> None:
    log = tmp_path / "log"
    kept, told = store(tmp_path / "a.zarr"), []
    for block in LAYOUT.blocks()[::2]:
        kept.add(block, values(np.arange(90).reshape(9, 10)[LAYOUT.slices(block)].ravel()))
    stored = 90 - sum(map(LAYOUT.count, kept.missing()))
    found = fill(
        kept,
        Logged(str(log)),
        blank=blank,
        start_pool=here,
        progress=lambda *pair: told.append(pair),
    )
    assert [line.split()[0] for line in done(log)] == [f"{i}.{j}" for i, j in LAYOUT.blocks()[1::2]]
    assert (found.stored, found.computed) == (stored, 90 - stored)
    assert told[0] == (stored, 90)
    assert fill(kept, Logged(str(log)), blank=blank).computed == 0
    assert len(done(log)) == 7
    assert tree(kept.folder) == undisturbed(tmp_path / "b.zarr")


def test_two_runs_at_once_write_the_same_and_share_the_work(tmp_path: Path) -> None:
    """A chunk that the other run has stored meanwhile is not computed again."""
    log = tmp_path / "log"
    both = [store(tmp_path / "a.zarr") for _ in range(2)]
    runs = [
        threading.Thread(
            target=fill,
            args=(kept, Logged(str(log), 0.01)),
            kwargs={"blank": blank, "start_pool": own, "workers": 1},
        )
        for kept, own in zip(both, (here, threads), strict=True)
    ]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")
    assert 15 <= len(done(log)) <= 30
    log.unlink()
    first = both[0].missing
    both[0].missing = LAYOUT.blocks  # type: ignore[method-assign]  # as seen before the other run
    fill(both[0], Logged(str(log)), blank=blank)
    assert done(log) == []
    assert first() == []


# --- workers that end ---


@pytest.mark.long
@pytest.mark.parametrize(
    ("deadly", "tries"),
    [((37,), 1), ((37,), 2), ((37,), 3), ((0, 1, 89), 2), ((44, 45, 46, 47, 54, 55, 56, 57), 1)],
)
def test_a_cell_that_ends_its_worker_is_blank_and_the_others_are_kept(
    deadly: tuple[int, ...], tries: int, tmp_path: Path
) -> None:
    log = tmp_path / "log"
    with processes(2) as pool:
        found = fill(
            store(tmp_path / "a.zarr"),
            Logged(str(log), deadly=deadly),
            blank=blank,
            executor=pool,
            workers=2,
            tries=tries,
        )
    others_kept(tmp_path / "a.zarr", set(deadly))
    assert found.lost == deadly
    assert found.computed == 90
    lines = done(log)
    blocks = {line.split()[0] for line in lines if lines.count(line) > 1 or "0 8" not in line}
    harmed = {b for b in LAYOUT.blocks() for d in deadly if d in cells(b)}
    for block in set(LAYOUT.blocks()) - harmed:
        assert lines.count(f"{block[0]}.{block[1]} 0 {LAYOUT.count(block)}") == 1
    for block in harmed:
        assert lines.count(f"{block[0]}.{block[1]} 0 {LAYOUT.count(block)}") == tries
    deaths = len(deadly) * tries + len(harmed) * tries + len(deadly) * 3
    assert found.ended <= deaths
    assert len(lines) <= 15 + 2 * deaths
    assert blocks


def test_chunks_of_one_cell_in_memory(tmp_path: Path) -> None:
    layout = Layout(("y", "x"), (2, 3), (1, 1))
    kept = Memory(layout, VARIABLES)
    work = Logged(str(tmp_path / "log"), deadly=(4,), layout=layout)
    found = fill(kept, work, blank=blank, start_pool=processes, workers=1)
    assert (found.lost, found.ended) == ((4,), 2)
    assert kept.dataset().outcome.values.ravel().tolist() == [0, 1, 2, 3, 9, 0]


HALF = """
import multiprocessing, os, signal
from pathlib import Path
import chunk_work as c
from stability.storage.zarr_store import ChunkFiles

def write(self, block, arrays):
    if block == (2, 1) and multiprocessing.parent_process() is not None:
        Path.write_bytes = killed
    write_chunk(self, block, arrays)

def killed(self, content):
    write_bytes(self, content[:10])
    os.kill(os.getpid(), signal.SIGKILL)

write_bytes, write_chunk, ChunkFiles.add = Path.write_bytes, ChunkFiles.add, write
if __name__ == "__main__":
    found = c.run("processes", 0.0)
    print(found.ended, found.lost, found.computed)
"""


@pytest.mark.long
@LINUX
def test_a_worker_that_ends_while_it_writes_leaves_nothing(tmp_path: Path) -> None:
    """Two workers end in one chunk; its parts end none, and this process writes it."""
    (tmp_path / "script.py").write_text(HALF)
    found = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env=environment(""),
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert found.stdout.strip() == "2 () 90"
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


@pytest.mark.long
def test_a_worker_that_ends_once_costs_one_execution(tmp_path: Path) -> None:
    log = tmp_path / "log"
    work = Logged(str(log), deadly=(37,), spare=str(tmp_path / "spare"))
    found = fill(store(tmp_path / "a.zarr"), work, blank=blank, start_pool=processes, workers=2)
    assert (found.lost, found.ended, found.computed) == ((), 1, 90)
    assert len(done(log)) == 16
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


@LINUX
def test_a_worker_killed_from_outside_costs_its_chunk(tmp_path: Path) -> None:
    log, chosen = tmp_path / "log", random.Random(SEED)
    before = set(active_children())

    def kill() -> None:
        soon(lambda: [] if len(done(log)) > 4 else ["few"], 60.0)
        time.sleep(chosen.uniform(0.0, 0.1))
        workers = sorted(set(active_children()) - before, key=lambda p: p.pid or 0)
        workers[0].kill()

    killer = threading.Thread(target=kill)
    killer.start()
    with processes(2) as pool:
        found = fill(
            store(tmp_path / "a.zarr"), Logged(str(log), 0.1), blank=blank, executor=pool, workers=2
        )
    killer.join()
    assert found.lost == ()
    assert found.ended == 1
    assert len(done(log)) <= 15 + 1
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


@pytest.mark.long
def test_the_users_executor_that_breaks_is_a_sentence_and_the_store_resumes(tmp_path: Path) -> None:
    log = tmp_path / "log"
    work = Logged(str(log), 0.02, deadly=(70,), spare=str(tmp_path / "spare"))
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        with pytest.raises(st.StabilityError, match="a worker was ended from outside") as caught:
            fill(store(tmp_path / "a.zarr"), work, blank=blank, executor=pool, workers=2)
    assert str(caught.value).endswith("give the same call, with a fresh executor, to go on.")
    missing = store(tmp_path / "a.zarr").missing()
    assert 0 < len(missing) < 15
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        found = fill(store(tmp_path / "a.zarr"), work, blank=blank, executor=pool, workers=2)
    assert len(found.seconds) == len(missing)
    assert len(done(log)) <= 15 + 2
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


@pytest.mark.long
def test_workers_that_end_again_and_again_are_no_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stability.jobs.filling.MOST_ENDED", 4)
    work = Logged(str(tmp_path / "log"), deadly=tuple(range(90)))
    with pytest.raises(st.StabilityError, match="workers ended 5 times, which is too often"):
        fill(store(tmp_path / "a.zarr"), work, blank=blank, start_pool=processes, workers=2)
    assert soon(lambda: [str(p) for p in active_children()], 5.0) == []


class NeverStarted(ThreadPoolExecutor):
    """As of processes that end while they start."""

    def submit(self, *_: Any, **__: Any) -> Any:
        future: Future[Any] = Future()
        future.set_exception(BrokenProcessPool("ended abruptly"))
        return future


def test_an_executor_that_does_not_start_is_a_sentence(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with NeverStarted(1) as pool:
        with pytest.raises(st.StabilityError, match=r"or did not start \(a script needs `if __nam"):
            fill(store(tmp_path / "a.zarr"), Logged(str(log)), blank=blank, executor=pool)
    assert done(log) == []
    assert store(tmp_path / "a.zarr").missing() == LAYOUT.blocks()


@pytest.mark.long
def test_processes_that_do_not_start_are_a_sentence(tmp_path: Path) -> None:
    """A script without the guard starts itself again in each process."""
    (tmp_path / "script.py").write_text("import chunk_work as c\nc.run('processes', 0.0)\n")
    found = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env=environment(""),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert "which import script.py and would come to line 2 again" in found.stderr
    assert found.returncode == 1
    assert done(tmp_path / "log") == []


def test_a_script_without_a_file_starts_no_processes(tmp_path: Path) -> None:
    script = "if __name__ == '__main__':\n  import chunk_work as c\n  c.run('processes', 0.0)\n"
    found = subprocess.run(
        [sys.executable, "-"],
        cwd=tmp_path,
        env=environment(""),
        input=script,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert "cannot import <stdin>; put the script in a file" in found.stderr
    assert found.returncode == 1


def test_an_error_of_the_work_is_the_callers_and_what_is_done_is_kept(tmp_path: Path) -> None:
    def work(block: tuple[int, ...], part: slice) -> Any:
        if block == (3, 1):
            raise st.StabilityError("no such launch.")
        return Logged(os.devnull)(block, part)

    with pytest.raises(st.StabilityError, match="no such launch"):
        fill(store(tmp_path / "a.zarr"), work, blank=blank, start_pool=here)
    assert store(tmp_path / "a.zarr").missing() == LAYOUT.blocks()[10:]


# --- interruptions ---


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", ["own threads", "here", "processes"])
def test_ctrl_c_keeps_every_finished_cell_and_says_where(kind: str, tmp_path: Path) -> None:
    log = tmp_path / "log"
    kinds: dict[str, Pool] = {"here": here, "processes": processes}
    own = kinds.get(kind, threads)

    def stop(finished: int, _: int) -> None:
        if finished > 30:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        fill(
            store(tmp_path / "a.zarr"),
            Logged(str(log), 0.01),
            blank=blank,
            workers=2,
            start_pool=own,
            progress=stop,
        )
    told = int(str(caught.value).split()[1])
    assert "give the same command again to go on" in str(caught.value)
    missing = store(tmp_path / "a.zarr").missing()
    assert 30 < told <= 90 - sum(map(LAYOUT.count, missing))
    before = done(log)
    fill(store(tmp_path / "a.zarr"), Logged(str(log)), blank=blank)
    again = [line.split()[0] for line in done(log)[len(before) :]]
    assert sorted(again) == sorted(f"{i}.{j}" for i, j in missing)
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


def environment(mark: str) -> dict[str, str]:
    paths = [str(Path(st.__file__).parents[1]), str(Path(chunk_work.__file__).parent)]
    return os.environ | {MARK: mark, "PYTHONPATH": os.pathsep.join(paths)}


def killed_and_resumed(kind: str, kills: int, folder: Path, number: int, seconds: float) -> None:
    """Kill a driver of two workers at random moments until the store is full.

    The bounds: each kill costs the two chunks that ran; a chunk that was there is not done again.
    """
    chosen, mark, log = random.Random(SEED + kills), uuid.uuid4().hex, folder / "log"
    stopped = 0
    while True:
        before, there = len(done(log)), stored(folder / "a.zarr")
        driver = subprocess.Popen(
            [sys.executable, str(Path(chunk_work.__file__)), kind, str(seconds)],
            cwd=folder,
            env=environment(mark),
            stderr=subprocess.PIPE,
        )
        begun = before + (0 if stopped % 3 == 2 else 1)  # every third, while it starts
        soon(partial(_wait_for, begun, log, driver), 60.0)
        if stopped < kills:
            with suppress(subprocess.TimeoutExpired):
                driver.wait(chosen.uniform(0.0, 3 * seconds))
            driver.send_signal(number)
        _, errors = driver.communicate(timeout=120)
        assert soon(lambda: alive(mark), 30.0) == []
        new = [line.split()[0] for line in done(log)[before:]]
        assert not set(new) & there, "computed again what was stored"
        if driver.returncode == 0:
            break
        assert stopped < kills, errors.decode()
        stopped += 1
    assert stopped > 0
    print(f"{kind}: {stopped} kills, {len(done(log))} executions of 15 chunks")
    assert 15 <= len(done(log)) <= 15 + 2 * stopped
    assert tree(folder / "a.zarr") == undisturbed(folder / "b.zarr")


def _wait_for(lines: int, log: Path, driver: subprocess.Popen[bytes]) -> list[str]:
    return [] if len(done(log)) >= lines or driver.poll() is not None else ["not yet"]


def stored(folder: Path) -> set[str]:
    """Chunks that are there, by their records alone."""
    return {path.name.removeprefix("whole.") for path in (folder / "outcome").glob("whole.*")}


@LINUX
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_driver_that_is_killed_in_its_seventh_chunk_is_resumed(tmp_path: Path) -> None:
    log, blocks = tmp_path / "log", LAYOUT.blocks()

    def work(block: tuple[int, ...], part: slice) -> Any:
        if block == blocks[6]:
            time.sleep(60.0)
        return Logged(str(log))(block, part)

    driver = get_context("fork").Process(
        target=fill,
        args=(store(tmp_path / "a.zarr"), work),
        kwargs={"blank": blank, "start_pool": here},
    )
    driver.start()
    soon(lambda: [] if len(stored(tmp_path / "a.zarr")) == 6 else ["few"], 60.0)
    driver.kill()
    driver.join(60.0)
    assert driver.exitcode == -signal.SIGKILL
    first = [f"{i}.{j}" for i, j in blocks[:6]]
    assert stored(tmp_path / "a.zarr") == set(first)
    fill(store(tmp_path / "a.zarr"), Logged(str(log)), blank=blank, start_pool=here)
    assert [line.split()[0] for line in done(log)] == [f"{i}.{j}" for i, j in blocks]
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


@pytest.mark.long
@LINUX
@pytest.mark.parametrize(
    ("kind", "kills", "number"),
    [
        ("processes", 10, signal.SIGKILL),
        ("threads", 10, signal.SIGKILL),
        ("dask", 10, signal.SIGKILL),
        ("processes", 5, signal.SIGINT),
        ("dask", 5, signal.SIGINT),
    ],
)
def test_a_killed_driver_is_resumed(kind: str, kills: int, number: int, tmp_path: Path) -> None:
    killed_and_resumed(kind, kills, tmp_path, number, 0.3)


def test_an_engine_that_is_none_is_refused() -> None:
    for name in ("fibres", "", 5):
        with pytest.raises(st.StabilityError, match="the engine is .*; give threads, processes"):
            with engine(name):  # type: ignore[arg-type]
                pass
