"""The command `explore`: what it writes, and what it refuses."""

import json
from pathlib import Path

import pytest
from command_line import output, refused

LONG = pytest.mark.long


@pytest.mark.parametrize(
    "words",
    [
        pytest.param(["rolling", "--contact", "rough", "--k", "0.5", "--at", "0.8"], marks=LONG),
        pytest.param(["rolling", "--body", "torus", "--tube", "0.2", "--mu", "0.3"], marks=LONG),
        ["--system", "examples/bicycle.py:upright", "--at", "5", "--set", "g=9.81"],
    ],
)
def test_a_page_is_written_for_the_disk_a_body_and_a_system(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    text = output(capsys, "explore", *words, "--out", str(page), "--overwrite", "--json")
    said = json.loads(text)
    assert said == {"page": str(page), "bytes": page.stat().st_size}
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["rolling", "--k", "0.7"], "k is 0.7"),
        (["wobbling"], "wobbling"),
        (["--set", "nu=1"], "nu is given but the viscous law has none"),
        (["--positive", "v"], "--positive"),
        (["--contact", "mylaw:Law"], "cannot be imported"),
        (["--contact", "own_law:Weakening", "--set", "nu=1"], "the page draws smooth, viscous"),
        (["--x", "at:1"], "NAME:LO:HI"),
        (["--x", "at:one:2"], "one"),
        (["--mass", "-2"], "mass is -2"),
        (["--system", "examples/bicycle.py:upright", "--at", "5"], "g is missing"),
        (
            [
                "--system",
                "examples/watt_governor.py:running",
                "--set",
                "e=1",
                "--set",
                "a=1",
                "--set",
                "b=1",
            ],
            "no member at a = 1, b = 1",
        ),
    ],
)
def test_bad_options_are_one_sentence(
    words: list[str], part: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "page.html"
    assert part in refused(capsys, "explore", *words, "--out", str(target))
    assert not target.exists()
