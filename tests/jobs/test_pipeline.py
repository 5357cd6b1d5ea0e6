"""Work handed to an executor: order, bounds, what is kept, interruptions at the worst moment."""

import random
import signal
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest
from executors import Distributed, die, square
from kills import soon

import stability as st
from stability.jobs.pipeline import AHEAD, Counted, here, ordered, threads
from stability.jobs.processes import processes


class Kept(dict[int, int]):
    """What is kept, in memory; odd pieces prove damaged."""

    folder = Path()

    def done(self, key: int) -> bool:
        return key in self

    def get(self, key: int) -> int | None:
        return None if key % 2 else self[key]

    def add(self, key: int, value: int) -> None:
        self[key] = value


def children() -> list[str]:
    """Worker processes; one that was reaped by another thread is listed for a moment yet."""
    return [str(child) for child in get_context().active_children()]


def squares(i: int) -> Callable[[], int]:
    return partial(square, i)


@pytest.mark.parametrize("own", [threads, here, processes])
def test_results_keep_the_order_of_the_keys(own: Any) -> None:
    seen: list[tuple[int, int]] = []
    count = Counted(lambda *pair: seen.append(pair), 12)
    found = list(ordered(range(12), squares, workers=2, start_pool=own, progress=count))
    assert found == [(i, i * i) for i in range(12)]
    assert seen == [(i, 12) for i in range(1, 13)]


@pytest.mark.few(1)
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_few_pieces_are_in_flight(workers: int) -> None:
    begun: list[int] = []

    def task(i: int) -> Callable[[], int]:
        begun.append(i)
        return partial(square, i)

    with Distributed() as pool:
        for n, _ in enumerate(ordered(range(60), task, executor=pool, workers=workers)):
            assert len(begun) <= n + AHEAD * workers
        assert 1 < pool.most <= AHEAD * workers
    assert begun == list(range(60))


def test_a_piece_is_kept_and_told_of_as_soon_as_it_is_finished() -> None:
    """The first one runs until all the others in flight have been finished and kept."""
    kept, seen = Kept(), []

    def wait(i: int) -> int:
        end = time.monotonic() + 20
        while i == 0 and len(kept) < 7 and time.monotonic() < end:
            time.sleep(0.01)
        return i

    count = Counted(lambda done, _: seen.append(done), 8)
    tasks: Any = ordered(range(8), lambda i: partial(wait, i), workers=2, keep=kept, progress=count)
    with closing(tasks) as results:
        next(results)
        assert len(kept) == 8
        assert seen == list(range(1, 9))


def test_what_is_kept_whole_is_not_done_again() -> None:
    kept, worked = Kept({0: 100, 1: 101, 2: 102}), []

    def task(i: int) -> Callable[[], int]:
        worked.append(i)
        return partial(square, i)

    found = dict(ordered(range(5), task, keep=kept))
    assert found == {0: 100, 1: 1, 2: 102, 3: 9, 4: 16}
    assert worked == [1, 3, 4]
    assert kept == found


def test_what_has_not_begun_is_cancelled_when_the_iterator_is_closed() -> None:
    done: list[int] = []
    gate = threading.Event()

    def work(i: int) -> None:
        if i:
            gate.wait(10)
        done.append(i)

    with ThreadPoolExecutor(1) as pool:
        tasks = ordered(range(20), lambda i: partial(work, i), executor=pool, workers=5)
        with closing(tasks) as results:
            next(results)
        gate.set()
    assert len(done) <= 3


