"""Commands that are killed leave no processes, and no files once another command has run there."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from kills import COMMANDS, LATEST, SIGNALS, delays, kill, next_run, readable, soon

import stability as st
from stability.storage.files import atomic_write, together
from stability.storage.litter import _start, clear, temporary

SEED = int(os.environ.get("STABILITY_SEED", "20261121"))
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")


def test_files_of_ended_processes_are_removed_and_others_stay(tmp_path: Path) -> None:
    code = "import sys; from stability.storage.litter import temporary; print(temporary('.nc'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    dead, mine = tmp_path / done.stdout.strip(), tmp_path / temporary(".nc")
    folder = tmp_path / done.stdout.strip().removesuffix(".nc")
    dead.touch()
    mine.touch()
    folder.mkdir()
    (folder / "figure.png").touch()
    host = mine.name.split("-")[1]
    foreign = tmp_path / mine.name.replace(host, "0123abcd")  # of a machine that shares the disk
    old = tmp_path / mine.name.replace(host, "0123abce")
    later = tmp_path / mine.name.replace(f"-{os.getpid()}-", f"-{os.getpid()}-1")  # number reused
    others = [tmp_path / n for n in (".stability-", ".stability-rc", ".hidden", "a.nc")]
    for path in (foreign, old, later, *others):
        path.touch()
    os.utime(old, (time.time() - 8 * 86400,) * 2)
    clear(tmp_path, always=True)
    assert {p.name for p in tmp_path.iterdir()} == {p.name for p in (mine, foreign, *others)}


def test_a_command_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    code = (
        "import os, signal, sys; from stability.storage.files import atomic_write\n"
        "with atomic_write(sys.argv[1]) as file:\n"
        "    file.write_text('half'); os.kill(os.getpid(), signal.SIGKILL)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "m.nc")], check=False)
    assert len(list(tmp_path.iterdir())) == 1
    next_run(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_several_files_are_all_there_or_none(tmp_path: Path) -> None:
    (tmp_path / "b").write_text("before")
    with pytest.raises(st.StabilityError, match="exists by now"), together():
        for name in ("a", "b", "c"):
            with atomic_write(tmp_path / name, overwrite=name == "b") as file:
                file.write_text("after")
        (tmp_path / "c").write_text("another's")
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"b": "before", "c": "another's"}
    with pytest.raises(KeyboardInterrupt), together():
        for name in ("a", "b"):
            with atomic_write(tmp_path / name, overwrite=True) as file:
                file.write_text("after")
        raise KeyboardInterrupt
    assert not (tmp_path / "a").exists()
    assert (tmp_path / "b").read_text() == "before"


def test_a_signal_waits_until_every_file_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def interrupted(self: Path, target: Path) -> Path:
        signal.raise_signal(signal.SIGINT)
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt), together():
        for name in ("a", "b"):
            with atomic_write(tmp_path / name, overwrite=True) as file:
                file.write_text("after")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]


@pytest.mark.few(1)
@pytest.mark.skipif(sys.platform == "win32", reason="processes without parents")
@pytest.mark.parametrize("system", ["linux", "another"])
def test_a_worker_ends_with_its_parent(system: str, tmp_path: Path) -> None:
    """By the kernel's signal, and where there is none by looking."""
    child = (
        "import os, sys, time\n"
        f"sys.platform = {system!r}\n"
        "from stability.jobs.processes import follow\n"
        "follow(int(sys.argv[1]))\n"
        "open(sys.argv[2], 'w').write(str(os.getpid()))\n"
        "time.sleep(600)"
    )
    parent = (
        "import os, subprocess, sys, time\n"
        f"subprocess.Popen([sys.executable, '-c', {child!r}, str(os.getpid()), sys.argv[1]])\n"
        "while not (os.path.exists(sys.argv[1]) and open(sys.argv[1]).read()): time.sleep(0.05)\n"
        "os.kill(os.getpid(), 9)"
    )
    note = tmp_path / "pid"
    subprocess.run([sys.executable, "-c", parent, str(note)], check=False, timeout=60)
    process = int(note.read_text())

    def there() -> list[str]:
        return [] if _start(process) is None else ["it runs"]

    assert soon(there, 30.0) == []


