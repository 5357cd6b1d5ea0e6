"""Pages that work: an atlas, a report and the explorer, made small by the build."""

from __future__ import annotations

import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.errors import ExtensionError
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

import stability

from .commands import ROOT, environment, folder
from .figures import fingerprint
from .notebooks import written

PARTS = {
    "atlas": "stability atlas --out OUT/atlas --resolution 60",
    "report": "stability report --out OUT/report --cases hoop,gentle,near "
    "--methods ad,sympy,simulate,lsoda",
}
"""Command of each part."""
EXPLORER = "stability explore --out OUT/explorer/index.html"
PAGE = """# The explorer

The stability diagram as one file: open it, move the sliders, click a point. It needs no server and
no network. The page says what is proved, and what is computed in your browser.

```{live} explorer/index.html
:title: the explorer
:height: 900
```

Make your own: `stability explore --out page.html`, or {py:func}`stability.explore` in Python.
"""


ALONE = ("report",)
"""Parts that measure times, so that nothing else runs meanwhile."""
_others: list[subprocess.Popen[str]] = []


def make(place: str) -> None:
    """Make the parts that are missing, or of another state of the package.

    Those that measure are made at once; the others while Sphinx reads the pages, until `finish`.

    Parameters
    ----------
    place
        Folder whose content is copied to the root of the site.
    """
    target = ROOT / "docs" / "live" / "explorer.md"
    parts = dict(PARTS)
    if "explore" in stability.__all__:
        parts["explorer"] = EXPLORER
        written(target, PAGE)
    else:
        target.unlink(missing_ok=True)
    lines = []
    for name, command in parts.items():
        part, mark = Path(place) / name, f"{fingerprint()} {command}"
        stamp = part / ".made"
        if stamp.is_file() and stamp.read_text() == mark:
            continue
        logging.getLogger(__name__).info("making %s: %s", name, command)
        shutil.rmtree(part, ignore_errors=True)
        if name == "explorer":
            part.mkdir(parents=True)
        line = f"{command.replace('OUT', place)}\nprintf %s {shlex.quote(mark)} > {stamp}\n"
        if name in ALONE:
            _wait(_start(line))
        else:
            lines.append(line)
    if lines:
        _others.append(_start("".join(lines)))


def _start(lines: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        ["bash", "-ec", lines],
        cwd=ROOT,
        env=environment(),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )


def _wait(one: subprocess.Popen[str]) -> None:
    said, _ = one.communicate()
    if one.returncode:
        raise ExtensionError(f"{one.args!r} ended with {one.returncode}:\n{said}")


def finish(app: Any, env: Any) -> list[str]:  # noqa: ARG001
    """Wait for the parts, before anything is written."""
    while _others:
        _wait(_others.pop())
    return []


WIDGET = "application/vnd.jupyter.widget-view+json"
"""Kind of output of a cell that shows a widget; drawing it would ask a server for scripts."""


def widgets(app: Any, doctree: nodes.document) -> None:
    """Show the explorer's own page in the place of its widget, which is the same page."""
    docname = app.env.docname
    for node in [n for n in doctree.findall(nodes.raw) if WIDGET in n.astext()]:
        node.replace_self(framed(docname, "explorer/index.html", "the explorer", 900))
        app.env.nb_metadata[docname]["js_files"].pop("ipywidgets_state", None)


def framed(docname: str, name: str, title: str, height: int) -> nodes.raw:
    """A frame with a page of the site, and a link that opens it alone."""
    url = "../" * docname.count("/") + name
    text = (
        f'<iframe class="live" src="{url}" title="{title}" height="{height}" loading="lazy">'
        f'</iframe><p class="live-link"><a href="{url}">Open {title} on its own page</a></p>'
    )
    return nodes.raw("", text, format="html")


class Live(SphinxDirective):
    """A page within the page, with a link that opens it alone.

    The name is within the site's extra files; `from-page` takes one that a command of this page
    has written.
    """

    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {
        "title": directives.unchanged_required,
        "height": directives.positive_int,
        "from-page": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        """The frame."""
        name, extra = self.arguments[0], Path(self.config.html_extra_path[0])
        if "from-page" in self.options:
            source = folder(self.env.docname) / name
            name = f"made/{self.env.docname}/{name}"
            (extra / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, extra / name)
        elif Path(name).parts[0] not in (*PARTS, "explorer"):
            raise ExtensionError(f"{name} is made by no command of {__name__}")
        title, height = self.options.get("title", name), self.options.get("height", 640)
        return [framed(self.env.docname, name, title, height)]
