"""The version and the name on an index: packaging and recipe read this file."""

__version__ = "0.5.0"
DISTRIBUTION = "stability-nonholonomic"
"""Name of the package on an index: `stability` there is a package of somebody else."""


def install_line(extra: str) -> str:
    """What a user types for an extra, until the package is published.

    Examples
    --------
    >>> install_line("video")
    "`pip install '.[video]'` from a checkout of stability-nonholonomic"
    """
    return f"`pip install '.[{extra}]'` from a checkout of {DISTRIBUTION}"
