"""Directives `run`, `file` and `made`: commands that the build runs, and what they write.

All of a page share one folder, as a reader's terminal does.  A command that fails ends the build.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.directives.code import container_wrapper
from sphinx.errors import ExtensionError
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[2]
MADE = ROOT / "docs" / "_made"
_log = logging.getLogger(__name__)
LONGEST = 240
"""Seconds after which a command is stopped."""


def folder(docname: str) -> Path:
    """The folder of a page's commands, in which the examples are at hand."""
    place = MADE / docname
    place.mkdir(parents=True, exist_ok=True)
    if not (place / "examples").exists():
        (place / "examples").symlink_to(ROOT / "examples")
    return place


def fresh(app: Any, docname: str, source: list[str]) -> None:  # noqa: ARG001
    """Empty the folder of a page that is read again."""
    shutil.rmtree(MADE / docname, ignore_errors=True)


def environment() -> dict[str, str]:
    """Variables of a command: the package's own programs first, plain text."""
    paths = [str(Path(sys.executable).parent), os.environ.get("PATH", "")]
    return {**os.environ, "PATH": os.pathsep.join(paths), "COLUMNS": "90", "TQDM_DISABLE": "1"}


def output(command: str, where: Path, expected: int, page: str) -> str:
    """What a command prints; a warning where its exit code is not the expected one."""
    done = subprocess.run(
        ["bash", "-ec", command],
        cwd=where,
        env=environment(),
        text=True,
        timeout=LONGEST,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode != expected:
        _log.warning(
            "%r ended with %d, expected %d:\n%s",
            command,
            done.returncode,
            expected,
            done.stdout,
            location=page,
            type="command",
        )
    lines = [re.sub(r"^.*\r", "", line).rstrip() for line in done.stdout.splitlines()]
    return "\n".join(line for line in lines if not re.match(r"^\w+: +\d+%\|", line))


def shortened(text: str, most: int) -> str:
    """The first lines of a text, with a mark where some are left out."""
    lines = text.splitlines()
    return text if len(lines) <= most else "\n".join([*lines[:most], "…"])


class Run(SphinxDirective):
    """Commands of a shell, run by the build, with what they print."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "lines": directives.positive_int,
        "exit": directives.nonnegative_int,
    }

    def run(self) -> list[nodes.Node]:
        """One block: each command behind `$`, then its output."""
        where, shown = folder(self.env.docname), []
        text = "\n".join(self.content)
        for command in re.split(r"(?<!\\)\n", text):
            if not command.strip():
                continue
            found = output(command, where, self.options.get("exit", 0), self.env.docname)
            shown.append(f"$ {command}")
            if found:
                shown.append(shortened(found, self.options.get("lines", 40)))
        block = nodes.literal_block("\n".join(shown), "\n".join(shown), language="console")
        self.set_source_info(block)
        return [block]


class File(SphinxDirective):
    """A file that the reader writes: shown, and written into the page's folder."""

    has_content = True
    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {"language": directives.unchanged}

    def run(self) -> list[nodes.Node]:
        """The block with the file's name over it."""
        name, text = self.arguments[0], "\n".join(self.content)
        (folder(self.env.docname) / name).write_text(text + "\n", encoding="utf-8")
        language = self.options.get("language", "toml" if name.endswith(".toml") else "python")
        block = nodes.literal_block(text, text, language=language)
        self.set_source_info(block)
        return [container_wrapper(self, block, name)]


class Made(SphinxDirective):
    """A picture that a command of the page has written, with its caption."""

    has_content = True
    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {
        "alt": directives.unchanged_required,
        "width": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        """The figure."""
        place = folder(self.env.docname) / self.arguments[0]
        if not place.is_file():
            raise ExtensionError(f"{place} is not there; a command of the page must write it")
        name = "/" + place.relative_to(ROOT / "docs").as_posix()
        image = nodes.image("", uri=name, alt=self.options.get("alt", ""))
        if "width" in self.options:
            image["width"] = self.options["width"]
        figure = nodes.figure("", image)
        if self.content:
            caption = nodes.caption()
            inline, _ = self.state.inline_text(" ".join(self.content), self.lineno)
            caption += inline
            figure += caption
        return [figure]


class Checkout(SphinxDirective):
    """A copy of the package in the page's folder, for pages that change the package's files."""

    def run(self) -> list[nodes.Node]:
        """Nothing: the copy is all."""
        target = folder(self.env.docname) / "stability"
        shutil.copytree(
            ROOT / "stability",
            target,
            ignore=shutil.ignore_patterns("__pycache__"),
            dirs_exist_ok=True,
        )
        return []


class Edit(SphinxDirective):
    """Lines that the reader adds to a file of the package, after the line that holds a text."""

    has_content = True
    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {"after": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        """The lines with the file's name and the line before them."""
        name, after = self.arguments[0], self.options["after"]
        path = folder(self.env.docname) / name
        lines = path.read_text(encoding="utf-8").split("\n")
        places = [i for i, line in enumerate(lines) if after in line]
        if places:
            lines[places[0] + 1 : places[0] + 1] = list(self.content)
            path.write_text("\n".join(lines), encoding="utf-8")
        else:  # a warning, so that one build names every fault
            _log.warning("%s has no line with %r", name, after, location=self.get_location())
        text = "\n".join(self.content)
        block = nodes.literal_block(text, text, language="python")
        self.set_source_info(block)
        return [container_wrapper(self, block, f"{name}, after the line with ``{after}``")]
