"""Pickling of records that hold CasADi expressions.

CasADi pickles an expression only within a context, in which expressions share their symbols.  A
record opens a context of its own where none is open, so that `pickle` alone is enough.
"""

from __future__ import annotations

import copy
import pickle
from typing import Any, Self

from casadi import global_pickle_context, global_unpickle_context
from casadi.casadi import _current_pickle_context  # type: ignore[attr-defined]

from ..base.types import fields_of


class Portable:
    """A frozen dataclass with expressions that pickles, also in a process pool, and copies."""

    __getstate__ = fields_of

    def __reduce_ex__(self, protocol: Any) -> Any:
        if _current_pickle_context():  # an outer record, or a caller, shares the symbols
            return object.__reduce_ex__(self, protocol)
        with global_pickle_context():
            return _read, (pickle.dumps(self, protocol),)

    def __copy__(self) -> Self:
        new = object.__new__(type(self))
        new.__dict__.update(self.__getstate__())
        return new

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        new = object.__new__(type(self))
        memo[id(self)] = new
        new.__dict__.update(copy.deepcopy(self.__getstate__(), memo))
        return new


def _read(written: bytes) -> Any:
    with global_unpickle_context():
        return pickle.loads(written)
