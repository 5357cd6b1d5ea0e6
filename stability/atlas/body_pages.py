"""The pages of the atlas of bodies: one for each body, and an index with a picture of each."""

from __future__ import annotations

import html
from collections.abc import Mapping

from ..bodies.families import FAMILIES
from .body_diagrams import POLES, Diagram, Key, Shown, family_of, kinds, names, spoken
from .page import _figure, _foot, _head

TITLE = "Stability atlas of bodies of revolution"
ABOUT = (
    "Each diagram shows one family of steady motions of one body: where small disturbances decay "
    "(blue), where they grow (vermilion, hatched), and where by linear approximation they do "
    "neither (neutral, dotted), with the boundary in between. Numbers are dimensionless "
    "(m = R = g = 1). A verdict without a proof is called undecided. The equations follow from the "
    "height of the centre of mass over the plane."
)


def pages(
    bodies: Mapping[str, Shown],
    found: Mapping[Key, Diagram],
    absent: Mapping[tuple[str, str], str],
    resolution: int,
) -> dict[str, str]:
    """The text of every page by its file name.

    Parameters
    ----------
    bodies
        The bodies by key.
    found
        The diagrams.
    absent
        A sentence for each family that a body does not have, by the keys of both.
    resolution
        Points along the axis of the family.
    """
    foot = _foot(f"stability atlas --bodies --resolution {resolution}")
    texts = {"index.html": _index(bodies, found)}
    texts |= {f"{key}.html": _page(key, bodies, found, absent) for key in bodies}
    return {name: "\n".join([*lines, foot]) + "\n" for name, lines in texts.items()}


def _links(bodies: Mapping[str, Shown], here: str = "") -> str:
    index = "" if not here else '<a href="index.html">all bodies</a>'
    others = (
        f'<a href="{k}.html">{s.name}</a>' if k != here else f"<strong>{s.name}</strong> "
        for k, s in bodies.items()
    )
    return f"<nav>{index}{''.join(others)}</nav>"


def _index(bodies: Mapping[str, Shown], found: Mapping[Key, Diagram]) -> list[str]:
    """The page with one picture of each body."""
    lines = [*_head(TITLE), f'<p class="lead">{ABOUT}</p>', _links(bodies), '<div class="row">']
    for key, shown in bodies.items():
        mine = [d for (body, _, _), d in found.items() if body == key]
        drawn = [d.picture for d in mine if d.figure]
        count = f"{len(drawn)} diagrams" if len(drawn) != 1 else "1 diagram"
        picture = (
            f'<img src="{drawn[0].stem}.png" alt="{html.escape(drawn[0].alternative)}" '
            'loading="lazy">'
            if drawn
            else ""
        )
        lines.append(
            f'<figure><a href="{key}.html">{picture}</a><figcaption><a href="{key}.html">'
            f"<strong>{shown.name.capitalize()}</strong></a> ({shown.told}): {count}. "
            f"{html.escape(shown.profile)}</figcaption></figure>"
        )
    return [*lines, "</div>"]


def _page(
    key: str,
    bodies: Mapping[str, Shown],
    found: Mapping[Key, Diagram],
    absent: Mapping[tuple[str, str], str],
) -> list[str]:
    """The page of one body."""
    shown = bodies[key]
    axial, transverse = shown.make().moments()
    lines = [
        *_head(f"Stability atlas: {shown.name}"),
        _links(bodies, key),
        f'<p class="lead">{html.escape(shown.profile)} At {shown.told} the moments of inertia are '
        f"{axial:.4g} (about the axis) and {transverse:.4g} (across it) mR². {ABOUT}</p>",
    ]
    for name in names(shown):
        family, _ = family_of(name)
        end = shown.ends[name.endswith("-pi")] if family == "vertical" and shown.ends else ""
        head = spoken(family).capitalize() + (f", {end}" if end else "")
        lines.append(f'<h2 id="{name}">{head}</h2>')
        if (key, name) in absent:
            lines.append(f"<p>{html.escape(absent[key, name])}</p>")
            continue
        alike = " Both ends are alike." * (name in POLES and not shown.ends)
        motion = FAMILIES[family].motion
        lines.append(f"<p>{motion[0].upper()}{motion[1:]}.{alike}</p>")
        mine = [found[key, name, kind] for kind in kinds(shown, name)]
        drawn = [_figure(d.picture, True) for d in mine if d.figure]
        lines += ['<div class="row pairs">', *drawn, "</div>"] if drawn else []
        lines += [_sentence(d) for d in mine if not d.figure]
    return lines


def _sentence(diagram: Diagram) -> str:
    """A sentence in place of a figure, with its map."""
    picture = diagram.picture
    return f'<p>{html.escape(picture.caption)} <a href="{picture.stem}.nc">NetCDF</a></p>'
