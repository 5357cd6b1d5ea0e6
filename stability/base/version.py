"""The version, here and nowhere else: packaging and recipe read this file."""

__version__ = "0.5.0"
