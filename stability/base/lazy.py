"""Public names that load their module when they are first used; a stub lists them."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import resolve_name
from pathlib import PurePath
from typing import Any

from .calls import guarded

HOMES: dict[str, str] = {}
"""Public name: its module."""


def attach(
    module: str, public: bool = True
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a module, by the imports of its stub.

    The names of a module that the stub imports with `*` are found too, and not listed.

    Parameters
    ----------
    module
        Name of the module, which is being imported.
    public
        If its names are for every user, and their calls are guarded.
    """
    this = sys.modules[module]
    spec = this.__spec__
    assert spec is not None and spec.origin is not None and spec.loader is not None
    read: Callable[[str], bytes] = spec.loader.get_data  # type: ignore[attr-defined]
    stub = read(str(PurePath(spec.origin).with_suffix(".pyi"))).decode()
    lines = re.findall(r"^from (\S+) import (\*|[A-Za-z]\w*)", stub, re.M)
    rooms = [name for home, name in lines if home == "."]
    others = [import_module(home, spec.parent) for home, name in lines if name == "*"]
    homes = {n: resolve_name(h, spec.parent) for h, n in lines if n != "*" and h != "."}
    if public:
        HOMES.update(homes)

    def find(name: str) -> Any:
        if name in rooms:
            return import_module(f".{name}", spec.parent)
        if name in homes:
            value = getattr(import_module(homes[name]), name)
            value = guarded(value, name) if public else value
        else:
            value = next((getattr(o, name) for o in others if name in o.__all__), None)
            if value is None:
                raise AttributeError(f"module {module!r} has no attribute {name!r}")
        for class_name, home in HOMES.items():  # classes of results, which no one asks for by name
            if isinstance(loaded := getattr(sys.modules.get(home), class_name, None), type):
                guarded(loaded, class_name)
        setattr(this, name, value)
        return value

    return find, lambda: sorted([*homes, *rooms]), sorted(homes)
