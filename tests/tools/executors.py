"""An executor as of a cluster: work travels in bytes, begins late, and ends in any order."""

from __future__ import annotations

import os
import pickle
import random
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, TypeVar

T = TypeVar("T")


class Distributed(Executor):
    """Two threads that each take any of the pieces that wait, after a while.

    What pieces and results hold is pickled on the way, as between machines.
    """

    def __init__(self, seed: int = 20261122, workers: int = 2) -> None:
        self.random = random.Random(seed)
        self.waiting: list[tuple[Future[Any], bytes]] = []
        self.changed = threading.Condition()
        self.open, self.most, self.closed = 0, 0, False
        self.order: list[int] = []
        """Numbers of the pieces in the order in which they ended."""
        self.count = 0
        self.threads = [threading.Thread(target=self._serve) for _ in range(workers)]
        for thread in self.threads:
            thread.start()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        future: Future[T] = Future()
        with self.changed:
            content = pickle.dumps((self.count, fn, args, kwargs))
            self.count += 1
            self.open += 1
            self.most = max(self.most, self.open)
            self.waiting.append((future, content))
            self.changed.notify()
        return future

    def _serve(self) -> None:
        while True:
            with self.changed:
                while not self.waiting and not self.closed:
                    self.changed.wait()
                if not self.waiting:
                    return
            time.sleep(self.random.uniform(0.0, 0.01))
            with self.changed:
                if not self.waiting:
                    continue
                future, content = self.waiting.pop(self.random.randrange(len(self.waiting)))
            if future.set_running_or_notify_cancel():
                self._do(future, content)

    def _do(self, future: Future[Any], content: bytes) -> None:
        number, fn, args, kwargs = pickle.loads(content)
        found, failure = None, None
        try:
            found = pickle.loads(pickle.dumps(fn(*args, **kwargs)))
        except BaseException as error:
            failure = error
        self.order.append(number)
        with self.changed:
            self.open -= 1
        if failure is not None:
            future.set_exception(failure)
        else:
            future.set_result(found)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        with self.changed:
            self.closed = True
            for future, _ in self.waiting if cancel_futures else []:
                future.cancel()
            self.changed.notify_all()
        for thread in self.threads if wait else []:
            thread.join()


def square(i: int) -> int:
    time.sleep(0.01 if i % 2 else 0.0)
    return i * i


def die(i: int) -> int:
    if i == 3:
        os._exit(5)
    return i
