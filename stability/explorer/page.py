"""The page as one text: modules of `script/` joined, styles, the 3-D library, and the data."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import lru_cache
from importlib.resources import files
from posixpath import dirname, join, normpath
from typing import Any

from ..base.errors import StabilityError

ENTRY = "explorer.js"
"""The module that starts the page."""
IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\.[\w/.]+)";\n', re.MULTILINE)
"""An import of names from another module of `script/`."""
EXPORT = re.compile(r"^export (?:async )?(?:const|let|function\*?|class) (\w+)", re.MULTILINE)
"""An export of a declaration."""


def page(data: Mapping[str, Any], title: str) -> str:
    """One HTML file that needs no other file, no server and no network."""
    parts = {
        "TITLE": title.replace("&", "&amp;").replace("<", "&lt;"),
        "STYLE": _read("style.css"),
        "DATA": json_in_html(shared(data)),
        "THREE": library().replace("</script", "<\\/script"),
        "SCRIPT": script().replace("</script", "<\\/script"),
    }
    found = _read("page.html")
    return re.sub(r"@(\w+)@", lambda match: parts[match.group(1)], found)


def module(data: Mapping[str, Any]) -> str:
    """The same page as the module of a widget."""
    return "\n".join([
        script(), f"const DATA = {json.dumps(shared(data))};",
        f"const THREE_TEXT = {json.dumps(library())};",
        f"const STYLE_TEXT = {json.dumps(_read('style.css'))};",
        "export default {render({el}) { return mountWidget(el, DATA, THREE_TEXT, STYLE_TEXT); }};",
    ])  # fmt: skip


@lru_cache(maxsize=1)
def library() -> str:
    """The 3-D library with its licence."""
    return f"/*\nthree.js\n{_read('library/three.LICENSE')}*/\n{_read('library/three.js')}"


LONG = 200
"""Length of a text that is worth a place of its own where it occurs twice."""


def shared(data: Mapping[str, Any]) -> dict[str, Any]:
    """The data with each long text that occurs twice in one list, `texts`.

    Examples
    --------
    >>> long = "x" * 300
    >>> shared({"a": [long, "y"], "b": long})["data"]
    {'a': [{'text': 0}, 'y'], 'b': {'text': 0}}
    """
    counts: Counter[str] = Counter(t for t in _texts(data) if len(t) > LONG)
    places = {t: i for i, t in enumerate(t for t, n in counts.items() if n > 1)}

    def put(value: Any) -> Any:
        if isinstance(value, str):
            return {"text": places[value]} if value in places else value
        if isinstance(value, Mapping):
            return {n: put(v) for n, v in value.items()}
        return [put(v) for v in value] if isinstance(value, (list, tuple)) else value

    return {"texts": list(places), "data": put(data)}


def _texts(value: Any) -> Iterator[str]:
    """Every text in nested lists and tables."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (Mapping, list, tuple)):
        for one in value.values() if isinstance(value, Mapping) else value:
            yield from _texts(one)


def json_in_html(data: Mapping[str, Any]) -> str:
    """JSON that no reader of HTML takes for an end of its element."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


@lru_cache(maxsize=1)
def script() -> str:
    """The modules of `script/` as one text, each after those that it imports.

    Raises
    ------
    StabilityError
        If two modules import each other.
    """
    done: dict[str, str] = {}
    _collect(ENTRY, done, ())
    return "\n".join([*done.values(), f"const {{mountPage, mountWidget}} = {_variable(ENTRY)};"])


def _collect(name: str, done: dict[str, str], above: tuple[str, ...]) -> None:
    """Put a module after its imports, in a function of its own that returns what it exports."""
    if name in done:
        return
    if name in above:
        raise StabilityError(f"modules of the page import each other: {' → '.join(above)}.")
    text = _read(f"script/{name}")

    def imported(match: re.Match[str]) -> str:
        place = normpath(join(dirname(name), match.group(2)))
        _collect(place, done, (*above, name))
        return f"const {match.group(1)} = {_variable(place)};\n"

    body = IMPORT.sub(imported, text)
    exports = ", ".join(match.group(1) for match in EXPORT.finditer(body))
    body = EXPORT.sub(lambda match: match.group(0).removeprefix("export "), body)
    done[name] = f"const {_variable(name)} = (() => {{\n{body}return {{{exports}}};\n}})();"


def _variable(name: str) -> str:
    """The variable that holds the exports of a module."""
    return "of_" + re.sub(r"\W", "_", name.removesuffix(".js"))


def _read(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
