"""The command line.

A thin layer on the public names.  `commands.py` parses a command line and runs its command;
`subject.py` reads which body, law or system of one's own it is about, with `body.py` for bodies of
revolution and `modules.py` for what a user's module names; `options.py` holds the parser and the
options and answers that commands share.
May import `explorer` and the floors below.
To add a command: a module with `EXAMPLES`, `add_arguments` and `run`, and its entry in `COMMANDS`
of `commands.py`.
"""

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line; see `stability.cli.commands.main`."""
    from .commands import main as run

    return run(arguments)
