"""Data that all pieces of a job need; each worker reads its own copy.

CasADi's objects must not be used by several threads at once.  A process has none of its parent's
objects.
"""

from __future__ import annotations

import hashlib
import pickle
import threading
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, TypeVar, cast

from ..base.errors import ParameterError, StabilityError, one_line

T = TypeVar("T")
MOST_COPIES = 8
"""Largest number of copies in a thread; the oldest is dropped first."""
SHORT = 120
"""Largest number of characters of an error in a message."""
_THREAD = threading.local()


def shared(value: T, executor: Executor | None) -> Callable[[], T]:
    """A function that gives the value to a worker; pieces of work use it in place of the value.

    Parameters
    ----------
    value
        Data that every piece needs.
    executor
        Executor whose workers use the value: each thread or process then has its own copy.  None
        for threads of this package, which share the value: they avoid CasADi or take turns.

    Returns
    -------
    callable

    Raises
    ------
    ParameterError
        If the value cannot be sent.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> value = {"k": 0.25}
    >>> with ThreadPoolExecutor(1) as pool:
    ...     copy = pool.submit(shared(value, pool)).result()
    >>> copy == value, copy is value
    (True, False)
    """
    if executor is None:
        return partial(_same, value)
    from casadi import global_pickle_context

    try:
        with global_pickle_context():
            content = pickle.dumps(value)
    except Exception as error:
        raise ParameterError(
            "the work cannot be sent to the workers of the executor: "
            f"{one_line(str(error), SHORT)}; define contact laws in a module, not in a function."
        ) from None
    return _Copied(hashlib.sha256(content).digest(), content)


def _same(value: T) -> T:
    return value


@dataclass(frozen=True)
class _Copied(Generic[T]):
    """A value as bytes, read once in each thread."""

    name: bytes
    """Checksum of the bytes."""
    content: bytes = field(repr=False)
    """The bytes."""

    def __call__(self) -> T:
        """The copy of this thread."""
        held: dict[bytes, Any] = _THREAD.__dict__.setdefault("held", {})
        if self.name not in held:
            while len(held) >= MOST_COPIES:
                del held[next(iter(held))]
            held[self.name] = self._read()
        return cast(T, held[self.name])

    def _read(self) -> Any:
        from casadi import global_unpickle_context

        try:
            with global_unpickle_context():
                return pickle.loads(self.content)
        except Exception as error:
            raise StabilityError(
                f"a worker cannot read its work: {one_line(str(error), SHORT)}; define contact "
                "laws in a module that it can import."
            ) from None
