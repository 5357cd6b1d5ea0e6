"""`python -m stability`, and the program `stability`."""

import signal


def run() -> int:
    """Run the command line as a process of its own, which Ctrl-C ends without a traceback."""
    try:
        from .cli.commands import main

        return main()
    except KeyboardInterrupt:  # while the command line itself was imported
        return 130
    finally:  # what is left to do is to leave
        signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    raise SystemExit(run())
