"""A command that takes long shows so at once, before it imports what it needs."""

import io
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from stability.cli import terminal
from stability.cli.terminal import Clock, progress_bar, say, waiting

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LONG = (
    "atlas --out a",
    "map spinning --x at:1:4:9 --y mu:0.1:2:9 --out m.nc",
    "map spinning --x at:1:4:9 --y mu:0.1:2:9 --out m.nc --verdict-only",
    f"map --system {EXAMPLES}/bicycle.py:upright --x v:0.1:10:9 --y g:1:20:9 --out m.nc",
    "boundaries spinning --axis at:0.1:5:9 --mu 0.97",
    "simulate --theta 1.2 --mu 0.3 --time 10 --plot m.png",
    "basins --family rolling --x at:1:2:9 --y tilt:0.1:0.5:9 --mu 0.3 --time 10 --out b.zarr",
    f"scene {EXAMPLES}/scenes/rolled-coin.toml",
    *(
        f"table {name}"
        for name in (
            "families",
            "conditions",
            "drift",
            "hopf",
            "codimension",
            "launches",
            "benchmarks",
        )
    ),
    "chart spectrum --out a",
    "failures --out a",
    "report --out a",
)
"""Commands that can take more than two seconds."""
OF_BODIES = (
    "atlas --bodies --out a",
    "map spinning --body torus --tube 0.2 --x at:1:4:9 --y mu:0.1:2:9 --out m.nc",
)
"""Such commands of other bodies, whose module loads CasADi."""
SCRIPT = """
import sys
from stability.cli import terminal
from stability.cli.commands import main
class Opened(BaseException): pass
def opened(**_): raise Opened
terminal._shown = opened
for line in sys.argv[1:]:
    try:
        main(line.split())
    except Opened:
        heavy = {"casadi", "scipy", "xarray", "pandas", "matplotlib", "sympy", "flint"}
        print(line, sorted(heavy & sys.modules.keys()), sep="|")
"""


@pytest.mark.few(1)
@pytest.mark.parametrize(("lines", "read"), [(LONG, []), (OF_BODIES, [])])
def test_long_commands_open_their_bar_before_they_import_libraries(
    tmp_path: Path, lines: tuple[str, ...], read: list[str]
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *lines],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines() == [f"{line}|{read}" for line in lines]
    assert list(tmp_path.iterdir()) == []


class Terminal(io.StringIO):
    """Text that takes itself for a terminal, and tells when something was written."""

    def __init__(self) -> None:
        super().__init__()
        self.written = threading.Event()

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.written.set()
        return super().write(text)


def on_screen(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """A terminal as standard error; no fixture, since pytest sets its own after those."""
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    return stream


@pytest.mark.long
def test_a_bar_moves_while_no_piece_of_work_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = on_screen(monkeypatch)
    with progress_bar("figures", after=0.0) as progress:
        for told in ("0 figures", " 0/27 ", " 0/27 "):
            screen.truncate(0)
            screen.written.clear()
            assert screen.written.wait(10.0)  # the clock has written, and nobody else
            assert told in screen.getvalue()
            progress(0, 27)
    assert not [t for t in threading.enumerate() if isinstance(t, Clock)]


def test_a_message_has_a_line_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = on_screen(monkeypatch)
    with waiting("working", after=0.0):
        assert screen.written.wait(10.0)
        assert "working 00:" in screen.getvalue()
        say("a message")
    before = screen.getvalue().split("stability: a message\n")[0]
    assert before.endswith("\r")
    assert not before.rsplit("\r", 2)[1].strip(), before[-80:]


def test_short_work_and_what_is_no_terminal_show_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    screen = on_screen(monkeypatch)
    with progress_bar("figures", after=60.0) as progress:
        progress(1, 2)
    assert screen.getvalue() == ""
    quiet = io.StringIO()
    monkeypatch.setattr(sys, "stderr", quiet)
    with waiting(after=0.0), progress_bar("figures", after=0.0) as progress:
        progress(1, 2)
    assert quiet.getvalue() == ""
    assert terminal._bars == []