def test_an_error_of_the_work_is_the_error_of_the_caller() -> None:
    for own in (threads, here):
        with pytest.raises(ZeroDivisionError):
            list(ordered([0, 1], lambda i: lambda: 1 // i, start_pool=own))


def test_a_worker_that_dies_gets_one_sentence() -> None:
    def run(**how: Any) -> None:
        list(ordered(range(9), lambda i: partial(die, i), workers=1, **how))

    with pytest.raises(st.StabilityError, match="a worker was ended from outside") as caught:
        run(start_pool=processes)
    assert str(caught.value).endswith(".")
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        with pytest.raises(st.StabilityError, match="a worker was ended from outside"):
            run(executor=pool)


def test_an_executor_that_takes_nothing_gets_one_sentence() -> None:
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(st.StabilityError, match="executor takes no more work: cannot schedule"):
        list(ordered([1], squares, executor=pool))

    class Cancels(ThreadPoolExecutor):
        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
            future = super().submit(time.sleep, 0.1)
            future = super().submit(fn, *args, **kwargs)
            future.cancel()
            return future

    with Cancels(1) as pool, pytest.raises(st.StabilityError, match="has cancelled the work"):
        list(ordered([1], squares, executor=pool))


@pytest.mark.parametrize(
    "kind",
    ["threads", "here", "distributed", pytest.param("processes", marks=pytest.mark.long)],
)
def test_an_interruption_at_any_moment_leaves_what_was_finished(kind: str) -> None:
    chosen = random.Random(20261122)
    for _ in range(1 if kind == "processes" else 6):
        kept, limit = Kept(), chosen.randrange(1, 20)

        def stop(done: int, _: int, limit: int = limit) -> None:
            if done >= limit:
                raise KeyboardInterrupt

        def run(progress: Any, kept: Kept = kept) -> dict[int, int]:
            how: dict[str, Any] = {
                "start_pool": {"here": here, "processes": processes}.get(kind, threads)
            }
            pool: Executor = Distributed() if kind == "distributed" else ThreadPoolExecutor(1)
            with pool:
                if kind == "distributed":
                    how["executor"] = pool
                tasks = ordered(
                    range(0, 40, 2), squares, workers=2, keep=kept, progress=progress, **how
                )
                with closing(tasks) as results:
                    return dict(results)

        with pytest.raises(KeyboardInterrupt):
            run(Counted(stop, 20))
        assert limit <= len(kept) <= 20
        assert soon(children, 5.0) == []
        assert run(None) == {i: i * i for i in range(0, 40, 2)}


def test_processes_of_our_own_do_not_outlive_a_failure() -> None:
    def stop(*_: int) -> None:
        raise KeyboardInterrupt

    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        list(
            ordered(
                [0.0, 90.0],
                lambda t: partial(time.sleep, t),
                workers=2,
                start_pool=processes,
                progress=Counted(stop, 2),
            )
        )
    assert time.monotonic() - begin < 60
    assert soon(children, 5.0) == []


def _slow() -> int:
    time.sleep(0.02)
    return 1


def _by_hand(pool: ThreadPoolExecutor) -> None:
    for future in [pool.submit(_slow) for _ in range(4)]:
        future.result()


def _ordered(pool: ThreadPoolExecutor) -> None:
    with closing(ordered(range(4), lambda _: _slow, executor=pool)) as results:
        list(results)


@pytest.mark.parametrize(("run", "stopped"), [(_by_hand, RuntimeError), (_ordered, None)])
def test_an_interruption_within_a_condition_is_an_interruption(
    run: Callable[[ThreadPoolExecutor], None], stopped: type[Exception] | None
) -> None:
    """A signal just behind the release of a condition's lock; by hand it is a RuntimeError."""
    came = []

    def trace(frame: Any, event: str, _: Any) -> Any:
        if event == "return" and frame.f_code.co_name == "_release_save" and not came:
            came.append(True)
            signal.raise_signal(signal.SIGINT)
        return trace

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with ThreadPoolExecutor(1) as pool:
        traced = sys.gettrace()
        try:
            with pytest.raises(stopped or KeyboardInterrupt):
                sys.settrace(trace)
                run(pool)
        finally:
            sys.settrace(traced)
            signal.signal(signal.SIGINT, before)
    assert came
