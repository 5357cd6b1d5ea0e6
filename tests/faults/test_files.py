"""Names, endings, full disks, closed streams: one sentence, exit code 2, nothing half-written."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import stability as st
from stability.base.errors import listed
from stability.cli import main
from stability.storage.formats import formats_for
from stability.storage.text import json_text

MAP = ("map", "rolling", "--x", "at:1:2:5", "--y", "mu:0.1:1:4")
RUN = ("simulate", "--theta", "1.4", "--mu", "0.3", "--time", "1")
STREAM = ("map", "tumbling", "--x", "at:0.05:1.5:900", "--y", "mu:0.1:5:900", "--verdict-only")
SMALL = ("map", "tumbling", "--x", "at:0.05:1.5:90", "--y", "mu:0.1:5:90", "--verdict-only")


def program(*words: str, cwd: Path, before: str = "", **options: Any) -> Any:
    """The command in a process of its own, after some Python."""
    code = f"import sys\n{before}\nfrom stability.cli import main\nsys.exit(main(sys.argv[1:]))"
    return subprocess.run(
        [sys.executable, "-c", code, *words],
        cwd=cwd,
        text=True,
        timeout=120,
        check=False,
        **{"capture_output": True} | options,
    )


@pytest.mark.parametrize(
    "words",
    [
        (*MAP, "--out", "x.png"),
        (*MAP, "--out", "x.csv", "--force"),
        (*MAP, "--out", "x.html"),
        (*MAP, "--verdict-only", "--out", "x.png"),
        (*MAP, "--out", "x.nc", "--plot", "x.nc"),
        (*RUN, "--out", "x.png"),
        (*RUN, "--out", "x.html", "--film", "x.gif"),
        (*RUN, "--plot", "x.nc"),
        (*RUN, "--film", "x.png"),
        ("atlas", "--out", "x.png"),
        ("report", "--out", "x.nc"),
        ("failures", "--out", "x.json"),
        (*MAP, "--out", "x.nc", "--checkpoint", "x.nc"),
    ],
)
def test_an_ending_of_another_format_is_refused(
    words: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(list(words)) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert "must end in" in told.err or "named like a file" in told.err
    assert list(tmp_path.iterdir()) == []


def test_endings_are_refused_in_python_too(tmp_path: Path) -> None:
    found = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3))
    endings = [ending for format_ in formats_for("write") for ending in format_.endings]
    with pytest.raises(st.StabilityError, match=re.escape(f"must end in {listed(endings, 'or')}.")):
        st.write_map(found, tmp_path / "map.png")
    assert st.read_map(st.write_map(found, tmp_path / "map")).identical(found)


@pytest.mark.few(28)
@pytest.mark.parametrize("option", ["--out", "--plot", "--film", "--checkpoint", "folder"])
@pytest.mark.parametrize(
    "name", ["loop", "loop/a", "a\0b", "a\ud800b", "folder", "gone/a", "x" * 300, "dangling/a"]
)
def test_a_name_that_cannot_be_written_gets_one_sentence(
    option: str,
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    ends = {"--out": ".nc", "--plot": ".png", "--film": ".gif"}.get(option, "")
    target = Path(f"loop{ends}")
    target.symlink_to(target)
    Path("dangling").symlink_to("nowhere")
    Path(f"folder{ends}").mkdir()
    Path(f"folder{ends}", "kept").touch()
    before = sorted(os.listdir())
    path = f"loop{ends}/a{ends}" if name == "loop/a" else name + ends
    words = {
        "--out": [*MAP, "--out", path],
        "--plot": [*RUN, "--plot", path],
        "--film": [*RUN, "--film", path],
        "--checkpoint": [*MAP, "--out", "m.nc", "--checkpoint", path],
        "folder": ["atlas", "--resolution", "8", "--out", path],
    }[option]
    assert main(words) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "Traceback" not in told
    assert sorted(os.listdir()) == before


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
@pytest.mark.parametrize(
    ("words", "size"),
    [
        ((*MAP, "--out", "m.nc", "--plot", "m.png"), 60_000),
        ((*SMALL, "--out", "m.nc"), 4_000),
        ((*MAP, "--out", "m.nc", "--checkpoint", "kept"), 1_500),
    ],
    ids=["map", "stream", "checkpoint"],
)
def test_a_full_disk_leaves_nothing(
    words: tuple[str, ...],
    size: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The system lets no file grow beyond some bytes, which looks like a full disk."""
    import resource

    monkeypatch.chdir(tmp_path)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        code = main(list(words))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    _refused_and_nothing_left(code, capsys.readouterr().err, tmp_path)


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
@pytest.mark.parametrize(
    ("words", "size"),
    [
        ((*MAP, "--out", "m.nc", "--plot", "m.png"), 60_000),
        ((*STREAM, "--out", "m.nc"), 10_000),
        ((*MAP, "--out", "m.nc", "--checkpoint", "kept"), 1_500),
        ((*RUN, "--out", "r.nc", "--film", "r.html"), 60_000),
        ((*RUN, "--out", "r.nc", "--film", "r.gif"), 60_000),
        ((*RUN, "--out", "r.nc", "--film", "r.mp4"), 60_000),
        ((*RUN, "--out", "r.nc", "--plot", "r.pdf"), 20_000),
    ],
    ids=["map", "stream", "checkpoint", "html", "gif", "mp4", "pdf"],
)
def test_a_full_disk_under_a_process_leaves_nothing(
    words: tuple[str, ...], size: int, tmp_path: Path
) -> None:
    limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))"
    done = program(*words, cwd=tmp_path, before=limit)
    _refused_and_nothing_left(done.returncode, done.stderr, tmp_path)


