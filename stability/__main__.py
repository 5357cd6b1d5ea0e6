"""`python -m stability`, and the program `stability`."""

import signal


def run() -> int:
    """Run the command line as its own process; Ctrl-C ends it without a traceback."""
    try:
        from .cli.commands import main

        return main()
    except KeyboardInterrupt:  # during the import of the command line
        return 130
    finally:  # only the exit is left: Ctrl-C may end it at once
        signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    raise SystemExit(run())
