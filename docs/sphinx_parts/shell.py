"""Commands of a plain page: the build runs each `sh` block, in the page's own folder."""

from __future__ import annotations

import re
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util.docutils import SphinxDirective

from .blocks import BLOCK, changed, files, replacements
from .commands import folder, output


def executed(app: Any, docname: str, source: list[str]) -> None:  # noqa: ARG001
    """Make a directive of each block of commands, and write the files of the page."""
    text = source[0]
    for name, code in files(text).items():
        (folder(docname) / name).write_text(code, encoding="utf-8")

    def directive(found: re.Match[str]) -> str:
        kind, words, body = found.groups()
        option = {None: "", "run with ": f":with: {words}\n", "not run: ": f":not: {words}\n"}
        return f"```{{sh}}\n{option[kind]}{body}```"

    source[0] = BLOCK.sub(directive, text)


class Sh(SphinxDirective):
    """Commands, shown as they are, and run by the build."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "with": directives.unchanged_required,
        "not": directives.unchanged_required,
    }

    def run(self) -> list[nodes.Node]:
        """The block, and a line where it is not run as it stands."""
        text, said = "\n".join(self.content), ""
        if "not" in self.options:
            said = f"The build of this page does not run this: {self.options['not']}."
        else:
            where = folder(self.env.docname)
            words = self.options.get("with")
            output(changed(text, words) if words else text, where, 0, self.env.docname)
            if words:
                pairs = " and ".join(f"{new} for {old}" for old, new in replacements(words))
                said = f"The build of this page runs this with {pairs}."
        block = nodes.literal_block(text, text, language="sh")
        self.set_source_info(block)
        note = [nodes.paragraph("", said, classes=["ran"])] if said else []
        return [block, *note]
