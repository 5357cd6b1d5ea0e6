"""Processes that do pieces in groups, within limits of time."""

import os
import time
from concurrent.futures import BrokenExecutor
from functools import partial
from typing import Any

import pytest

from stability.jobs.processes import Lanes, WorkerEnded, WorkerLate, processes

LONG = 60.0


@pytest.fixture(scope="module")
def killed() -> tuple[object, ...]:
    """What became of a group with a piece that is late and one that ends its process."""
    works: list[tuple[Any, float]] = [
        (os.getpid, LONG),
        (os.getpid, LONG),
        (partial(time.sleep, 600), 0.2),
        (os.getpid, LONG),
        (partial(os._exit, 7), LONG),
        (lambda: 1, LONG),  # cannot be sent
        (os.getpid, LONG),
    ]
    with processes(2, fresh=True) as pool:
        futures = pool.submit_group(works)
        others = pool.submit_group([(os.getpid, LONG)])
        return tuple(f.exception() or f.result() for f in (*futures, *others))


def test_a_group_shares_a_process_until_a_piece_ends_it(killed: tuple[object, ...]) -> None:
    first, second, late, third, ended, unsent, fourth, other = killed
    assert first == second
    assert isinstance(late, WorkerLate) and 0.2 <= late.seconds < LONG
    assert isinstance(ended, WorkerEnded) and not isinstance(ended, WorkerLate)
    assert str(ended) == "ended with code 7"
    assert isinstance(unsent, Exception) and not isinstance(unsent, BrokenExecutor)
    assert len({first, third, fourth, other, os.getpid()}) == 5


def test_a_limit_of_one_piece_is_none_of_another() -> None:
    with processes(2) as pool:
        [slow] = pool.submit_group([(partial(time.sleep, 600), 0.2)])
        quick = [pool.submit(os.getpid) for _ in range(3)]
        assert isinstance(slow.exception(), WorkerLate)
        assert all(f.result() != os.getpid() for f in quick)


def test_pieces_that_wait_are_cancelled_and_those_that_run_are_killed() -> None:
    pool = Lanes(1)
    works: list[tuple[Any, float]] = [(partial(time.sleep, 600), LONG), (os.getpid, LONG)]
    running, waiting = pool.submit_group(works)
    other = pool.submit(os.getpid)
    while not running.running():
        time.sleep(0.01)
    pool.kill()
    assert isinstance(running.exception(), BrokenExecutor)
    assert isinstance(waiting.exception(), BrokenExecutor)
    assert other.cancelled()


def test_a_process_that_does_not_start_in_time_ends_the_work() -> None:
    with processes(1, patience=0.0) as pool:
        with pytest.raises(BrokenExecutor, match="do not start"):
            pool.submit(os.getpid).result(LONG)