def _refused_and_nothing_left(code: int, said: str, folder: Path) -> None:
    assert code == 2, said
    assert said.count("\n") == 1
    assert "Traceback" not in said
    left = [p for p in folder.rglob("*") if p.is_file() and p.parent.name != "kept"]
    assert left == []


@pytest.mark.long
def test_standard_output_leads_where_it_led_after_an_error(tmp_path: Path) -> None:
    code = (
        "import os, sys\n"
        "from stability.cli import main\n"
        "words = ['spectrum', 'rolling', '--at', '1.8', '--mu', '0.3']\n"
        "kept = os.dup(1)\n"
        "os.dup2(os.open('/dev/full', os.O_WRONLY), 1)\n"
        "first = main(words)\n"
        "here = os.readlink('/proc/self/fd/1')\n"
        "os.dup2(kept, 1)\n"
        "print(first, here, main(words))\n"
    )
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout.splitlines()[-1] == "2 /dev/full 0"
    assert done.stderr == "stability: the output cannot be written: No space left on device.\n"


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="descriptors")
def test_closed_streams_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "stability", *MAP, "--out", "m.nc"]
    done = subprocess.run(
        ["sh", "-c", '"$@" >&-', "sh", *words],
        cwd=tmp_path,
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("stability: standard output is closed")
    assert list(tmp_path.iterdir()) == []
    done = subprocess.run(
        ["sh", "-c", '"$@" 2>&- <&-', "sh", *words],
        cwd=tmp_path,
        text=True,
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert st.read_map(tmp_path / "m.nc").verdict.shape == (4, 5)


def test_a_reader_that_leaves_is_no_error(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "stability", "cite"]
    process = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    errors = process.stderr.read()
    process.stderr.close()
    assert (process.wait(), errors) == (0, b"")


def no_constant(name: str) -> None:
    raise AssertionError(f"{name} is no JSON")


@pytest.mark.parametrize(
    "words",
    [
        ("table", "drift", "--mu", "0.3", "--tilt", "0.01"),
        ("spectrum", "rolling", "--at", "1e150", "--mu", "1e-300"),
        ("spectrum", "tumbling", "--at", "0.001", "--mu", "3", "--k", "0.5", "--certify"),
        (*RUN, "--no-check"),
    ],
)
def test_json_is_strict(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    if main([*words, "--json"]) == 0:
        json.loads(capsys.readouterr().out, parse_constant=no_constant)


@pytest.mark.long
def test_a_number_without_bound_is_null(capsys: pytest.CaptureFixture[str]) -> None:
    import numpy as np

    record = {
        "a": [float("inf"), np.float64("-inf"), np.nan, 1.5],
        "b": np.array([1, 2]),
        "c": True,
    }
    assert json.loads(json_text(record)) == {"a": [None, None, None, 1.5], "b": [1, 2], "c": True}
    words = ["table", "conditions", "--contact", "linear-viscous", "--k", "0.25", "--mu", "1"]
    assert main([*words, "--json"]) == 0
    text = capsys.readouterr().out
    assert '"mu_high": null' in text
    json.loads(text, parse_constant=no_constant)


def test_every_standard_stream_that_is_closed_is_opened_on_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Otherwise the next file takes the number, and what a library prints goes into that file."""
    from stability.cli import terminal

    fstat, opened = os.fstat, list[str]()

    def closed(number: int) -> os.stat_result:
        if number < 3:
            raise OSError(number)
        return fstat(number)

    with monkeypatch.context() as patch:
        patch.setattr(terminal.os, "fstat", closed)
        patch.setattr(terminal.os, "open", lambda name, _: opened.append(name))
        terminal.prepare()
    assert opened == [os.devnull] * 3
