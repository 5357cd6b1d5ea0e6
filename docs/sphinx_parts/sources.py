"""Links from pages to files of the repository: each such file becomes a page with its text."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.errors import ExtensionError

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = {".py": "python", ".toml": "toml", ".json": "json", ".md": "markdown", ".cff": "yaml"}


def linked(app: Any, doctree: nodes.document) -> None:
    """Lead links of a page to files outside the site to their pages."""
    docname = app.env.docname
    here = Path(app.env.doc2path(docname)).parent
    found: set[str] = set()
    for node in list(doctree.findall(addnodes.download_reference)):
        target = (here / node["reftarget"].partition("#")[0]).resolve()
        if not target.is_relative_to(ROOT) or not target.is_file():
            raise ExtensionError(f"{docname}: no file {node['reftarget']} in the repository")
        name = target.relative_to(ROOT)
        if name.parts[0] == "notebooks":
            page = f"notebooks/{name.stem}"
        else:
            page = f"source/{name.as_posix()}"
            found.add(name.as_posix())
        up = "../" * docname.count("/")
        link = nodes.reference("", "", refuri=f"{up}{page}.html", internal=True)
        link += node.children
        node.replace_self(link)
    known(app.env)[docname] = found


def known(env: Any) -> dict[str, set[str]]:
    """Files that each page links to."""
    if not hasattr(env, "linked_sources"):
        env.linked_sources = {}
    files: dict[str, set[str]] = env.linked_sources
    return files


def purge(app: Any, env: Any, docname: str) -> None:  # noqa: ARG001
    """Forget the links of a page that is read again."""
    known(env).pop(docname, None)


def merge(app: Any, env: Any, docnames: set[str], other: Any) -> None:  # noqa: ARG001
    """Take the links that another process has read."""
    known(env).update({n: known(other)[n] for n in docnames if n in known(other)})


def pages(app: Any) -> Iterator[tuple[str, dict[str, Any], str]]:
    """One page for each file that is linked."""
    for name in sorted(set().union(*known(app.env).values())):
        path = ROOT / name
        text = path.read_text(encoding="utf-8")
        shown = app.builder.highlighter.highlight_block(
            text, LANGUAGES.get(path.suffix, "text"), linenos=False
        )
        body = f"<h1>{name}</h1>\n{shown}"
        yield f"source/{name}", {"title": name, "body": body, "parents": []}, "page.html"
