"""The page on many launches says what the package does."""

import re
from pathlib import Path
from typing import Any

import pytest

from stability.cli.commands import _parser

PAGE = Path(__file__).resolve().parents[2] / "docs" / "explanation" / "basins.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.long
def test_the_code_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for block in blocks("python"):
        exec(block, names)
    printed = capsys.readouterr().out
    assert "'settled': 1" in printed
    assert names["found"].outcome.shape == (20, 24)
    assert names["both"].sizes["phi_dot"] == 32
    assert float(names["settled"][-1]) > 0.5 > float(names["settled"][0])
    low, high = names["exponent"].interval
    assert low < names["exponent"].exponent < high
    assert 0 < names["shock"].size <= 0.3


def test_commands_of_the_page_parse() -> None:
    commands = [line for block in blocks("sh") for line in block.replace("\\\n", " ").splitlines()]
    assert len(commands) == 3
    for line in commands:
        assert _parser().parse_args(line.split()[1:]).run
