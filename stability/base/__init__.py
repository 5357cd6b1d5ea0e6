"""Ground floor: errors, checks, axes, verdicts, types.  Imports nothing of the package."""
