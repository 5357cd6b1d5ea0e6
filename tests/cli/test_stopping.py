"""What a command prints while it is stopped."""

from __future__ import annotations

import os
import signal

import pytest

from stability.cli.terminal import stoppable


class HalfBuilt:
    """An object whose constructor was interrupted."""

    def __del__(self) -> None:
        raise AttributeError("'HalfBuilt' object has no attribute 'expr'")


def freed(*, stopped: bool) -> None:
    with stoppable():
        if stopped:
            with pytest.raises(KeyboardInterrupt):
                os.kill(os.getpid(), signal.SIGINT)
        HalfBuilt()


def test_an_object_freed_after_a_signal_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    freed(stopped=True)
    assert capsys.readouterr().err == ""


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_object_that_cannot_be_freed_is_heard_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    heard = []
    monkeypatch.setattr("sys.unraisablehook", heard.append)
    freed(stopped=True)
    assert not heard
    freed(stopped=False)
    assert [h.exc_type for h in heard] == [AttributeError]
