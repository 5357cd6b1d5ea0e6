"""The same page as a widget of a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base.errors import StabilityError
from .page import module


def widget(data: Mapping[str, Any]) -> Any:
    """A widget that a notebook shows.

    Raises
    ------
    StabilityError
        If anywidget is not installed.
    """
    try:
        from anywidget import AnyWidget
    except ImportError:
        raise StabilityError(
            "anywidget is missing, which shows the explorer in a notebook; say pip install "
            "'stability[widget]', or give out='page.html' and open that file."
        ) from None
    source = module(data)

    class Explorer(AnyWidget):
        """The explorer in a notebook."""

        _esm = source

    return Explorer()
