"""Connects the parts of this folder with Sphinx."""

from __future__ import annotations

from typing import Any

from . import (
    command_line,
    commands,
    figures,
    live,
    mathml,
    notebooks,
    order,
    reference,
    shell,
    sources,
)


def made(app: Any) -> None:
    """Write the pages that are derived from the code of today, before Sphinx looks for pages."""
    reference.alone(app)
    notebooks.copy()
    reference.write()
    command_line.write()
    live.make(app.config.html_extra_path[0])


def setup(app: Any) -> dict[str, bool]:
    """Register directives, formulas and events."""
    app.add_directive("run", commands.Run)
    app.add_directive("file", commands.File)
    app.add_directive("made", commands.Made)
    app.add_directive("checkout", commands.Checkout)
    app.add_directive("edit", commands.Edit)
    app.add_directive("live", live.Live)
    app.add_directive("sh", shell.Sh)
    app.add_html_math_renderer("mathml", (mathml.inline, None), (mathml.display, None))
    app.connect("builder-inited", made)
    app.connect("env-before-read-docs", order.ordered)
    app.connect("source-read", commands.fresh)
    app.connect("source-read", shell.executed)
    app.connect("source-read", notebooks.executed)
    app.connect("doctree-read", live.widgets, priority=299)
    app.connect("doctree-read", figures.replaced, priority=300)
    app.connect("doctree-read", sources.linked, priority=301)
    app.connect("env-purge-doc", sources.purge)
    app.connect("env-merge-info", sources.merge)
    app.connect("html-collect-pages", sources.pages)
    app.connect("autodoc-process-docstring", reference.sections)
    app.connect("autodoc-process-signature", reference.defaults)
    app.connect("env-updated", live.finish)
    app.connect("missing-reference", reference.resolved)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