@pytest.mark.few(1)
@LINUX
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_to_the_group_leaves_the_helper_of_multiprocessing_alone(number: int) -> None:
    """If it dies, the next one knows no semaphore and ends each release in a traceback."""
    code = (
        "import os, time\n"
        "from multiprocessing.resource_tracker import _resource_tracker as helper\n"
        "from stability.jobs.processes import processes\n"
        "with processes(1) as pool:\n"
        "    pool.submit(abs, -2).result()\n"
        "    first = helper._pid\n"
        f"    os.kill(first, {int(number)})\n"
        "    time.sleep(0.3)\n"
        "    print(pool.submit(abs, -1).result(), helper._pid == first)\n"
        "    helper.ensure_running()\n"
        "    print(helper._pid == first)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.stdout.split(), done.stderr) == (["1", "True", "True"], "")


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timer here")
def test_an_interruption_within_hdf5_does_not_end_the_process(tmp_path: Path) -> None:
    """A stream that is interrupted at any moment leaves nothing, and the process goes on."""
    code = (
        "import os, random, signal, sys, stability as st\n"
        "signal.signal(signal.SIGALRM, lambda *_: os.kill(os.getpid(), signal.SIGINT))\n"
        "axes = {'x': ('at', 0.5, 5, 600), 'y': ('mu', 0.01, 10, 600, 'log')}\n"
        "st.stream_map('rolling', out='first.nc', **axes)\n"
        "def once(seconds):\n"
        "    try:\n"
        "        signal.setitimer(signal.ITIMER_REAL, seconds)\n"
        "        st.stream_map('rolling', out='next.nc', overwrite=True, **axes)\n"
        "    finally:\n"
        "        signal.setitimer(signal.ITIMER_REAL, 0)\n"
        "stopped = 0\n"
        "for i in range(30):\n"
        "    try:\n"
        "        once(0.001 * (i + 1))\n"
        "    except KeyboardInterrupt:\n"
        "        stopped += 1\n"
        "print(stopped, sum(n.startswith('.') for n in os.listdir()))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    stopped, left = map(int, done.stdout.split())
    assert stopped > 5
    assert left == 0


@pytest.mark.long
@LINUX
@pytest.mark.parametrize(
    ("name", "number", "delay"),
    [
        ("map", signal.SIGTERM, 2.5),
        ("simulate", signal.SIGHUP, 3.0),
        ("atlas", signal.SIGKILL, 6.0),
    ],
)
def test_a_killed_command_leaves_nothing(
    name: str, number: int, delay: float, tmp_path: Path
) -> None:
    found = kill(name, number, delay, tmp_path)
    assert (found.orphans, found.litter, found.partial) == ([], [], [])
    assert "Traceback" not in found.errors
    next_run(tmp_path)


@LINUX
@pytest.mark.long
@pytest.mark.parametrize("name", list(COMMANDS))
def test_a_hundred_kills(name: str, tmp_path: Path) -> None:
    """Kills at random moments, by every signal in turn, of the process or of its whole group."""
    count = int(os.environ.get("STABILITY_KILLS", "100"))
    tally: Counter[str] = Counter()
    slowest = 0.0
    bad = []
    for i, delay in enumerate(delays(SEED, count, COMMANDS[name].span)):
        folder = tmp_path / str(i)
        folder.mkdir()
        number = SIGNALS[i % len(SIGNALS)]
        group = i % 3 == 0
        found = kill(name, number, delay, folder, group=group)
        readable(folder)
        slowest = max(slowest, 0.0 if found.whole else found.took)
        tally["done before" if found.whole else f"{signal.Signals(number).name}"] += 1
        if found.orphans or found.litter or found.partial or "Traceback" in found.errors:
            bad.append((i, delay, found))
    print(f"{name}: {dict(tally)}, slowest end {slowest:.1f} s, bad {bad}")
    assert not bad
    assert slowest < LATEST


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc here")
def test_a_process_is_known_by_when_it_started() -> None:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        since = float(Path("/proc/uptime").read_text().split()[0])
        start = _start(process.pid)
        assert start is not None
        assert abs(start / os.sysconf("SC_CLK_TCK") - since) < 30
        assert _start(process.pid) == start
        process.communicate(b"\n")
    assert _start(process.pid) is None


def test_a_folder_is_not_searched_again_at_once(tmp_path: Path) -> None:
    ended = subprocess.Popen([sys.executable, "-c", "pass"])
    ended.wait()
    left = tmp_path / temporary(".nc").replace(f"-{os.getpid()}-", f"-{ended.pid}-")
    clear(tmp_path)
    left.write_text("of a process that has ended")
    clear(tmp_path)
    assert left.exists()
    clear(tmp_path, always=True)
    assert not left.exists()
