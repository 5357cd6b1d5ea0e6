"""Types that many modules name, and the state of a record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Progress = Callable[[int, int], None]


def fields_of(record: Any) -> dict[str, Any]:
    """Fields of a frozen record without its cached values: its state when pickled."""
    return {f.name: getattr(record, f.name) for f in fields(record)}
