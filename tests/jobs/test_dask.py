"""Workers of `distributed`: a scheduler of our own and one by its address; killed workers."""

import os
import random
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chunk_work import LAYOUT, Logged, blank, cells, done, others_kept, store, tree, undisturbed
from distributed import Client, LocalCluster
from kills import soon

import stability as st
from stability.jobs.dask import engine
from stability.jobs.filling import fill

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")


@pytest.fixture(autouse=True)
def kept_random() -> Iterator[None]:
    """The state of Python's random numbers, which `distributed` uses."""
    before = random.getstate()
    yield
    random.setstate(before)


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler that was there before, with two workers; a piece may end two of them."""
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        host="127.0.0.1",
        silence_logs=60,
        dashboard_address="127.0.0.1:0",
    ) as cluster:
        yield cluster.scheduler_address


@pytest.mark.long
def test_a_scheduler_in_one_word_gives_the_same_store(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with engine("local", 2) as (executor, workers):
        assert workers == 2
        found = fill(
            store(tmp_path / "a.zarr"),
            Logged(str(log), deadly=(89,)),
            blank=blank,
            executor=executor,
            workers=workers,
            tries=1,
        )
    assert found.lost == (89,)
    others_kept(tmp_path / "a.zarr", {89})
    assert {line.split()[0] for line in done(log)} == {f"{i}.{j}" for i, j in LAYOUT.blocks()}
    assert 2 <= found.ended <= 3
    # a scheduler sends a chunk that ends its worker to another one, unless it is told not to
    [harmed] = [b for b in LAYOUT.blocks() if 89 in cells(b)]
    assert done(log).count(f"{harmed[0]}.{harmed[1]} 0 {LAYOUT.count(harmed)}") == 1


@pytest.mark.long
def test_a_scheduler_by_its_address_lives_on(address: str, tmp_path: Path) -> None:
    log = tmp_path / "log"
    for name in "ab":
        with engine(address) as (executor, workers):
            assert workers == 2
            fill(
                store(tmp_path / f"{name}.zarr"),
                Logged(str(log)),
                blank=blank,
                executor=executor,
                workers=workers,
            )
        assert tree(tmp_path / f"{name}.zarr") == undisturbed(tmp_path / f"{name}_alone.zarr")
    assert len(done(log)) == 30


@pytest.mark.long
def test_a_future_is_released_when_its_chunk_is_stored(address: str, tmp_path: Path) -> None:
    held: list[int] = []
    with Client(address, set_as_default=False) as client:

        def look(*_: int) -> None:
            held.append(len(client.futures))

        fill(
            store(tmp_path / "a.zarr"),
            Logged(os.devnull, 0.01),
            blank=blank,
            workers=2,
            executor=client.get_executor(pure=False),
            progress=look,
        )
        assert soon(lambda: list(client.futures), 5.0) == []
    assert 0 < max(held) <= 2 * 2 + 2


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_a_killed_worker_of_a_scheduler_costs_its_chunk(address: str, tmp_path: Path) -> None:
    log, killed = tmp_path / "log", list[int]()
    with engine(address) as (executor, workers), Client(address, set_as_default=False) as client:

        def kill() -> None:
            soon(lambda: [] if len(done(log)) > 4 else ["few"], 60.0)
            pids = client.run(os.getpid, on_error="ignore")
            killed.append(min(pids.values()))
            os.kill(killed[0], 9)

        killer = threading.Thread(target=kill)
        killer.start()
        found = fill(
            store(tmp_path / "a.zarr"),
            Logged(str(log), 0.2),
            blank=blank,
            executor=executor,
            workers=workers,
        )
        killer.join()
    assert found.lost == ()
    assert len(done(log)) <= 15 + 2
    assert killed  # perhaps between two chunks
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")
    assert found.computed == LAYOUT.total


@pytest.mark.parametrize(
    "name", ["tcp://127.0.0.1:9", "nope://127.0.0.1:9", "tcp://here", "tcp://"]
)
def test_a_scheduler_that_does_not_answer_is_a_sentence(name: str) -> None:
    begin = time.monotonic()
    with pytest.raises(st.StabilityError, match="the scheduler .* does not answer") as caught:
        with engine(name):
            pass
    assert "start it by `dask scheduler`" in str(caught.value)
    assert time.monotonic() - begin < 9.0


def test_without_distributed_there_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    for name in ("dask", "tcp://127.0.0.1:9"):
        with pytest.raises(st.StabilityError, match=r"`pip install '\.\[scale\]'` from a checkout"):
            with engine(name):
                pass


def test_a_scheduler_without_workers_is_a_sentence() -> None:
    with LocalCluster(
        n_workers=0, host="127.0.0.1", silence_logs=60, dashboard_address="127.0.0.1:0"
    ) as cluster:
        words: Any = "has no workers; start some by `dask worker"
        with pytest.raises(st.StabilityError, match=words), engine(cluster.scheduler_address):
            pass
