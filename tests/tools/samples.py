"""A small seeded sample for `make test`; the whole campaign for `make test-long`."""

from __future__ import annotations

import random
from collections.abc import Iterable
from typing import Any

import pytest


def sized(name: str, small: Any, full: Any) -> pytest.MarkDecorator:
    """One argument of a test: small in `make test`, full in `make test-long`."""
    values = [pytest.param(small, id="few"), pytest.param(full, id="all", marks=pytest.mark.long)]
    return pytest.mark.parametrize(name, values)


def few(cases: Iterable[Any], count: int, seed: int = 0) -> list[Any]:
    """All cases; those that a seeded draw of `count` leaves out are long."""
    every = list(cases)
    drawn = set(random.Random(seed).sample(range(len(every)), min(count, len(every))))

    def long(case: Any) -> Any:
        if isinstance(case, type(pytest.param())):
            return pytest.param(*case.values, id=case.id, marks=[*case.marks, pytest.mark.long])
        values = case if isinstance(case, tuple) else (case,)
        return pytest.param(*values, marks=pytest.mark.long)

    return [case if i in drawn else long(case) for i, case in enumerate(every)]
