"""Stability of steady motions: which can be seen, for which parameters, and how do we know.

The public names are in `__init__.pyi`.  Records that calls return are in `results`, input of other
programs in `export`, and what basins are counted by in `statistics`; each is found here as well.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from .base import above
from .base.lazy import attach
from .base.version import __version__ as __version__

__getattr__, __dir__, __all__ = attach(__name__)  # noqa: PLE0605

_ABOVE = {
    "figure of a spectrum": ("figures.loci", "plot_locus"),
    "spectrum": ("spectra.spectrum", "spectrum"),
    "citation of a file": ("storage.datasets", "file_citation"),
}
"""Where the functions are that rooms below call: `.plot()`, `.spectra`, `citation` of a path."""


def _finder(module: str, name: str) -> Callable[[], Any]:
    return lambda: getattr(import_module(f".{module}", __name__), name)


for _call, _place in _ABOVE.items():
    above.register(_call, _finder(*_place))
