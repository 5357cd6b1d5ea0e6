"""Work handed to an executor: order, bounds, and an interruption at the worst moment."""

import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import closing
from typing import Any

import pytest

from stability.jobs.pipeline import completed, in_order
from stability.storage.files import postponed


def test_results_keep_the_order_of_the_tasks_and_few_run_ahead() -> None:
    begun: list[int] = []

    def task(i: int) -> Callable[[], int]:
        def work() -> int:
            time.sleep(0.01 if i % 2 else 0.0)
            return i * i

        return work

    def tasks() -> Iterator[tuple[int, Callable[[], int]]]:
        for i in range(30):
            begun.append(i)
            yield i, task(i)

    with ThreadPoolExecutor(3) as pool:
        for n, (key, value) in enumerate(in_order(pool, tasks(), ahead=4)):
            assert (key, value) == (n, n * n)
            assert len(begun) <= n + 5


def test_what_has_not_begun_is_cancelled_when_the_iterator_is_closed() -> None:
    done: list[int] = []
    gate = threading.Event()

    def work(i: int) -> None:
        if i:
            gate.wait(10)
        done.append(i)

    with ThreadPoolExecutor(1) as pool:
        tasks = [(i, lambda i=i: work(i)) for i in range(20)]
        with closing(in_order(pool, tasks, ahead=20)) as results:
            next(results)
        gate.set()
    assert len(done) <= 3


def test_any_executor_serves() -> None:
    """One that works at once, as a queue of a cluster might in a test."""

    class Here(Executor):
        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
            future: Future[Any] = Future()
            future.set_result(fn(*args, **kwargs))
            return future

    assert list(in_order(Here(), [(i, lambda i=i: -i) for i in range(4)], 2)) == [
        (0, 0), (1, -1), (2, -2), (3, -3)
    ]  # fmt: skip


def test_an_error_of_the_work_is_the_error_of_the_caller() -> None:
    with ThreadPoolExecutor(1) as pool, pytest.raises(ZeroDivisionError):
        list(in_order(pool, [(0, lambda: 1 // 0)], 1))


def _slow() -> int:
    time.sleep(0.02)
    return 1


def _by_hand(pool: ThreadPoolExecutor) -> None:
    for future in [pool.submit(_slow) for _ in range(4)]:
        future.result()


def _in_order(pool: ThreadPoolExecutor) -> None:
    with closing(in_order(pool, [(i, _slow) for i in range(4)], 2)) as results:
        list(results)


def _completed(pool: ThreadPoolExecutor) -> None:
    with postponed():
        futures = [pool.submit(_slow) for _ in range(3)]
    list(completed(futures))


@pytest.mark.parametrize(
    ("run", "stopped"), [(_by_hand, RuntimeError), (_in_order, None), (_completed, None)]
)
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
