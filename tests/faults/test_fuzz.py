"""Random calls and command lines: an answer or one short sentence, never anything else.

A few hundred of each here; `STABILITY_FUZZ_SEED` and `STABILITY_FUZZ_COUNT` set seed and number of
the long campaigns.  tests/tools/fuzz.py repeats a case by its number.
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import fuzz_commands
import pytest
from fuzz import campaign, too_much

SEED = os.environ.get("STABILITY_FUZZ_SEED", "campaign")
COUNT = int(os.environ.get("STABILITY_FUZZ_COUNT", "10000"))
ENVIRONMENTS: dict[str, dict[str, str | None]] = {
    "plain": {},
    "ASCII": {"LC_ALL": "C", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
    "one column": {"COLUMNS": "1", "NO_COLOR": "1", "TERM": "dumb"},
    "no home": {"HOME": None, "MPLCONFIGDIR": "/nonexistent", "XDG_CACHE_HOME": "/nonexistent"},
    "no folder for temporary files": {"TMPDIR": "/nonexistent"},
    "warnings are errors": {"PYTHONWARNINGS": "error"},
    "optimised": {"PYTHONOPTIMIZE": "2"},
    "no such backend": {"MPLBACKEND": "bogus"},
}
"""Settings of a process that have no say in the answer."""


@pytest.mark.parametrize(
    ("kind", "count"),
    [("calls", 7), ("commands", 20), pytest.param("calls", 90, marks=pytest.mark.long)],
)
def test_random_input_gets_an_answer_or_a_sentence(kind: str, count: int) -> None:
    found = campaign(kind, "suite", count)
    assert not found.faults, "\n".join(found.faults)
    assert found.counts["done"] > count / 10
    assert found.counts["refused"] > count / 10


@pytest.mark.long
@pytest.mark.parametrize("kind", ["calls", "commands"])
def test_a_campaign_of_random_input(kind: str) -> None:
    found = campaign(kind, SEED, COUNT)
    print(kind, SEED, dict(found.counts), "slowest", found.slowest)
    assert not found.faults, "\n".join(found.faults)


@pytest.mark.long
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_random_commands_as_processes_of_their_own(name: str, tmp_path: Path) -> None:
    environment = os.environ | {k: v for k, v in ENVIRONMENTS[name].items() if v is not None}
    for gone in (k for k, v in ENVIRONMENTS[name].items() if v is None):
        environment.pop(gone, None)
    numbers = random.Random(f"{SEED} {name}").sample(range(100_000), 40)
    for number in numbers:
        words, valid = fuzz_commands.line(SEED, number)
        if any(w in fuzz_commands.INTERRUPTED for w in words) or any("\0" in w for w in words):
            continue  # a process takes no NUL, and has no timer
        place = tmp_path / str(number)
        place.mkdir()
        fuzz_commands.tidy(place)
        done = subprocess.run(
            [sys.executable, "-m", "stability", *words],
            cwd=place,
            env=environment,
            capture_output=True,
            timeout=300,
            check=False,
        )
        out, err = (s.decode("utf-8", "replace") for s in (done.stdout, done.stderr))
        wrong = fuzz_commands.wrong(words, valid, done.returncode, out, err, place)
        assert not wrong, f"{number} {words}: {wrong}"


@pytest.mark.parametrize(
    ("text", "why"),
    [("a\nb\nc", "3 lines"), ("x" * 301, "a line of 301"), ("a\x1bb", "the character")],
)
def test_the_judge_of_messages_can_say_no(text: str, why: str) -> None:
    assert why in too_much(text)
    assert too_much("k is 0.7; give another.\n") == ""


def test_the_judge_of_commands_can_say_no(tmp_path: Path) -> None:
    fuzz_commands.tidy(tmp_path)

    def wrong(*how: object, valid: bool = False) -> str:
        code, out, err = how
        return fuzz_commands.wrong(["spectrum", "--json"], valid, code, out, err, tmp_path)  # type: ignore[arg-type]

    assert wrong(0, '{"verdict": "stable"}\n', "") == ""
    assert "strict" in wrong(0, '{"x": NaN}', "")
    assert "verdict" in wrong(0, '{"verdict": "perhaps"}', "")
    assert "valid line" in wrong(2, "", "stability: no.\n", valid=True)
    assert "exit code" in wrong(1, "", "")
    assert "standard error" in wrong(0, "", "x.py:3: RuntimeWarning: overflow")
    assert "traceback" in wrong("Traceback\n...", "", "")
    assert "without a word" in wrong(2, "", "")
    (tmp_path / "half.nc").write_text("half")
    assert "half.nc" in wrong(2, "", "stability: no.\n")
