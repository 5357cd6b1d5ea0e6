"""The terminal of a command: its streams, and the signals that stop it."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..base.errors import one_line
from ..storage.files import STOPS, named
from ..storage.targets import path_text

PATIENCE = 0.8
"""Time after which a command shows on a terminal that it works [s]."""
TICK = 0.25
"""Time between two looks at the clock [s]."""


class Stop:
    """The signal that stopped a command, or none."""

    def __init__(self) -> None:
        self.number = 0
        self._before = len(named())

    @property
    def code(self) -> int:
        """Exit code, as a shell gives it."""
        return 128 + (self.number or int(signal.SIGINT))

    @property
    def sentence(self) -> str:
        """Files written before the stop, in one sentence."""
        files: list[Path] = named()[self._before :]
        if not files:
            return "interrupted; nothing was written"
        more = f" and {len(files) - 1} more" if files[1:] else ""
        return f"interrupted; {path_text(files[0])}{more} had been written, whole"

    def check(self) -> None:
        """Raise KeyboardInterrupt again if a library has swallowed it."""
        if self.number:
            raise KeyboardInterrupt


_stops: list[Stop] = []
_bars: list[Any] = []
"""Bars of this process on the terminal."""


def check() -> None:
    """Raise KeyboardInterrupt if the running command continued after a signal to stop."""
    if _stops:
        _stops[-1].check()


@contextmanager
def stoppable() -> Iterator[Stop]:
    """Let SIGTERM and SIGHUP end a command as Ctrl-C does, so that nothing is left behind.

    A signal that is ignored (`nohup`), or that a calling program handles, stays so.
    """
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def end(number: int, _: Any) -> None:
        stop.number = number
        raise KeyboardInterrupt

    def quiet(swallowed: Any) -> None:
        # a KeyboardInterrupt in a destructor: `check` raises it again.  After a signal: an object
        # that a library was building, and that cannot be freed well
        if not stop.number and not issubclass(swallowed.exc_type, KeyboardInterrupt):
            hook(swallowed)

    hook, sys.unraisablehook = sys.unraisablehook, quiet
    before = {n: signal.getsignal(n) for n in STOPS}
    plain = (signal.SIG_DFL, signal.default_int_handler)
    mine = {n: handler for n, handler in before.items() if handler in plain}
    for number in mine:
        signal.signal(number, end)
    _stops.append(stop)
    try:
        yield stop
    finally:
        _stops.pop()
        sys.unraisablehook = hook
        for number, handler in mine.items():
            signal.signal(number, handler)


class Clock(threading.Thread):
    """Moves a bar by its time, also while no piece of work ends.

    Parameters
    ----------
    bar
        A bar of tqdm.
    """

    def __init__(self, bar: Any) -> None:
        super().__init__(daemon=True)
        self.bar, self.done = bar, threading.Event()

    def run(self) -> None:
        """Draw the bar again and again, until the work is done."""
        while not self.done.wait(TICK):
            self.bar.update(0)


@contextmanager
def _shown(**look: Any) -> Iterator[Any]:
    """A bar of tqdm on standard error that moves by itself; None where that is no terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    # miniters=0: drawn by the clock, not after a number of pieces
    # smoothing=0: pieces end by thousands, and between two looks at the clock none ends
    bar = tqdm(total=None, leave=False, miniters=0, smoothing=0, file=sys.stderr, **look)
    clock = Clock(bar)
    _bars.append(bar)
    clock.start()
    try:
        yield bar
    finally:
        _bars.remove(bar)
        clock.done.set()
        clock.join()
        bar.close()


@contextmanager
def progress_bar(unit: str, after: float = PATIENCE) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on a terminal, shown where the work takes long.

    Open it before the imports that the work needs: they take a second.

    Parameters
    ----------
    unit
        Name of the pieces.
    after
        Time before anything is shown [s].
    """
    with _shown(unit=f" {unit}", delay=after) as bar:

        def update(done: int, total: int) -> None:
            check()
            if bar is None:
                return
            if bar.total is None:  # what is done by now was stored, or took no time of this bar
                bar.total, bar.start_t = total, bar._time()
                bar.n = bar.initial = bar.last_print_n = done
            elif bar.total != total:
                bar.reset(total)
            bar.update(done - bar.n)

        yield update


@contextmanager
def waiting(word: str = "answering", after: float = PATIENCE) -> Iterator[None]:
    """The time that work has taken, on a terminal, where the number of its pieces is not known.

    Parameters
    ----------
    word
        What is done.
    after
        Time before anything is shown [s].
    """
    with _shown(desc=word, bar_format="{desc} {elapsed}", delay=after):
        yield


def prepare() -> bool:
    """Prepare the streams for any text; False without a standard output.

    A closed descriptor 0, 1 or 2 is opened on the null device.  Otherwise the next file would take
    its number, and libraries would print into that file.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and not stream.closed:
            # a terminal that lacks √ shows its code instead
            with suppress(OSError, ValueError):
                stream.reconfigure(errors="backslashreplace")
    return sys.stdout is not None and not sys.stdout.closed


def say(sentence: str) -> None:
    """Print a message on standard error; without an open standard error nothing happens.

    Parameters
    ----------
    sentence
        Text of the message.
    """
    with suppress(OSError, ValueError, AttributeError):
        for bar in _bars:  # its clock draws it again, below the message
            bar.clear()
        print(f"stability: {one_line(sentence)}", file=sys.stderr, flush=True)


def drop_output() -> None:
    """Discard the buffer of standard output, which cannot be written; keep its destination."""
    try:
        number = sys.stdout.fileno()
        kept = os.dup(number)
    except (AttributeError, OSError, ValueError):
        return
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, number)
        with suppress(OSError, ValueError):
            sys.stdout.flush()
    finally:
        os.dup2(kept, number)
        os.close(kept)
        os.close(null)


LEAST_MEMORY = 640 * 2**20
"""Bytes of address space below which libraries do not load: OpenBLAS aborts or never returns."""


def allowed_memory() -> int:
    """Bytes of address space that the process may have."""
    try:
        import resource
    except ImportError:  # not on Windows
        return 2**63
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return 2**63 if limit == resource.RLIM_INFINITY else limit


STARVED = (
    "bad_alloc",
    "failed to map segment",
    "annot allocate memory",
    "nable to allocate",
    "can't start new thread",
    "out of memory",
    "ot enough memory",
)
"""Parts of the messages of libraries without memory, whose classes of error differ."""


def starved(reason: BaseException | None) -> bool:
    """Whether an error comes from too little memory, in Python or in a library.

    Parameters
    ----------
    reason
        The error; its causes are checked too.

    Examples
    --------
    >>> starved(MemoryError()), starved(RuntimeError("std::bad_alloc")), starved(KeyError("x"))
    (True, True, False)
    """
    limited = allowed_memory() < 2**62
    while reason is not None:
        if isinstance(reason, MemoryError) or any(word in str(reason) for word in STARVED):
            return True
        if limited and isinstance(reason, ImportError):  # some libraries give no other reason
            return True
        reason = reason.__cause__ or reason.__context__
    return False
