"""The link of the page: the view comes back from it, and what is damaged in it does no harm."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from node import Engine
from page_numbers import OPEN

STATE = "stabilityExplorer.view.state"


@pytest.fixture
def page(page_of_disk: Path) -> Engine:
    return Engine(page_of_disk)


def test_what_a_link_says_restores_the_view(page: Engine, page_of_disk: Path) -> None:
    generator = np.random.default_rng(4)
    keys = page.evaluate("[...stabilityExplorer.view.subjects.keys()]")
    fresh = Engine(page_of_disk)
    for key in keys:
        page.evaluate("(key) => stabilityExplorer.view.choose(key)", key)
        names = page.evaluate("stabilityExplorer.view.subject.names")
        page.evaluate(
            "(given) => stabilityExplorer.view.move(given)",
            {n: float(generator.uniform(0.01, 0.5)) for n in names},
        )
        low = float(generator.uniform(0.01, 1))
        page.evaluate(
            "(more) => { const {view} = stabilityExplorer, {ranges} = view.state;"
            "view.set({...more, ranges: {...ranges, at: more.at}}); }",
            {
                "x": names[-1],
                "y": names[0],
                "at": [low, 3 * low, "log"],
                "along": names[-1],
                "show": "mode",
                "mode": 1,
                "kick": 2,
                "tilt": 0.2,
                "until": 200,
            },
        )
        link = page.evaluate("stabilityExplorer.view.write()")
        fresh.evaluate(OPEN, f"#{link}")
        kept, found = (dict(one.evaluate(STATE)) for one in (page, fresh))
        kept.pop("at")
        assert found == kept, key


def test_a_link_that_is_damaged_restores_the_rest(page: Engine) -> None:
    before: dict[str, Any] = page.evaluate(STATE)
    for k, link in ((0.3, "#at=%E0%A4%A&k=0.3"), (0.2, "#%=1&k=0.2"), (0.4, "#k=0.4&mu=%zz")):
        page.evaluate(OPEN, link)
        assert page.evaluate(STATE) == before | {"values": before["values"] | {"k": k}}, link


def test_what_a_link_says_wrongly_stays_as_it_was(page: Engine) -> None:
    page.evaluate(OPEN, "#show=rolling-rough&at=0.9&k=nonsense&tilt=3&time=-1&xaxis=foo:1:2")
    found = page.evaluate(STATE)
    assert (found["subject"], found["values"]) == ("rolling rough", {"at": 0.9, "k": 0.25})
    assert (found["tilt"], found["until"]) == (0.1, 60)
    page.evaluate(OPEN, "#k=0.7&at=1")  # no thin body has this inertia factor
    assert page.evaluate(STATE)["values"] == {"at": 1, "k": 0.25}
