"""Commands that are killed at random moments, and what they leave: processes and files."""

import os
import random
import re
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import stability as st
from stability.cli import main
from stability.storage.litter import clear

MAP = ("map", "tumbling", "--x", "at:0.05:1.5:300", "--y", "mu:0.1:5:300")
RUN = ("simulate", "--theta", "1.4", "--omega3", "1", "--mu", "0.3", "--time", "4")
LATEST = 20.0
"""Seconds that a command may take to end after it was asked to."""
MARK = "STABILITY_VICTIM"


@dataclass(frozen=True)
class Command:
    """A command that writes."""

    words: tuple[str, ...]
    """Its arguments; it runs in an empty folder."""
    targets: tuple[str, ...]
    """What it makes, all together or not at all."""
    span: float
    """It is killed within so many seconds of its start."""
    kept: str = ""
    """Pattern of the paths that may be left for a later run."""


REPORT = r"report/cells\.jsonl"
COMMANDS = {
    "map": Command((*MAP, "--out", "m.nc", "--plot", "m.png"), ("m.nc", "m.png"), 7.0),
    "checkpoint": Command(
        (*MAP, "--modes", "--out", "m.nc", "--checkpoint", "kept"),
        ("m.nc",),
        6.0,
        r"kept/(map\.json|\d+\.npz)",
    ),
    "verdict-only": Command(
        (
            "map",
            "tumbling",
            "--x",
            "at:0.05:1.5:6000",
            "--y",
            "mu:0.1:5:6000",
            "--verdict-only",
            "--out",
            "m.nc",
        ),
        ("m.nc",),
        6.0,
    ),
    "simulate": Command(
        (*RUN, "--out", "r.nc", "--plot", "r.png", "--film", "r.gif"),
        ("r.nc", "r.png", "r.gif"),
        14.0,
    ),
    "simulate-mp4": Command((*RUN, "--out", "r.nc", "--film", "r.mp4"), ("r.nc", "r.mp4"), 14.0),
    "atlas": Command(("atlas", "--out", "atlas", "--resolution", "8"), ("atlas",), 40.0),
    "chart": Command(
        ("chart", "spectrum", "--out", "report"), ("report/index.html",), 15.0, REPORT
    ),
    "failures": Command(
        ("failures", "--out", "report", "--workers", "2"), ("report/index.html",), 15.0, REPORT
    ),
    "report": Command(("report", "--out", "report"), ("report/index.html",), 15.0, REPORT),
}
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


def start(command: Command, folder: Path, mark: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "stability", *command.words],
        cwd=folder,
        env=os.environ | {MARK: mark, "PYTHONPATH": str(Path(st.__file__).parents[1])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=_hearing,
    )


def _hearing() -> None:
    """Signals as a terminal leaves them: a job in the background inherits that some are ignored."""
    for number in SIGNALS[1:]:
        signal.signal(number, signal.SIG_DFL)


def alive(mark: str) -> list[str]:
    """Command lines of the processes that a command started, itself among them."""
    found = []
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            if entry.name.isdigit() and f"{MARK}={mark}".encode() in (
                entry / "environ"
            ).read_bytes().split(b"\0"):
                found.append((entry / "cmdline").read_bytes().replace(b"\0", b" ").decode())
    return found


def soon(empty: Callable[[], list[str]], seconds: float) -> list[str]:
    """What is left after some seconds at most."""
    end = time.monotonic() + seconds
    while (left := empty()) and time.monotonic() < end:
        time.sleep(0.1)
    return left


@dataclass
class Outcome:
    """What came of a kill."""

    code: int
    took: float
    """Seconds from the signal to the end."""
    orphans: list[str]
    litter: list[str]
    partial: list[str]
    """Targets that are there while others are not."""
    errors: str
    whole: bool
    """Whether the command was done before."""


def kill(name: str, number: int, delay: float, folder: Path, *, group: bool = False) -> Outcome:
    """Start a command, send it a signal, let another command write to its folders, and look."""
    command, mark = COMMANDS[name], uuid.uuid4().hex
    process = start(command, folder, mark)
    with suppress(subprocess.TimeoutExpired):
        process.wait(delay)
    done = process.poll() is not None
    begin = time.monotonic()
    if not done:
        (os.killpg if group else os.kill)(process.pid, number)
    with suppress(subprocess.TimeoutExpired):
        process.wait(60)
    took = time.monotonic() - begin
    process.kill()
    _, errors = process.communicate()  # once every process that has the pipe has ended
    orphans = soon(lambda: alive(mark), 10.0)
    for place in {folder, *(folder / Path(t).parent for t in command.targets), folder / "kept"}:
        if place.is_dir():
            clear(place, always=True)  # as the next command that writes there
    litter = [p for p in _paths(folder) if not _expected(command, p)]
    there = [t for t in command.targets if (folder / t).exists()]
    partial = there if 0 < len(there) < len(command.targets) else []
    return Outcome(
        process.returncode, took, orphans, litter, partial, errors.decode(errors="replace"), done
    )


def _paths(folder: Path) -> Iterator[str]:
    for path in folder.rglob("*"):
        if path.is_file():
            yield str(path.relative_to(folder))


def _expected(command: Command, path: str) -> bool:
    made = any(path == t or path.startswith(f"{t}/") for t in command.targets)
    if "report/index.html" in command.targets and Path(path, "..", "..").name == "":
        made = made or (Path(path).parent.name == "report" and not Path(path).name.startswith("."))
    return made or bool(command.kept and re.fullmatch(command.kept, path))


def next_run(folder: Path) -> None:
    """Another command that writes to a folder."""
    words = ["map", "rolling", "--x", "at:1:2:3", "--y", "mu:1:2:3", "--force"]
    assert main([*words, "--out", str(folder / "next.nc")]) == 0
    (folder / "next.nc").unlink()


def readable(folder: Path) -> None:
    """Every file that is there can be read."""
    for path in folder.rglob("*.nc"):
        if path.name == "r.nc":
            st.read_motion(path)
        elif path.parent.name != "report":
            st.read_map(path)


def delays(seed: int, count: int, span: float) -> list[float]:
    """Moments, even over the span but the start, when only libraries are imported."""
    chosen = random.Random(seed)
    return [chosen.uniform(0.3, span) for _ in range(count)]
