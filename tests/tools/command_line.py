"""What the command line prints and refuses, in this process."""

import os
import signal
import threading
from collections.abc import Callable

import pytest

from stability.cli import main


def output(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(list(words)) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Exit code 2, one sentence on standard error, nothing on standard output."""
    try:
        code = main(list(words))
    except SystemExit as stop:
        code = stop.code
    captured = capsys.readouterr()
    assert code == 2
    assert captured.out == ""
    assert captured.err.startswith("stability: ")
    assert len(captured.err.strip().splitlines()) == 1
    assert captured.err.strip().endswith(".")
    assert "Traceback" not in captured.err
    return captured.err


def interrupted(begun: Callable[[], object], *words: str) -> int:
    """The exit code of a command that is sent Ctrl-C once it has begun."""
    ended = threading.Event()

    def interrupt() -> None:
        while not ended.wait(0.005):
            if begun():
                os.kill(os.getpid(), signal.SIGINT)
                return

    watch = threading.Thread(target=interrupt)
    watch.start()
    try:
        return main(list(words))
    finally:
        ended.set()
        watch.join()
