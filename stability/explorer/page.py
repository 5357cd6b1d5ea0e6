"""A page: its data from the subjects, and one text of modules, styles, 3-D library and data."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from posixpath import dirname, join, normpath
from typing import Any

from ..base.axis import Axis
from ..base.errors import NameUnknownError, ParameterError, StabilityError, listed, shown
from ..base.looks import page_looks, page_style
from ..base.verdict import Verdict
from ..base.version import __version__, install_line
from .certificates import LETTERS
from .quantities import CURVES, PageUnits
from .subject import PageSubject

LAW_NAMES = {
    "smooth": "Smooth",
    "viscous": "Viscous",
    "linear-viscous": "Linear",
    "rough": "Rough",
}
"""Words on the buttons."""
WORDS = {
    "smooth": "no friction",
    "viscous": "viscous friction, F\u00a0=\u00a0−μ\u00a0N\u00a0v",
    "linear-viscous": "linear viscous friction, F\u00a0=\u00a0−c\u00a0v",
    "rough": "no slip",
}
"""Each law in words."""
PROOFS = (
    "Float: computed in floating point, without a proof. Proved in this page: at this point the "
    "signs of the conditions exceed their rounding errors. Certified by the package: the verdict "
    "holds on a whole rectangle, by exact arithmetic."
)
"""What the words on a page say of numbers and verdicts."""


@dataclass(frozen=True)
class Contents:
    """What a page holds; of the disk, of a body and of a user's system it differs by data."""

    title: str
    """Title of the page."""
    subjects: Sequence[PageSubject]
    """Every family under its laws."""
    start: PageSubject
    """The one at first."""
    motions: Mapping[str, Any]
    """Equations of launches by `PageSubject.model`."""
    certificates: Mapping[str, list[Any]]
    """Proved rectangles by the key of a subject."""
    families: Mapping[str, str]
    """Word on each family's button."""
    says: str
    """What moves, in words."""
    computed_from: str
    """What the page computes from, in words."""
    units: PageUnits | None = None
    """Units of a body; None for a user's system."""
    stated: Mapping[str, str] | None = None
    """Units that such a system states, by the names of times, rates and curves."""
    more: str = ""
    """Further sentences of the last line."""

    def data(self, axes: Sequence[Axis | None]) -> dict[str, Any]:
        """The data of the page; it begins with these axes, or its own for None."""
        start, units, stated = self.start, self.units, self.stated
        values = {n: q.value for n, q in start.called.items()}
        for axis in axes:
            if axis is not None and axis.name not in values:
                raise NameUnknownError(
                    f"axis is {shown(axis.name)}; give {listed(list(values), 'or')}."
                )
        sizes = {n: units.sizes[q.kind] if units else 1.0 for n, q in start.called.items()}
        laws = dict.fromkeys(s.law for s in self.subjects)
        return {
            "format": 1,
            "version": __version__,
            "subjects": [s.record for s in self.subjects],
            "start": {
                "subject": start.key,
                "values": values,
                "axes": [
                    a and [a.name, a.low / sizes[a.name], a.high / sizes[a.name], *["log"] * a.log]
                    for a in axes
                ],
            },
            "units": {n: kind.words for n, kind in CURVES.items()} if stated is None else stated,
            "si": units.told() if units else {},
            "scale": units.scale if units else "",
            "kinds": {n: k.name for n, k in CURVES.items()},
            "solid": bool(start.body),
            "motions": self.motions,
            "certificates": self.certificates,
            "names": {
                "families": self.families,
                "laws": {law: LAW_NAMES.get(law, law.capitalize()) for law in laws if law},
                "says": {
                    law: f"{self.says}; {WORDS.get(law, f'{law} contact')}."
                    if law
                    else f"{self.says}."
                    for law in laws
                },
            },
            "looks": {**page_looks(), "letters": {LETTERS[v.code]: v.word for v in Verdict}},
            "foot": foot(self.computed_from, units) + self.more,
        }


def foot(source: str, units: PageUnits | None = None) -> str:
    """The last line of a page."""
    made = f"Made by stability {__version__}. This page computes everything itself, from {source}"
    words = f"{PROOFS} {made}"
    if units is None:
        return f"{words}."
    if units.dimensionless:
        where = ", R the length of the body" if units.length == "length" else ""
        return f"{words}; numbers are dimensionless, m = R = g = 1{where}."
    return f"{words}, without dimension (m = R = g = 1), and shows SI units for {units.body}."


def axis_of(axis: Any, which: str) -> Axis | None:
    """An axis from (name, low, high) and perhaps "log", as of a map without its count."""
    if axis is None:
        return None
    if not isinstance(axis, (list, tuple)) or len(axis) not in (3, 4):
        raise ParameterError(
            f"{which} is {shown(axis)}; give (name, low, high) or (name, low, high, 'log')."
        )
    return Axis.of((*axis[:3], 2, *axis[3:]), which)


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
        "STYLE": style(),
        "DATA": json_in_html(shared(data)),
        "THREE": library().replace("</script", "<\\/script"),
        "SCRIPT": script().replace("</script", "<\\/script"),
    }
    template = _read("page.html")
    return re.sub(r"@(\w+)@", lambda match: parts[match.group(1)], template)


def module(data: Mapping[str, Any]) -> str:
    """The same page as the module of a widget."""
    return "\n".join([
        script(), f"const DATA = {json.dumps(shared(data))};",
        f"const THREE_TEXT = {json.dumps(library())};",
        f"const STYLE_TEXT = {json.dumps(style())};",
        "export default {render({el}) { return mountWidget(el, DATA, THREE_TEXT, STYLE_TEXT); }};",
    ])  # fmt: skip


def style() -> str:
    """The style sheet, with the colours and looks of verdicts."""
    return f"{page_style()}\n{_read('style.css')}"


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
        for entry in value.values() if isinstance(value, Mapping) else value:
            yield from _texts(entry)


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
            "anywidget is missing, which shows the explorer in a notebook; "
            f"{install_line('widget')}, or give out='page.html' and open that file."
        ) from None
    source = module(data)

    class Explorer(AnyWidget):
        """The explorer in a notebook."""

        _esm = source

    return Explorer()
