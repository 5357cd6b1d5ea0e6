"""The page of a report: static HTML with figures, tables, and the files behind them."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.looks import LOOKS, cell_style
from ..base.provenance import machine, today
from ..storage.files import write_file
from ..storage.html import figure, head
from . import failures as catalogue
from .calls import WAYS
from .marks import Mark
from .motion import chart as motion_chart
from .motion.drivers import DRIVERS
from .scenes import sentence
from .spectrum import chart as spectrum_chart
from .spectrum.routes import ROUTES

if TYPE_CHECKING:
    from .plan import Part, RouteStanding


PAGE = "index.html"
TITLE = "stability: cost against error, and where methods fail"
HEADING = "Cost against error, and where methods fail"
TITLES = {
    "spectrum": "Spectra: time against error",
    "motion": "Motions: work against precision",
    "calls": "Whole calls: time against error",
    "scenes": "Scenes: the least model that answers",
    "failures": "Where methods fail",
}
"""Heading of each part."""
WHY = {
    "spectrum": "it checks that the motion is steady, removes the zeros by structure, and puts a "
    "disc with a bound about every eigenvalue, none of which the rival does",
    "simulate": "it runs every launch three times, which tells its error, and watches for the ends "
    "of the motion; simulate(check=False) is charted as “unchecked”",
}
"""Reason why a default route may not be the fastest, by route."""
ANOTHER = {
    ("spectrum", "verdict"): "it finds the eigenvalues too",
    ("simulate", "model"): "the rival is another model, whose energy account closes for any of its "
    "path",
}
"""More specific reasons: for a route and a word in the panel or the rival."""
STYLE = """
h2 { margin: 2.4rem 0 .3rem; font-size: 1.3rem; }
h3 { margin: 1.4rem 0 .2rem; font-size: 1rem; }
p, ul { max-width: 48rem; } nav a { margin-right: 1rem; }
.figures { columns: 25rem 2; column-gap: 2.5rem; }
figure { margin: 0 0 1.5rem; break-inside: avoid; }
figcaption { max-width: 34rem; margin-top: .4rem; }
dl { font-size: .85rem; margin: .5rem 0; max-width: 48rem; } dd { margin: 0 0 .25rem 1rem; }
dt { font-weight: 600; } code, h1, p, li, dd { overflow-wrap: anywhere; }
@media (min-width: 40rem) { dl.methods { display: grid; grid-template-columns: max-content 1fr; }
  dl.methods dd { margin-bottom: .1rem; } }
@media (max-width: 40rem) { body { padding: .75rem; } h1 { font-size: 1.35rem; }
  nav a { display: inline-block; padding: .35rem 0; } }
table { border-collapse: collapse; font-size: .8rem; } th, td { padding: .15rem .45rem; }
th { text-align: left; font-weight: 600; } tr { border-bottom: 1px solid var(--rule); }
.scroll { overflow-x: auto; } .scroll th.turned { writing-mode: vertical-rl; rotate: 180deg;
  text-align: left; padding: .3rem .1rem; } td.mark { text-align: center; min-width: 1.4rem; }
