"""The command line.

A thin layer on the public names.  `commands.py` parses a command line and runs its command;
`subject.py` reads which body, law or system of one's own it is about.
May import `explorer` and the floors below.
To add a command: a module with one function of the parsed options, and its help in `_parser` of
`commands.py`.
"""

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line; see `stability.cli.commands.main`."""
    from .commands import main as run

    return run(arguments)
