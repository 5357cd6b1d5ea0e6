"""Input of other programs.

LaTeX, C, AUTO-07p and BifurcationKit.jl, from the graph that the package evaluates.
May import `basin`, `scene` and the floors below.
To add a format: one function in a module like `to_c.py`, for a program that continues equilibria
in `to_continuation.py`; its line in `__init__.pyi`, and a word in `FORMATS` of `cli/export.py`.
"""

from ..base.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__)  # noqa: PLE0605
