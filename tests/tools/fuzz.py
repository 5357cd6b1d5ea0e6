"""The supervisor of both fuzzers: cases in a process of their own, with a watch on each.

A case follows from (seed, number) alone, so that every fault is repeated by
`python tests/tools/fuzz.py commands|calls SEED FIRST LAST`, which prints what is wrong.  A case
that takes more than `LIMIT` seconds of processor time counts as hanging and is killed; a worker
that dies counts as a crash; the campaign goes on behind either.
"""

from __future__ import annotations

import json
import os
import resource
import select
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

LIMIT = 20.0
"""Seconds of processor time for one case."""
WALL = 240.0
"""Seconds by the clock for one case, since a loaded machine gives little time to each process."""
MEMORY = 8 * 2**30
"""Bytes of address space of a worker."""
LINES, WIDTH = 2, 300
"""Longest message."""
HERE = Path(__file__).resolve().parent


@dataclass
class Harvest:
    """What came of a campaign."""

    counts: Counter[str] = field(default_factory=Counter)
    """Cases by outcome."""
    faults: list[str] = field(default_factory=list)
    """One text for each fault."""
    slowest: tuple[float, str] = (0.0, "")
    """Seconds and text of the longest case."""


def too_much(message: str) -> str:
    """Why a message is not one or two short printable lines; empty if it is."""
    lines = message.rstrip("\n").split("\n")
    if len(lines) > LINES:
        return f"{len(lines)} lines"
    if max(map(len, lines)) > WIDTH:
        return f"a line of {max(map(len, lines))} characters"
    bad = [c for c in message if c != "\n" and not c.isprintable()]
    return f"the character {bad[0]!r}" if bad else ""


def _processor_time(pid: int) -> float:
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _worker(kind: str, seed: str, first: int, last: int) -> subprocess.Popen[bytes]:
    environment = os.environ | {"PYTHONHASHSEED": "0", "MPLBACKEND": "Agg"}
    environment["PYTHONPATH"] = os.pathsep.join([str(HERE.parents[1]), str(HERE)])
    return subprocess.Popen(
        [sys.executable, str(HERE / "fuzz.py"), kind, seed, str(first), str(last), "--worker"],
        stdout=subprocess.PIPE,
        env=environment,
    )


def campaign(kind: str, seed: str, count: int) -> Harvest:
    """Run cases 0 to count - 1 of a seed, restarting the worker behind a hang or a crash."""
    harvest, following = Harvest(), 0
    while following < count:
        worker = _worker(kind, seed, following, count)
        begun = following
        for record in _records(worker):
            if "begin" in record:
                begun = record["begin"]
                continue
            harvest.counts[record["status"]] += 1
            harvest.slowest = max(harvest.slowest, (record["seconds"], record["what"]))
            if record["status"] in ("fault", "hang", "crash"):
                harvest.faults.append(f"{seed}:{begun} {record['what']}: {record['detail']}")
            following = begun + 1
        if worker.returncode:
            what = f"{seed}:{begun} the worker ended with {worker.returncode}"
            harvest.counts["hang" if worker.returncode == -9 else "crash"] += 1
            harvest.faults.append(what)
            following = begun + 1
    return harvest


def _records(worker: subprocess.Popen[bytes]) -> Iterator[dict[str, object]]:
    assert worker.stdout is not None
    descriptor, rest = worker.stdout.fileno(), b""
    clock, used = time.monotonic(), None
    while True:
        if select.select([descriptor], [], [], 0.5)[0]:
            piece = os.read(descriptor, 1 << 16)
            if not piece:
                break
            clock, used = time.monotonic(), _processor_time(worker.pid)
            *lines, rest = (rest + piece).split(b"\n")
            yield from map(json.loads, lines)
        elif used is not None:  # the clock runs from the first report: importing takes its time
            over = _processor_time(worker.pid) - used > LIMIT
            if over or time.monotonic() - clock > WALL:
                worker.kill()
                break
    worker.wait()
    worker.stdout.close()


def _work(kind: str, seed: str, first: int, last: int, *, quiet: bool) -> None:
    """The cases themselves, each reported on the descriptor that was standard output."""
    import faulthandler

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    report = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    module = __import__(f"fuzz_{kind}")
    if quiet:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    else:
        faulthandler.enable(os.dup(2))

    def say(record: dict[str, object]) -> None:
        data = json.dumps(record).encode() + b"\n"
        while data:
            data = data[os.write(report, data) :]

    with module.workplace() as place:
        for number in range(first, last):
            say({"begin": number})
            start = time.process_time()
            record = module.case(seed, number, place)
            say(record | {"seconds": time.process_time() - start})


if __name__ == "__main__":
    chosen, its_seed, low, high = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    if "--worker" in sys.argv:
        _work(chosen, its_seed, low, high, quiet=True)
    elif "--here" in sys.argv:  # to see where it hangs or what it prints
        _work(chosen, its_seed, low, high, quiet=False)
    else:
        found = campaign(chosen, its_seed, high)
        print(dict(found.counts), "slowest", found.slowest)
        print("\n".join(found.faults))
