"""Formulas as MathML, which browsers draw without a script and without a network."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml


def _mathml(text: str, *, block: bool) -> str:
    return str(latex2mathml.tex2mathml(text, as_block=block))


def inline(self: Any, node: nodes.math) -> None:
    """A formula within a line."""
    self.body.append(_mathml(node.astext(), block=False))
    raise nodes.SkipNode


def display(self: Any, node: nodes.math_block) -> None:
    """A formula on its own line."""
    self.body.append(f'<div class="math">{_mathml(node.astext(), block=True)}</div>')
    raise nodes.SkipNode