.own { color: #b34700; } td.number { text-align: right; }
@media (prefers-color-scheme: dark) { .own { color: #ff9a5c; } }
details { margin: .8rem 0; } summary { cursor: pointer; }
"""


def write(folder: Path, parts: Sequence[Part]) -> Path:
    """Write the page of a report.

    Returns
    -------
    Path
        `index.html` in the folder.
    """
    body = [
        *head(TITLE, STYLE + cell_style(mark.word for mark in Mark), HEADING),
        _lead(machine()),
        "<nav>" + "".join(f'<a href="#{p.name}">{TITLES[p.name]}</a>' for p in parts) + "</nav>",
    ]
    for part in parts:
        body += [f'<h2 id="{part.name}">{TITLES[part.name]}</h2>', *_section(part)]
    body.append(_footer(machine()))
    target = folder / PAGE
    write_file(target, "\n".join(body) + "\n", overwrite=True)
    return target


def _lead(here: Mapping[str, str]) -> str:
    return (
        "<p>Every quantity of the rolling and sliding disk has several routes to it. Here they "
        "answer the same questions on one machine: how long does each take, how far is it from the "
        f"truth, and where does it go wrong? Measured on {html.escape(here['processor'])}, "
        f"{here['cores']} cores, {here['memory']}. Times are those of this machine on that day; "
        "ratios within a panel are what carries over. The package's routes are vermilion.</p>"
    )


def _footer(here: Mapping[str, str]) -> str:
    versions = ", ".join(
        f"{name} {v}"
        for name, v in here.items()
        if name not in ("processor", "cores", "memory", "system", "stability")
    )
    return (
        f"<footer><p>Made by <code>stability report</code>, stability {here['stability']}, "
        f"{today()}, on {html.escape(here['processor'])}, {here['cores']} cores, {here['memory']}, "
        f"{html.escape(here['system'])}; {html.escape(versions)}.</p></footer></body></html>"
    )


def _section(part: Part) -> list[str]:
    files = ", ".join(f'<a href="{name}">{name}</a>' for name in part.data)
    lines = [f"<p>Numbers behind it, every raw timing among them: {files}.</p>"]
    places: list[str] = []
    if part.name == "failures":
        lines += _verdict(part.chart)
    elif part.name == "scenes":
        lines.append(f"<p>{html.escape(sentence(part.chart))}</p>")
    elif part.name != "calls":
        paragraph, places = _standings(part)
        lines.append(paragraph)
    if not part.plates and part.name != "scenes":
        lines.append("<p>No cell of this part has ended, so no figure is drawn.</p>")
    lines += [*_methods(part), '<div class="figures">']
    endings = {"png": "PNG", "pdf": "PDF"}
    lines += [figure(p.stem, p.caption, p.caption[:90], endings) for p in part.plates]
    lines.append("</div>")
    if part.name == "failures":
        lines += _tables(part.chart)
    return lines + places


def _methods(part: Part) -> list[str]:
    """The methods of a part, a line each, and why some of them crash."""
    asked = {
        "spectrum": spectrum_chart.CHARTED,
        "motion": motion_chart.NAMES,
        "failures": (*catalogue.ROUTE_NAMES, *catalogue.DRIVER_NAMES),
        "calls": WAYS,
        "scenes": (),
    }[part.name]
    if not asked:
        return []
    table: dict[str, Any] = WAYS if part.name == "calls" else {**ROUTES, **DRIVERS}
    names = set(_asked(part))
    lines = [
        f"<dt{' class=own' if table[n].own else ''}>{n}</dt><dd>{html.escape(table[n].title)}</dd>"
        for n in asked
        if n in names
    ]
    block = ["<h3>Methods</h3>", '<dl class="methods">', *lines, "</dl>"]
    if part.name == "failures":
        block += _crashes(part.chart, table)
    return block


def _asked(part: Part) -> Iterable[str]:
    """Names of the methods that a part asked."""
    if part.name == "failures":
        return (e.method for e in part.chart)
    if part.name == "calls":
        return (row["way"] for row in part.chart)
    along = "route" if part.name == "spectrum" else "driver"
    return [str(name) for name in part.chart[along].values]


def _crashes(answers: Sequence[catalogue.Entry], records: Mapping[str, Any]) -> list[str]:
    """For each method that crashed: how often, with which message, and why."""
    lines = []
    for name in dict.fromkeys(e.method for e in answers if e.mark is Mark.CRASHED):
        asked = [e for e in answers if e.method == name and e.mark is not None]
        crashed = [e for e in asked if e.mark is Mark.CRASHED]
        said, _ = Counter(e.note for e in crashed).most_common(1)[0]
        lines.append(
            f"<dt>{name}: {len(crashed)} of {len(asked)} cases</dt><dd>"
            f"{html.escape(records[name].flaw)} Message: <code>{html.escape(said)}</code></dd>"
        )
    return ["<h3>Why some crash</h3>", "<dl>", *lines, "</dl>"] if lines else []


# --- charts ---


def reason(standing: RouteStanding) -> str:
    """Reason why a route is not on the front."""
    for (route, word), text in ANOTHER.items():
        if route == standing.route and (word in standing.panel or word in standing.rival):
            return text
    return WHY[standing.route]


def _standings(part: Part) -> tuple[str, list[str]]:
    """A paragraph on the standing of the package's default routes, and their table."""
    from .plan import nearest, standings

    rows = standings(part)
    best = nearest(rows).values()
    if not best:
        return "", []
    behind = [s for s in best if not s.on_front]
    paragraph = (
        f"<p>In {len(best) - len(behind)} of {len(best)} panels a route that the package "
        "takes by default is on the Pareto front."
    )
    if behind:
        factors = dict.fromkeys(f"{f(s.factor for s in behind):.2g}" for f in (min, max))
        paragraph += (
            f" In the others the nearest is {' to '.join(factors)} times slower than the fastest "
            "route that is as accurate; the table below the figures says for each why."
        )
    lines = [
        "<details><summary>Where each default route stands in each panel, and why it is not the "
        'fastest where it is not</summary><div class="scroll"><table>',
        "<tr><th>panel</th><th>route</th><th>front</th><th>times slower than</th><th></th>"
        "<th>because</th></tr>",
    ]
    for s in rows:
        rest = (
            "<td></td><td></td><td></td>"
            if s.on_front
            else f'<td class="number">{s.factor:.3g}</td><td>{s.rival}</td>'
            f"<td>{html.escape(reason(s))}</td>"
        )
        mark = "yes" if s.on_front else "no"
        lines.append(
            f'<tr><td>{html.escape(s.panel)}</td><td class="own">{s.route}</td>'
            f"<td>{mark}</td>{rest}</tr>"
        )
    return paragraph + "</p>", [*lines, "</table></div></details>"]


# --- catalogue ---


def _verdict(answers: Sequence[catalogue.Entry]) -> list[str]:
    bad = catalogue.misleading(answers)
    asked = [e for e in answers if e.mark is not None]
    defaults = catalogue.defaults()
    mine = [e for e in asked if e.method in defaults]
    counts = {mark: sum(e.mark is mark for e in mine) for mark in Mark}
    listing = ", ".join(f"{n} {mark.word}" for mark, n in counts.items() if n)
    cases = len({(e.part, e.case) for e in asked})
    lines = [
        f"<p>{cases} hard cases, {len(asked)} answers. The routes that the package takes by "
        f"default gave {len(mine)} of them: {listing}.</p>"
    ]
    if bad:
        rows = "; ".join(f"{e.case}, {e.method}: {e.mark.word if e.mark else ''}" for e in bad)
        lines.append(f"<p><strong>Misleading: {html.escape(rows)}.</strong></p>")
    legend = "".join(
        f'<li><span class="{m.word}">&nbsp;{LOOKS[m.word].sign}&nbsp;</span> {m.value}</li>'
        for m in Mark
    )
    return [*lines, f"<ul>{legend}</ul>"]


def _tables(answers: Sequence[catalogue.Entry]) -> list[str]:
    lines, ours = [], catalogue.own_methods()
    for part, heading in catalogue.HEADINGS.items():
        methods, rows = catalogue.by_case(answers, part)
        if not rows:
            continue
        titles: dict[str, Any] = {**ROUTES, **DRIVERS}
        head = "".join(
            f'<th class="turned{" own" if m in ours else ""}" '
            f'title="{html.escape(titles[m].title, quote=True)}">{m}</th>'
            for m in methods
        )
        lines += [
            f"<details><summary>{heading}: the table; point at a cell to read what was seen"
            f'</summary><div class="scroll"><table><tr><th>case</th>{head}</tr>'
        ]
        texts = catalogue.texts(part)
        for case, row in rows.items():
            physics, truth = texts[case]
            tip = html.escape(f"{physics}. Known: {truth}", quote=True)
            cells = "".join(map(_cell, row))
            lines.append(f'<tr><td title="{tip}">{html.escape(case)}</td>{cells}</tr>')
        lines.append("</table></div></details>")
    return lines


def _cell(entry: catalogue.Entry) -> str:
    if entry.mark is None:
        return "<td></td>"
    digits = ""
    if entry.mark is Mark.DEGRADED and entry.digits == entry.digits:
        digits = f"{entry.digits:.0f}"
    tip = html.escape(f"{entry.method}: {entry.mark.word}. {entry.note}", quote=True)
    shown = digits or LOOKS[entry.mark.word].sign
    return f'<td class="mark {entry.mark.word}" title="{tip}">{shown}</td>'
