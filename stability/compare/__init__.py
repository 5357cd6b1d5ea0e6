"""Cost against error; hard cases.

Compares routes to one answer on this machine, and shows where methods fail.
May import `figures`, `tables`, `export` and the floors below.
To add a route, a driver or a hard case: a class or a record, as `docs/explanation/compare.md` says.
The names for it are listed in `__init__.pyi`.
"""

from ..base.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, public=False)  # noqa: PLE0605
