"""What launches and basins are counted by: distributions, fractions with errors, exponents."""

from .base.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__)  # noqa: PLE0605
