"""Records that the public calls return, for annotations and for `isinstance`."""

from .base.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__)  # noqa: PLE0605
