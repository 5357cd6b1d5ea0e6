"""The command line: a thin layer on the public names; one file for each command."""

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line; see `stability.cli.commands.main`."""
    from .commands import main as run

    return run(arguments)
